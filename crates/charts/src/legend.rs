//! Labels, the heading, and the legend above a diagram.

use super::look::{INK, LINE, MARK, ROW, TEXT, bold, font, stroke};
use super::{Area, Band, ChartError, Drawn, Figure, Style, failed};
use plotters::prelude::*;

/// Mean advance of a character in units of the font size.
const ADVANCE: f64 = 0.47;
/// Width of a key.
const KEY: i32 = 44;

pub(super) fn label(area: &Area, text: &str, at: (i32, i32)) -> Drawn {
    area.draw(&Text::new(text.to_owned(), at, font(TEXT))).map_err(failed)
}

/// What stands before an entry.
enum Key {
    Line(ShapeStyle),
    Dots(ShapeStyle),
    Rings(ShapeStyle),
    Joined(ShapeStyle),
    Band(ShapeStyle),
    Rug,
}

fn entries(figure: &Figure) -> Vec<(&str, Key)> {
    let filled = |b: &Band| b.colour.rgb().mix(0.25).filled();
    let key = |l: &super::Line| match l.style {
        Style::Dots => Key::Dots(stroke(l)),
        Style::Rings => Key::Rings(stroke(l)),
        Style::Joined => Key::Joined(stroke(l)),
        Style::Solid | Style::Thin | Style::Dashed | Style::Broad => Key::Line(stroke(l)),
    };
    let lines = figure.lines.iter().map(|l| (l.label.as_str(), key(l)));
    let bands = figure.bands.iter().map(|b| (b.label.as_str(), Key::Band(filled(b))));
    let rug = figure.rug.iter().map(|r| (r.label.as_str(), Key::Rug));
    // What has no name belongs to something that has.
    lines.chain(bands).chain(rug).filter(|(name, _)| !name.is_empty()).collect()
}

/// Space that an entry takes.
fn length(text: &str) -> i32 {
    62 + (ADVANCE * f64::from(TEXT) * text.chars().count() as f64) as i32
}

/// The title of a figure; returns its height.
pub(super) fn heading(area: &Area, figure: &Figure) -> Result<i32, ChartError> {
    if !figure.title.is_empty() {
        let words = Text::new(figure.title.clone(), (12, 10), bold(TEXT));
        area.draw(&words).map_err(failed)?;
    }
    Ok(heading_height(figure))
}

/// Height of the title of a figure.
pub(super) fn heading_height(figure: &Figure) -> i32 {
    if figure.title.is_empty() { 0 } else { ROW + 8 }
}

/// The legend above the diagram, from `top` on, where it hides nothing; returns where it ends.
pub(super) fn legend(area: &Area, figure: &Figure, top: i32) -> Result<i32, ChartError> {
    let width = area.dim_in_pixel().0 as i32;
    let entries = entries(figure);
    if entries.is_empty() {
        return Ok(top);
    }
    let (mut x, mut y) = (12, top + 8);
    for (text, key) in entries {
        if x > 12 && x + length(text) > width {
            (x, y) = (12, y + ROW);
        }
        draw_key(area, &key, (x, y + TEXT / 2))?;
        label(area, text, (x + 54, y))?;
        x += length(text) + 26;
    }
    Ok(y + ROW)
}

fn draw_key(area: &Area, key: &Key, (x, middle): (i32, i32)) -> Drawn {
    let line = |points: Vec<(i32, i32)>, style| area.draw(&PathElement::new(points, style));
    let mark = |style| area.draw(&Circle::new((x + KEY / 2, middle), MARK, style));
    match *key {
        Key::Line(style) => line(vec![(x, middle), (x + KEY, middle)], style),
        Key::Dots(style) => mark(style.filled()),
        Key::Rings(style) => mark(style.stroke_width(LINE)),
        Key::Joined(style) => {
            line(vec![(x, middle), (x + KEY, middle)], style).and_then(|()| mark(style.filled()))
        }
        Key::Band(style) => {
            area.draw(&Rectangle::new([(x, middle - 16), (x + KEY, middle + 16)], style))
        }
        Key::Rug => [4, 12, 18, 30, 36].into_iter().try_for_each(|d| {
            line(vec![(x + d, middle - 10), (x + d, middle + 10)], INK.stroke_width(2))
        }),
    }
    .map_err(failed)
}
