//! One number of many machines: what is typical, how it is spread, and which machines are elsewhere.
//!
//! Random effects with a broad second population for those that are elsewhere,
//!
//! ```text
//! y_m ~ (1 - q) N(mu, tau^2 + s_m^2) + q N(mu_0, B^2 + s_m^2)
//! ```
//!
//! | on paper | in code |
//! | --- | --- |
//! | number y_m of machine m, its standard deviation s_m | [`Number`] |
//! | what is typical mu, spread tau of typical machines | [`Population`] |
//! | probability w_m that a machine is typical | `weights` |
//! | tau on a grid, mu and its precision at each, the weight of each | `Grid` |
//! | p-value of machine m | [`Population::p`] |
//!
//! Nothing is known of mu and tau beforehand (flat priors); the likelihood of a machine counts with its w. Where a
//! machine should be, the others say: a mean of normal distributions over what they say of tau,
//!
//! ```text
//! f_m(y) = integral of p(tau | the others) N(y; mu(tau), tau^2 + s_m^2 + var mu(tau)) d tau
//! ```
//!
//! which has the tails of Student's t where they are few. w_m follows from f_m(y_m), and f_m from the w of the
//! others: this is repeated. The p-value is the share of f_m that lies further out than y_m.

use statrs::function::erf::erfc;
use std::f64::consts::{PI, SQRT_2};

/// Machines without which nothing is said of what is typical.
pub const FEWEST: usize = 5;
/// Share q of machines that are elsewhere: how many machines the belief counts for, and of those how many are.
const BELIEF: (f64, f64) = (10.0, 1.0);
/// Standard deviation of the broad population in those of the typical one, at least.
const BROAD: f64 = 10.0;
/// Rounds from weights to weights: more change no digit that is shown.
const ROUNDS: usize = 30;
/// Steps of the grid of tau: from a share of the least standard deviation to so many ranges of the numbers, each by a
/// factor.
const GRID: (f64, f64, f64) = (0.1, 100.0, 1.15);
/// Standard deviations below this share of the largest value are rounding.
const ROUNDING: f64 = 1e-9;

/// A number of one machine with its standard deviation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Number {
    /// Value.
    pub value: f64,
    /// Standard deviation.
    pub std: f64,
}

/// What is typical of a number.
#[derive(Clone, Debug, PartialEq)]
pub struct Population {
    /// Its mean over typical machines.
    pub mean: f64,
    /// Standard deviation of the mean.
    pub mean_std: f64,
    /// Standard deviation of typical machines about the mean, without that of their estimates (median of what the
    /// machines say of it).
    pub spread: f64,
    /// Of every machine the probability that a typical one lies as far out, by what the others say.
    pub p: Vec<f64>,
}

impl Population {
    /// The population of finite numbers; none of fewer machines than [`FEWEST`].
    pub fn of(numbers: &[Number]) -> Option<Self> {
        if numbers.len() < FEWEST {
            return None;
        }
        // About the median, so that sums of squares lose no digits.
        let middle = median(numbers.iter().map(|n| n.value));
        let largest = numbers.iter().fold(0.0, |m: f64, n| m.max(n.value.abs()).max(n.std));
        let least = (ROUNDING * largest).max(f64::MIN_POSITIVE.sqrt());
        let about = |n: &Number| Number { value: n.value - middle, std: n.std.max(least) };
        let numbers: Vec<Number> = numbers.iter().map(about).collect();
        let grid = Grid::of(&numbers, &weights(&numbers));
        let all = grid.posterior(None);
        let mean: f64 = all.iter().map(|point| point.share * point.mean).sum();
        let variance = |p: &Point| p.share * (p.mean_variance + (p.mean - mean).powi(2));
        let p = (0..numbers.len()).map(|m| grid.p(m)).collect();
        let mean_std = all.iter().map(variance).sum::<f64>().sqrt();
        Some(Self { mean: mean + middle, mean_std, spread: half(&all), p })
    }
}

/// What weighted machines say of mu at every tau of a grid.
struct Grid {
    machines: Vec<(Number, f64)>,
    steps: Vec<Step>,
}

/// One tau, the width of its cell, and sums over all machines with the precision w / (tau^2 + s^2): of 1, y, y^2, and
/// of w log(tau^2 + s^2).
struct Step {
    tau: f64,
    width: f64,
    sums: [f64; 4],
}

/// One tau with its share of the posterior, the mean of mu there and its variance.
struct Point {
    tau: f64,
    share: f64,
    mean: f64,
    mean_variance: f64,
}

