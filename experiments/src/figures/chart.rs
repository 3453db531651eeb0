//! Line charts and box plots as SVG, in one style.

use plotters::coord::Shift;
use plotters::coord::types::RangedCoordf64;
use plotters::prelude::*;
use plotters::series::DashedLineSeries;
use std::ops::Range;

use crate::StudyError;
use crate::statistics::quantile;

/// Okabe and Ito's colours, which colour-blind readers can tell apart.
const COLOURS: [RGBColor; 6] = [
    RGBColor(0, 114, 178),
    RGBColor(213, 94, 0),
    RGBColor(0, 158, 115),
    RGBColor(204, 121, 167),
    RGBColor(230, 159, 0),
    RGBColor(86, 180, 233),
];
const INK: RGBColor = RGBColor(40, 40, 40);
const GRID: RGBColor = RGBColor(225, 225, 225);
const PANEL: (u32, u32) = (520, 400);
const FONT: &str = "sans-serif";

type Area<'a> = DrawingArea<SVGBackend<'a>, Shift>;
type Plane<'a> = Cartesian2d<RangedCoordf64, RangedCoordf64>;

/// How a series is drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Style {
    /// A solid line.
    Line,
    /// A dashed line.
    Dashed,
    /// A solid line with a dot at each point.
    Dots,
}

/// One curve.
#[derive(Clone, Debug)]
pub struct Series {
    /// Entry of the legend.
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
}

/// Scale of an axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Scale {
    /// Equal steps.
    Linear,
    /// Equal factors; values must be positive.
    Log,
}

impl Scale {
    fn place(self, value: f64) -> f64 {
        match self {
            Self::Linear => value,
            Self::Log => value.max(f64::MIN_POSITIVE).log10(),
        }
    }
}

/// An axis: what it shows, with its unit, and how.
#[derive(Clone, Copy, Debug)]
pub struct Axis<'a> {
    /// Label, with the unit in parentheses.
    pub label: &'a str,
    /// Scale.
    pub scale: Scale,
}

impl<'a> Axis<'a> {
    /// A linear axis.
    pub fn linear(label: &'a str) -> Self {
        Self { label, scale: Scale::Linear }
    }

    /// A logarithmic axis.
    pub fn log(label: &'a str) -> Self {
        Self { label, scale: Scale::Log }
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

/// Samples of one box of a box plot.
#[derive(Clone, Debug)]
pub struct Samples<'a> {
    /// Label under the box.
    pub label: &'a str,
    /// The values.
    pub values: Vec<f64>,
}

/// Draw one box plot a panel: median, quartiles, whiskers to the last value within 1.5
/// interquartile ranges, and the values beyond as dots.
///
/// # Errors
/// [`StudyError::Figure`] when there is nothing finite to draw.
pub fn box_figure(
    titles: &[&str],
    y_label: &str,
    panels: &[Vec<Samples>],
) -> Result<String, StudyError> {
    figure(panels.len(), |area, k| box_panel(area, titles[k], y_label, &panels[k]))
}

fn figure(
    count: usize,
    draw: impl Fn(&Area, usize) -> Result<(), StudyError>,
) -> Result<String, StudyError> {
    let mut svg = String::new();
    {
        let size = (PANEL.0 * count as u32, PANEL.1);
        let root = SVGBackend::with_string(&mut svg, size).into_drawing_area();
        root.fill(&WHITE).map_err(failed)?;
        for (k, area) in root.split_evenly((1, count)).iter().enumerate() {
            draw(area, k)?;
        }
        root.present().map_err(failed)?;
    }
    Ok(svg)
}

fn failed(error: impl std::fmt::Display) -> StudyError {
    StudyError::Figure { reason: error.to_string() }
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

fn frame<'a, 'b: 'a>(
    area: &'a Area<'b>,
    title: &str,
    xs: Range<f64>,
    ys: Range<f64>,
) -> Result<ChartContext<'a, SVGBackend<'b>, Plane<'b>>, StudyError> {
    ChartBuilder::on(area)
        .caption(title, (FONT, 18, &INK))
        .margin(12)
        .margin_right(24)
        .x_label_area_size(48)
        .y_label_area_size(68)
        .build_cartesian_2d(xs, ys)
        .map_err(failed)
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
    };
    let dashed = series.style == Style::Dashed;
    drawn.map_err(failed)?.label(&series.label).legend(move |(x, y)| key(x, y, line, dashed));
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

