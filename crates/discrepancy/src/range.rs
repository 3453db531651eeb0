//! The range of a series without its outliers, and even knots on a range.

/// Smallest and largest of the finite values when one in `ends` is left out at either end; zeros
/// where there is none.
pub(crate) fn inner_range(mut values: Vec<f64>, ends: usize) -> (f64, f64) {
    values.retain(|v| v.is_finite());
    values.sort_by(f64::total_cmp);
    let cut = values.len() / ends;
    match (values.get(cut), values.iter().rev().nth(cut)) {
        (Some(low), Some(high)) => (*low, *high),
        _ => (0.0, 0.0),
    }
}

/// The two of some even knots about a value, by the first, and the share of the second: a function
/// between knots is on a straight line, and constant beyond the range.
pub(crate) fn between_knots(x: f64, (from, to): (f64, f64), knots: usize) -> (usize, f64) {
    let place = (x - from) / (to - from) * (knots - 1) as f64;
    let place = place.clamp(0.0, (knots - 1) as f64);
    let knot = (place as usize).min(knots - 2);
    (knot, place - knot as f64)
}