impl Grid {
    fn of(numbers: &[Number], weights: &[f64]) -> Self {
        let machines: Vec<(Number, f64)> =
            numbers.iter().copied().zip(weights.iter().copied()).collect();
        let deviations = numbers.iter().map(|n| n.std);
        let (least, most) =
            deviations.fold((f64::INFINITY, 0.0), |(a, b): (f64, f64), s| (a.min(s), b.max(s)));
        let (first, last) = (GRID.0 * least, GRID.1 * (range(numbers) + most));
        let count = ((last / first).ln() / GRID.2.ln()).ceil() as usize;
        let step = |k: usize| {
            let tau = first * GRID.2.powi(k as i32);
            // The first cell reaches down to 0.
            let width = if k == 0 { tau } else { tau * GRID.2.ln() };
            let add = |sums: [f64; 4], machine: &(Number, f64)| {
                let own = terms(machine, tau);
                [0, 1, 2, 3].map(|i| sums[i] + own[i])
            };
            Step { tau, width, sums: machines.iter().fold([0.0; 4], add) }
        };
        let steps = (0..=count).map(step).collect();
        Self { machines, steps }
    }

    /// The posterior of tau, perhaps without one machine.
    fn posterior(&self, without: Option<usize>) -> Vec<Point> {
        let point = |step: &Step| {
            let own = without.map_or([0.0; 4], |m| terms(&self.machines[m], step.tau));
            let [ones, values, squares, logs] = [0, 1, 2, 3].map(|i| step.sums[i] - own[i]);
            let ones = ones.max(f64::MIN_POSITIVE);
            let misfit = (squares - values * values / ones).max(0.0);
            let log = step.width.ln() - 0.5 * (logs + ones.ln() + misfit);
            Point { tau: step.tau, share: log, mean: values / ones, mean_variance: ones.recip() }
        };
        let mut points: Vec<Point> = self.steps.iter().map(point).collect();
        let highest = points.iter().fold(f64::NEG_INFINITY, |h, p| h.max(p.share));
        points.iter_mut().for_each(|p| p.share = (p.share - highest).exp());
        let all: f64 = points.iter().map(|p| p.share).sum();
        points.iter_mut().for_each(|p| p.share /= all);
        points
    }

    /// Where a machine should be by what the others say: share, mean and variance of normal distributions.
    fn expected(&self, machine: usize) -> impl Iterator<Item = (f64, f64, f64)> {
        let std = self.machines[machine].0.std;
        let one = move |p: Point| (p.share, p.mean, p.tau.powi(2) + std * std + p.mean_variance);
        self.posterior(Some(machine)).into_iter().map(one)
    }

    /// Density of a machine's number by what the others say.
    fn density(&self, machine: usize) -> f64 {
        let value = self.machines[machine].0.value;
        self.expected(machine).map(|(share, mean, v)| share * normal(value - mean, v)).sum()
    }

    /// Two-sided p-value of a machine by what the others say.
    fn p(&self, machine: usize) -> f64 {
        let value = self.machines[machine].0.value;
        let beyond = |mean: f64, v: f64| erfc((value - mean).abs() / (SQRT_2 * v.sqrt()));
        let all = self.expected(machine).map(|(share, mean, v)| share * beyond(mean, v));
        all.sum::<f64>().min(1.0)
    }
}

/// What a machine adds to the sums of a [`Step`].
fn terms((number, weight): &(Number, f64), tau: f64) -> [f64; 4] {
    let variance = tau * tau + number.std * number.std;
    let precision = weight / variance;
    [precision, precision * number.value, precision * number.value.powi(2), weight * variance.ln()]
}

fn normal(from_mean: f64, variance: f64) -> f64 {
    (-0.5 * from_mean.powi(2) / variance).exp() / (2.0 * PI * variance).sqrt()
}

/// The tau below which half of the posterior lies.
fn half(points: &[Point]) -> f64 {
    let mut below = 0.0;
    let reached = |p: &&Point| {
        below += p.share;
        below >= 0.5
    };
    points.iter().find(reached).map_or(f64::NAN, |p| p.tau)
}

/// Probability of each machine that it is a typical one; numbers are about their median.
fn weights(numbers: &[Number]) -> Vec<f64> {
    let scale = 1.4826 * median(numbers.iter().map(|n| n.value.abs()));
    let noise = median(numbers.iter().map(|n| n.std));
    let near = scale.hypot(noise);
    let broad = (BROAD * near).max(range(numbers));
    let elsewhere = |n: &Number| normal(n.value, broad * broad + n.std * n.std);
    let mut share = BELIEF.1 / BELIEF.0;
    let typical = |density: f64, n: &Number, share: f64| {
        let (here, there) = ((1.0 - share) * density, share * elsewhere(n));
        if here > 0.0 { here / (here + there) } else { 0.0 }
    };
    let first = |n: &Number| typical(normal(n.value, near * near + n.std * n.std), n, share);
    let mut weights: Vec<f64> = numbers.iter().map(first).collect();
    for _ in 0..ROUNDS {
        let count: f64 = weights.iter().sum();
        share = (numbers.len() as f64 - count + BELIEF.1) / (numbers.len() as f64 + BELIEF.0);
        let grid = Grid::of(numbers, &weights);
        weights =
            (0..numbers.len()).map(|m| typical(grid.density(m), &numbers[m], share)).collect();
    }
    weights
}

