//! A sample and its neighbours: what they predict, and whether it can be one of them.

use super::{
    DEGREE, FEWEST, FEWEST_BESIDE, LEAP_AT_END, LONGEST_RUN, MOST_TOGETHER, PLAUSIBLE_SD, REACH,
    UPPER_SD,
};
use std::ops::Range;

/// Neighbours on both sides.
const BOTH: usize = 2 * REACH;

/// A sample at the origin of time and values, and its neighbours in order of time.
pub(super) struct Window {
    /// Times from the sample's, in steps.
    times: [f64; BOTH],
    /// Values from the sample's.
    values: [f64; BOTH],
    /// Number of neighbours.
    count: usize,
    /// Number of those that come before the sample.
    before: usize,
}

/// What is expected of the samples of a window.
#[derive(Clone, Copy)]
pub(super) struct Expected {
    /// Standard deviation of the noise.
    pub sd: f64,
    /// Standard deviations beyond which noise does not go.
    pub limit: f64,
    /// Quantum of the channel: rounding of the sample and of what predicts it, half a quantum
    /// each, is no Gaussian and adds to the rest.
    pub quantum: f64,
    /// The motion's steps between samples are seldom larger.
    pub step: f64,
    /// The largest of these away from the ends.
    pub largest: f64,
}

/// What a polynomial says at one time.
struct Predicted {
    value: f64,
    /// Standard deviation of what a new sample there differs by, in units of the noise.
    spread: f64,
    /// Sum of the squared residuals of the samples it was fitted to.
    squares: f64,
}

impl Window {
    /// `before` and `after` are `(time, value)` in order of time, at most twice [`REACH`] together,
    /// from the sample's; none with too few.
    pub(super) fn of(
        before: impl ExactSizeIterator<Item = (f64, f64)>,
        after: impl ExactSizeIterator<Item = (f64, f64)>,
    ) -> Option<Self> {
        let (left, right) = (before.len(), after.len());
        if left + right < FEWEST {
            return None;
        }
        let (mut times, mut values) = ([0.0; BOTH], [0.0; BOTH]);
        for (i, (time, value)) in before.chain(after).enumerate() {
            (times[i], values[i]) = (time, value);
        }
        Some(Self { times, values, count: left + right, before: left })
    }

    /// How far the sample is from what all neighbours predict: the standard deviation of noise
    /// that this is one of.
    pub(super) fn deviation(&self) -> f64 {
        let predicted = self.predict(|_| true, DEGREE, 0.0);
        -predicted.value / predicted.spread
    }

    /// Whether the sample is an outlier (the conditions of the module documentation).
    pub(super) fn is_outlier(&self, of: Expected) -> bool {
        let Some(left_out) = self.left_out(of.sd) else { return false };
        let kept = |i: usize| !left_out.contains(&i);
        let far = |(time, value): (f64, f64)| {
            let predicted = self.predict(kept, DEGREE, time);
            (value - predicted.value).abs() > of.limit * of.sd * predicted.spread + of.quantum
        };
        let own = (0.0, 0.0);
        let others = left_out.iter().map(|&i| (self.times[i], self.values[i]));
        if !others.chain([own]).all(far) {
            return false;
        }
        let run = self.run(kept);
        if run.len() >= LONGEST_RUN {
            return false;
        }
        let members = run.clone().map(|i| (self.times[i], self.values[i]));
        !members.chain([own]).any(|sample| self.may_be_an_end(kept, sample, of.sd))
            && self.is_abrupt(run.clone(), self.least_step(kept, run, of))
    }

    /// The step that an outlier exceeds, before and after it and its run.
    fn least_step(&self, kept: impl Fn(usize) -> bool, run: Range<usize>, of: Expected) -> f64 {
        if run.start.min(self.count - run.end) < FEWEST_BESIDE {
            let kept: Vec<f64> =
                (0..self.count).filter(|&i| kept(i)).map(|i| self.values[i]).collect();
            let steps = kept.windows(2).map(|pair| (pair[1] - pair[0]).abs());
            LEAP_AT_END * steps.fold(of.largest, f64::max)
        } else if run.is_empty() {
            0.0
        } else {
            of.step
        }
    }

    /// The neighbours that are left out next to the sample, without one that is kept between.
    fn run(&self, kept: impl Fn(usize) -> bool) -> Range<usize> {
        let first = (0..self.before).rev().find(|&i| kept(i)).map_or(0, |i| i + 1);
        let end = (self.before..self.count).find(|&i| kept(i)).unwrap_or(self.count);
        first..end
    }

