//! Labels, and the legend above a diagram.

use super::look::{INK, ROW, TEXT, font, stroke};
use super::{Area, Band, Drawn, Figure, FigureError, failed};
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
    Band(ShapeStyle),
    Rug,
}

fn entries(figure: &Figure) -> Vec<(&str, Key)> {
    let filled = |b: &Band| b.colour.rgb().mix(0.25).filled();
    let lines = figure.lines.iter().map(|l| (l.label.as_str(), Key::Line(stroke(l))));
    let bands = figure.bands.iter().map(|b| (b.label.as_str(), Key::Band(filled(b))));
    let rug = figure.rug.iter().map(|r| (r.label.as_str(), Key::Rug));
    lines.chain(bands).chain(rug).collect()
}

/// Space that an entry takes.
fn length(text: &str) -> i32 {
    62 + (ADVANCE * f64::from(TEXT) * text.chars().count() as f64) as i32
}

/// The legend above the diagram, where it hides nothing; returns its height.
pub(super) fn legend(area: &Area, figure: &Figure) -> Result<i32, FigureError> {
    let width = area.dim_in_pixel().0 as i32;
    let (mut x, mut y) = (12, 8);
    for (text, key) in entries(figure) {
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
    match *key {
        Key::Line(style) => line(vec![(x, middle), (x + KEY, middle)], style),
        Key::Band(style) => {
            area.draw(&Rectangle::new([(x, middle - 16), (x + KEY, middle + 16)], style))
        }
        Key::Rug => [4, 12, 18, 30, 36].into_iter().try_for_each(|d| {
            line(vec![(x + d, middle - 10), (x + d, middle + 10)], INK.stroke_width(2))
        }),
    }
    .map_err(failed)
}
