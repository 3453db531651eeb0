//! Lines with no more points than a picture shows: those whose neighbours a straight line passes.
//!
//! Ramer (1972), Douglas and Peucker (1973): of a stretch between two points that stay, the point that is
//! farthest from their connection stays as well, until none is farther than the tolerance.

use lacuna_charts::{Line, Scale};

/// Tolerance as a share of what the line spans.
const TOLERANCE: f64 = 1e-3;
/// Parts of what a line spans to which its points are rounded, and distances from it: what is beyond
/// would differ between machines.
const POINTS: f64 = 1e5;
const DISTANCES: f64 = 1e9;

/// The line with fewer points, each rounded, as they are seen along axes of these scales.
#[must_use]
pub fn line(line: Line, (x, y): (&Scale, &Scale)) -> Line {
    let seen = |v: f64, scale: &Scale| if *scale == Scale::Log { v.log10() } else { v };
    let meant = |v: f64, scale: &Scale| if *scale == Scale::Log { 10f64.powf(v) } else { v };
    let points: Vec<_> = line.points.iter().map(|p| (seen(p.0, x), seen(p.1, y))).collect();
    let (xs, ys) = (span(points.iter().map(|p| p.0)), span(points.iter().map(|p| p.1)));
    let scaled: Vec<_> = points.iter().map(|p| (p.0 / xs, p.1 / ys)).collect();
    let rounded = |value: f64, span: f64| (value * POINTS).round() / POINTS * span;
    let stay = stay(&scaled).into_iter().map(|k| scaled[k]);
    let points = stay.map(|p| (meant(rounded(p.0, xs), x), meant(rounded(p.1, ys), y)));
    Line { points: points.collect(), ..line }
}

/// The power of ten that is no more than what values span.
fn span(values: impl Iterator<Item = f64>) -> f64 {
    let ends = |(a, b): (f64, f64), v: f64| (a.min(v), b.max(v));
    let (low, high) = values.fold((f64::INFINITY, f64::NEG_INFINITY), ends);
    let length = if high > low { high - low } else { low.abs() };
    if length > 0.0 && length.is_finite() { 10f64.powf(length.log10().floor()) } else { 1.0 }
}

/// The points that stay.
fn stay(points: &[(f64, f64)]) -> Vec<usize> {
    let Some(last) = points.len().checked_sub(1) else { return vec![] };
    let mut stays = vec![false; points.len()];
    (stays[0], stays[last]) = (true, true);
    let mut stretches = vec![(0, last)];
    while let Some((from, to)) = stretches.pop() {
        let away = |k: usize| {
            let distance = distance(points[k], points[from], points[to]);
            (distance * DISTANCES).round()
        };
        let farthest = (from + 1..to).max_by(|&a, &b| away(a).total_cmp(&away(b)));
        if let Some(k) = farthest.filter(|&k| away(k) > TOLERANCE * DISTANCES) {
            stays[k] = true;
            stretches.extend([(from, k), (k, to)]);
        }
    }
    (0..points.len()).filter(|&k| stays[k]).collect()
}

/// How far a point is from the stretch between two others.
fn distance(point: (f64, f64), from: (f64, f64), to: (f64, f64)) -> f64 {
    let (along, off) = ((to.0 - from.0, to.1 - from.1), (point.0 - from.0, point.1 - from.1));
    let length = along.0 * along.0 + along.1 * along.1;
    let share = (along.0 * off.0 + along.1 * off.1) / length;
    let share = if length > 0.0 { share.clamp(0.0, 1.0) } else { 0.0 };
    (off.0 - share * along.0).hypot(off.1 - share * along.1)
}

#[cfg(test)]
mod tests {
    use super::*;
    use lacuna_charts::{Colour, Style};

    fn thinned(points: Vec<(f64, f64)>) -> Vec<(f64, f64)> {
        let line = Line::new("", Colour::Blue, Style::Solid, points);
        super::line(line, (&Scale::Linear, &Scale::Linear)).points
    }

    #[test]
    fn corners_stay_and_what_is_between_them_goes() {
        let bent = |k: usize| (k as f64, (k as f64 - 30.0).max(0.0));
        let found = thinned((0..=100).map(bent).collect());
        assert_eq!(found, [(0.0, 0.0), (30.0, 0.0), (100.0, 70.0)]);
    }

    #[test]
    fn a_curve_keeps_its_course_and_a_loop_its_way() {
        let turned = |k: usize| std::f64::consts::TAU * k as f64 / 1000.0;
        let circle: Vec<(f64, f64)> = (0..=1000).map(|k| turned(k).sin_cos()).collect();
        let found = thinned(circle);
        assert!((20..150).contains(&found.len()), "{} points", found.len());
        for pair in found.windows(2) {
            let middle = (0.5 * (pair[0].0 + pair[1].0)).hypot(0.5 * (pair[0].1 + pair[1].1));
            assert!((middle - 1.0).abs() < 2.0 * TOLERANCE, "{middle}");
        }
    }

    #[test]
    fn few_points_and_flat_lines_stay() {
        assert_eq!(thinned(vec![]), []);
        assert_eq!(thinned(vec![(0.0, 2.0), (1.0, 2.0), (3.0, 2.0)]), [(0.0, 2.0), (3.0, 2.0)]);
    }
}
