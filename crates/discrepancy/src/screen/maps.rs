//! The equations of motion linearised along a fitted trajectory, step by step.
//!
//! ```text
//! d_{k+1} = A_k d_k + B_k r_k + E_k v_k,    y_k = C_k d_k
//! ```
//!
//! where r is a small force on each channel, v a small change of each input, and y what the
//! outputs change by. The derivatives are exact: those of the Runge-Kutta step itself.

use crate::likelihood::{Fit, Problem};
use lacuna_numbers::{Dual, LANES, Number};
use lacuna_plants::Hold;
use lacuna_plants::model::{Direction, Measured, System};
use rayon::prelude::*;

/// A recording's maps from sample to sample.
pub struct Maps {
    /// Length of d: the machine's state and the memory of effects.
    pub width: usize,
    /// Columns of one map: d, forces, inputs.
    columns: usize,
    /// Maps, row-major `width x columns`, one a sample.
    steps: Vec<f64>,
    /// Outputs by the machine's state, row-major, one a sample; empty where all are entries of
    /// the state.
    outputs: Vec<f64>,
    /// The entry of the state that each output is.
    entries: Vec<Option<usize>>,
    machine: usize,
    /// Inputs after the effects of the fit.
    pub inputs: Vec<f64>,
}

/// What drives the linearised motion.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Drive {
    /// A force on a channel.
    Force(usize),
    /// A change of an input.
    Input(usize),
}

impl Maps {
    /// Linearise a recording along the states `path` (rows of the whole state).
    #[must_use]
    pub fn new(fit: &Fit, recording: usize, path: &[f64]) -> Self {
        let problem = fit.problem;
        let (model, h) = (problem.model, &fit.hypothesis);
        let observed = &problem.dataset.recordings[recording];
        let m = model.inputs.len();
        let machine = model.machine_states();
        let width = path.len() / observed.len();
        let columns = width + model.channels() + m;
        let inputs = problem.effective_inputs(&h.effects, observed);
        let linear =
            Linear { problem, fit, times: &observed.times, inputs: &inputs, width, columns };
        let rows: Vec<Vec<f64>> = (0..columns.div_ceil(LANES))
            .into_par_iter()
            .map(|chunk| linear.chunk(chunk * LANES, path))
            .collect();
        let samples = observed.len();
        let mut steps = vec![0.0; samples * width * columns];
        for (chunk, part) in rows.iter().enumerate() {
            let first = chunk * LANES;
            let lanes = LANES.min(columns - first);
            for (row, values) in part.chunks_exact(LANES).enumerate() {
                let at = row * columns + first;
                steps[at..at + lanes].copy_from_slice(&values[..lanes]);
            }
        }
        let entries: Vec<Option<usize>> = problem
            .dataset
            .outputs
            .iter()
            .map(|o| if let Measured::State(i) = o.of { Some(i) } else { None })
            .collect();
        let outputs =
            if entries.iter().all(Option::is_some) { vec![] } else { linear.outputs(path) };
        Self { width, columns, steps, outputs, entries, machine, inputs }
    }

    /// Add to `out` (one series an output, as long as `range`) what driving with `series`
    /// changes, from no change at the beginning of the range.
    pub fn propagate(
        &self,
        range: &std::ops::Range<usize>,
        channels: usize,
        drives: &[(Drive, &[f64], f64)],
        out: &mut [Vec<f64>],
    ) {
        let (n, c) = (self.width, self.columns);
        let (mut d, mut next) = (vec![0.0; n], vec![0.0; n]);
        let places: Vec<usize> = drives
            .iter()
            .map(|drive| match drive.0 {
                Drive::Force(channel) => n + channel,
                Drive::Input(j) => n + channels + j,
            })
            .collect();
        for (at, k) in range.clone().enumerate() {
            self.observe(k, &d, at, out);
            let map = &self.steps[k * n * c..(k + 1) * n * c];
            for (i, next) in next.iter_mut().enumerate() {
                let row = &map[i * c..(i + 1) * c];
                let own: f64 = row[..n].iter().zip(&d).map(|(a, x)| a * x).sum();
                let driven = drives.iter().zip(&places);
                *next = own + driven.map(|((_, s, sign), &p)| row[p] * s[k] * sign).sum::<f64>();
            }
            std::mem::swap(&mut d, &mut next);
        }
    }

