//! A hypothesis on one recording, stepped from sample to sample in any kind of number.

use super::end::Diverged;
use super::filter::Filter;
use super::sweep::Run;
use super::{Problem, Window};
use crate::dataset::Observed;
use lacuna_numbers::Number;
use lacuna_plants::InputPath;
use lacuna_plants::model::{
    Measured, ModelEffect, SeriesEffect, StepInput, Strand, System, Workspace, advance_together,
    sensed,
};
use std::borrow::Cow;
use std::sync::Arc;

/// A hypothesis on one recording in one kind of number.
pub(super) struct Chain<'p, T: Number> {
    pub(super) run: &'p Run<'p>,
    /// The same in all of them, but for the directions that their numbers carry.
    pub(super) links: Vec<Link<'p, T>>,
}

/// What a chain steps along.
pub(super) struct Link<'p, T: Number> {
    pub(super) system: System<T>,
    pub(super) inputs: Inputs<'p, T>,
    pub(super) sensors: Vec<SeriesEffect<T>>,
}

/// The effective inputs, row-major.
pub(super) enum Inputs<'p, T> {
    /// They depend on nothing that moves.
    Fixed(Cow<'p, [f64]>),
    /// They carry derivatives by parameters of actuators.
    Moving(Vec<T>),
}

/// The effective inputs along a window and the step that leaves it.
enum Along<'c, T: Number> {
    Fixed(Arc<InputPath<'c, f64>>),
    Moving(InputPath<'c, T>),
}

impl<T: Number> Along<'_, T> {
    fn step(&self, at: usize) -> StepInput<'_, T> {
        match self {
            Self::Fixed(path) => path.step_in(at),
            Self::Moving(path) => path.step(at),
        }
    }

    fn sample(&self, at: usize, u: &mut [T]) {
        match self {
            Self::Fixed(path) => path.sample_in(at, u),
            Self::Moving(path) => u.copy_from_slice(path.sample(at)),
        }
    }
}

/// A link on its way through a window.
struct Way<'c, T: Number> {
    link: &'c Link<'c, T>,
    inputs: Along<'c, T>,
    workspace: Workspace<T>,
    state: &'c mut [T],
    /// The inputs at a sample.
    u: Vec<T>,
    /// Outputs so far.
    out: Vec<Vec<T>>,
    y: Vec<T>,
    innovations: Vec<T>,
}

impl<T: Number> Way<'_, T> {
    /// The step that leaves a sample.
    fn strand(&mut self, at: usize) -> Strand<'_, T> {
        let Way { link, inputs, workspace, state, .. } = self;
        Strand { system: &link.system, workspace, inputs: inputs.step(at), state }
    }
}

impl<T: Number> Chain<'_, T> {
    /// Outputs over a window, link by link, from whole states, which are left at the window's end (of
    /// the sample after it where there is one). A filter corrects the states at each sample;
    /// `visit` the first of them.
    ///
    /// # Errors
    /// [`Diverged`].
    pub(super) fn window(
        &self,
        w: &Window,
        filter: Option<&Filter>,
        states: &mut [Vec<T>],
        mut visit: impl FnMut(&[T]),
    ) -> Result<Vec<Vec<Vec<T>>>, Diverged> {
        let times = &self.run.observed().times;
        let links = self.links.iter().zip(states);
        let mut ways: Vec<Way<T>> = links.map(|(l, state)| self.way(l, w, state)).collect();
        for (at, k) in w.range.clone().enumerate() {
            for way in &mut ways {
                self.sample((at, k), w, filter, way);
            }
            visit(ways[0].state);
            if k + 1 == times.len() {
                break;
            }
            let span = (times[k], times[k + 1]);
            match &mut ways[..] {
                [alone] => advance_together(&mut [alone.strand(at)], span, self.run.substeps),
                ways => {
                    let mut strands: Vec<Strand<T>> =
                        ways.iter_mut().map(|way| way.strand(at)).collect();
                    advance_together(&mut strands, span, self.run.substeps);
                }
            }
            self.run.check(k + 1, ways[0].state)?;
        }
        let mut all: Vec<_> = ways.into_iter().map(|way| way.out).collect();
        for (link, out) in self.links.iter().zip(&mut all) {
            self.sense(link, &times[w.range.clone()], out);
        }
        Ok(all)
    }

    fn way<'c>(&self, link: &'c Link<'c, T>, w: &Window, state: &'c mut [T]) -> Way<'c, T> {
        let count = self.run.problem.dataset.outputs.len();
        Way {
            link,
            inputs: self.inputs_along(link, w),
            workspace: link.system.workspace(),
            state,
            u: vec![T::constant(0.0); self.run.problem.model.input_width()],
            out: vec![Vec::with_capacity(w.range.len()); count],
            y: vec![T::constant(0.0); count],
            innovations: vec![T::constant(0.0); count],
        }
    }

    /// What the outputs are at a sample, and what that says of the state.
    fn sample(
        &self,
        (at, k): (usize, usize),
        w: &Window,
        filter: Option<&Filter>,
        way: &mut Way<T>,
    ) {
        let (problem, observed) = (self.run.problem, self.run.observed());
        let Way { link, inputs, state, u, out, y, innovations, .. } = way;
        inputs.sample(at, u);
        link.system.impose(u, state);
        problem.observation.evaluate(&link.system, observed.times[k], state, u, y);
        for (series, value) in out.iter_mut().zip(&*y) {
            series.push(*value);
        }
        let Some(filter) = filter else { return };
        for (o, innovation) in innovations.iter_mut().enumerate() {
            *innovation = T::constant(0.0);
            if filter.measured(at, o) {
                let (run, times) = ((problem, observed), &observed.times[w.range.clone()]);
                *innovation = innovation_of(run, &link.sensors, (o, k), times, &out[o]);
            }
        }
        filter.correct(at, innovations, state);
    }

    fn inputs_along<'c>(&self, link: &'c Link<'c, T>, w: &Window) -> Along<'c, T> {
        let (problem, count) = (self.run.problem, self.run.substeps.count);
        match &link.inputs {
            Inputs::Fixed(inputs) => Along::Fixed(problem.inputs_along(w, inputs, count)),
            Inputs::Moving(inputs) => {
                let series = (&self.run.observed().times[..], &inputs[..]);
                let range = w.range.start..w.range.end + 1;
                Along::Moving(problem.model.inputs_along(series, range, count))
            }
        }
    }

    /// What the sensors make of the outputs.
    fn sense(&self, link: &Link<'_, T>, times: &[f64], out: &mut [Vec<T>]) {
        for (series, output) in out.iter_mut().zip(&self.run.problem.dataset.outputs) {
            let Measured::State(state) = output.of else { continue };
            *series = sensed(&link.sensors, state, times, std::mem::take(series));
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