fn range(numbers: &[Number]) -> f64 {
    let ends = |(low, high): (f64, f64), n: &Number| (low.min(n.value), high.max(n.value));
    let (low, high) = numbers.iter().fold((f64::INFINITY, f64::NEG_INFINITY), ends);
    high - low
}

/// Median of finite values.
pub(super) fn median(values: impl Iterator<Item = f64>) -> f64 {
    let mut sorted: Vec<f64> = values.collect();
    sorted.sort_by(f64::total_cmp);
    let n = sorted.len();
    match n {
        0 => f64::NAN,
        _ => 0.5 * (sorted[(n - 1) / 2] + sorted[n / 2]),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::excitation::{add_gaussian_noise, rng};

    /// Machines about 2 with a spread of 0.3 and standard deviations between 0.01 and 0.4.
    fn drawn(seed: u64, count: usize) -> Vec<Number> {
        let mut rng = rng(seed, 0);
        let mut unit = vec![0.0; 2 * count];
        add_gaussian_noise(&mut unit, 1.0, &mut rng).unwrap();
        let one = |m: usize| {
            let std = 0.01 + 0.39 * (m % 7) as f64 / 6.0;
            Number { value: 2.0 + 0.3 * unit[m] + std * unit[count + m], std }
        };
        (0..count).map(one).collect()
    }

    #[test]
    fn mean_and_spread_are_those_of_the_typical_machines() {
        let mut numbers = drawn(1, 200);
        for n in numbers.iter_mut().step_by(10) {
            n.value += 5.0;
        }
        let population = Population::of(&numbers).unwrap();
        assert!((population.mean - 2.0).abs() < 3.0 * population.mean_std, "{population:?}");
        assert!((population.spread - 0.3).abs() < 0.06, "{}", population.spread);
    }

    /// Share of typical machines with p-values below some levels.
    fn shares<const N: usize>(count: usize, machines: usize, levels: [f64; N]) -> [f64; N] {
        let fleets = (machines / count) as u64;
        let all: Vec<f64> =
            (0..fleets).flat_map(|seed| Population::of(&drawn(seed, count)).unwrap().p).collect();
        levels.map(|level| all.iter().filter(|p| **p < level).count() as f64 / all.len() as f64)
    }

    #[test]
    fn p_values_of_typical_machines_are_as_small_as_they_say_at_most() {
        let levels = [0.1, 0.01, 0.001, 0.0001];
        for count in [5, 6, 12, 40] {
            let shares = shares(count, 8_000, levels);
            for (share, level) in shares.into_iter().zip(levels) {
                // Beside the level, three standard deviations of a count.
                let most = 1.2 * level + 3.0 * (level / 8_000.0).sqrt();
                assert!(share <= most, "{count} machines: {shares:?}");
            }
        }
        let [half] = shares(40, 8_000, [0.5]);
        assert!((half - 0.5).abs() < 0.05, "{half}");
    }

    #[test]
    fn a_few_that_are_elsewhere_do_not_hide_each_other() {
        for seed in 0..20 {
            let mut numbers = drawn(seed, 30);
            for n in &mut numbers[..3] {
                *n = Number { value: 6.0, std: 0.05 };
            }
            let p = Population::of(&numbers).unwrap().p;
            assert!(p[..3].iter().all(|p| *p < 1e-6), "{p:?}");
        }
    }

    #[test]
    fn nothing_is_said_of_few_and_halves_are_both_typical() {
        assert_eq!(Population::of(&drawn(1, FEWEST - 1)), None);
        let one = |m: usize| Number { value: (m % 2) as f64, std: 0.01 };
        let p = Population::of(&(0..20).map(one).collect::<Vec<_>>()).unwrap().p;
        assert!(p.iter().all(|p| *p > 0.1), "{p:?}");
        let same = Population::of(&[Number { value: 1.0, std: 0.0 }; 6]).unwrap();
        assert!(same.p.iter().all(|p| *p > 0.99) && same.spread < 1e-8, "{same:?}");
    }
}
