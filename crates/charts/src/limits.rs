//! The ranges that a diagram shows.

use super::axis::Scale;
use super::{ChartError, Figure};
use std::ops::Range;

/// Horizontal and vertical range.
pub(super) type Limits = (Range<f64>, Range<f64>);

/// The ranges of what a figure shows, of places along its axes.
///
/// # Errors
/// [`ChartError::Empty`] when nothing finite is in view.
pub(super) fn limits(figure: &Figure) -> Result<Limits, ChartError> {
    let lines = || figure.lines.iter().flat_map(|l| l.points.iter().copied());
    let edges = figure.bands.iter().flat_map(|b| &b.edges);
    let points = lines().chain(edges.flat_map(|e| [(e.0, e.1), (e.0, e.2)]));
    let empty = || ChartError::Empty { lines: figure.lines.len() };
    let finite: Vec<_> = points.filter(|p| p.0.is_finite() && p.1.is_finite()).collect();
    let (low, high) = figure.within.unwrap_or((f64::NEG_INFINITY, f64::INFINITY));
    let seen = finite.iter().map(|p| p.1).filter(|y| (low..=high).contains(y));
    let xs = match &figure.x.scale {
        Scale::Names(names) => -0.5..names.len() as f64 - 0.5,
        _ => extent(finite.iter().map(|p| p.0), 0.0).ok_or_else(empty)?,
    };
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

#[cfg(test)]
mod tests {
    use super::extent;

    #[test]
    fn flat_lines_and_wide_ranges_have_limits() {
        assert_eq!(extent([0.0, 0.0].into_iter(), 0.1), Some(-1.0..1.0));
        assert_eq!(extent([5.0].into_iter(), 0.1), Some(4.5..5.5));
        assert_eq!(extent([f64::MIN, f64::MAX].into_iter(), 0.1), None);
    }
}
