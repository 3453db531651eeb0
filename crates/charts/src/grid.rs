//! Small multiples: diagrams side by side under one legend, as a file of its own.

use super::legend::{heading, heading_height, legend};
use super::limits::{Limits, limits};
use super::look::{ROW, Surface, dress};
use super::plot::Side;
use super::{Area, ChartError, Figure, Frame, curves, layer, panel};
use plotters::prelude::*;

/// Diagrams in rows. Those of a row share their vertical range, so that they compare at a glance.
#[derive(Clone, Debug, PartialEq)]
pub struct Grid {
    /// What all show, in words, for those who do not see them.
    pub description: String,
    /// Diagrams from left to right; rows may differ in length. All have the first one's legend
    /// and size.
    pub rows: Vec<Vec<Figure>>,
}

/// The diagrams as one SVG text, as wide as its container.
///
/// # Errors
/// [`ChartError::Empty`] when there is no diagram, or nothing finite in one of them.
pub fn grid_svg(grid: &Grid) -> Result<String, ChartError> {
    let placed = grid.rows.iter().map(|row| row.iter().map(Figure::placed).collect());
    let rows: Vec<Vec<Figure>> = placed.collect();
    let first = rows.iter().flatten().next().ok_or(ChartError::Empty { lines: 0 })?;
    let limits = rows.iter().map(|row| shared(row)).collect::<Result<Vec<_>, _>>()?;
    let columns = rows.iter().map(Vec::len).max().unwrap_or(1);
    // Each diagram is as large as a figure of its own, with space in place of the legend.
    let (width, height) = first.size.units();
    let width = width * columns as u32;
    let top = legend_height(first, width)?;
    let size = (width, top as u32 + height * rows.len() as u32);
    let draw = |root: &Area, which: Side| -> Result<Vec<Frame>, ChartError> {
        let places = root.split_vertically(top).1.split_evenly((rows.len(), columns));
        let drawn = places.chunks(columns).zip(rows.iter().zip(&limits));
        let panels = drawn.flat_map(|(places, (row, limits))| places.iter().zip(row).zip(limits));
        let one = |((place, figure), limits): ((&Area, &Figure), &Limits)| {
            let place = place.margin(0, ROW, 0, 0);
            let top = match which {
                Side::Vertical => heading(&place, figure)?,
                Side::Horizontal => heading_height(figure),
            };
            panel(&place.split_vertically(top).1, figure, limits, which)
        };
        panels.map(one).collect()
    };
    let (mut text, frames) = layer(size, |root| {
        legend(root, first, 0)?;
        draw(root, Side::Vertical)
    })?;
    text.push_str(&layer(size, |root| draw(root, Side::Horizontal))?.0);
    for (figure, frame) in rows.iter().flatten().zip(&frames) {
        text.push_str(&curves(figure, frame).into_string());
    }
    Ok(dress(&text, &grid.description, size, Surface::Own))
}

/// The limits of the diagrams of a row, the vertical ones in common.
fn shared(row: &[Figure]) -> Result<Vec<Limits>, ChartError> {
    let own = row.iter().map(limits).collect::<Result<Vec<_>, _>>()?;
    let low = own.iter().map(|(_, ys)| ys.start).fold(f64::INFINITY, f64::min);
    let high = own.iter().map(|(_, ys)| ys.end).fold(f64::NEG_INFINITY, f64::max);
    Ok(own.into_iter().map(|(xs, _)| (xs, low..high)).collect())
}

/// Height of the legend on a drawing of this width.
fn legend_height(figure: &Figure, width: u32) -> Result<i32, ChartError> {
    let mut unused = String::new();
    let trial = SVGBackend::with_string(&mut unused, (width, 1)).into_drawing_area();
    legend(&trial, figure, 0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Axis, Band, Colour, Line, Rug, Style};

    fn figure(x: &str, scale: f64) -> Figure {
        let points: Vec<(f64, f64)> =
            (0..9).map(|k| (f64::from(k), scale * f64::from(k))).collect();
        let edges = points.iter().map(|p| (p.0, p.1 - 1.0, p.1 + 1.0)).collect();
        Figure {
            bands: vec![Band { label: "band".into(), colour: Colour::Blue, edges }],
            lines: vec![Line {
                label: "curve".into(),
                colour: Colour::Blue,
                style: Style::Solid,
                points,
            }],
            rug: Some(Rug { label: "data".into(), at: vec![-1.0, 0.0, 3.0, 8.0, 9.0] }),
            ..Figure::new(Axis::linear(x, ""), Axis::linear("f", ""))
        }
    }

    #[test]
    fn diagrams_share_a_legend_and_rows_their_range() {
        let rows = vec![vec![figure("x", 1.0), figure("dx", 10.0)], vec![figure("x<", 1.0)]];
        let svg = grid_svg(&Grid { description: "f & g".into(), rows: rows.clone() }).unwrap();
        for (part, times) in
            [("f &amp; g", 2), ("x&lt;\n", 1), ("curve\n", 1), ("data\n", 1), ("ground", 2)]
        {
            assert_eq!(svg.matches(part).count(), times, "{part}");
        }
        assert!(svg.contains("viewBox=\"0 0 1840 1256\""), "{}", &svg[..300]);
        let limits = shared(&rows[0]).unwrap();
        assert_eq!(limits[0].1, limits[1].1);
        assert_eq!(limits[1].1, super::limits(&rows[0][1]).unwrap().1);
    }

    #[test]
    fn nothing_to_draw_is_an_error() {
        let empty = |rows| grid_svg(&Grid { description: String::new(), rows });
        assert_eq!(empty(vec![]), Err(ChartError::Empty { lines: 0 }));
        assert_eq!(empty(vec![vec![]]), Err(ChartError::Empty { lines: 0 }));
        let nan = empty(vec![vec![figure("x", f64::NAN)]]);
        assert_eq!(nan, Err(ChartError::Empty { lines: 1 }));
    }
}
