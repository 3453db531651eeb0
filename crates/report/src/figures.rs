//! Line figures as SVG text, in one look.
//!
//! A figure brings its own colours for light and dark surroundings and scales with its
//! container. The same colours mean the same everywhere: what was measured is ink, the model
//! as it was is [`Colour::Vermilion`], what Lacuna says is [`Colour::Blue`].

use maud::{PreEscaped, html};
use plotters::coord::Shift;
use plotters::coord::types::RangedCoordf64;
use plotters::prelude::*;
use std::ops::Range;

/// Units of the drawing: twice those of a phone's width, since coordinates are whole numbers.
const SIZE: (u32, u32) = (920, 600);
const TEXT: i32 = 40;
const ROW: i32 = 48;
const FONT: &str = "sans-serif";
/// Mean advance of a character in units of the font size.
const ADVANCE: f64 = 0.47;
const LINE: u32 = 4;
const BROAD: u32 = 12;
/// The width that stands for a dashed line while drawing: plotters would draw each dash as
/// an element of its own.
const DASHED: u32 = 5;
const INK: RGBColor = RGBColor(0x33, 0x38, 0x3F);
const GRID: RGBColor = RGBColor(0xDD, 0xE1, 0xE6);
/// Ink and grid change with the surroundings; the data's colours are readable on both.
const STYLE: &str = "@media screen and (prefers-color-scheme: dark){\
.lacuna-figure [fill=\"#33383F\"]{fill:#D9DDE3}.lacuna-figure [stroke=\"#33383F\"]{stroke:#D9DDE3}\
.lacuna-figure [stroke=\"#DDE1E6\"]{stroke:#363C45}}";

type Area<'a> = DrawingArea<SVGBackend<'a>, Shift>;
type Plane<'a> = Cartesian2d<RangedCoordf64, RangedCoordf64>;
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
    /// Abscissa, lower and upper edge.
    pub edges: Vec<(f64, f64, f64)>,
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
    /// Values beyond which curves are cut off; all are shown without it.
    pub within: Option<(f64, f64)>,
}

/// The figure as SVG text, as wide as its container.
///
/// # Errors
/// [`FigureError::Empty`] when no line has a finite point in view.
pub fn svg(figure: &Figure) -> Result<String, FigureError> {
    let (xs, ys) = limits(figure)?;
    let mut text = String::new();
    {
        let root = SVGBackend::with_string(&mut text, SIZE).into_drawing_area();
        let top = legend(&root, figure)?;
        label(&root, &figure.y, (12, top))?;
        let (_, plane) = root.split_vertically(top + ROW);
        draw(&plane, figure, xs, ys)?;
        root.present().map_err(failed)?;
    }
    Ok(dress(&text, &figure.description))
}

fn failed(error: impl std::fmt::Display) -> FigureError {
    FigureError::Drawing { reason: error.to_string() }
}

/// Replace the opening tag by one that scales, with the words and the colours.
fn dress(text: &str, description: &str) -> String {
    let body = text.split_once('>').map_or(text, |(_, body)| body);
    let dashed = format!("stroke-width=\"{DASHED}\"");
    let body = body.replace(&dashed, &format!("stroke-width=\"{LINE}\" stroke-dasharray=\"14 9\""));
    let (width, height) = SIZE;
    let body = body.strip_suffix("</svg>\n").or(body.strip_suffix("</svg>")).unwrap_or(&body);
    html! {
        svg class="lacuna-figure" xmlns="http://www.w3.org/2000/svg" role="img"
            aria-label=(description) width="100%" viewBox={ "0 0 " (width) " " (height) } {
            title { (description) }
            style { (PreEscaped(STYLE)) }
            (PreEscaped(body))
        }
    }
    .into_string()
}

fn limits(figure: &Figure) -> Result<(Range<f64>, Range<f64>), FigureError> {
    let lines = || figure.lines.iter().flat_map(|l| l.points.iter().copied());
    let edges = figure.bands.iter().flat_map(|b| &b.edges);
    let points = lines().chain(edges.flat_map(|e| [(e.0, e.1), (e.0, e.2)]));
    let empty = || FigureError::Empty { lines: figure.lines.len() };
    let finite: Vec<_> = points.filter(|p| p.0.is_finite() && p.1.is_finite()).collect();
    let (low, high) = figure.within.unwrap_or((f64::NEG_INFINITY, f64::INFINITY));
    let seen = finite.iter().map(|p| p.1).filter(|y| (low..=high).contains(y));
    let xs = extent(finite.iter().map(|p| p.0), 0.0).ok_or_else(empty)?;
    Ok((xs, extent(seen, 0.05).ok_or_else(empty)?))
}

