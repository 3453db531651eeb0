//! The axes of a diagram.

use super::axis::Scale;
use super::frame::Frame;
use super::limits::Limits;
use super::look::{GRID, INK, TEXT, font};
use super::tick::{tick, ticks};
use super::{Area, ChartError, Figure, failed};
use plotters::coord::ranged1d::{DefaultFormatting, KeyPointHint, Ranged};
use plotters::coord::types::RangedCoordf64;
use plotters::prelude::*;
use std::ops::Range;

/// Which axis is drawn: each is a layer of its own, so that a script can change the horizontal
/// one.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Side {
    Horizontal,
    Vertical,
}

/// A range of places along an axis with the ticks of its scale.
struct Marked {
    places: RangedCoordf64,
    ticks: Vec<f64>,
}

impl Marked {
    fn new(range: &Range<f64>, scale: &Scale) -> Self {
        Self { places: range.clone().into(), ticks: ticks(range, scale) }
    }
}

impl Ranged for Marked {
    type FormatOption = DefaultFormatting;
    type ValueType = f64;

    fn map(&self, value: &f64, limit: (i32, i32)) -> i32 {
        self.places.map(value, limit)
    }

    fn key_points<Hint: KeyPointHint>(&self, hint: Hint) -> Vec<f64> {
        // What is allowed to be light would be lines between the ticks.
        if hint.weight().allow_light_points() { Vec::new() } else { self.ticks.clone() }
    }

    fn range(&self) -> Range<f64> {
        self.places.range()
    }
}

/// One axis with its grid; returns where the plane is.
pub(super) fn axis(
    area: &Area,
    figure: &Figure,
    (xs, ys): Limits,
    side: Side,
) -> Result<Frame, ChartError> {
    let mut chart = ChartBuilder::on(area)
        .margin_top(6)
        .margin_right(34)
        .margin_left(12)
        .x_label_area_size(98)
        .y_label_area_size(132)
        .build_cartesian_2d(Marked::new(&xs, &figure.x.scale), Marked::new(&ys, &figure.y.scale))
        .map_err(failed)?;
    let (across, down) = chart.plotting_area().get_pixel_range();
    let in_x = |v: &f64| tick(*v, &xs, &figure.x.scale);
    let in_y = |v: &f64| tick(*v, &ys, &figure.y.scale);
    let below = figure.x.label();
    let mut mesh = chart.configure_mesh();
    mesh.light_line_style(TRANSPARENT)
        .bold_line_style(GRID.stroke_width(2))
        .axis_style(INK.stroke_width(2))
        .label_style(font(TEXT - 3))
        .axis_desc_style(font(TEXT))
        .x_label_formatter(&in_x)
        .y_label_formatter(&in_y);
    match side {
        Side::Horizontal => mesh.disable_y_mesh().disable_y_axis().x_desc(&below),
        Side::Vertical => mesh.disable_x_mesh().disable_x_axis(),
    };
    mesh.draw().map_err(failed)?;
    Ok(Frame::new(across, down, (xs.clone(), ys.clone())))
}
