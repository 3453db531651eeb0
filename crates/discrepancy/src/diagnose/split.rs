//! Which recordings are fitted and which are kept for proof.

use crate::dataset::{Dataset, Observed};
use crate::range::inner_range;

/// Split recordings into those that are fitted and those kept for proof: one in four, or the
/// last quarter of a single one.
///
/// What a recording alone shows of the machine's range must be fitted, not kept: a stop that
/// only one of them touches could not be found without it. So those are kept, one after the
/// other, whose outputs and inputs lie most within the range of the others; of equal ones the
/// last.
#[must_use]
pub fn split(dataset: &Dataset) -> (Dataset, Dataset) {
    let all = &dataset.recordings;
    if let [only] = &all[..] {
        let cut = only.len() * 3 / 4;
        let (head, tail) = (only.part(0..cut), only.part(cut..only.len()));
        return (dataset.with_recordings(vec![head]), dataset.with_recordings(vec![tail]));
    }
    let ranges: Vec<Vec<(f64, f64)>> = all.iter().map(ranges).collect();
    let mut fitted: Vec<usize> = (0..all.len()).collect();
    for _ in 0..all.len().div_ceil(4) {
        let least = fitted
            .iter()
            .map(|&r| (lost_without(&ranges, &fitted, r), r))
            .min_by(|a, b| a.0.total_cmp(&b.0).then(b.1.cmp(&a.1)));
        fitted.retain(|&r| least.is_none_or(|(_, gone)| r != gone));
    }
    let part = |is_fitted: bool| {
        let of = all.iter().enumerate().filter(|(r, _)| fitted.contains(r) == is_fitted);
        dataset.with_recordings(of.map(|(_, o)| o.clone()).collect())
    };
    (part(true), part(false))
}

/// Range of each output and input of a recording, without the outermost thousandth.
fn ranges(o: &Observed) -> Vec<(f64, f64)> {
    let m = o.commands.len() / o.len().max(1);
    let inputs = (0..m).map(|j| o.command(j));
    o.outputs.iter().cloned().chain(inputs).map(|v| inner_range(v, 1000)).collect()
}

/// Share of the range of any channel that the others do not cover without recording `gone`.
fn lost_without(ranges: &[Vec<(f64, f64)>], fitted: &[usize], gone: usize) -> f64 {
    let union = |k: usize, without: Option<usize>| {
        fitted
            .iter()
            .filter(|&&r| Some(r) != without)
            .map(|&r| ranges[r][k])
            .fold((f64::INFINITY, f64::NEG_INFINITY), |u, r| (u.0.min(r.0), u.1.max(r.1)))
    };
    let lost = |k: usize| {
        let (all, rest) = (union(k, None), union(k, Some(gone)));
        let width = (all.1 - all.0).max(f64::MIN_POSITIVE);
        1.0 - ((rest.1 - rest.0) / width).clamp(0.0, 1.0)
    };
    (0..ranges[gone].len()).map(lost).fold(0.0, f64::max)
}
