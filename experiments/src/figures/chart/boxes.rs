//! Box plots.

use plotters::prelude::*;

use super::tick::tick;
use super::{Area, COLOURS, FONT, GRID, INK, Plane, Scale, extent, failed, figure, frame};
use crate::StudyError;
use crate::statistics::quantile;

/// Samples of one box of a box plot.
#[derive(Clone, Debug)]
pub struct Samples<'a> {
    /// Label under the box.
    pub label: &'a str,
    /// The values.
    pub values: Vec<f64>,
}

/// Draw one box plot a panel: median, quartiles, whiskers to the last value within 1.5
/// interquartile ranges, and the values beyond as dots. The axis of a panel is logarithmic where the
/// greatest value is more than ten times the smallest median.
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

fn box_panel(area: &Area, title: &str, y_label: &str, boxes: &[Samples]) -> Result<(), StudyError> {
    let scale = scale(boxes);
    let ys = extent(boxes.iter().flat_map(|b| b.values.iter().map(|v| scale.place(*v))), 0.06)?;
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
        .y_label_formatter(&|v| tick(*v, &ys, scale))
        .label_style((FONT, 14, &INK))
        .axis_desc_style((FONT, 16, &INK))
        .draw()
        .map_err(failed)?;
    for (k, samples) in boxes.iter().enumerate() {
        draw_box(&mut chart, k, &samples.values, scale)?;
    }
    Ok(())
}

/// Logarithmic for values that span more than a decade, as [`box_figure`] says.
fn scale(boxes: &[Samples]) -> Scale {
    let over = |q: f64| boxes.iter().map(move |b| quantile(&b.values, q));
    let lowest = over(0.0).fold(f64::INFINITY, f64::min);
    let median = over(0.5).fold(f64::INFINITY, f64::min);
    let greatest = over(1.0).fold(f64::NEG_INFINITY, f64::max);
    if lowest > 0.0 && greatest > 10.0 * median { Scale::Log } else { Scale::Linear }
}

fn draw_box(
    chart: &mut ChartContext<SVGBackend, Plane>,
    k: usize,
    values: &[f64],
    scale: Scale,
) -> Result<(), StudyError> {
    let (low, middle, high) =
        (quantile(values, 0.25), quantile(values, 0.5), quantile(values, 0.75));
    let reach = 1.5 * (high - low);
    let inside = |v: &f64| (low - reach..=high + reach).contains(v);
    let (within, beyond): (Vec<f64>, Vec<f64>) = values.iter().partition(|v| inside(v));
    // Quartiles and whiskers are those of the values, whatever the scale they are drawn on.
    let [bottom, low, middle, high, top] =
        [quantile(&within, 0.0), low, middle, high, quantile(&within, 1.0)].map(|v| scale.place(v));
    let (x, half) = (k as f64, 0.18);
    let colour = COLOURS[(k + 1) % COLOURS.len()];
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
    let dots =
        beyond.iter().map(|v| Circle::new((x, scale.place(*v)), 2, colour.mix(0.6).filled()));
    chart.draw_series(dots).map_err(failed)?;
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn wild_values_make_the_axis_logarithmic() {
        let samples = |values: &[f64]| Samples { label: "", values: values.to_vec() };
        assert_eq!(scale(&[samples(&[1.0, 2.0, 3.0]), samples(&[4.0, 9.0])]), Scale::Linear);
        assert_eq!(scale(&[samples(&[1.0, 2.0, 3.0]), samples(&[4.0, 21.0])]), Scale::Log);
        assert_eq!(scale(&[samples(&[0.0, 2.0, 21.0])]), Scale::Linear);
    }
}
