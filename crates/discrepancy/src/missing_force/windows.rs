//! Compact test functions on the samples of a recording, with their derivatives.

use lacuna_occupation::{Functional, Quadrature, TestFunction};

/// Exponent p of phi = (1 - tau^2)^p.
const EXPONENT: u32 = 4;
/// Windows begin this part of their width after one another: as good as at every sample.
const OVERLAP: usize = 4;
/// Fewest and most intervals of a window.
const INTERVALS: (usize, usize) = (12, 192);
/// Windows are as long as it takes for the noise of the mean force over one to be this share of
/// the force: longer ones blur, shorter ones are many.
const NOISE: f64 = 0.3;
/// Times are even where no sample is this share of a step off.
const EVEN: f64 = 0.02;

/// One window: y -> int phi^(d) y dt for d = 0, 1, 2, as sums over the samples, with int phi = 1.
pub(super) struct Window {
    /// First sample.
    pub first: usize,
    /// Weights of the samples from the first on, for each d.
    pub weights: [Vec<f64>; 3],
}

/// The functionals of a window of `intervals` even steps of length 1, int phi = 1.
pub(super) fn unit(intervals: usize) -> Option<[Vec<f64>; 3]> {
    let times: Vec<f64> = (0..=intervals).map(|k| k as f64).collect();
    of(&times)
}

fn of(times: &[f64]) -> Option<[Vec<f64>; 3]> {
    let width = times[times.len() - 1] - times[0];
    let test = TestFunction::Compact { exponent: EXPONENT, width, stride: times.len() };
    let weights = |d: usize| -> Option<Vec<f64>> {
        let all = test.functionals(times, Quadrature::Trapezoid, d).ok()?;
        all.into_iter().next().map(|f: Functional| f.weights)
    };
    let mut all = [weights(0)?, weights(1)?, weights(2)?];
    let area: f64 = all[0].iter().sum();
    all.iter_mut().flatten().for_each(|w| *w /= area);
    Some(all)
}

/// Intervals of a channel's windows, from what noise leaves of the mean over one:
/// `noise(weights)` is the standard deviation of the mean force over a window of even unit
/// steps, `force` that of the force, and `most` the intervals that the motion allows.
pub(super) fn intervals(noise: impl Fn(&[Vec<f64>; 3]) -> f64, force: f64, most: usize) -> usize {
    let most = most.clamp(INTERVALS.0, INTERVALS.1);
    let mut n = INTERVALS.0;
    while n < most && unit(n).is_some_and(|w| noise(&w) > NOISE * force) {
        n = (n + n.div_ceil(4)).min(most);
    }
    n
}

/// Windows of `intervals` steps that slide along times, at most about `most` of them; those
/// that hold a sample at which `unknown` are left out.
pub(super) fn windows(
    times: &[f64],
    intervals: usize,
    most: usize,
    unknown: impl Fn(usize) -> bool,
) -> Vec<Window> {
    let Some(unit) = unit(intervals) else { return vec![] };
    let stride = (intervals / OVERLAP).max(times.len().div_ceil(most.max(1)));
    let starts = (0..times.len().saturating_sub(intervals)).step_by(stride);
    let window = |first: usize| {
        let range = first..=first + intervals;
        if range.clone().any(&unknown) {
            return None;
        }
        let times = &times[range];
        let weights = if is_even(times) {
            let step = (times[intervals] - times[0]) / intervals as f64;
            let scaled = |d: usize| unit[d].iter().map(|w| w / step.powi(d as i32)).collect();
            [scaled(0), scaled(1), scaled(2)]
        } else {
            of(times)?
        };
        Some(Window { first, weights })
    };
    starts.filter_map(window).collect()
}

/// Whether times are those of an even grid, but for how they are written.
fn is_even(times: &[f64]) -> bool {
    let intervals = times.len() - 1;
    let step = (times[intervals] - times[0]) / intervals as f64;
    let off = |(k, t): (usize, &f64)| (t - times[0] - step * k as f64).abs() > EVEN * step;
    !times.iter().enumerate().any(off)
}
