//! States that nothing measures: a first guess from what they do to those that are.
//!
//! Where a state h is hidden but drives measured ones, `x' = D(x, h, u)`, the value that makes D
//! agree with the measured motion is a guess of h, good enough for the likelihood to begin from.
//!
//! Coordinates that nothing measures are followed by a filter that does not know where they begin,
//! from what they do to those that are measured; and so are first-order states that other
//! outputs show ([`Shown`]).

use super::maps::Maps;
use super::shown::Shown;
use super::sweep::{Run, Starts};
use super::{Hypothesis, Problem, ProcessNoise, Window};
use crate::DiagnoseError;
use crate::trajectories::SmoothedRecording;
use lacuna_plants::Substeps;
use lacuna_plants::model::System;
use lacuna_plants::{Model, Plant};

/// Samples at which a hidden state is guessed; straight lines between them.
const POINTS: usize = 200;
/// Magnitudes that are tried, from the smallest to the largest as shares of the measured states'.
const MAGNITUDES: usize = 60;
const SMALLEST: f64 = 1e-3;
const LARGEST: f64 = 1e3;

/// What a filter may not know of a hidden coordinate, in units of the largest that is measured.
const WIDE: f64 = 2.0;
/// What drives the machine while it is followed: a share of the measured accelerations, each a few
/// samples long.
const DRIVEN: f64 = 0.05;
const SAMPLES: f64 = 10.0;
/// A share of the variance at the beginning that a filter must take away of what is not hidden
/// for good.
const SEEN: f64 = 0.5;

/// Fill the hidden states of all recordings' smoothed motion.
///
/// # Errors
/// A coordinate that nothing measured depends on, nor on its velocity.
pub(super) fn fill(problem: &mut Problem) -> Result<(), DiagnoseError> {
    let shown = Shown::simulated(problem);
    if shown.is_none() {
        for motion in &mut problem.smoothed {
            guess(problem.model, &problem.hidden, motion);
        }
    }
    follow(problem, shown)
}

/// Fill the hidden coordinates, and the first-order states that outputs show, by a filter.
fn follow(problem: &mut Problem, shown: Option<Shown>) -> Result<(), DiagnoseError> {
    let n = problem.model.coordinates.len();
    let coordinates: Vec<usize> = problem.hidden.iter().copied().filter(|&i| i < 2 * n).collect();
    let states = shown.iter().flat_map(|s| s.states.iter().copied());
    let followed: Vec<usize> = coordinates.iter().copied().chain(states).collect();
    if followed.is_empty() {
        return Ok(());
    }
    let h = Hypothesis::of(problem.model).held();
    let noise = driving(problem, shown.as_ref());
    let variances = variances(problem, &coordinates, shown.as_ref());
    let substeps = steps(problem, shown.as_ref());
    let mut least = vec![f64::INFINITY; variances.len()];
    for r in 0..problem.smoothed.len() {
        let samples = problem.smoothed[r].len();
        let windows = [Window { recording: r, range: 0..samples }];
        let begin = shown.as_ref().map_or(problem.smoothed[r].state(0), |s| &s.begins[r]);
        let machine = vec![begin.to_vec()];
        let starts = Starts { machine, memory: vec![] };
        let (windows, starts) = (&windows[..], &starts);
        let run = Run { problem, hypothesis: &h, windows, starts, filters: &[], substeps };
        // Where the model runs away, nothing is known of what it hides.
        let Ok(maps) = Maps::not_knowing(&run, Some(&noise), &variances) else { continue };
        for (least, v) in least.iter_mut().zip(&maps.filters[0].unknown) {
            *least = least.min(*v);
        }
        for k in 0..samples {
            for &i in &followed {
                problem.smoothed[r].set(k, i, maps.path[k * variances.len() + i]);
            }
        }
    }
    // Where only its velocity is seen a coordinate begins anywhere: what depends on it says the rest.
    let is_unseen = |i: usize| least[i] > SEEN * variances[i];
    let unseen = coordinates.iter().find(|&&i| i < n && is_unseen(i) && is_unseen(i + n));
    unseen.map_or(Ok(()), |&i| {
        Err(DiagnoseError::Unmeasured { channel: problem.model.state_name(i).to_owned() })
    })
}

/// Steps of a filter: as many as levels and currents need, which may be much faster than what is
/// sampled.
fn steps(problem: &Problem, shown: Option<&Shown>) -> Substeps {
    let model = problem.model;
    match shown {
        Some(_) => problem.substeps(&model.values(), &model.effects, false),
        None => Substeps::even(1),
    }
}

/// Random forces of a share of those that move the measured coordinates, and the states that outputs show.
fn driving(problem: &Problem, shown: Option<&Shown>) -> ProcessNoise {
    let model = problem.model;
    let n = model.coordinates.len();
    let measured = (0..n).filter(|i| !problem.hidden.contains(i));
    let acceleration =
        measured.map(|c| super::problem::deviation(&problem.accelerations(c))).fold(0.0, f64::max);
    let intensity = |rate: f64, m: f64| DRIVEN * rate / m * (SAMPLES * problem.sample).sqrt();
    let mobility = problem.mobility();
    let mut forces: Vec<f64> = mobility.iter().map(|m| intensity(acceleration, *m)).collect();
    for c in shown.iter().flat_map(|s| &s.states).map(|i| i - n) {
        forces[c] = intensity(super::problem::deviation(&problem.accelerations(c)), mobility[c]);
    }
    ProcessNoise { forces, ..ProcessNoise::none(problem) }
}

