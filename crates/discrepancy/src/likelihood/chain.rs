//! A hypothesis on one recording, stepped from sample to sample in any kind of number.

use super::end::Diverged;
use super::filter::Filter;
use super::sweep::Run;
use super::{Problem, Window};
use crate::dataset::Observed;
use lacuna_numbers::Number;
use lacuna_plants::InputPath;
use lacuna_plants::model::{Measured, ModelEffect, SeriesEffect, System, sensed};

/// A hypothesis on one recording in one kind of number.
pub(super) struct Chain<'p, T: Number> {
    pub(super) run: &'p Run<'p>,
    pub(super) system: System<T>,
    pub(super) inputs: Inputs<T>,
    pub(super) sensors: Vec<SeriesEffect<T>>,
}

/// The effective inputs, row-major.
pub(super) enum Inputs<T> {
    /// They depend on nothing that moves.
    Fixed(Vec<f64>),
    /// They carry derivatives by parameters of actuators.
    Moving(Vec<T>),
}

impl<T: Number> Chain<'_, T> {
    /// Outputs over a window from a whole state, which is left at the window's end (of the
    /// sample after it where there is one). A filter corrects the state at each sample.
    ///
    /// # Errors
    /// [`Diverged`].
    pub(super) fn window(
        &self,
        w: &Window,
        filter: Option<&Filter>,
        state: &mut [T],
        mut visit: impl FnMut(&[T]),
    ) -> Result<Vec<Vec<T>>, Diverged> {
        let (problem, observed) = (self.run.problem, self.run.observed());
        let mut workspace = self.system.workspace();
        let count = problem.dataset.outputs.len();
        let mut out = vec![Vec::with_capacity(w.range.len()); count];
        let mut y = vec![T::constant(0.0); count];
        let mut innovations = vec![T::constant(0.0); count];
        let times = &observed.times;
        let inputs = self.inputs_along(w);
        for (at, k) in w.range.clone().enumerate() {
            problem.observation.evaluate(&self.system, times[k], state, inputs.sample(at), &mut y);
            for (series, value) in out.iter_mut().zip(&y) {
                series.push(*value);
            }
            if let Some(filter) = filter {
                for (o, innovation) in innovations.iter_mut().enumerate() {
                    *innovation = T::constant(0.0);
                    if filter.measured(at, o) {
                        let (run, times) = ((problem, observed), &times[w.range.clone()]);
                        *innovation = innovation_of(run, &self.sensors, (o, k), times, &out[o]);
                    }
                }
                filter.correct(at, &innovations, state);
            }
            visit(state);
            if k + 1 == times.len() {
                break;
            }
            let (span, input) = ((times[k], times[k + 1]), inputs.step(at));
            self.system.advance(&mut workspace, span, input, self.run.substeps, state);
            self.run.check(k + 1, state)?;
        }
        self.sense(&times[w.range.clone()], &mut out);
        Ok(out)
    }

    /// The inputs along a window and the step that leaves it.
    fn inputs_along(&self, w: &Window) -> InputPath<T> {
        let (problem, times) = (self.run.problem, &self.run.observed().times[..]);
        let model = problem.model;
        let (range, substeps) = (w.range.start..w.range.end + 1, self.run.substeps);
        match &self.inputs {
            Inputs::Fixed(inputs) => {
                model.inputs_along((times, inputs), range, substeps).map(|_, u| T::constant(*u))
            }
            Inputs::Moving(inputs) => model.inputs_along((times, inputs), range, substeps),
        }
    }

    /// What the sensors make of the outputs.
    fn sense(&self, times: &[f64], out: &mut [Vec<T>]) {
        for (series, output) in out.iter_mut().zip(&self.run.problem.dataset.outputs) {
            let Measured::State(state) = output.of else { continue };
            *series = sensed(&self.sensors, state, times, std::mem::take(series));
        }
    }
}

/// Samples that a sensor remembers: more than the longest delay that is believed.
const REMEMBERED: usize = 64;

/// What the sensors of an output make of the last value of its series.
fn sensed_last<T: Number>(
    sensors: &[SeriesEffect<T>],
    of: Measured,
    times: &[f64],
    series: &[T],
) -> T {
    let last = series[series.len() - 1];
    let Measured::State(state) = of else { return last };
    if sensors.iter().all(|s| s.channel != state) {
        return last;
    }
    let from = series.len().saturating_sub(REMEMBERED);
    let tail = sensed(sensors, state, &times[from..series.len()], series[from..].to_vec());
    tail[tail.len() - 1]
}

/// What was measured of output `o` at sample `k` beyond what its sensors make of its series, which
/// ends there, in units of the noise; NaN where nothing was measured.
fn innovation_of<T: Number>(
    (problem, observed): (&Problem, &Observed),
    sensors: &[SeriesEffect<T>],
    (o, k): (usize, usize),
    times: &[f64],
    series: &[T],
) -> T {
    let seen = sensed_last(sensors, problem.dataset.outputs[o].of, times, series);
    (-seen + observed.outputs[o][k]) * problem.weights[o]
}

/// What the sensors of a recording see of outputs that come sample by sample.
pub(super) struct Sensing<'p> {
    problem: &'p Problem<'p>,
    observed: &'p Observed,
    sensors: Vec<SeriesEffect>,
    begin: usize,
    times: &'p [f64],
    series: Vec<Vec<f64>>,
    innovations: Vec<f64>,
}

impl<'p> Sensing<'p> {
    pub(super) fn new(
        problem: &'p Problem<'p>,
        observed: &'p Observed,
        effects: &[ModelEffect],
        w: &Window,
    ) -> Self {
        let count = problem.dataset.outputs.len();
        Self {
            problem,
            observed,
            sensors: SeriesEffect::sensors(effects),
            begin: w.range.start,
            times: &observed.times[w.range.clone()],
            series: vec![Vec::with_capacity(w.range.len()); count],
            innovations: vec![0.0; count],
        }
    }

    /// Innovations of sample `k`, the next one, in units of the noise; NaN where nothing was
    /// measured.
    pub(super) fn innovations(&mut self, k: usize, outputs: &[f64]) -> &[f64] {
        debug_assert_eq!(self.series[0].len(), k - self.begin);
        for (o, y) in outputs.iter().enumerate() {
            self.series[o].push(*y);
            let (run, series) = ((self.problem, self.observed), &self.series[o]);
            self.innovations[o] = innovation_of(run, &self.sensors, (o, k), self.times, series);
        }
        &self.innovations
    }
}
