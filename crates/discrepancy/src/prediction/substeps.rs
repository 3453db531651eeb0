//! How many RK4 steps a model needs from one sample to the next.

use super::Series;
use crate::dataset::{Dataset, Observed};
use crate::diagnosis::Integration;
use std::ops::Range;

/// Most RK4 steps between two samples.
pub(super) const MOST: usize = 32;
/// Error of the steps as a share of the noise.
pub const TOLERANCE: f64 = 0.01;

/// Three stretches of a recording on which steps are compared.
pub(super) fn stretches(observed: &Observed) -> [Range<usize>; 3] {
    const STRETCH: usize = 400;
    let length = observed.len().min(STRETCH);
    [0, 1, 2].map(|k| k * (observed.len() - length) / 2).map(|start| start..start + length)
}

/// Fewest RK4 steps a sample whose error over some stretches stays well below the noise:
/// doubled until doubling changes little. `runs` are those of the stretches with so many steps.
pub(super) fn fewest(
    dataset: &Dataset,
    (tolerance, most): (f64, usize),
    runs: impl Fn(usize) -> Vec<Series>,
) -> Integration {
    let mut substeps = 1;
    let mut coarse = runs(substeps);
    let mut error = f64::INFINITY;
    while substeps < most {
        substeps *= 2;
        let fine = runs(substeps);
        let pairs = coarse.iter().zip(&fine);
        error = pairs.map(|(a, b)| weighted_distance(dataset, a, b)).fold(0.0, f64::max);
        if error < tolerance {
            return Integration { steps_a_sample: substeps / 2, error_over_noise: error };
        }
        coarse = fine;
    }
    Integration { steps_a_sample: substeps, error_over_noise: error }
}

/// Largest difference of two sets of series in units of the noise, or of a thousandth of
/// the channel's range where the noise is finer than any model follows.
fn weighted_distance(dataset: &Dataset, a: &Series, b: &Series) -> f64 {
    let mut largest = 0.0f64;
    for (k, (a, b)) in a.iter().zip(b).enumerate() {
        let w = (1.0 / dataset.noise_sd(k)).min(1e3 / dataset.half_range(k));
        for (x, y) in a.iter().zip(b) {
            // Where both diverge nothing can be compared.
            if x.is_finite() || y.is_finite() {
                let d = ((x - y) * w).abs();
                largest = if d.is_nan() { f64::INFINITY } else { largest.max(d) };
            }
        }
    }
    largest
}
