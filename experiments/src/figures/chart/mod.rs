//! Line charts, box plots and tables as SVG, in one style.

mod boxes;
mod line;
mod matrix;
mod tick;

use plotters::coord::Shift;
use plotters::coord::types::RangedCoordf64;
use plotters::prelude::*;
use std::ops::Range;

use crate::StudyError;

pub use boxes::{Samples, box_figure};
pub use line::{Panel, Series, Style, line_figure};
pub use matrix::{Matrix, matrix_figure};

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
