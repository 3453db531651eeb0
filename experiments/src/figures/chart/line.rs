//! Line charts.

use plotters::prelude::*;
use plotters::series::DashedLineSeries;
use std::ops::Range;

use super::tick::tick;
use super::{Area, Axis, COLOURS, FONT, GRID, INK, Plane, extent, failed, figure, frame};
use crate::StudyError;

/// How a series is drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Style {
    /// A solid line.
    Line,
    /// A dashed line.
    Dashed,
    /// A solid line with a dot at each point.
    Dots,
    /// A ring at each point, and no line.
    Rings,
}

/// One curve.
#[derive(Clone, Debug)]
pub struct Series {
    /// Entry of the legend; none when empty.
    pub label: String,
    /// Points in the order they are joined.
    pub points: Vec<(f64, f64)>,
    /// How it is drawn.
    pub style: Style,
    /// Which colour of the palette.
    pub colour: usize,
}

impl Series {
    /// A solid curve.
    pub fn line(label: &str, colour: usize, points: Vec<(f64, f64)>) -> Self {
        Self { label: label.into(), points, style: Style::Line, colour }
    }

    /// A dashed curve.
    pub fn dashed(label: &str, colour: usize, points: Vec<(f64, f64)>) -> Self {
        Self { style: Style::Dashed, ..Self::line(label, colour, points) }
    }

    /// A solid curve with dots.
    pub fn dots(label: &str, colour: usize, points: Vec<(f64, f64)>) -> Self {
        Self { style: Style::Dots, ..Self::line(label, colour, points) }
    }

    /// Rings that belong to another series, and so have no entry of the legend.
    pub fn rings(colour: usize, points: Vec<(f64, f64)>) -> Self {
        Self { style: Style::Rings, ..Self::line("", colour, points) }
    }
}

/// One diagram of a figure.
#[derive(Clone, Debug)]
pub struct Panel<'a> {
    /// Heading.
    pub title: &'a str,
    /// Horizontal axis.
    pub x: Axis<'a>,
    /// Vertical axis.
    pub y: Axis<'a>,
    /// Curves.
    pub series: Vec<Series>,
}

/// Draw panels side by side and return the SVG text.
///
/// # Errors
/// [`StudyError::Figure`] when there is nothing finite to draw.
pub fn line_figure(panels: &[Panel]) -> Result<String, StudyError> {
    figure(panels.len(), |area, k| line_panel(area, &panels[k]))
}

fn line_panel(area: &Area, panel: &Panel) -> Result<(), StudyError> {
    let placed: Vec<Vec<(f64, f64)>> = panel.series.iter().map(|s| place(panel, s)).collect();
    let xs = extent(placed.iter().flatten().map(|p| p.0), 0.0)?;
    let ys = extent(placed.iter().flatten().map(|p| p.1), 0.06)?;
    let mut chart = frame(area, panel.title, xs.clone(), ys.clone())?;
    let (x, y) = (panel.x, panel.y);
    chart
        .configure_mesh()
        .light_line_style(TRANSPARENT)
        .bold_line_style(GRID)
        .axis_style(INK)
        .x_desc(x.label)
        .y_desc(y.label)
        .x_labels(7)
        .y_labels(7)
        .x_label_formatter(&|v| tick(*v, &xs, x.scale))
        .y_label_formatter(&|v| tick(*v, &ys, y.scale))
        .label_style((FONT, 14, &INK))
        .axis_desc_style((FONT, 16, &INK))
        .draw()
        .map_err(failed)?;
    let corner = emptiest_corner(placed.iter().flatten(), &xs, &ys);
    for (series, points) in panel.series.iter().zip(placed) {
        curve(&mut chart, series, points)?;
    }
    if panel.series.len() > 1 {
        legend(&mut chart, corner)?;
    }
    Ok(())
}

fn place(panel: &Panel, series: &Series) -> Vec<(f64, f64)> {
    let points = series.points.iter();
    points.map(|p| (panel.x.scale.place(p.0), panel.y.scale.place(p.1))).collect()
}

