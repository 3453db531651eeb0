//! The range of a series without its outliers.

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
