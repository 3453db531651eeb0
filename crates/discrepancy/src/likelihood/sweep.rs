//! One recording run through in its windows, in plain or in dual numbers.

use super::chain::{Chain, Inputs, Link};
use super::end::Diverged;
use super::filter::Filter;
use super::{Hypothesis, Problem, Window};
use crate::dataset::Observed;
use lacuna_effects::Law;
use lacuna_numbers::{Dual, LANES, Number};
use lacuna_plants::Substeps;
use lacuna_plants::dynamics::Sharing;
use lacuna_plants::model::{Direction, SeriesEffect, System, effective_inputs};
use rayon::prelude::*;

/// A value beyond this is divergence, not motion.
pub(super) const DIVERGED: f64 = 1e12;

/// The states with which the windows of one recording begin.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Starts {
    /// The machine's state of each window.
    pub machine: Vec<Vec<f64>>,
    /// The effects' memory at the beginning of the recording.
    pub memory: Vec<f64>,
}

/// Windows one after the other, the states with which they begin, a filter a window.
pub(super) type Piece<'w> = (&'w [Window], Starts, &'w [Filter]);

/// Windows of a piece of a recording that begins with such a memory: memory runs on from window to window, and
/// without any a recording falls apart into pieces that can be run through side by side.
pub(super) fn piece_length(windows: usize, memory: &[f64]) -> usize {
    const PIECES: usize = 4;
    windows.div_ceil(if memory.is_empty() { PIECES } else { 1 }).max(1)
}

/// The windows of a recording in pieces that can be run through side by side.
pub(super) fn pieces<'w>(
    windows: &'w [Window],
    starts: &Starts,
    filters: &'w [Filter],
) -> Vec<Piece<'w>> {
    let length = piece_length(windows.len(), &starts.memory);
    let piece = |(k, windows): (usize, &'w [Window])| {
        let range = k * length..k * length + windows.len();
        let machine = starts.machine[range.clone()].to_vec();
        let starts = Starts { machine, memory: starts.memory.clone() };
        (windows, starts, filters.get(range).unwrap_or(&[]))
    };
    windows.chunks(length).enumerate().map(piece).collect()
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
    pub substeps: Substeps,
}

