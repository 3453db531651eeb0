//! First-order states that nothing measures but an expression, or the force on an imposed
//! coordinate: a pressure by what it pushes with, a level by the reading of a load cell.
//!
//! Where the recorded y = h(x, u) depends on such a state x, the model is simulated from the
//! recorded inputs, with what is measured as it was measured; h there tells how large x is, and
//! where in the simulated motion the recording begins,
//!
//! ```text
//! x ~ x_k + (y_k - h(x_k, u_k)) / (dh/dx),   x_0 = argmin_k |(y_0 - h(x_k, u_0)) / sigma|^2
//! ```
//!
//! from where a filter follows it.

use super::problem::Problem;
use super::sweep::DIVERGED;
use crate::trajectories::SmoothedRecording;
use lacuna_numbers::{Dual, Number};
use lacuna_plants::Substeps;
use lacuna_plants::model::{Measured, System};

/// Samples of a recording at which outputs are looked at.
const POINTS: usize = 200;

/// Hidden first-order states, where outputs show any of them.
pub(super) struct Shown {
    /// Their entries of the machine's state.
    pub states: Vec<usize>,
    /// How large each is: as recorded where an output shows it, else as simulated.
    pub sizes: Vec<f64>,
    /// The state of which each recording begins.
    pub begins: Vec<Vec<f64>>,
}

impl Shown {
    /// Of a problem, whose smoothed motion then has its hidden states as the model simulates them; none where no output
    /// shows a first-order one, and the motion stays as it is.
    pub(super) fn simulated(problem: &mut Problem) -> Option<Self> {
        let n = problem.model.coordinates.len();
        let states: Vec<usize> = problem.hidden.iter().copied().filter(|&i| i >= 2 * n).collect();
        let is_entry = |o: &crate::Output| matches!(o.of, Measured::State(_));
        if states.is_empty() || problem.dataset.outputs.iter().all(is_entry) {
            return None;
        }
        let hidden = problem.hidden.clone();
        let model = problem.model;
        let steps = problem.substeps(&model.values(), &model.effects, false);
        let recordings = 0..problem.smoothed.len();
        let motion = recordings.clone().map(|r| simulated(problem, r, steps)).collect();
        let measured = std::mem::replace(&mut problem.smoothed, motion);
        let sizes: Vec<Option<f64>> = states.iter().map(|&i| recorded_size(problem, i)).collect();
        if sizes.iter().all(Option::is_none) {
            problem.smoothed = measured;
            return None;
        }
        let largest = |i: usize| problem.series(|x| x[i].abs()).into_iter().fold(0.0, f64::max);
        let size = |(i, size): (&usize, Option<f64>)| size.unwrap_or_else(|| largest(*i));
        let sizes = states.iter().zip(sizes).map(size).collect();
        let begins = recordings.map(|r| begin(problem, r, &hidden)).collect();
        Some(Self { states, sizes, begins })
    }
}

/// A recording's motion with its hidden states as the model says, what is measured being as it was
/// measured; from 0, again where it runs away.
fn simulated(problem: &Problem, r: usize, steps: Substeps) -> SmoothedRecording {
    let (model, observed) = (problem.model, &problem.dataset.recordings[r]);
    let system = System::new(model);
    let mut motion = problem.smoothed[r].clone();
    let inputs = problem.effective_inputs(&model.effects, observed);
    let path = model.inputs_along((&observed.times, &inputs), 0..motion.len(), steps.count);
    let mut workspace = system.workspace();
    let mut x = system.at_rest(motion.state(0));
    for k in 1..motion.len() {
        let times = (motion.times[k - 1], motion.times[k]);
        system.advance(&mut workspace, times, path.step_in(k - 1), steps, &mut x);
        if !x.iter().all(|x| x.abs() < DIVERGED) {
            x = system.at_rest(motion.state(k));
        }
        for (i, x) in x.iter_mut().enumerate().take(model.machine_states()) {
            match problem.hidden.contains(&i) {
                true => motion.set(k, i, *x),
                false => *x = motion.state(k)[i],
            }
        }
    }
    motion
}