/// The range of values, widened at both ends by a share of its length.
fn extent(values: impl Iterator<Item = f64>, share: f64) -> Option<Range<f64>> {
    let (low, high) =
        values.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), v| (a.min(v), b.max(v)));
    // Beyond the square root of the largest number the axis arithmetic overflows.
    if low > high || low < -1e150 || high > 1e150 {
        return None;
    }
    let length = high - low;
    // A flat line, up to rounding, stands in the middle.
    let flat = length <= 1e-12 * low.abs().max(high.abs());
    let margin = match flat {
        true if low == 0.0 => 1.0,
        true => 0.1 * low.abs(),
        false => share * length,
    };
    Some(low - margin..high + margin)
}

fn font(size: i32) -> TextStyle<'static> {
    (FONT, size).into_font().color(&INK)
}

fn label(area: &Area, text: &str, at: (i32, i32)) -> Drawn {
    area.draw(&Text::new(text.to_owned(), at, font(TEXT))).map_err(failed)
}

/// The legend above the diagram, where it hides nothing; returns its height.
fn legend(area: &Area, figure: &Figure) -> Result<i32, FigureError> {
    let filled = |b: &Band| b.colour.rgb().mix(0.25).filled();
    let bands = figure.bands.iter().map(|b| (&b.label, filled(b), 16));
    let lines = figure.lines.iter().map(|l| (&l.label, stroke(l), 0));
    let (mut x, mut y) = (12, 8);
    for (text, style, half) in lines.chain(bands) {
        let length = 62 + (ADVANCE * f64::from(TEXT) * text.chars().count() as f64) as i32;
        if x > 12 && x + length > SIZE.0 as i32 {
            (x, y) = (12, y + ROW);
        }
        let middle = y + TEXT / 2;
        let key = [(x, middle - half), (x + 44, middle + half)];
        match style.filled {
            true => area.draw(&Rectangle::new(key, style)),
            false => area.draw(&PathElement::new(key.to_vec(), style)),
        }
        .map_err(failed)?;
        label(area, text, (x + 54, y))?;
        x += length + 26;
    }
    Ok(y + ROW)
}

/// Colour and width of a line.
fn stroke(line: &Line) -> ShapeStyle {
    let colour = line.colour.rgb();
    match line.style {
        Style::Solid => colour.stroke_width(LINE),
        Style::Dashed => colour.stroke_width(DASHED),
        Style::Broad => colour.mix(0.4).stroke_width(BROAD),
    }
}

fn draw(area: &Area, figure: &Figure, xs: Range<f64>, ys: Range<f64>) -> Drawn {
    let mut chart = ChartBuilder::on(area)
        .margin_top(6)
        .margin_right(34)
        .margin_left(12)
        .x_label_area_size(98)
        .y_label_area_size(132)
        .build_cartesian_2d(xs.clone(), ys.clone())
        .map_err(failed)?;
    chart
        .configure_mesh()
        .light_line_style(TRANSPARENT)
        .bold_line_style(GRID.stroke_width(2))
        .axis_style(INK.stroke_width(2))
        .x_desc(&figure.x)
        .x_labels(6)
        .y_labels(6)
        .x_label_formatter(&|v| tick(*v, &xs))
        .y_label_formatter(&|v| tick(*v, &ys))
        .label_style(font(TEXT - 3))
        .axis_desc_style(font(TEXT))
        .draw()
        .map_err(failed)?;
    for band in &figure.bands {
        draw_band(&mut chart, band, &ys)?;
    }
    for line in &figure.lines {
        draw_line(&mut chart, line, &ys)?;
    }
    Ok(())
}

fn draw_band(chart: &mut ChartContext<SVGBackend, Plane>, band: &Band, ys: &Range<f64>) -> Drawn {
    let finite = |e: &&(f64, f64, f64)| e.0.is_finite() && e.1.is_finite() && e.2.is_finite();
    let edges: Vec<_> = band.edges.iter().filter(finite).collect();
    let cut = |y: f64| y.clamp(ys.start, ys.end);
    let lower = edges.iter().map(|e| (e.0, cut(e.1)));
    let upper = edges.iter().rev().map(|e| (e.0, cut(e.2)));
    let outline: Vec<_> = lower.chain(upper).collect();
    let shape = Polygon::new(outline, band.colour.rgb().mix(0.25));
    chart.draw_series([shape]).map_err(failed)?;
    Ok(())
}

fn draw_line(chart: &mut ChartContext<SVGBackend, Plane>, line: &Line, ys: &Range<f64>) -> Drawn {
    let style = stroke(line);
    let pieces = pieces(&line.points, ys);
    chart.draw_series(pieces.into_iter().map(|p| PathElement::new(p, style))).map_err(failed)?;
    Ok(())
}

