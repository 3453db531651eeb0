//! Initial states of windows for a given field, and what is left of the samples then.

use faer::Mat;

use super::flow::{Integrator, Run, Setting, Shot};
use super::motion::Motion;
use super::refine::OutputNoise;
use crate::linear::Factor;

/// Halvings of a step before it is given up.
const HALVINGS: usize = 6;
/// Gauss-Newton steps for an initial state.
const INITIAL_STEPS: usize = 2;
/// ... which end where a step gains less than this share of what is left.
const INITIAL_GAIN: f64 = 1e-2;
/// A step that would gain less than this share is not taken.
const NOTHING: f64 = 1e-3;

/// Sums of squares of what is left, and the number of samples, per output.
#[derive(Debug, Clone)]
pub(super) struct Misfit {
    pub squares: Vec<f64>,
    pub counts: Vec<usize>,
}

impl Misfit {
    pub fn new(outputs: usize) -> Self {
        Self { squares: vec![0.0; outputs], counts: vec![0; outputs] }
    }

    pub fn add(&mut self, other: &Self) {
        self.squares.iter_mut().zip(&other.squares).for_each(|(a, b)| *a += b);
        self.counts.iter_mut().zip(&other.counts).for_each(|(a, b)| *a += b);
    }

    pub fn chi_square(&self, noise: &OutputNoise) -> f64 {
        self.squares.iter().zip(&noise.0).map(|(s, sd)| s / (sd * sd)).sum()
    }
}

/// The measurements of a window: sample, state, output, value.
pub(super) fn measurements(shot: &Shot, states: usize) -> Vec<(usize, usize, f64)> {
    let motion = &shot.motion;
    let n = motion.dimension();
    let mut found = Vec::new();
    let mut add = |values: &[f64], offset: usize| {
        for (index, &value) in values.iter().enumerate().filter(|(_, v)| !v.is_nan()) {
            let (k, i) = (index / n, offset + index % n);
            if i < states {
                found.push((k, i, value));
            }
        }
    };
    add(motion.coordinates(), 0);
    if let Some(rates) = motion.rates() {
        add(rates, n);
    }
    found
}

/// Fits the initial state of a window and returns what is left; none where its trajectory is lost.
pub(super) fn fit_initial(
    integrator: &mut Integrator<'_>,
    shot: &mut Shot,
    setting: &Setting,
    noise: &OutputNoise,
) -> Option<Misfit> {
    let seen = measurements(shot, setting.states());
    let count = setting.states();
    let mut states = Vec::new();
    let mut run = integrator.run(&shot.initial)?;
    let mut best = misfit(&run.states, count, noise, &seen);
    for last in 1..=INITIAL_STEPS {
        let (step, expected) = initial_step(&run, setting, noise, &seen)?;
        let before = shot.initial.clone();
        let chi = best.chi_square(noise);
        if expected < NOTHING * (1.0 + chi) {
            break;
        }
        let mut length = 1.0;
        let mut gained = None;
        for _ in 0..HALVINGS {
            let moved = before.iter().zip(&step).map(|(z, d)| z + length * d);
            shot.initial = moved.collect();
            let found = integrator.states(&shot.initial, &mut states);
            let found = found.then(|| misfit(&states, count, noise, &seen));
            match found.filter(|found| found.chi_square(noise) < chi) {
                Some(found) => {
                    gained = Some(found);
                    break;
                }
                None => length *= 0.5,
            }
        }
        let Some(found) = gained else {
            shot.initial = before;
            break;
        };
        best = found;
        if last == INITIAL_STEPS || chi - best.chi_square(noise) < INITIAL_GAIN * (1.0 + chi) {
            break;
        }
        run = integrator.run(&shot.initial)?;
    }
    Some(best)
}

fn misfit(
    states: &[f64],
    count: usize,
    noise: &OutputNoise,
    seen: &[(usize, usize, f64)],
) -> Misfit {
    let mut left = Misfit::new(noise.0.len());
    for &(k, i, value) in seen {
        left.squares[i] += (value - states[k * count + i]).powi(2);
        left.counts[i] += 1;
    }
    left
}

/// Least squares in the initial state, with a ridge that is far below any information, and what that gains in the
/// linearised misfit.
fn initial_step(
    run: &Run,
    setting: &Setting,
    noise: &OutputNoise,
    seen: &[(usize, usize, f64)],
) -> Option<(Vec<f64>, f64)> {
    let count = setting.states();
    let mut gram = Mat::zeros(count, count);
    let mut moment = Mat::zeros(count, 1);
    for &(k, i, value) in seen {
        let row = &run.transitions[(k * count + i) * count..(k * count + i + 1) * count];
        let weight = noise.0[i].powi(-2);
        let left = value - run.states[k * count + i];
        for (a, &p) in row.iter().enumerate() {
            moment[(a, 0)] += weight * p * left;
            row.iter().enumerate().for_each(|(b, q)| gram[(a, b)] += weight * p * q);
        }
    }
    for a in 0..count {
        gram[(a, a)] += 1e-6 / setting.half_range[a].powi(2);
    }
    let factor = Factor::of(gram).ok()?;
    factor.solve_lower(&mut moment);
    let gain = moment.col_as_slice(0).iter().map(|v| v * v).sum();
    factor.solve_lower_transposed(&mut moment);
    Some((moment.col_as_slice(0).to_vec(), gain))
}

/// An initial state from the first samples: values, and divided differences for the derivatives.
pub(super) fn guess_initial(motion: &Motion, setting: &Setting) -> Vec<f64> {
    let (n, times) = (motion.dimension(), motion.times());
    let mut state = setting.middle.clone();
    for i in 0..n {
        let values = motion.coordinates().iter().skip(i).step_by(n);
        let seen: Vec<(f64, f64)> =
            times.iter().copied().zip(values.copied()).filter(|(_, y)| !y.is_nan()).collect();
        if let Some(first) = seen.first() {
            state[i] = first.1;
        }
        if setting.order > 1 {
            let few = &seen[..seen.len().min(4)];
            if let [first, .., last] = few {
                state[n + i] = (last.1 - first.1) / (last.0 - first.0);
            }
            let rate = motion.rates().map(|r| r[i]).filter(|r| !r.is_nan());
            state[n + i] = rate.unwrap_or(state[n + i]);
        }
    }
    state
}
