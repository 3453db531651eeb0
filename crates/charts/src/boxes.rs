//! Box plots: the parts of a figure whose horizontal axis has names.

use super::{Band, Colour, Line, Style};

/// Half the width of a box, and of the ends of whiskers, in steps from name to name.
const BOX: f64 = 0.2;
const END: f64 = 0.1;
/// Whiskers reach to the last value within this many interquartile ranges.
const REACH: f64 = 1.5;

/// The box of values at name number `at`: median, quartiles, whiskers to the last value within
/// 1.5 interquartile ranges, and the values beyond as dots. Nothing for no finite value.
#[must_use]
pub fn box_plot(at: usize, colour: Colour, values: &[f64]) -> (Option<Band>, Vec<Line>) {
    let mut sorted: Vec<f64> = values.iter().copied().filter(|v| v.is_finite()).collect();
    sorted.sort_by(f64::total_cmp);
    if sorted.is_empty() {
        return (None, Vec::new());
    }
    let x = at as f64;
    let [low, middle, high] = [0.25, 0.5, 0.75].map(|q| quantile(&sorted, q));
    let reach = REACH * (high - low);
    let inside = |v: &f64| (low - reach..=high + reach).contains(v);
    let (within, beyond): (Vec<f64>, Vec<f64>) = sorted.iter().partition(|v| inside(v));
    let (bottom, top) = (within[0], within[within.len() - 1]);
    let line = |style, points| Line::new("", colour, style, points);
    let bar = |y: f64, half: f64| vec![(x - half, y), (x + half, y)];
    let edge = [(-BOX, low), (BOX, low), (BOX, high), (-BOX, high), (-BOX, low)];
    let lines = vec![
        line(Style::Thin, edge.map(|(dx, y)| (x + dx, y)).to_vec()),
        line(Style::Thin, vec![(x, bottom), (x, low)]),
        line(Style::Thin, vec![(x, high), (x, top)]),
        line(Style::Thin, bar(bottom, END)),
        line(Style::Thin, bar(top, END)),
        line(Style::Solid, bar(middle, BOX)),
        line(Style::Rings, beyond.into_iter().map(|v| (x, v)).collect()),
    ];
    let edges = vec![(x - BOX, low, high), (x + BOX, low, high)];
    (Some(Band { label: String::new(), colour, edges }), lines)
}

/// The `q`-quantile of sorted values, linear between them.
fn quantile(sorted: &[f64], q: f64) -> f64 {
    let place = q * (sorted.len() - 1) as f64;
    let (below, above) = (sorted[place.floor() as usize], sorted[place.ceil() as usize]);
    below + (place - place.floor()) * (above - below)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_box_has_quartiles_whiskers_and_what_is_beyond() {
        let values = [1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 100.0, f64::NAN];
        let (band, lines) = box_plot(2, Colour::Blue, &values);
        assert_eq!(band.unwrap().edges, [(1.8, 3.0, 7.0), (2.2, 3.0, 7.0)]);
        assert_eq!(lines[5].points, [(1.8, 5.0), (2.2, 5.0)]);
        assert_eq!(lines[2].points, [(2.0, 7.0), (2.0, 8.0)]);
        assert_eq!(lines[6].points, [(2.0, 100.0)]);
        assert_eq!(box_plot(0, Colour::Blue, &[f64::NAN]), (None, vec![]));
    }
}