fn curve(
    chart: &mut ChartContext<SVGBackend, Plane>,
    series: &Series,
    points: Vec<(f64, f64)>,
) -> Result<(), StudyError> {
    let colour = COLOURS[series.colour % COLOURS.len()];
    let line = colour.stroke_width(2);
    let drawn = match series.style {
        Style::Dashed => chart.draw_series(DashedLineSeries::new(points, 7, 5, line)),
        Style::Line => chart.draw_series(LineSeries::new(points, line)),
        Style::Dots => chart.draw_series(LineSeries::new(points, line).point_size(3)),
        Style::Rings => chart.draw_series(points.into_iter().map(|p| Circle::new(p, 4, line))),
    };
    let drawn = drawn.map_err(failed)?;
    if !series.label.is_empty() {
        let dashed = series.style == Style::Dashed;
        drawn.label(&series.label).legend(move |(x, y)| key(x, y, line, dashed));
    }
    Ok(())
}

/// The short line beside an entry of the legend.
fn key(x: i32, y: i32, line: ShapeStyle, dashed: bool) -> PathElement<(i32, i32)> {
    // A legend takes one element: a dashed key is its first dash.
    let length = if dashed { 9 } else { 22 };
    PathElement::new(vec![(x, y), (x + length, y)], line)
}

fn legend<'a, 'b: 'a>(
    chart: &mut ChartContext<'a, SVGBackend<'b>, Plane<'b>>,
    corner: SeriesLabelPosition,
) -> Result<(), StudyError> {
    chart
        .configure_series_labels()
        .position(corner)
        .margin(8)
        .background_style(WHITE.mix(0.85))
        .border_style(GRID)
        .label_font((FONT, 14, &INK))
        .draw()
        .map_err(failed)
}

/// The corner in which a legend hides the fewest points.
fn emptiest_corner<'a>(
    points: impl Iterator<Item = &'a (f64, f64)> + Clone,
    xs: &Range<f64>,
    ys: &Range<f64>,
) -> SeriesLabelPosition {
    // A legend covers about half of the width and a quarter of the height.
    let share = |v: f64, range: &Range<f64>| (v - range.start) / (range.end - range.start);
    let hidden = |right: bool, upper: bool| {
        let inside = |p: &&(f64, f64)| {
            let (x, y) = (share(p.0, xs), share(p.1, ys));
            (if right { x > 0.5 } else { x < 0.5 }) && (if upper { y > 0.75 } else { y < 0.25 })
        };
        points.clone().filter(inside).count()
    };
    [
        (hidden(true, true), SeriesLabelPosition::UpperRight),
        (hidden(false, true), SeriesLabelPosition::UpperLeft),
        (hidden(true, false), SeriesLabelPosition::LowerRight),
        (hidden(false, false), SeriesLabelPosition::LowerLeft),
    ]
    .into_iter()
    .min_by_key(|(count, _)| *count)
    .map_or(SeriesLabelPosition::UpperRight, |(_, corner)| corner)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_figure_holds_its_words() {
        let series = vec![
            Series::line("true", 0, vec![(0.0, 1.0), (1.0, 2.0)]),
            Series::dashed("identified", 1, vec![(0.0, 1.1), (1.0, 1.9)]),
        ];
        let (x, y) = (Axis::linear("time (s)"), Axis::log("error (rad)"));
        let svg = line_figure(&[Panel { title: "Regulator", x, y, series }]).unwrap();
        for word in ["Regulator", "time (s)", "error (rad)", "true", "identified"] {
            assert!(svg.contains(word), "{word}");
        }
    }

    #[test]
    fn the_legend_avoids_the_curve() {
        let falling: Vec<(f64, f64)> =
            (0..10).map(|k| (f64::from(k), 9.0 - f64::from(k))).collect();
        let corner =
            |points: &[(f64, f64)]| emptiest_corner(points.iter(), &(0.0..9.0), &(0.0..9.0));
        assert!(matches!(corner(&falling), SeriesLabelPosition::UpperRight));
        let rising: Vec<(f64, f64)> = falling.iter().map(|&(x, y)| (x, 9.0 - y)).collect();
        assert!(matches!(corner(&rising), SeriesLabelPosition::UpperLeft));
    }

    #[test]
    fn nothing_to_draw_is_an_error() {
        let axis = Axis::linear("x");
        let series = vec![Series::line("none", 0, vec![(f64::NAN, f64::NAN)])];
        assert!(line_figure(&[Panel { title: "", x: axis, y: axis, series }]).is_err());
    }
}
