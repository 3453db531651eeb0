//! A diagram: axes, bands, lines and marks.

use super::limits::Limits;
use super::look::{GRID, INK, TEXT, font, stroke};
use super::pieces::pieces;
use super::tick::tick;
use super::{Area, Band, Drawn, Figure, Line, Rug, failed};
use plotters::coord::types::RangedCoordf64;
use plotters::prelude::*;
use std::ops::Range;

type Plane<'a> = Cartesian2d<RangedCoordf64, RangedCoordf64>;

/// Height of a rug's marks as a share of the diagram's.
const RUG: f64 = 0.05;

/// The axes, and what a figure shows within its limits.
pub(super) fn plot(area: &Area, figure: &Figure, (xs, ys): Limits) -> Drawn {
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
    if let Some(rug) = &figure.rug {
        draw_rug(&mut chart, rug, &xs, &ys)?;
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

fn draw_rug(
    chart: &mut ChartContext<SVGBackend, Plane>,
    rug: &Rug,
    xs: &Range<f64>,
    ys: &Range<f64>,
) -> Drawn {
    let top = ys.start + RUG * (ys.end - ys.start);
    let seen = rug.at.iter().filter(|x| xs.contains(x) || **x == xs.end);
    let mark = |&x: &f64| PathElement::new(vec![(x, ys.start), (x, top)], INK.stroke_width(2));
    chart.draw_series(seen.map(mark)).map_err(failed)?;
    Ok(())
}