/// The pieces of a line between gaps and inside a range of values.
fn pieces(points: &[(f64, f64)], ys: &Range<f64>) -> Vec<Vec<(f64, f64)>> {
    let mut pieces: Vec<Vec<(f64, f64)>> = vec![vec![]];
    for pair in points.windows(2) {
        let Some((from, to)) = inside(pair[0], pair[1], ys) else {
            pieces.push(vec![]);
            continue;
        };
        match pieces.last_mut() {
            Some(piece) if piece.last() == Some(&from) => piece.push(to),
            _ => pieces.push(vec![from, to]),
        }
    }
    pieces.retain(|p| !p.is_empty());
    pieces
}

/// The part of a segment inside a range of values; its ends are kept exactly where they
/// are inside.
fn inside(a: (f64, f64), b: (f64, f64), ys: &Range<f64>) -> Option<((f64, f64), (f64, f64))> {
    let finite = [a.0, a.1, b.0, b.1].iter().all(|v| v.is_finite());
    let apart = a.1.max(b.1) < ys.start || a.1.min(b.1) > ys.end;
    if !finite || apart {
        return None;
    }
    let end = |p: (f64, f64)| {
        let y = p.1.clamp(ys.start, ys.end);
        if y == p.1 {
            return p;
        }
        (a.0 + (b.0 - a.0) * ((y - a.1) / (b.1 - a.1)), y)
    };
    Some((end(a), end(b)))
}

/// Text of a tick: as many digits as the range needs, without trailing zeros.
fn tick(value: f64, range: &Range<f64>) -> String {
    let length = range.end - range.start;
    if value.abs() < 1e-9 * length {
        return "0".to_owned();
    }
    let digits = 1.5 - length.log10();
    let largest = range.start.abs().max(range.end.abs());
    if !(2e-3..1e5).contains(&largest) {
        let digits = (digits + largest.log10()).ceil().clamp(0.0, 9.0) as usize;
        let text = format!("{value:.digits$e}");
        let (number, power) = text.split_once('e').unwrap_or((&text, "0"));
        return format!("{}e{power}", trim(number));
    }
    let digits = digits.ceil().clamp(0.0, 9.0) as usize;
    trim(&format!("{value:.digits$}")).to_owned()
}

fn trim(number: &str) -> &str {
    match number.contains('.') {
        true => number.trim_end_matches('0').trim_end_matches('.'),
        false => number,
    }
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
            within: None,
        }
    }

    #[test]
    fn a_figure_holds_its_words_escaped() {
        let svg = svg(&figure(vec![(0.0, 1.0), (1.0, 2.0)])).unwrap();
        for word in ["velocity (m/s)", "force (N)", "a&lt;b", "Force &amp; &quot;law&quot;"] {
            assert!(svg.contains(word), "{word}");
        }
        assert!(svg.contains("stroke-dasharray"));
        assert!(svg.starts_with("<svg") && svg.ends_with("</svg>"));
        assert_eq!(svg.matches("</svg>").count(), 1);
    }

    #[test]
    fn nothing_to_draw_is_an_error() {
        let empty = svg(&figure(vec![(f64::NAN, 1.0), (0.0, f64::INFINITY)]));
        assert_eq!(empty, Err(FigureError::Empty { lines: 1 }));
        assert_eq!(svg(&figure(vec![])), Err(FigureError::Empty { lines: 1 }));
    }

    #[test]
    fn lines_are_cut_at_gaps_and_at_the_edge_of_the_view() {
        let points = [(0.0, 0.0), (1.0, 2.0), (2.0, 0.0), (3.0, f64::NAN), (4.0, 0.0), (5.0, 0.5)];
        let expected = [
            vec![(0.0, 0.0), (0.5, 1.0)],
            vec![(1.5, 1.0), (2.0, 0.0)],
            vec![(4.0, 0.0), (5.0, 0.5)],
        ];
        assert_eq!(pieces(&points, &(-1.0..1.0)), expected);
        let across = pieces(&[(0.0, -3.0), (1.0, 3.0)], &(-1.5..1.5));
        assert_eq!(across, [vec![(0.25, -1.5), (0.75, 1.5)]]);
    }

    #[test]
    fn flat_lines_and_wide_ranges_have_limits() {
        assert_eq!(extent([0.0, 0.0].into_iter(), 0.1), Some(-1.0..1.0));
        assert_eq!(extent([5.0].into_iter(), 0.1), Some(4.5..5.5));
        assert_eq!(extent([f64::MIN, f64::MAX].into_iter(), 0.1), None);
    }

    #[test]
    fn ticks_have_the_digits_that_the_range_needs() {
        let table = [
            (0.25, 0.0..1.0, "0.25"),
            (-0.0, -5.0..5.0, "0"),
            (20.0, 0.0..100.0, "20"),
            (0.0005, 0.0..0.001, "5e-4"),
            (250_000.0, 0.0..1e6, "2.5e5"),
            (1000.5, 1000.0..1001.0, "1000.5"),
        ];
        for (value, range, expected) in table {
            assert_eq!(tick(value, &range), expected);
        }
    }
}
