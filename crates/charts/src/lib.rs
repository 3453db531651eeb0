//! Charts as SVG text, in one look.
//!
//! A value v stands along its axis at
//!
//! ```text
//! place(v) = v  (linear),   log10 v  (logarithmic),   k  (name number k)
//! ```
//!
//! | chart | drawn by | of |
//! | --- | --- | --- |
//! | lines, marks and bands against one variable | [`svg`] | [`Figure`] |
//! | small multiples under one legend | [`grid_svg`] | [`Grid`] |
//! | box plots | [`svg`], of what [`box_plot`] makes | [`Figure`] |
//! | values before and after in units of another | [`ratios_svg`] | [`Ratios`] |
//! | tables of counts | [`matrix_svg`] | [`Matrix`] |
//!
//! A chart brings its own colours for light and dark surroundings and scales with its container;
//! legends stand above the data, where they hide nothing. The same colours mean the same
//! everywhere: what was measured, or is true, is ink, what it is compared with is
//! [`Colour::Vermilion`], what Lacuna says is [`Colour::Blue`]. A chart knows nothing of what it
//! shows.

mod axis;
mod boxes;
mod curves;
mod frame;
mod grid;
mod legend;
mod limits;
mod look;
mod matrix;
mod pieces;
mod plot;
mod ratios;
mod tick;

pub use axis::{Axis, Scale};
pub use boxes::box_plot;
pub use grid::{Grid, grid_svg};
pub use look::{Size, Surface};
pub use matrix::{Matrix, matrix_svg};
pub use ratios::{Ratio, Ratios, ratios_svg};

use curves::curves;
use frame::Frame;
use legend::{heading, label, legend};
use limits::{Limits, limits};
use look::{INK, ROW, dress};
use maud::{PreEscaped, html};
use plot::{Side, axis};
use plotters::coord::Shift;
use plotters::prelude::*;

type Area<'a> = DrawingArea<SVGBackend<'a>, Shift>;
type Drawn = Result<(), ChartError>;

/// Why a chart cannot be drawn.
#[derive(Debug, thiserror::Error, PartialEq, Eq)]
pub enum ChartError {
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
    /// What was measured, learned from it, or is true.
    Ink,
    /// What Lacuna says.
    Blue,
    /// What that is compared with first: the model as it was.
    Vermilion,
    /// Another.
    Green,
    /// Another.
    Purple,
}

