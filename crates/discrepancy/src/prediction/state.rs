//! The state at the beginning of a run, fitted to the samples that follow; and the runs from it.

use super::{Prediction, Series, windows};
use crate::dataset::Observed;
use crate::decision::Decision;
use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;
use std::ops::Range;

/// A model on one recording, as the fit of a state sees it.
pub(super) trait Runner: Sync {
    /// The recording.
    fn observed(&self) -> &Observed;

    /// Weight of each output's residual: one over its noise.
    fn weights(&self) -> &[f64];

    /// A first guess of the state at a sample.
    fn guess(&self, at: usize) -> Vec<f64>;

    /// Whether effects remember anything.
    fn remembers(&self) -> bool {
        false
    }

    /// Write into a guess of the state at the end of `range` what effects remember after a run over it
    /// from the whole state `x0`; nothing where there is no memory.
    fn remember(&self, _range: Range<usize>, _x0: &[f64], _guess: &mut [f64]) {}

    /// Outputs over `range` from the whole state `x0`; NaN from where the model diverges.
    fn run(&self, range: Range<usize>, x0: &[f64]) -> Series;

    /// Derivatives of those outputs, which are `here`, by each entry of `x0`: by forward differences
    /// where a runner knows no better.
    fn run_along(&self, range: Range<usize>, x0: &[f64], here: &Series) -> Vec<Series> {
        let by = |i: usize| {
            let mut moved = x0.to_vec();
            let h = state_step(x0[i]);
            moved[i] += h;
            let mut there = self.run(range.clone(), &moved);
            for (there, here) in there.iter_mut().flatten().zip(here.iter().flatten()) {
                *there = (*there - here) / h;
            }
            there
        };
        (0..x0.len()).map(by).collect()
    }
}

/// Damping with which a fit begins; what the derivatives promise with no more is what the optimum
/// is below.
const BELIEVED: f64 = 1e-3;

/// A fit is done where a step takes off less than this share of the squares that it leaves: errors change by half of
/// it.
const CONVERGED: f64 = 1e-4;

/// The same of a fit that another one begins with.
const BEGUN: f64 = 1e-2;

/// First share of a range that is fitted where the whole of it leads a fit astray: one in so many.
const SHORTEST: usize = 8;

/// A state, and the weighted residual that it leaves over the range that it was fitted to.
struct Fitted {
    x: Vec<f64>,
    rest: DVector<f64>,
}

impl Fitted {
    /// This one, or another that leaves less.
    fn or_better(self, other: Self) -> Self {
        if other.rest.norm_squared() < self.rest.norm_squared() { other } else { self }
    }
}

/// The state (memory of effects included) at the beginning of `range` that fits its samples best, from a guess.
/// What is unstable runs from a guess where no step leads back: where the whole range leaves more than noise it is
/// fitted once more by parts that grow, each from where the one before it was best, and the better stays.
fn fit_state(runner: &impl Runner, range: &Range<usize>, guess: Vec<f64>) -> Fitted {
    let at_once = fit_from(runner, range, guess.clone(), CONVERGED);
    let noise = Decision::default().explained * at_once.rest.len() as f64;
    if at_once.rest.norm_squared() <= noise {
        return at_once;
    }
    let shares = std::iter::successors(Some(SHORTEST), |share| Some(share / 2).filter(|s| *s > 1));
    let begun = shares.fold(guess, |x, share| {
        let end = range.start + (range.len() / share).max(2).min(range.len());
        fit_from(runner, &(range.start..end), x, BEGUN).x
    });
    at_once.or_better(fit_from(runner, range, begun, CONVERGED))
}

/// The same by Levenberg and Marquardt, on the state alone, until steps take off less than a share of what is left.
fn fit_from(runner: &impl Runner, range: &Range<usize>, guess: Vec<f64>, converged: f64) -> Fitted {
    let mut x = guess;
    let mut here = runner.run(range.clone(), &x);
    let mut rest = residual(runner, range, &here);
    let mut damping = BELIEVED;
    for _ in 0..20 {
        let jacobian = jacobian(runner, range, &x, &here);
        let gradient = jacobian.tr_mul(&rest);
        let normal = jacobian.tr_mul(&jacobian);
        let before = rest.norm_squared();
        let least = converged * before;
        let mut improved = false;
        for attempt in 0..8 {
            let Some(step) = damped_step(&normal, &gradient, damping) else { break };
            if attempt == 0 && damping <= BELIEVED && gradient.dot(&step) < least {
                break;
            }
            let candidate: Vec<f64> = x.iter().zip(step.iter()).map(|(x, d)| x + d).collect();
            let there = runner.run(range.clone(), &candidate);
            let trial = residual(runner, range, &there);
            if trial.norm_squared() < before {
                (x, here, rest) = (candidate, there, trial);
                damping = (damping * 0.1).max(1e-9);
                improved = true;
                break;
            }
            damping *= 10.0;
        }
        if !improved || before - rest.norm_squared() < least {
            break;
        }
    }
    Fitted { x, rest }
}

