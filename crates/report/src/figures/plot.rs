//! The axes of a diagram.

use super::frame::Frame;
use super::limits::Limits;
use super::look::{GRID, INK, TEXT, font};
use super::tick::tick;
use super::{Area, Figure, FigureError, failed};
use plotters::prelude::*;

/// Which axis is drawn: each is a layer of its own, so that a script can change the horizontal
/// one.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Axis {
    Horizontal,
    Vertical,
}

/// One axis with its grid; returns where the plane is.
pub(super) fn axis(
    area: &Area,
    figure: &Figure,
    (xs, ys): Limits,
    axis: Axis,
) -> Result<Frame, FigureError> {
    let mut chart = ChartBuilder::on(area)
        .margin_top(6)
        .margin_right(34)
        .margin_left(12)
        .x_label_area_size(98)
        .y_label_area_size(132)
        .build_cartesian_2d(xs.clone(), ys.clone())
        .map_err(failed)?;
    let (across, down) = chart.plotting_area().get_pixel_range();
    let (in_x, in_y) = (|v: &f64| tick(*v, &xs), |v: &f64| tick(*v, &ys));
    let mut mesh = chart.configure_mesh();
    mesh.light_line_style(TRANSPARENT)
        .bold_line_style(GRID.stroke_width(2))
        .axis_style(INK.stroke_width(2))
        .label_style(font(TEXT - 3))
        .axis_desc_style(font(TEXT))
        .x_label_formatter(&in_x)
        .y_label_formatter(&in_y)
        .x_labels(6)
        .y_labels(6);
    match axis {
        Axis::Horizontal => mesh.disable_y_mesh().disable_y_axis().x_desc(&figure.x),
        Axis::Vertical => mesh.disable_x_mesh().disable_x_axis(),
    };
    mesh.draw().map_err(failed)?;
    Ok(Frame::new(across, down, (xs.clone(), ys.clone())))
}