impl Colour {
    fn rgb(self) -> RGBColor {
        match self {
            Self::Ink => INK,
            Self::Blue => RGBColor(0x1F, 0x83, 0xC4),
            Self::Vermilion => RGBColor(0xD5, 0x5E, 0x00),
            Self::Green => RGBColor(0x00, 0x9E, 0x73),
            Self::Purple => RGBColor(0xCC, 0x79, 0xA7),
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
    /// A dot at each point and no line.
    Dots,
    /// A ring at each point and no line.
    Rings,
    /// A thin line with a dot at each point.
    Joined,
}

impl Style {
    /// Whether there is a line through the points.
    fn joins(self) -> bool {
        !matches!(self, Self::Dots | Self::Rings)
    }

    /// Whether there are marks at the points.
    fn marks(self) -> bool {
        matches!(self, Self::Dots | Self::Rings | Self::Joined)
    }
}

/// A curve.
#[derive(Clone, Debug, PartialEq)]
pub struct Line {
    /// Entry of the legend; none where it is empty.
    pub label: String,
    /// Its colour.
    pub colour: Colour,
    /// How it is drawn.
    pub style: Style,
    /// Points in the order in which they are joined; one that is not finite is a gap.
    pub points: Vec<(f64, f64)>,
}

impl Line {
    /// A curve.
    #[must_use]
    pub fn new(label: &str, colour: Colour, style: Style, points: Vec<(f64, f64)>) -> Self {
        Self { label: label.to_owned(), colour, style, points }
    }
}

/// The region between two curves.
#[derive(Clone, Debug, PartialEq)]
pub struct Band {
    /// Entry of the legend; none where it is empty.
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
    /// Heading; none where it is empty.
    pub title: String,
    /// Size.
    pub size: Size,
    /// Horizontal axis.
    pub x: Axis,
    /// Vertical axis.
    pub y: Axis,
    /// Bands, drawn first.
    pub bands: Vec<Band>,
    /// Lines, the last on top.
    pub lines: Vec<Line>,
    /// Marks at the foot, where there are any.
    pub rug: Option<Rug>,
    /// Values beyond which curves are cut off; all are shown without it.
    pub within: Option<(f64, f64)>,
}

impl Figure {
    /// Axes with nothing in them yet.
    #[must_use]
    pub fn new(x: Axis, y: Axis) -> Self {
        Self {
            description: String::new(),
            title: String::new(),
            size: Size::Small,
            x,
            y,
            bands: Vec::new(),
            lines: Vec::new(),
            rug: None,
            within: None,
        }
    }

    /// The same with every value where it is along its axis.
    fn placed(&self) -> Self {
        let (x, y) = (|v| self.x.scale.place(v), |v| self.y.scale.place(v));
        let mut placed = self.clone();
        for point in placed.lines.iter_mut().flat_map(|l| &mut l.points) {
            *point = (x(point.0), y(point.1));
        }
        for edge in placed.bands.iter_mut().flat_map(|b| &mut b.edges) {
            *edge = (x(edge.0), y(edge.1), y(edge.2));
        }
        for at in placed.rug.iter_mut().flat_map(|r| &mut r.at) {
            *at = x(*at);
        }
        placed.within = self.within.map(|(low, high)| (y(low), y(high)));
        placed
    }
}

/// The figure as SVG text, as wide as its container.
///
/// Its curves are paths of the class `line` or `band` in a group of the class `curves`, in
/// tenths of a unit from the upper left corner of the plane. The group tells where that plane is
/// and what it shows: `data-frame` holds left, top, right and bottom (units of the drawing) and
/// the places of the first and last abscissa and ordinate along their axes.
///
/// # Errors
/// [`ChartError::Empty`] when no line has a finite point in view.
pub fn svg(figure: &Figure, surface: Surface) -> Result<String, ChartError> {
    let figure = &figure.placed();
    let (limits, size) = (limits(figure)?, figure.size.units());
    let (mut text, (top, frame)) = layer(size, |root| {
        let top = heading(root, figure)?;
        let top = legend(root, figure, top)?;
        let frame = panel(&root.split_vertically(top).1, figure, &limits, Side::Vertical)?;
        Ok((top, frame))
    })?;
    let (foot, _) = layer(size, |root| {
        panel(&root.split_vertically(top).1, figure, &limits, Side::Horizontal)
    })?;
    text.push_str(&inside(&foot, figure, &frame));
    Ok(dress(&text, &figure.description, size, surface))
}

/// What is drawn, as the inside of an SVG text.
fn layer<T>(
    size: (u32, u32),
    draw: impl FnOnce(&Area) -> Result<T, ChartError>,
) -> Result<(String, T), ChartError> {
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
fn panel(area: &Area, figure: &Figure, limits: &Limits, which: Side) -> Result<Frame, ChartError> {
    let (heading, plane) = area.split_vertically(ROW);
    if which == Side::Vertical {
        label(&heading, &figure.y.label(), (12, 0))?;
    }
    axis(&plane, figure, limits.clone(), which)
}

/// The horizontal axis as a group, and the curves.
fn inside(foot: &str, figure: &Figure, frame: &Frame) -> String {
    let curves = curves(figure, frame);
    html! { g class="x-axis" { (PreEscaped(foot)) } (curves) }.into_string()
}

fn failed(error: impl std::fmt::Display) -> ChartError {
    ChartError::Drawing { reason: error.to_string() }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn figure(points: Vec<(f64, f64)>) -> Figure {
        let line = Line { label: "a<b".into(), colour: Colour::Blue, style: Style::Dashed, points };
        Figure {
            description: "Force & \"law\"".into(),
            lines: vec![line],
            ..Figure::new(Axis::linear("velocity", "m/s"), Axis::linear("force", "N"))
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
    fn logarithmic_figures_leave_out_what_has_no_logarithm() {
        let points = vec![(1.0, 1e-3), (2.0, 0.0), (3.0, 1e-1)];
        let (x, y) = (Axis::linear("trial", ""), Axis::log("error", "m"));
        let lines = vec![Line::new("ours", Colour::Blue, Style::Dots, points)];
        let title = "Errors".to_owned();
        let figure = Figure { title, size: Size::Wide, lines, ..Figure::new(x, y) };
        let svg = svg(&figure, Surface::Own).unwrap();
        assert!(svg.contains("viewBox=\"0 0 1640 940\"") && svg.contains("Errors"));
        let marks = svg.split("class=\"marks\"").nth(1).unwrap();
        assert_eq!(marks.split("/path").next().unwrap().matches("h0").count(), 2);
        for tick in ["0.001\n", "0.01\n", "0.1\n"] {
            assert!(svg.contains(tick), "{tick}");
        }
    }

    #[test]
    fn a_figure_on_paper_is_light_in_the_dark() {
        let drawn = |surface| svg(&figure(vec![(0.0, 1.0), (1.0, 2.0)]), surface).unwrap();
        let (paper, own) = (drawn(Surface::Paper), drawn(Surface::Own));
        assert!(paper.contains("class=\"ground\"") && own.contains("class=\"ground\""));
        assert!(!paper.contains("prefers-color-scheme") && own.contains("prefers-color-scheme"));
    }

    #[test]
    fn nothing_to_draw_is_an_error() {
        let empty = svg(&figure(vec![(f64::NAN, 1.0), (0.0, f64::INFINITY)]), Surface::Own);
        assert_eq!(empty, Err(ChartError::Empty { lines: 1 }));
        assert_eq!(svg(&figure(vec![]), Surface::Own), Err(ChartError::Empty { lines: 1 }));
    }
}
