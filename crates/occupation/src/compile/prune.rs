//! Which blocks a function needs.

use rayon::prelude::*;

use super::layout::{Blocks, Layout};
use super::samples::Samples;

/// A function's series with blocks left out.
#[derive(Debug, Clone)]
pub(crate) struct Pruned {
    pub function: usize,
    pub blocks: Blocks,
    /// Absolute values of the coefficients that were left out.
    pub left_out: f64,
}

/// The largest blocks, as many as keep the error on the samples within `enough`; none where all of them do not.
pub(crate) fn prune(
    function: usize,
    blocks: &Blocks,
    layout: &Layout,
    samples: &Samples,
    enough: f64,
) -> Option<Pruned> {
    let magnitude = |c: &[f64; 8]| c.iter().map(|c| c.abs()).sum::<f64>();
    let mut order: Vec<(&[u16; 2], &[f64; 8])> = blocks.iter().collect();
    order.sort_by(|a, b| magnitude(b.1).total_cmp(&magnitude(a.1)).then_with(|| a.0.cmp(b.0)));
    let errors = errors_by_count(function, &order, layout, samples);
    let count = errors.iter().position(|error| *error <= enough)?;
    let left_out = order[count..].iter().map(|(_, c)| magnitude(c)).sum();
    let blocks = order[..count].iter().map(|(at, c)| (**at, **c)).collect();
    Some(Pruned { function, blocks, left_out })
}

/// Greatest error on the samples with the first 0, 1, 2, ... blocks.
fn errors_by_count(
    function: usize,
    order: &[(&[u16; 2], &[f64; 8])],
    layout: &Layout,
    samples: &Samples,
) -> Vec<f64> {
    let none = || vec![0.0; order.len() + 1];
    let add = |mut errors: Vec<f64>, (z, values): (&Vec<f64>, &Vec<f64>)| {
        let (outer, inner) = layout.values(z);
        let mut left = values[function];
        errors[0] = f64::max(errors[0], left.abs());
        for (error, (at, coefficients)) in errors[1..].iter_mut().zip(order) {
            let inner = &inner[8 * usize::from(at[1])..];
            let sum: f64 = coefficients.iter().zip(inner).map(|(c, p)| c * p).sum();
            left -= outer[usize::from(at[0])] * sum;
            *error = error.max(left.abs());
        }
        errors
    };
    let greater = |a: Vec<f64>, b: Vec<f64>| a.iter().zip(&b).map(|(a, b)| a.max(*b)).collect();
    samples.points.par_iter().zip(&samples.values).fold(none, add).reduce(none, greater)
}