impl<'a> Run<'a> {
    /// The recording.
    pub fn observed(&self) -> &'a Observed {
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
                let mut residual = Vec::with_capacity(w.range.len() * out.len());
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
        let link = Link {
            system: System::with(problem.model, &h.parameters, &h.effects),
            inputs: Inputs::Fixed(problem.effective_inputs(&h.effects, self.observed())),
            sensors: SeriesEffect::sensors(&h.effects),
        };
        let chain = Chain { run: self, links: vec![link] };
        let machine = problem.model.machine_states();
        let mut memory = self.starts.memory.clone();
        for (k, (w, x)) in self.windows.iter().zip(&self.starts.machine).enumerate() {
            let mut states = [x.iter().chain(&memory).copied().collect::<Vec<f64>>()];
            let out = chain.window(w, self.filters.get(k), &mut states, &mut visit)?;
            memory.copy_from_slice(&states[0][machine..]);
            out.into_iter().for_each(|out| each(k, w, out));
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
    /// windows before it. So many runs are made side by side that share the machine's threads.
    ///
    /// # Errors
    /// [`Diverged`].
    pub fn linearise(&self, beside: usize) -> Result<Vec<Columns>, Diverged> {
        self.linearise_from(0, beside)
    }

    /// The same by theta alone.
    ///
    /// # Errors
    /// [`Diverged`].
    pub fn linearise_by_theta(&self, beside: usize) -> Result<Vec<Columns>, Diverged> {
        let machine = self.problem.model.machine_states();
        self.linearise_from(machine + self.starts.memory.len(), beside)
    }

    /// [`Run::linearise`], where so many runs are made side by side; without memory, which runs on from
    /// window to window, pieces of the recording are run through side by side as well.
    ///
    /// # Errors
    /// [`Diverged`].
    pub fn linearise_in_pieces(&self, beside: usize) -> Result<Vec<Columns>, Diverged> {
        let pieces = pieces(self.windows, self.starts, self.filters);
        let beside = pieces.len() * beside;
        let piece = |(windows, starts, filters): &Piece| {
            Run { windows, starts, filters, ..*self }.linearise(beside)
        };
        let parts: Result<Vec<_>, Diverged> = pieces.par_iter().map(piece).collect();
        Ok(parts?.into_iter().flatten().collect())
    }

    fn linearise_from(&self, begin: usize, beside: usize) -> Result<Vec<Columns>, Diverged> {
        let machine = self.problem.model.machine_states();
        let entries = machine + self.starts.memory.len() + self.hypothesis.free.len();
        let sweep = |first: usize| Sweep { run: self, lanes: first..entries.min(first + LANES) };
        // One at least: residuals are told by those that carry nothing as well.
        let sweeps: Vec<Sweep> =
            (begin..entries.max(begin + 1)).step_by(LANES).map(sweep).collect();
        // What sweeps share is computed once for those that run together, and so cut the same steps.
        let threads = (rayon::current_num_threads() / beside).max(1);
        let together = match self.problem.model.dynamics().sharing() {
            Sharing::None if !self.substeps.cut => 1,
            Sharing::Some if !self.substeps.cut => sweeps.len().div_ceil(threads),
            _ => sweeps.len(),
        };
        let parts: Result<Vec<Vec<Vec<Columns>>>, Diverged> =
            sweeps.par_chunks(together.max(1)).map(|sweeps| self.sweep(sweeps)).collect();
        let mut all: Vec<Columns> = vec![Columns::default(); self.windows.len()];
        for part in parts?.into_iter().flatten() {
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

impl Run<'_> {
    /// The columns of the windows, sweep by sweep.
    fn sweep(&self, sweeps: &[Sweep]) -> Result<Vec<Vec<Columns>>, Diverged> {
        let chain = Chain { run: self, links: sweeps.iter().map(Sweep::link).collect() };
        let slopes: Vec<Vec<f64>> = sweeps.iter().map(Sweep::slopes).collect();
        let machine = self.problem.model.machine_states();
        let mut memory: Vec<Vec<Dual>> = sweeps.iter().map(Sweep::memory).collect();
        let mut all = vec![Vec::with_capacity(self.windows.len()); sweeps.len()];
        for (k, (w, x)) in self.windows.iter().zip(&self.starts.machine).enumerate() {
            let begin = |(s, z): (&Sweep, &Vec<Dual>)| s.begin(x, z);
            let mut states: Vec<Vec<Dual>> = sweeps.iter().zip(&memory).map(begin).collect();
            let out = chain.window(w, self.filters.get(k), &mut states, |_| ())?;
            for (i, (sweep, out)) in sweeps.iter().zip(&out).enumerate() {
                memory[i].copy_from_slice(&states[i][machine..]);
                sweep.forget(&mut memory[i]);
                all[i].push(sweep.columns(w, out, &slopes[i]));
            }
        }
        Ok(all)
    }
}

/// Some of the entries, carried along in the lanes of dual numbers.
struct Sweep<'p> {
    run: &'p Run<'p>,
    lanes: std::ops::Range<usize>,
}

impl<'p> Sweep<'p> {
    fn lane(&self, entry: usize) -> Option<usize> {
        self.lanes.contains(&entry).then(|| entry - self.lanes.start)
    }

    /// Entries of theta in these lanes: index, lane.
    fn theta(&self) -> impl Iterator<Item = (usize, usize)> + '_ {
        let before = self.run.problem.model.machine_states() + self.run.starts.memory.len();
        (0..self.run.hypothesis.free.len()).filter_map(move |j| Some((j, self.lane(before + j)?)))
    }

    fn link(&self) -> Link<'p, Dual> {
        let (problem, h) = (self.run.problem, self.run.hypothesis);
        let directions: Vec<(Direction, usize)> =
            self.theta().map(|(j, lane)| (h.direction(j), lane)).collect();
        let (model, sample) = (problem.model, problem.sample);
        Link {
            system: System::along(model, &h.parameters, &h.effects, &directions, sample),
            inputs: self.inputs(self.run.observed(), &directions),
            sensors: SeriesEffect::sensors_along(&h.effects, &directions),
        }
    }

    /// The effective inputs, with derivatives where a parameter of an actuator is in these lanes.
    fn inputs(
        &self,
        observed: &'p Observed,
        directions: &[(Direction, usize)],
    ) -> Inputs<'p, Dual> {
        let (problem, effects) = (self.run.problem, &self.run.hypothesis.effects);
        let on_input = |e: usize| {
            let (effect, channel) = (effects[e].effect, effects[e].channel);
            let inner = problem.model.in_servo(effect, channel).is_some();
            matches!(effect.law, Law::Input(_)) && !inner
        };
        let moves =
            directions.iter().any(|(d, _)| matches!(*d, Direction::Effect(e, _) if on_input(e)));
        if !moves {
            return Inputs::Fixed(problem.effective_inputs(effects, observed));
        }
        let along = SeriesEffect::inputs_along(problem.model, effects, directions);
        let commands = observed.commands.iter().map(|&u| Dual::constant(u)).collect();
        let m = problem.model.input_width();
        Inputs::Moving(effective_inputs(&along, m, &observed.times, commands))
    }

    fn seed(&self, value: f64, entry: usize) -> Dual {
        Dual::among(value, entry, self.lanes.start)
    }

    /// The memory with which the recording begins.
    fn memory(&self) -> Vec<Dual> {
        let machine = self.run.problem.model.machine_states();
        let memory = self.run.starts.memory.iter().enumerate();
        memory.map(|(i, &z)| self.seed(z, machine + i)).collect()
    }

    /// The whole state with which a window begins.
    fn begin(&self, machine: &[f64], memory: &[Dual]) -> Vec<Dual> {
        let machine = machine.iter().enumerate().map(|(i, &x)| self.seed(x, i));
        machine.chain(memory.iter().copied()).collect()
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
        let rows = w.range.len() * out.len();
        let by = (0..self.lanes.len()).map(|_| Vec::with_capacity(rows)).collect();
        let mut columns = Columns { residual: Vec::with_capacity(rows), by };
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
