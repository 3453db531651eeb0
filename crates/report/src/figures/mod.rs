//! Line figures as SVG text, in one look.
//!
//! A figure brings its own colours for light and dark surroundings and scales with its
//! container. The same colours mean the same everywhere: what was measured is ink, the model
//! as it was is [`Colour::Vermilion`], what Lacuna says is [`Colour::Blue`].

mod curves;
mod frame;
mod grid;
mod legend;
mod limits;
mod look;
mod pieces;
mod plot;
mod ratios;
mod tick;

pub use grid::{Grid, grid_svg};

use legend::{label, legend};
use limits::{Limits, limits};
pub use look::Surface;
pub use ratios::{Ratio, Ratios, ratios_svg};

use curves::curves;
use frame::Frame;
use look::{INK, ROW, SIZE, dress};
use maud::{PreEscaped, html};
use plot::{Axis, axis};
use plotters::coord::Shift;
use plotters::prelude::*;

type Area<'a> = DrawingArea<SVGBackend<'a>, Shift>;
type Drawn = Result<(), FigureError>;

/// Why a figure cannot be drawn.
#[derive(Debug, thiserror::Error, PartialEq, Eq)]
pub enum FigureError {
    /// Nothing to draw.
    #[error("a figure needs at least one finite point, found none in {lines} lines")]
    Empty {
        /// Lines that were given.
        lines: usize,
    },
    /// The drawing library failed.
    #[error("the figure cannot be drawn: {reason}")]
    Drawing {
        /// What it said.
        reason: String,
    },
}

/// Colours that colour-blind readers can tell apart (Okabe and Ito), and ink.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Colour {
    /// What was measured, or learned from it.
    Ink,
    /// What Lacuna says.
    Blue,
    /// The model as it was.
    Vermilion,
}

impl Colour {
    fn rgb(self) -> RGBColor {
        match self {
            Self::Ink => INK,
            Self::Blue => RGBColor(0x1F, 0x83, 0xC4),
            Self::Vermilion => RGBColor(0xD5, 0x5E, 0x00),
        }
    }
}

/// How a line is drawn, so that lines can be told apart without their colours.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Style {
    /// A line.
    Solid,
    /// A thin line, for dense noise that must not hide what is beneath.
    Thin,
    /// A dashed line.
    Dashed,
    /// A broad pale line, which others may cover and not hide.
    Broad,
}

/// A curve.
#[derive(Clone, Debug, PartialEq)]
pub struct Line {
    /// Entry of the legend.
    pub label: String,
    /// Its colour.
    pub colour: Colour,
    /// How it is drawn.
    pub style: Style,
    /// Points in the order in which they are joined; one that is not finite is a gap.
    pub points: Vec<(f64, f64)>,
}

/// The region between two curves.
#[derive(Clone, Debug, PartialEq)]
pub struct Band {
    /// Entry of the legend.
    pub label: String,
    /// Its colour, drawn pale.
    pub colour: Colour,
    /// Abscissa, lower and upper edge; one that is not finite is a gap.
    pub edges: Vec<(f64, f64, f64)>,
}

/// Short marks at the foot of a diagram: where the data are.
#[derive(Clone, Debug, PartialEq)]
pub struct Rug {
    /// Entry of the legend.
    pub label: String,
    /// Abscissas of the marks.
    pub at: Vec<f64>,
}

/// A diagram of lines over bands.
#[derive(Clone, Debug, PartialEq)]
pub struct Figure {
    /// What it shows, in words, for those who do not see it.
    pub description: String,
    /// Label of the horizontal axis, with its unit.
    pub x: String,
    /// Label of the vertical axis, with its unit.
    pub y: String,
    /// Bands, drawn first.
    pub bands: Vec<Band>,
    /// Lines, the last on top.
    pub lines: Vec<Line>,
    /// Marks at the foot, where there are any.
    pub rug: Option<Rug>,
    /// Values beyond which curves are cut off; all are shown without it.
    pub within: Option<(f64, f64)>,
}