/// Weighted residual over a range; a large finite number where the model diverges, so
/// that the fit can still compare.
fn residual(runner: &impl Runner, range: &Range<usize>, predicted: &Series) -> DVector<f64> {
    weighted(runner, range, predicted, |y, p, weight| {
        let e = (y - p) * weight;
        if e.is_finite() { e.clamp(-1e6, 1e6) } else { 1e6 }
    })
}

/// Derivative of the weighted prediction, which is `here`, with respect to the state at the
/// beginning; 0 where the model has diverged.
fn jacobian(runner: &impl Runner, range: &Range<usize>, x: &[f64], here: &Series) -> DMatrix<f64> {
    let slope = |_, d: f64, weight: f64| if d.is_finite() { d * weight } else { 0.0 };
    let all = runner.run_along(range.clone(), x, here);
    let columns: Vec<_> = all.iter().map(|by| weighted(runner, range, by, slope)).collect();
    DMatrix::from_columns(&columns)
}

/// Something of each measured sample of a range, output by output: of what was measured, of what
/// `series` has there, and of the output's weight.
fn weighted(
    runner: &impl Runner,
    range: &Range<usize>,
    series: &Series,
    of: impl Fn(f64, f64, f64) -> f64,
) -> DVector<f64> {
    let mut out = Vec::new();
    for (k, series) in series.iter().enumerate() {
        let measured = &runner.observed().outputs[k][range.clone()];
        for (y, value) in measured.iter().zip(series).filter(|(y, _)| y.is_finite()) {
            out.push(of(*y, *value, runner.weights()[k]));
        }
    }
    DVector::from_vec(out)
}

/// A run to the end from the state that fits the first `warmup` samples, which do not
/// count for the error.
pub(super) fn free_run(runner: &impl Runner, warmup: usize) -> Prediction {
    let samples = runner.observed().len();
    let warmup = warmup.clamp(2, samples);
    let x0 = fit_state(runner, &(0..warmup), runner.guess(0)).x;
    let counted = if warmup < samples { warmup..samples } else { 0..warmup };
    Prediction { outputs: runner.run(0..samples, &x0), counted }
}

/// Runs of `horizon` seconds, the state at the beginning of each fitted to that window. Each fit begins with
/// the memory that the window before ended with, and from rest where that is another: from one of them, a fit
/// of what several springs remember need not find the way.
pub(super) fn windowed(runner: &impl Runner, horizon: f64) -> Prediction {
    let observed = runner.observed();
    let ranges = windows(observed, horizon);
    let runs = if runner.remembers() { in_turn(runner, ranges) } else { at_once(runner, ranges) };
    let mut outputs = vec![Vec::with_capacity(observed.len()); runner.weights().len()];
    for run in runs {
        outputs.iter_mut().zip(run).for_each(|(all, part)| all.extend(part));
    }
    Prediction { outputs, counted: 0..observed.len() }
}

/// Runs of which none knows of another.
fn at_once(runner: &impl Runner, ranges: Vec<Range<usize>>) -> Vec<Series> {
    let run = |range: Range<usize>| {
        let x0 = fit_state(runner, &range, runner.guess(range.start)).x;
        runner.run(range, &x0)
    };
    ranges.into_par_iter().map(run).collect()
}

/// Runs each of which begins with what the one before it ended with.
fn in_turn(runner: &impl Runner, ranges: Vec<Range<usize>>) -> Vec<Series> {
    let mut before: Option<(usize, Vec<f64>)> = None;
    let run = |range: Range<usize>| {
        let at_rest = runner.guess(range.start);
        let mut guess = at_rest.clone();
        if let Some((start, x0)) = &before {
            runner.remember(*start..range.start + 1, x0, &mut guess);
        }
        let again = (guess != at_rest).then_some(at_rest);
        let fitted = |guess| fit_state(runner, &range, guess);
        let best = fitted(guess);
        let x0 = match again.map(fitted) {
            Some(other) => best.or_better(other).x,
            None => best.x,
        };
        before = Some((range.start, x0.clone()));
        runner.run(range, &x0)
    };
    ranges.into_iter().map(run).collect()
}

fn damped_step(
    normal: &DMatrix<f64>,
    gradient: &DVector<f64>,
    damping: f64,
) -> Option<DVector<f64>> {
    let mut damped = normal.clone();
    let largest = normal.diagonal().max();
    for i in 0..damped.nrows() {
        // A state that leaves no trace in the window stays where it is.
        damped[(i, i)] += damping * normal[(i, i)] + 1e-14 * largest + f64::MIN_POSITIVE;
    }
    damped.cholesky().map(|c| c.solve(gradient))
}

/// Step of a forward difference with respect to a state.
fn state_step(x: f64) -> f64 {
    1e-6 * (1e-2 + x.abs())
}
