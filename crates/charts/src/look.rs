//! Sizes, colours and widths.

use super::{Line, Style};
use maud::{PreEscaped, html};
use plotters::prelude::*;

/// Size of a figure: how much room its texts, which have one size, leave to the rest.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Size {
    /// Beside others, or as wide as a phone.
    #[default]
    Small,
    /// As wide as a page: room for a legend with numbers.
    Wide,
}

impl Size {
    /// Units of a drawing: about twice those of a screen, since coordinates are whole numbers.
    pub(super) fn units(self) -> (u32, u32) {
        match self {
            Self::Small => (920, 600),
            Self::Wide => (1640, 940),
        }
    }
}

pub(super) const TEXT: i32 = 40;
pub(super) const ROW: i32 = 48;
const FONT: &str = "sans-serif";
pub(super) const LINE: u32 = 4;
const BROAD: u32 = 12;
/// Radius of marks.
pub(super) const MARK: i32 = 7;
const THIN: u32 = 3;
/// The width that stands for a dashed line while drawing: plotters would draw each dash as
/// an element of its own.
const DASHED: u32 = 5;
pub(super) const INK: RGBColor = RGBColor(0x33, 0x38, 0x3F);
pub(super) const GRID: RGBColor = RGBColor(0xDD, 0xE1, 0xE6);
/// Ink and grid change with the surroundings; the data's colours are readable on both.
const STYLE: &str = "@media screen and (prefers-color-scheme: dark){\
.lacuna-figure [fill=\"#33383F\"]{fill:#D9DDE3}.lacuna-figure [stroke=\"#33383F\"]{stroke:#D9DDE3}\
.lacuna-figure [stroke=\"#DDE1E6\"]{stroke:#363C45}.lacuna-figure .ground{fill:#15181C}}";

/// What a figure is drawn on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Surface {
    /// What contains it, such as a page, has a colour.
    Container,
    /// The figure is a file of its own and brings its ground.
    Own,
    /// The same, on a page that is light whatever surrounds it.
    Paper,
}

/// What was drawn in a frame that scales, with the words and the colours.
pub(super) fn dress(
    text: &str,
    description: &str,
    (width, height): (u32, u32),
    surface: Surface,
) -> String {
    let dashed = format!("stroke-width=\"{DASHED}\"");
    let body = text.replace(&dashed, &format!("stroke-width=\"{LINE}\" stroke-dasharray=\"14 9\""));
    html! {
        svg class="lacuna-figure" xmlns="http://www.w3.org/2000/svg" role="img"
            aria-label=(description) width="100%" viewBox={ "0 0 " (width) " " (height) } {
            title { (description) }
            @if surface != Surface::Paper {
                style { (PreEscaped(STYLE)) }
            }
            @if surface != Surface::Container {
                rect class="ground" width=(width) height=(height) fill="#FFFFFF" {}
            }
            (PreEscaped(body))
        }
    }
    .into_string()
}

pub(super) fn font(size: i32) -> TextStyle<'static> {
    (FONT, size).into_font().color(&INK)
}

pub(super) fn bold(size: i32) -> TextStyle<'static> {
    (FONT, size, FontStyle::Bold).into_font().color(&INK)
}

/// Width of a line.
pub(super) fn width(style: Style) -> u32 {
    match style {
        Style::Thin | Style::Joined => THIN,
        Style::Solid | Style::Dashed | Style::Dots | Style::Rings => LINE,
        Style::Broad => BROAD,
    }
}

/// A colour as SVG has it.
pub(super) fn hex(RGBColor(r, g, b): RGBColor) -> String {
    format!("#{r:02X}{g:02X}{b:02X}")
}

/// Colour and width of a line's key.
pub(super) fn stroke(line: &Line) -> ShapeStyle {
    let colour = line.colour.rgb();
    match line.style {
        Style::Thin | Style::Joined => colour.stroke_width(THIN),
        Style::Solid | Style::Dots | Style::Rings => colour.stroke_width(LINE),
        Style::Dashed => colour.stroke_width(DASHED),
        Style::Broad => colour.mix(0.4).stroke_width(BROAD),
    }
}
