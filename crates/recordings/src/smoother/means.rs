//! Smoothed means between samples.
//!
//! Between two measurements the mean of the prior's posterior is the polynomial of degree 2n - 1 that has the value and
//! the n - 1 derivatives of the mean at both ends: nothing else is to be kept of a path whose bands are not asked for.

use super::Prior;

/// Most derivatives, the value included.
const MOST: usize = 4;

/// The means of a smoothed series.
#[derive(Clone, Debug, PartialEq)]
pub struct MeanPath {
    times: Vec<f64>,
    /// Value and derivatives at each sample, N x `order`.
    states: Vec<f64>,
    order: usize,
}

impl MeanPath {
    pub(super) fn new(prior: Prior, times: Vec<f64>, states: Vec<f64>) -> Self {
        Self { times, states, order: prior.order() }
    }

    /// Values at the samples (`derivative` 0), or first or second derivatives, per second to its power.
    pub fn at_samples(&self, derivative: usize) -> impl Iterator<Item = f64> + '_ {
        self.states.iter().skip(derivative).step_by(self.order).copied()
    }

    /// Value and first derivative at `times`, which ascend and lie within those of the series.
    pub fn at(&self, times: &[f64]) -> Vec<[f64; 2]> {
        let mut after = 1;
        let mut piece = self.piece(after);
        let at = |&time: &f64| {
            let before = after;
            while after + 1 < self.times.len() && self.times[after] < time {
                after += 1;
            }
            if after != before {
                piece = self.piece(after);
            }
            piece.at(time)
        };
        times.iter().map(at).collect()
    }

    fn piece(&self, after: usize) -> Piece {
        let step = self.times[after] - self.times[after - 1];
        let state = |k: usize| &self.states[k * self.order..(k + 1) * self.order];
        Piece::new(self.times[after - 1], step, state(after - 1), state(after))
    }
}

/// T(s) + s^n P(1 - s) on \[0, 1\]: T the Taylor polynomial of the start, and P what makes it end right.
struct Piece {
    start: f64,
    step: f64,
    order: usize,
    taylor: [f64; MOST],
    end: [f64; MOST],
}

impl Piece {
    fn new(start: f64, step: f64, left: &[f64], right: &[f64]) -> Self {
        let order = left.len();
        let (mut taylor, mut missing) = ([0.0; MOST], [0.0; MOST]);
        let mut scale = 1.0;
        for i in 0..order {
            taylor[i] = left[i] * scale;
            missing[i] = right[i] * scale;
            scale *= step / (i + 1) as f64;
        }
        // In terms of (s - 1)^i: what the end has and the Taylor polynomial has not.
        for i in 0..order {
            missing[i] -= (i..order).map(|j| binomial(j, i) * taylor[j]).sum::<f64>();
        }
        let mut end = [0.0; MOST];
        for (k, end) in end.iter_mut().enumerate().take(order) {
            let of = |i: usize| {
                let sign = if i.is_multiple_of(2) { 1.0 } else { -1.0 };
                binomial(order - 1 + k - i, k - i) * sign * missing[i]
            };
            *end = (0..=k).map(of).sum();
        }
        Self { start, step, order, taylor, end }
    }

    fn at(&self, time: f64) -> [f64; 2] {
        let s = (time - self.start) / self.step;
        let [taylor, taylor_slope] = polynomial(&self.taylor, s);
        let [end, end_slope] = polynomial(&self.end, 1.0 - s);
        let below = s.powi(self.order as i32 - 1);
        let slope = taylor_slope + below * (self.order as f64 * end - s * end_slope);
        [taylor + s * below * end, slope / self.step]
    }
}

/// Value and derivative.
fn polynomial(coefficients: &[f64; MOST], x: f64) -> [f64; 2] {
    let [mut value, mut slope] = [0.0; 2];
    for c in coefficients.iter().rev() {
        slope = slope * x + value;
        value = value * x + c;
    }
    [value, slope]
}

fn binomial(n: usize, k: usize) -> f64 {
    (0..k).map(|j| (n - j) as f64 / (j + 1) as f64).product()
}