    /// Whether the sample and the neighbours of its run begin and end with a step that is larger
    /// than `step`, where there is a neighbour to step from or to.
    fn is_abrupt(&self, run: Range<usize>, step: f64) -> bool {
        let value = |i: usize| self.values[i];
        let first = if run.start < self.before { value(run.start) } else { 0.0 };
        let last = if run.end > self.before { value(run.end - 1) } else { 0.0 };
        let up = run.start.checked_sub(1).map(|i| (first - value(i)).abs());
        let down = (run.end < self.count).then(|| (value(run.end) - last).abs());
        [up, down].into_iter().flatten().all(|size| size > step)
    }

    /// The fewest neighbours, at most two, without which the others are a motion with noise of
    /// this standard deviation. The second is sought with the first left out.
    fn left_out(&self, sd: f64) -> Option<Vec<usize>> {
        let mut out = Vec::new();
        loop {
            let left = self.count - out.len();
            let squares = self.predict(|i| !out.contains(&i), DEGREE, 0.0).squares;
            if squares <= sd * sd * upper_point(left - DEGREE - 1) {
                return Some(out);
            }
            if out.len() + 1 == MOST_TOGETHER || left == FEWEST {
                return None;
            }
            let without =
                |i: usize| self.predict(|j| j != i && !out.contains(&j), DEGREE, 0.0).squares;
            let others = (0..self.count).filter(|i| !out.contains(i)).map(|i| (without(i), i));
            out.push(others.min_by(|a, b| a.0.total_cmp(&b.0))?.1);
        }
    }

    /// Whether a sample may be the last or the first of a motion on one side: whether it is
    /// near to what the nearest neighbour, the nearest three and all on a side extrapolate by
    /// degree 0, 1 and 2, or between these and what both sides predict.
    fn may_be_an_end(
        &self,
        kept: impl Fn(usize) -> bool + Copy,
        (time, value): (f64, f64),
        sd: f64,
    ) -> bool {
        let side = (value - self.predict(kept, DEGREE, time).value).signum();
        let before: Vec<usize> = (0..self.before).rev().filter(|&i| kept(i)).collect();
        let after: Vec<usize> = (self.before..self.count).filter(|&i| kept(i)).collect();
        [before, after].iter().filter(|nearest| !nearest.is_empty()).any(|nearest| {
            [(0, 1), (1, FEWEST_BESIDE), (2, REACH)].iter().any(|&(degree, points)| {
                let used = &nearest[..points.min(nearest.len())];
                let degree = degree.min(used.len() - 1);
                let predicted = self.predict(|i| used.contains(&i), degree, time);
                (value - predicted.value) * side <= PLAUSIBLE_SD * sd * predicted.spread
            })
        })
    }

    /// Least squares of the neighbours that are `used`, by polynomials that are orthogonal on
    /// their times.
    fn predict(&self, used: impl Fn(usize) -> bool, degree: usize, time: f64) -> Predicted {
        let (mut x, mut rest, mut count) = ([0.0; BOTH], [0.0; BOTH], 0);
        for i in (0..self.count).filter(|&i| used(i)) {
            (x[count], rest[count]) = (self.times[i], self.values[i]);
            count += 1;
        }
        let (x, rest) = (&x[..count], &mut rest[..count]);
        // Values of this polynomial and the last, at the samples and at the time asked for.
        let (mut now, mut last) = ([1.0; BOTH], [0.0; BOTH]);
        let (mut now_there, mut last_there) = (1.0, 0.0);
        let (mut value, mut leverage, mut last_norm) = (0.0, 0.0, f64::INFINITY);
        for _ in 0..=degree {
            let (mut norm, mut product, mut moment) = (0.0, 0.0, 0.0);
            for i in 0..count {
                let square = now[i] * now[i];
                norm += square;
                product += now[i] * rest[i];
                moment += x[i] * square;
            }
            let (share, centre, back) = (product / norm, moment / norm, norm / last_norm);
            value += share * now_there;
            leverage += now_there * now_there / norm;
            for i in 0..count {
                rest[i] -= share * now[i];
                (now[i], last[i]) = ((x[i] - centre) * now[i] - back * last[i], now[i]);
            }
            (now_there, last_there) = ((time - centre) * now_there - back * last_there, now_there);
            last_norm = norm;
        }
        let squares = rest.iter().map(|r| r * r).sum();
        Predicted { value, spread: (1.0 + leverage).sqrt(), squares }
    }
}

/// The 99.9 % point of the chi-square distribution (E. B. Wilson, M. M. Hilferty, 1931: its cube
/// root is nearly Gaussian); within 2 % from three degrees of freedom on.
fn upper_point(freedom: usize) -> f64 {
    let n = freedom as f64;
    let share = 2.0 / (9.0 * n);
    n * (1.0 - share + UPPER_SD * share.sqrt()).powi(3)
}
