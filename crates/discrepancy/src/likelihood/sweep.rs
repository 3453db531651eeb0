//! One recording run through in its windows, in plain or in dual numbers.

use super::chain::{Chain, Inputs};
use super::end::Diverged;
use super::filter::Filter;
use super::{Hypothesis, Problem, Window};
use crate::dataset::Observed;
use lacuna_effects::Law;
use lacuna_numbers::{Dual, LANES, Number};
use lacuna_plants::model::{Direction, SeriesEffect, System, effective_inputs};
use rayon::prelude::*;

/// A value beyond this is divergence, not motion.
const DIVERGED: f64 = 1e12;

/// The states with which the windows of one recording begin.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Starts {
    /// The machine's state of each window.
    pub machine: Vec<Vec<f64>>,
    /// The effects' memory at the beginning of the recording.
    pub memory: Vec<f64>,
}

/// Residuals of a window and their derivatives.
#[derive(Clone, Debug, Default)]
pub struct Columns {
    /// (measured - predicted) / noise, output by output.
    pub residual: Vec<f64>,
    /// Derivative of the *prediction* in units of the noise: by the machine's state at the
    /// window's beginning, by the memory at the recording's beginning, by theta.
    pub by: Vec<Vec<f64>>,
}

/// A hypothesis that is run through some windows of one recording.
#[derive(Clone, Copy)]
pub struct Run<'a> {
    /// The model and the recordings.
    pub problem: &'a Problem<'a>,
    /// What is supposed.
    pub hypothesis: &'a Hypothesis,
    /// Windows of one recording, one after the other.
    pub windows: &'a [Window],
    /// Where they begin.
    pub starts: &'a Starts,
    /// A filter a window; none where no noise drives the machine.
    pub filters: &'a [Filter],
    /// Runge-Kutta steps a sample.
    pub substeps: usize,
}

impl Run<'_> {
    /// The recording.
    pub fn observed(&self) -> &Observed {
        &self.problem.dataset.recordings[self.windows[0].recording]
    }

    /// Whether a state at a sample is one.
    pub(super) fn check<T: Number>(&self, k: usize, state: &[T]) -> Result<(), Diverged> {
        let diverged = |x: &T| x.value().is_nan() || x.value().abs() > DIVERGED;
        if state.iter().any(diverged) {
            let observed = self.observed();
            return Err(Diverged { recording: observed.name.clone(), time: observed.times[k] });
        }
        Ok(())
    }

    /// Sum of squares of the residuals of each window, in units of their noise.
    ///
    /// # Errors
    /// [`Diverged`].
    pub fn squares(&self) -> Result<Vec<f64>, Diverged> {
        let mut sums = Vec::with_capacity(self.windows.len());
        self.through(
            |_| (),
            |k, w, out| {
                let mut residual = vec![];
                scan(self.problem, w, &out, |measured, y, weight| {
                    residual.push((measured - y) * weight);
                });
                self.whiten(k, w, std::iter::once(&mut residual));
                sums.push(residual.iter().map(|r| r * r).sum::<f64>());
            },
        )?;
        Ok(sums)
    }

    /// The whole state at each sample of the recording, corrected by what was measured there
    /// where noise drives the machine.
    ///
    /// # Errors
    /// [`Diverged`].
    pub fn trajectory(&self) -> Result<Vec<f64>, Diverged> {
        let mut out = Vec::new();
        self.through(|x| out.extend_from_slice(x), |_, _, _| ())?;
        Ok(out)
    }

    /// Run through the windows, memory running on from each to the next: `visit` the whole state
    /// at each sample, then hand on each window's number and outputs.
    fn through(
        &self,
        mut visit: impl FnMut(&[f64]),
        mut each: impl FnMut(usize, &Window, Vec<Vec<f64>>),
    ) -> Result<(), Diverged> {
        let (problem, h) = (self.problem, self.hypothesis);
        let chain = Chain {
            run: self,
            system: System::with(problem.model, &h.parameters, &h.effects),
            inputs: Inputs::Fixed(problem.effective_inputs(&h.effects, self.observed())),
            sensors: SeriesEffect::sensors(&h.effects),
        };
        let machine = problem.model.machine_states();
        let mut memory = self.starts.memory.clone();
        for (k, (w, x)) in self.windows.iter().zip(&self.starts.machine).enumerate() {
            let mut state: Vec<f64> = x.iter().chain(&memory).copied().collect();
            let out = chain.window(w, self.filters.get(k), &mut state, &mut visit)?;
            memory.copy_from_slice(&state[machine..]);
            each(k, w, out);
        }
        Ok(())
    }

    /// Columns of the `k`-th window in units of the innovations' standard deviation.
    fn whiten<'c>(&self, k: usize, w: &Window, columns: impl Iterator<Item = &'c mut Vec<f64>>) {
        if let Some(filter) = self.filters.get(k) {
            filter.whiten(self.observed(), w, columns);
        }
    }

    /// Residuals of the windows with their derivatives by the machine's states, the memory and
    /// theta.
    ///
    /// Memory that runs on into a window is taken to depend on theta, not on the states of the
    /// windows before it.
    ///
    /// # Errors
    /// [`Diverged`].
    pub fn linearise(&self) -> Result<Vec<Columns>, Diverged> {
        let machine = self.problem.model.machine_states();
        let entries = machine + self.starts.memory.len() + self.hypothesis.free.len();
        let parts: Result<Vec<Vec<Columns>>, Diverged> = (0..entries.div_ceil(LANES))
            .into_par_iter()
            .map(|chunk| {
                let lanes = chunk * LANES..((chunk + 1) * LANES).min(entries);
                Sweep { run: self, lanes }.run()
            })
            .collect();
        let mut all: Vec<Columns> = vec![Columns::default(); self.windows.len()];
        for part in parts? {
            for (columns, part) in all.iter_mut().zip(part) {
                columns.residual = part.residual;
                columns.by.extend(part.by);
            }
        }
        for (k, (columns, w)) in all.iter_mut().zip(self.windows).enumerate() {
            let Columns { residual, by } = columns;
            self.whiten(k, w, std::iter::once(residual).chain(by));
        }
        Ok(all)
    }
}