/// Variances of the machine's state where the hidden coordinates may be anywhere.
fn variances(problem: &Problem, hidden: &[usize], shown: Option<&Shown>) -> Vec<f64> {
    let n = problem.model.coordinates.len();
    let largest = |of: &dyn Fn(usize) -> bool| {
        let entries = (0..2 * n).filter(|&i| of(i) && !problem.hidden.contains(&i));
        let values = entries.flat_map(|i| {
            problem
                .smoothed
                .iter()
                .flat_map(move |s| (0..s.len()).map(move |k| s.state(k)[i].abs()))
        });
        values.fold(0.0f64, f64::max)
    };
    let (q, v) = (largest(&|i| i < n), largest(&|i| i >= n));
    let variance = |i: usize| match hidden.contains(&i) {
        true => (WIDE * if i < n { q } else { v }).powi(2),
        false => 0.0,
    };
    let mut variances: Vec<f64> = (0..problem.model.machine_states()).map(variance).collect();
    for (&i, size) in shown.iter().flat_map(|s| s.states.iter().zip(&s.sizes)) {
        variances[i] = (WIDE * size).powi(2);
    }
    variances
}

/// Fill the hidden first-order states of a recording's smoothed motion.
fn guess(model: &Model, hidden: &[usize], motion: &mut SmoothedRecording) {
    let n = model.coordinates.len();
    let first_order: Vec<usize> = hidden.iter().copied().filter(|&i| i >= 2 * n).collect();
    if first_order.is_empty() {
        return;
    }
    let system = System::new(model);
    let tries = magnitudes(model, hidden, motion);
    let mut knots: Vec<usize> = (0..motion.len()).step_by(motion.len().div_ceil(POINTS)).collect();
    if knots.last() != Some(&(motion.len() - 1)) {
        knots.push(motion.len() - 1);
    }
    for &state in &first_order {
        let values: Vec<f64> = knots
            .iter()
            .map(|&k| best(model, &system, hidden, motion, (k, state), &tries))
            .collect();
        for (pair, ends) in knots.windows(2).zip(values.windows(2)) {
            for k in pair[0]..=pair[1] {
                let share = (k - pair[0]) as f64 / (pair[1] - pair[0]) as f64;
                motion.set(k, state, ends[0] + share * (ends[1] - ends[0]));
            }
        }
    }
}

/// Zero and magnitudes of both signs about those of the measured states.
fn magnitudes(model: &Model, hidden: &[usize], motion: &SmoothedRecording) -> Vec<f64> {
    let measured = (0..model.machine_states()).filter(|i| !hidden.contains(i));
    let largest = measured
        .flat_map(|i| (0..motion.len()).map(move |k| motion.state(k)[i].abs()))
        .fold(0.0f64, f64::max);
    let mut out = vec![0.0];
    for k in 0..MAGNITUDES {
        let share = k as f64 / (MAGNITUDES - 1) as f64;
        let size = largest * SMALLEST * (LARGEST / SMALLEST).powf(share);
        out.extend([size, -size]);
    }
    out
}

/// The value of a hidden state at sample `k` with which the measured states move as they do.
fn best(
    model: &Model,
    system: &System,
    hidden: &[usize],
    motion: &SmoothedRecording,
    (k, state): (usize, usize),
    tries: &[f64],
) -> f64 {
    let (machine, m) = (model.machine_states(), model.input_width());
    let u = &motion.inputs[k * m..(k + 1) * m];
    let mut derivative = vec![0.0; system.states()];
    let mut miss = |value: f64| {
        let mut x = system.at_rest(motion.state(k));
        x[state] = value;
        system.derivative(motion.times[k], &x, u, &mut derivative);
        let off = |i: usize| (derivative[i] - motion.rate(k, i)).powi(2);
        let sum: f64 = (0..machine).filter(|i| !hidden.contains(i)).map(off).sum();
        if sum.is_finite() { sum } else { f64::INFINITY }
    };
    let scored: Vec<f64> = tries.iter().map(|&v| miss(v)).collect();
    let at = (0..tries.len()).min_by(|&a, &b| scored[a].total_cmp(&scored[b])).unwrap_or(0);
    // Between the neighbours of the best by golden section.
    let mut order: Vec<f64> = tries.to_vec();
    order.sort_by(f64::total_cmp);
    let place = order.iter().position(|v| *v == tries[at]).unwrap_or(0);
    let (mut low, mut high) =
        (order[place.saturating_sub(1)], order[(place + 1).min(order.len() - 1)]);
    const GOLDEN: f64 = 0.618_033_988_749_894_8;
    for _ in 0..40 {
        let (a, b) = (high - GOLDEN * (high - low), low + GOLDEN * (high - low));
        if miss(a) < miss(b) { high = b } else { low = a }
    }
    0.5 * (low + high)
}