/// The figure as SVG text, as wide as its container.
///
/// Its curves are paths of the class `line` or `band` in a group of the class `curves`, in
/// tenths of a unit from the upper left corner of the plane. The group tells where that plane is
/// and what it shows: `data-frame` holds left, top, right and bottom (units of the drawing) and
/// the first and last abscissa and ordinate.
///
/// # Errors
/// [`FigureError::Empty`] when no line has a finite point in view.
pub fn svg(figure: &Figure, surface: Surface) -> Result<String, FigureError> {
    let limits = limits(figure)?;
    let (mut text, (top, frame)) = layer(SIZE, |root| {
        let top = legend(root, figure)?;
        let frame = panel(&root.split_vertically(top).1, figure, &limits, Axis::Vertical)?;
        Ok((top, frame))
    })?;
    let (foot, _) = layer(SIZE, |root| {
        panel(&root.split_vertically(top).1, figure, &limits, Axis::Horizontal)
    })?;
    text.push_str(&inside(&foot, figure, &frame));
    Ok(dress(&text, &figure.description, SIZE, surface))
}

/// What is drawn, as the inside of an SVG text.
fn layer<T>(
    size: (u32, u32),
    draw: impl FnOnce(&Area) -> Result<T, FigureError>,
) -> Result<(String, T), FigureError> {
    let mut text = String::new();
    let drawn = {
        let root = SVGBackend::with_string(&mut text, size).into_drawing_area();
        let drawn = draw(&root)?;
        root.present().map_err(failed)?;
        drawn
    };
    let body = text.split_once('>').map_or(text.as_str(), |(_, body)| body).trim_end();
    Ok((body.strip_suffix("</svg>").unwrap_or(body).to_owned(), drawn))
}

/// One axis of a diagram, the vertical one under its label.
fn panel(area: &Area, figure: &Figure, limits: &Limits, which: Axis) -> Result<Frame, FigureError> {
    let (heading, plane) = area.split_vertically(ROW);
    if which == Axis::Vertical {
        label(&heading, &figure.y, (12, 0))?;
    }
    axis(&plane, figure, limits.clone(), which)
}

/// The horizontal axis as a group, and the curves.
fn inside(foot: &str, figure: &Figure, frame: &Frame) -> String {
    let curves = curves(figure, frame);
    html! { g class="x-axis" { (PreEscaped(foot)) } (curves) }.into_string()
}

fn failed(error: impl std::fmt::Display) -> FigureError {
    FigureError::Drawing { reason: error.to_string() }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn figure(points: Vec<(f64, f64)>) -> Figure {
        let line = Line { label: "a<b".into(), colour: Colour::Blue, style: Style::Dashed, points };
        Figure {
            description: "Force & \"law\"".into(),
            x: "velocity (m/s)".into(),
            y: "force (N)".into(),
            bands: vec![],
            lines: vec![line],
            rug: None,
            within: None,
        }
    }

    #[test]
    fn a_figure_holds_its_words_escaped() {
        let svg = svg(&figure(vec![(0.0, 1.0), (1.0, 2.0)]), Surface::Container).unwrap();
        for word in ["velocity (m/s)", "force (N)", "a&lt;b", "Force &amp; &quot;law&quot;"] {
            assert!(svg.contains(word), "{word}");
        }
        assert!(svg.contains("stroke-dasharray"));
        assert!(svg.starts_with("<svg") && svg.ends_with("</svg>"));
        assert_eq!(svg.matches("</svg>").count(), 1);
    }

    #[test]
    fn nothing_to_draw_is_an_error() {
        let empty = svg(&figure(vec![(f64::NAN, 1.0), (0.0, f64::INFINITY)]), Surface::Own);
        assert_eq!(empty, Err(FigureError::Empty { lines: 1 }));
        assert_eq!(svg(&figure(vec![]), Surface::Own), Err(FigureError::Empty { lines: 1 }));
    }
}
