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
    let mut best = misfit(integrator, shot, setting, noise, &seen)?;
    for _ in 0..INITIAL_STEPS {
        let run = integrator.run(shot)?;
        let step = initial_step(&run, setting, noise, &seen)?;
        let before = shot.initial.clone();
        let chi = best.chi_square(noise);
        let mut length = 1.0;
        let mut gained = None;
        for _ in 0..HALVINGS {
            let moved = before.iter().zip(&step).map(|(z, d)| z + length * d);
            shot.initial = moved.collect();
            match misfit(integrator, shot, setting, noise, &seen) {
                Some(found) if found.chi_square(noise) < chi => {
                    gained = Some(found);
                    break;
                }
                _ => length *= 0.5,
            }
        }
        let Some(found) = gained else {
            shot.initial = before;
            break;
        };
        best = found;
        if chi - best.chi_square(noise) < INITIAL_GAIN * (1.0 + chi) {
            break;
        }
    }
    Some(best)
}

fn misfit(
    integrator: &mut Integrator<'_>,
    shot: &Shot,
    setting: &Setting,
    noise: &OutputNoise,
    seen: &[(usize, usize, f64)],
) -> Option<Misfit> {
    let states = integrator.states(shot)?;
    let mut left = Misfit::new(noise.0.len());
    for &(k, i, value) in seen {
        left.squares[i] += (value - states[k * setting.states() + i]).powi(2);
        left.counts[i] += 1;
    }
    Some(left)
}

/// Least squares in the initial state, with a ridge that is far below any information.
fn initial_step(
    run: &Run,
    setting: &Setting,
    noise: &OutputNoise,
    seen: &[(usize, usize, f64)],
) -> Option<Vec<f64>> {
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
    factor.solve_lower_transposed(&mut moment);
    Some(moment.col_as_slice(0).to_vec())
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