/// How large a state is by the output that shows it best, in the middle along the recordings; none
/// where no output depends on it.
fn recorded_size(problem: &Problem, state: usize) -> Option<f64> {
    let model = problem.model;
    let system = System::along(model, &model.values(), &model.effects, &[], problem.sample);
    let mut sizes: Vec<f64> = (0..problem.smoothed.len())
        .flat_map(|r| points(&problem.smoothed[r]).map(move |k| (r, k)))
        .filter_map(|at| recorded(problem, &system, at, state))
        .map(f64::abs)
        .collect();
    sizes.sort_by(f64::total_cmp);
    sizes.get(sizes.len() / 2).copied()
}

/// A state at a sample by the output that shows it best there.
fn recorded(
    problem: &Problem,
    system: &System<Dual>,
    (r, k): (usize, usize),
    state: usize,
) -> Option<f64> {
    let machine = problem.smoothed[r].state(k);
    let at_rest = system.at_rest(machine).into_iter().enumerate();
    let x: Vec<Dual> = at_rest.map(|(i, x)| Dual::among(x, i, state)).collect();
    let outputs = &problem.dataset.recordings[r].outputs;
    let told = shown(problem, system, (r, k), &x).into_iter().zip(outputs).zip(&problem.weights);
    told.map(|((y, measured), weight)| {
        let slope = y.tangent[0];
        (slope.abs() * weight, machine[state] + (measured[k] - y.value) / slope)
    })
    .filter(|(weight, x)| *weight > 0.0 && weight.is_finite() && x.is_finite())
    .max_by(|a, b| a.0.total_cmp(&b.0))
    .map(|(_, x)| x)
}

/// The measured state at the beginning of a recording, hidden entries being those of the simulated
/// motion with which the outputs are nearest to what was recorded first.
fn begin(problem: &Problem, r: usize, hidden: &[usize]) -> Vec<f64> {
    let (system, motion) = (System::new(problem.model), &problem.smoothed[r]);
    let outputs = &problem.dataset.recordings[r].outputs;
    let first = |series: &Vec<f64>| series.iter().copied().find(|y| y.is_finite());
    let first: Vec<Option<f64>> = outputs.iter().map(first).collect();
    let from = |k: usize| {
        let mut x = motion.state(0).to_vec();
        hidden.iter().for_each(|&i| x[i] = motion.state(k)[i]);
        x
    };
    let off = |k: usize| {
        let shown = shown(problem, &system, (r, 0), &system.at_rest(&from(k)));
        let each = shown.iter().zip(&first).zip(&problem.weights);
        each.filter_map(|((y, first), weight)| Some((((*first)? - y) * weight).powi(2))).sum()
    };
    let all = points(motion).map(|k| (k, off(k))).filter(|(_, off): &(usize, f64)| off.is_finite());
    let nearest = all.min_by(|a, b| a.1.total_cmp(&b.1));
    from(nearest.map_or(0, |(k, _)| k))
}

/// The outputs of a whole state with the inputs and the time of a sample.
fn shown<T: Number>(
    problem: &Problem,
    system: &System<T>,
    (r, k): (usize, usize),
    x: &[T],
) -> Vec<T> {
    let (motion, m) = (&problem.smoothed[r], problem.model.input_width());
    let u: Vec<T> = motion.inputs[k * m..(k + 1) * m].iter().map(|&u| T::constant(u)).collect();
    let mut y = vec![T::constant(0.0); problem.dataset.outputs.len()];
    problem.observation.evaluate(system, motion.times[k], x, &u, &mut y);
    y
}

/// Samples that are spread evenly over a recording.
fn points(motion: &SmoothedRecording) -> impl Iterator<Item = usize> + use<> {
    (0..motion.len()).step_by(motion.len().div_ceil(POINTS).max(1))
}