    fn observe(&self, k: usize, d: &[f64], at: usize, out: &mut [Vec<f64>]) {
        let count = out.len();
        for (o, series) in out.iter_mut().enumerate() {
            series[at] += match self.entries[o] {
                Some(i) => d[i],
                None => {
                    let row = (k * count + o) * self.machine;
                    let slopes = &self.outputs[row..row + self.machine];
                    slopes.iter().zip(d).map(|(c, x)| c * x).sum()
                }
            };
        }
    }
}

struct Linear<'p> {
    problem: &'p Problem<'p>,
    fit: &'p Fit<'p>,
    times: &'p [f64],
    inputs: &'p [f64],
    width: usize,
    columns: usize,
}

impl Linear<'_> {
    /// Derivatives of every step in [`LANES`] directions from `first` on: rows of the state's
    /// entries, sample after sample. The last sample has no step.
    fn chunk(&self, first: usize, path: &[f64]) -> Vec<f64> {
        let (problem, h) = (self.problem, &self.fit.hypothesis);
        let (model, m) = (problem.model, problem.model.inputs.len());
        let lane = |entry: usize| {
            (entry >= first && entry < (first + LANES).min(self.columns)).then(|| entry - first)
        };
        let forces: Vec<(Direction, usize)> = (0..model.channels())
            .filter_map(|c| Some((Direction::Force(c), lane(self.width + c)?)))
            .collect();
        let system = System::along(model, &h.parameters, &h.effects, &forces, problem.sample);
        let mut workspace = system.workspace();
        let seed = |value: f64, entry: usize| match lane(entry) {
            Some(l) => Dual::direction(value, l),
            None => Dual::constant(value),
        };
        let mut out = vec![0.0; self.times.len() * self.width * LANES];
        let mut state = vec![Dual::constant(0.0); self.width];
        for k in 0..self.times.len() - 1 {
            for (i, x) in state.iter_mut().enumerate() {
                *x = seed(path[k * self.width + i], i);
            }
            let inputs = |at: usize| -> Vec<Dual> {
                let base = self.width + model.channels();
                (0..m).map(|j| seed(self.inputs[at * m + j], base + j)).collect()
            };
            let here = inputs(k);
            let next = match model.hold {
                Hold::ZeroOrder => here.clone(),
                Hold::Linear => inputs(k + 1),
            };
            let span = (self.times[k], self.times[k + 1]);
            system.advance(&mut workspace, span, (&here, &next), self.fit.substeps, &mut state);
            let rows = &mut out[k * self.width * LANES..(k + 1) * self.width * LANES];
            for (row, x) in rows.chunks_exact_mut(LANES).zip(&state) {
                row.copy_from_slice(&x.tangent);
            }
        }
        out
    }

    /// Derivatives of the outputs by the machine's state.
    fn outputs(&self, path: &[f64]) -> Vec<f64> {
        let problem = self.problem;
        let (observation, count) = (&problem.observation, problem.dataset.outputs.len());
        let parameters = &self.fit.hypothesis.parameters;
        let numbers: Vec<Dual> = parameters.iter().map(|&p| Dual::constant(p)).collect();
        let bound = observation.bind(&numbers);
        let (machine, m) = (problem.model.machine_states(), problem.model.inputs.len());
        let mut y = vec![Dual::constant(0.0); count];
        let mut out = vec![0.0; self.times.len() * count * machine];
        for first in (0..machine).step_by(LANES) {
            for (k, &t) in self.times.iter().enumerate() {
                let state: Vec<Dual> = (0..machine)
                    .map(|i| {
                        let value = path[k * self.width + i];
                        if i >= first && i < first + LANES {
                            Dual::direction(value, i - first)
                        } else {
                            Dual::constant(value)
                        }
                    })
                    .collect();
                let u: Vec<Dual> =
                    self.inputs[k * m..(k + 1) * m].iter().map(|&u| Dual::constant(u)).collect();
                observation.evaluate(&bound, t, &state, &u, &mut y);
                for (o, y) in y.iter().enumerate() {
                    for i in first..(first + LANES).min(machine) {
                        out[(k * count + o) * machine + i] = y.tangent[i - first];
                    }
                }
            }
        }
        out
    }
}