/// Some of the entries, carried along in the lanes of dual numbers.
struct Sweep<'p> {
    run: &'p Run<'p>,
    lanes: std::ops::Range<usize>,
}

impl Sweep<'_> {
    fn lane(&self, entry: usize) -> Option<usize> {
        self.lanes.contains(&entry).then(|| entry - self.lanes.start)
    }

    /// Entries of theta in these lanes: index, lane.
    fn theta(&self) -> impl Iterator<Item = (usize, usize)> + '_ {
        let before = self.run.problem.model.machine_states() + self.run.starts.memory.len();
        (0..self.run.hypothesis.free.len()).filter_map(move |j| Some((j, self.lane(before + j)?)))
    }

    fn chain(&self) -> Chain<'_, Dual> {
        let (problem, h) = (self.run.problem, self.run.hypothesis);
        let directions: Vec<(Direction, usize)> =
            self.theta().map(|(j, lane)| (h.direction(j), lane)).collect();
        let (model, sample) = (problem.model, problem.sample);
        Chain {
            run: self.run,
            system: System::along(model, &h.parameters, &h.effects, &directions, sample),
            inputs: self.inputs(self.run.observed(), &directions),
            sensors: SeriesEffect::sensors_along(&h.effects, &directions),
        }
    }

    /// The effective inputs, with derivatives where a parameter of an actuator is in these lanes.
    fn inputs(&self, observed: &Observed, directions: &[(Direction, usize)]) -> Inputs<Dual> {
        let (problem, effects) = (self.run.problem, &self.run.hypothesis.effects);
        let on_input = |e: usize| matches!(effects[e].effect.law, Law::Input(_));
        let moves =
            directions.iter().any(|(d, _)| matches!(*d, Direction::Effect(e, _) if on_input(e)));
        if !moves {
            return Inputs::Fixed(problem.effective_inputs(effects, observed));
        }
        let along = SeriesEffect::inputs_along(effects, directions);
        let commands = observed.commands.iter().map(|&u| Dual::constant(u)).collect();
        let m = problem.model.input_width();
        Inputs::Moving(effective_inputs(&along, m, &observed.times, commands))
    }

    fn run(&self) -> Result<Vec<Columns>, Diverged> {
        let (chain, slopes) = (self.chain(), self.slopes());
        let Run { problem, windows, starts, filters, .. } = *self.run;
        let machine = problem.model.machine_states();
        let seed = |value: f64, entry: usize| Dual::among(value, entry, self.lanes.start);
        let memory = starts.memory.iter().enumerate();
        let mut memory: Vec<Dual> = memory.map(|(i, &z)| seed(z, machine + i)).collect();
        let mut all = Vec::with_capacity(windows.len());
        for (k, (w, x)) in windows.iter().zip(&starts.machine).enumerate() {
            let mut state: Vec<Dual> = x.iter().enumerate().map(|(i, &x)| seed(x, i)).collect();
            state.extend_from_slice(&memory);
            let out = chain.window(w, filters.get(k), &mut state, |_| ())?;
            memory.copy_from_slice(&state[machine..]);
            self.forget(&mut memory);
            all.push(self.columns(w, &out, &slopes));
        }
        Ok(all)
    }

    /// Memory forgets the states of the window that it leaves.
    fn forget(&self, memory: &mut [Dual]) {
        let states = self.run.problem.model.machine_states() + self.run.starts.memory.len();
        for entry in self.lanes.clone().filter(|&e| e < states) {
            for z in memory.iter_mut() {
                z.tangent[entry - self.lanes.start] = 0.0;
            }
        }
    }

    /// Derivative of what each lane carries by the entry that is fitted: that of the plain value
    /// where its logarithm is.
    fn slopes(&self) -> Vec<f64> {
        let mut slopes = vec![1.0; self.lanes.len()];
        let values = self.run.hypothesis.theta();
        for (j, lane) in self.theta() {
            slopes[lane] = self.run.hypothesis.free[j].slope(values[j]);
        }
        slopes
    }

    fn columns(&self, w: &Window, out: &[Vec<Dual>], slopes: &[f64]) -> Columns {
        let mut columns = Columns { residual: vec![], by: vec![Vec::new(); self.lanes.len()] };
        scan(self.run.problem, w, out, |measured, y: Dual, weight| {
            columns.residual.push((measured - y.value) * weight);
            for (l, by) in columns.by.iter_mut().enumerate() {
                by.push(y.tangent[l] * weight * slopes[l]);
            }
        });
        columns
    }
}

/// Go over the measured samples of a window, output by output: what was measured, what `out` has
/// there, and the output's weight.
pub(crate) fn scan<T: Copy>(
    problem: &Problem,
    w: &Window,
    out: &[Vec<T>],
    mut each: impl FnMut(f64, T, f64),
) {
    let observed = &problem.dataset.recordings[w.recording];
    for (output, series) in out.iter().enumerate() {
        let weight = problem.weights[output];
        let measured = &observed.outputs[output][w.range.clone()];
        for (&y, &predicted) in measured.iter().zip(series) {
            if y.is_finite() {
                each(y, predicted, weight);
            }
        }
    }
}
