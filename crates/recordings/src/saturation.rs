//! Sensors at the end of their range: samples that stay on the largest or smallest value of a
//! channel for longer than its noise lets any value stay.
//!
//! A sensor at its limit L shows L, and no noise. Below the limit a sample with noise of standard
//! deviation s falls into one bin of width w, wherever the motion is, with a probability of at most
//!
//! ```text
//! p = w / (s sqrt(2 pi)),   s^2 = sigma^2 - w^2 / 12,
//! ```
//!
//! so that of N samples with independent noise less than N p^(n-1) runs of n equal ones are expected.
//! A channel is at a limit where
//!
//! 1. on its largest or smallest value, beyond which nothing is seen, N p^(n-1) < alpha;
//! 2. no value inside its range is held as long: samples that a log repeats are no limit;
//! 3. that value is not 0: a machine at rest, or an empty tank, shows 0 without noise as well.
//!
//! All samples on such a value then say no more than that the truth lies on it or beyond. Where the
//! noise is finer than the bins, p is no less than 1: a sensor at its limit cannot be told from a
//! machine at rest, nor from the peak of a sine, and none is marked.
//!
//! | on paper | in code |
//! | --- | --- |
//! | noise sigma | [`NoiseEstimate::sd`] |
//! | bin w, the quantum or the smallest step between values | [`resolution`] |

use crate::noise::NoiseEstimate;
use crate::outliers::resolution;
use std::f64::consts::TAU;

/// Runs of pure noise that may be taken for a limit, of all channels of this length.
const FALSE_LIMITS: f64 = 0.01;

/// The rows of each recording, `(time, values)` of one channel, on which its sensor is at the end of
/// its range (module documentation), in order. NaN values are missing samples.
#[must_use]
pub fn find_saturated(recordings: &[(&[f64], &[f64])], noise: &NoiseEstimate) -> Vec<Vec<usize>> {
    let present = || recordings.iter().flat_map(|r| r.1).copied().filter(|v| !v.is_nan());
    let (low, high) =
        present().fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), v| (a.min(v), b.max(v)));
    let most = longest_by_noise(recordings, noise, present().count());
    let (mut at_limits, mut inside) = ([0, 0], 0);
    for (value, length) in recordings.iter().flat_map(|r| runs(r.1)) {
        match [low, high].iter().position(|limit| *limit == value) {
            Some(side) => at_limits[side] = length.max(at_limits[side]),
            None => inside = length.max(inside),
        }
    }
    let is_limit = |value: f64, length: usize| {
        low < high && value != 0.0 && length > inside && length as f64 > most
    };
    let (lower, upper) = (is_limit(low, at_limits[0]), is_limit(high, at_limits[1]));
    let saturated = |value: f64| (lower && value == low) || (upper && value == high);
    let rows = |values: &[f64]| (0..values.len()).filter(|&k| saturated(values[k])).collect();
    recordings.iter().map(|r| rows(r.1)).collect()
}

/// The length of a run that noise exceeds in one channel of a hundred at most; infinite where it is
/// finer than the bins.
fn longest_by_noise(recordings: &[(&[f64], &[f64])], noise: &NoiseEstimate, samples: usize) -> f64 {
    let bin = noise.quantum.unwrap_or(0.0).max(resolution(recordings));
    let own = (noise.sd * noise.sd - bin * bin / 12.0).max(0.0).sqrt();
    let share = bin / (own * TAU.sqrt());
    if share < 1.0 {
        1.0 + (samples as f64 / FALSE_LIMITS).ln() / -share.ln()
    } else {
        f64::INFINITY
    }
}

/// Runs of equal samples, missing ones between them or not: value and length.
fn runs(values: &[f64]) -> Vec<(f64, usize)> {
    let mut runs: Vec<(f64, usize)> = vec![];
    for &value in values.iter().filter(|v| !v.is_nan()) {
        match runs.last_mut() {
            Some((held, length)) if *held == value => *length += 1,
            _ => runs.push((value, 1)),
        }
    }
    runs
}