fn box_panel(area: &Area, title: &str, y_label: &str, boxes: &[Samples]) -> Result<(), StudyError> {
    let ys = extent(boxes.iter().flat_map(|b| b.values.iter().copied()), 0.06)?;
    let mut chart = frame(area, title, -0.5..boxes.len() as f64 - 0.5, ys.clone())?;
    let name = |v: &f64| match (v - v.round()).abs() < 1e-6 {
        true => boxes.get(v.round() as usize).map_or(String::new(), |b| b.label.into()),
        false => String::new(),
    };
    chart
        .configure_mesh()
        .disable_x_mesh()
        .light_line_style(TRANSPARENT)
        .bold_line_style(GRID)
        .axis_style(INK)
        .y_desc(y_label)
        .x_labels(2 * boxes.len() + 1)
        .y_labels(7)
        .x_label_formatter(&name)
        .y_label_formatter(&|v| tick(*v, &ys, Scale::Linear))
        .label_style((FONT, 14, &INK))
        .axis_desc_style((FONT, 16, &INK))
        .draw()
        .map_err(failed)?;
    for (k, samples) in boxes.iter().enumerate() {
        draw_box(&mut chart, k, &samples.values)?;
    }
    Ok(())
}

fn draw_box(
    chart: &mut ChartContext<SVGBackend, Plane>,
    k: usize,
    values: &[f64],
) -> Result<(), StudyError> {
    let (low, middle, high) =
        (quantile(values, 0.25), quantile(values, 0.5), quantile(values, 0.75));
    let reach = 1.5 * (high - low);
    let inside = |v: &f64| (low - reach..=high + reach).contains(v);
    let (within, beyond): (Vec<f64>, Vec<f64>) = values.iter().partition(|v| inside(v));
    let (bottom, top) = (quantile(&within, 0.0), quantile(&within, 1.0));
    let (x, half) = (k as f64, 0.18);
    let colour = COLOURS[k % COLOURS.len()];
    let bar = |y: f64, width: f64| vec![(x - width, y), (x + width, y)];
    let strokes = [
        (vec![(x, bottom), (x, low)], 1),
        (vec![(x, high), (x, top)], 1),
        (bar(bottom, 0.5 * half), 1),
        (bar(top, 0.5 * half), 1),
        (bar(middle, half), 3),
    ];
    let filled = Rectangle::new([(x - half, low), (x + half, high)], colour.mix(0.25).filled());
    let edge = Rectangle::new([(x - half, low), (x + half, high)], colour.stroke_width(1));
    chart.draw_series([filled, edge]).map_err(failed)?;
    let lines = strokes.map(|(path, width)| PathElement::new(path, colour.stroke_width(width)));
    chart.draw_series(lines).map_err(failed)?;
    let dots = beyond.iter().map(|v| Circle::new((x, *v), 2, colour.mix(0.6).filled()));
    chart.draw_series(dots).map_err(failed)?;
    Ok(())
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

/// The range of finite values, widened at both ends by a share of its length.
fn extent(values: impl Iterator<Item = f64>, share: f64) -> Result<Range<f64>, StudyError> {
    let finite = values.filter(|v| v.is_finite());
    let (low, high) =
        finite.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), v| (a.min(v), b.max(v)));
    if low > high {
        return Err(failed("there are no finite values to draw"));
    }
    let margin = match high > low {
        true => share * (high - low),
        false => 0.5,
    };
    Ok(low - margin..high + margin)
}

/// Text of a tick: as many digits as the range needs, without trailing zeros.
fn tick(value: f64, range: &Range<f64>, scale: Scale) -> String {
    let length = range.end - range.start;
    match scale {
        Scale::Linear => decimal(value, 1.5 - length.log10()),
        Scale::Log if length > 4.0 => power_of_ten(value),
        Scale::Log => decimal(10_f64.powf(value), 1.0 - value.floor()),
    }
}

fn decimal(value: f64, digits: f64) -> String {
    let digits = digits.ceil().clamp(0.0, 8.0) as usize;
    let text = format!("{value:.digits$}");
    let short = match text.contains('.') {
        true => text.trim_end_matches('0').trim_end_matches('.'),
        false => &text,
    };
    if short == "-0" { "0".into() } else { short.into() }
}

/// `10` with a superscript exponent; nothing between whole powers.
fn power_of_ten(exponent: f64) -> String {
    if (exponent - exponent.round()).abs() > 1e-6 {
        return String::new();
    }
    let superscript = |c: char| match c {
        '-' => '\u{207b}',
        '1' => '\u{b9}',
        '2' => '\u{b2}',
        '3' => '\u{b3}',
        digit => char::from_u32(0x2070 + digit.to_digit(10).unwrap_or(0)).unwrap_or(digit),
    };
    let text = (exponent.round() as i32).to_string();
    format!("10{}", text.chars().map(superscript).collect::<String>())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ticks_say_what_they_mean() {
        assert_eq!(tick(-3.0, &(-13.0..7.0), Scale::Log), "10\u{207b}\u{b3}");
        assert_eq!(tick(0.5, &(-13.0..7.0), Scale::Log), "");
        assert_eq!(tick(0.25, &(0.0..1.0), Scale::Linear), "0.25");
        assert_eq!(tick(-0.0, &(-5.0..5.0), Scale::Linear), "0");
        assert_eq!(tick(20.0, &(0.0..100.0), Scale::Linear), "20");
        assert_eq!(tick(-3.0, &(-3.0..3.0), Scale::Linear), "-3");
        assert_eq!(tick(-0.5, &(-1.0..1.0), Scale::Log), "0.32");
    }

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
