//! Predictions of a model.

use super::state::{self, Runner};
use super::{Prediction, Series, substeps, until_diverged};
use crate::dataset::{Dataset, Observed};
use lacuna_plants::dynamics::Bound;
use lacuna_plants::model::{Measured, ModelEffect, Observation};
use lacuna_plants::{Model, Plant, System, rk4_sampled};
use std::ops::Range;

/// A model, ready to predict the outputs of a dataset.
pub struct Predictor<'a> {
    model: Model,
    system: System,
    observation: Observation,
    bound: Bound,
    dataset: &'a Dataset,
    weights: Vec<f64>,
    substeps: usize,
}

/// A recording with the inputs that the actuators make of its commands.
struct Driven<'b> {
    observed: &'b Observed,
    effective: Vec<f64>,
}

impl<'a> Predictor<'a> {
    /// A model with its own parameters and effects.
    #[must_use]
    pub fn new(model: &Model, dataset: &'a Dataset) -> Self {
        Self::with(model, &model.values(), &model.effects, dataset)
    }

    /// A model with other parameters and effects.
    #[must_use]
    pub fn with(
        model: &Model,
        parameters: &[f64],
        effects: &[ModelEffect],
        dataset: &'a Dataset,
    ) -> Self {
        let mut this = Self::with_substeps(model, parameters, effects, dataset, 1);
        this.substeps = this.needed_substeps(substeps::TOLERANCE, substeps::MOST);
        this
    }

    /// The same with a given number of RK4 steps a sample.
    pub(crate) fn with_substeps(
        model: &Model,
        parameters: &[f64],
        effects: &[ModelEffect],
        dataset: &'a Dataset,
        substeps: usize,
    ) -> Self {
        let mut model = model.clone();
        model.effects = effects.to_vec();
        let measured: Vec<_> = dataset.outputs.iter().map(|o| o.of).collect();
        let observation = Observation::of(&model, &measured);
        let bound = observation.bind(parameters);
        let weights = (0..measured.len()).map(|k| 1.0 / dataset.noise_sd(k)).collect();
        let system = System::with(&model, parameters, effects);
        Self { model, system, observation, bound, dataset, weights, substeps }
    }

    /// RK4 steps between two samples, at most so many, whose error stays below a share of the
    /// noise.
    pub(crate) fn needed_substeps(&self, tolerance: f64, most: usize) -> usize {
        let Some(observed) = self.dataset.recordings.first() else { return 1 };
        let driven = self.drive(observed);
        let starts = substeps::stretches(observed).map(|s| (self.guess(observed, s.start), s));
        substeps::fewest(self.dataset, (tolerance, most), |steps| {
            starts.each_ref().map(|(state, s)| self.run(&driven, s.clone(), state, steps))
        })
    }

    fn drive<'b>(&self, observed: &'b Observed) -> Driven<'b> {
        let effective = self.model.effective_inputs(&observed.times, &observed.commands);
        Driven { observed, effective }
    }

    /// Outputs over `range` from the whole state `x0`, memory included; NaN from where the model diverges.
    fn run(&self, driven: &Driven, range: Range<usize>, x0: &[f64], substeps: usize) -> Series {
        let Driven { observed, effective } = driven;
        let m = self.model.inputs.len();
        let n = range.len();
        let times = &observed.times[range.clone()];
        let inputs = &effective[range.start * m..range.end * m];
        let width = self.system.states();
        let (states, reached) = until_diverged(times, |count| {
            let (times, inputs) = (&times[..count], &inputs[..count * m]);
            rk4_sampled(&self.system, x0, times, inputs, self.model.hold, substeps)
        });
        let mut outputs = vec![vec![f64::NAN; n]; self.weights.len()];
        let mut y = vec![0.0; self.weights.len()];
        for k in 0..reached {
            let u = &inputs[k * m..(k + 1) * m];
            let state = &states[k * width..(k + 1) * width];
            self.observation.evaluate(&self.bound, times[k], state, u, &mut y);
            for (series, value) in outputs.iter_mut().zip(&y) {
                series[k] = *value;
            }
        }
        for (series, output) in outputs.iter_mut().zip(&self.dataset.outputs) {
            if let Measured::State(state) = output.of {
                *series = self.model.observed(state, times, std::mem::take(series));
            }
        }
        outputs
    }

    /// A first guess of the state at a sample: what is measured there, velocities as slopes
    /// over a few samples, zero for what is not measured, memory at rest.
    fn guess(&self, observed: &Observed, at: usize) -> Vec<f64> {
        let n = self.model.coordinates.len();
        let mut x = vec![0.0; self.model.machine_states()];
        let near = at..(at + 12).min(observed.len());
        for (k, output) in self.dataset.outputs.iter().enumerate() {
            let Measured::State(i) = output.of else { continue };
            let (value, slope) =
                line(&observed.times[near.clone()], &observed.outputs[k][near.clone()]);
            x[i] = value;
            if i < n && self.dataset.output_of_state(i + n).is_none() {
                x[i + n] = slope;
            }
        }
        self.system.at_rest(&x)
    }

    /// A run to the end from the state that fits the first `warmup` samples, which do not
    /// count for the error.
    #[must_use]
    pub fn free_run(&self, observed: &Observed, warmup: usize) -> Prediction {
        state::free_run(&Driving { predictor: self, driven: &self.drive(observed) }, warmup)
    }

    /// Runs of `horizon` seconds, the state at the beginning of each fitted to that window.
    #[must_use]
    pub fn windowed(&self, observed: &Observed, horizon: f64) -> Prediction {
        state::windowed(&Driving { predictor: self, driven: &self.drive(observed) }, horizon)
    }
}

/// A model on a recording.
struct Driving<'r, 'a> {
    predictor: &'r Predictor<'a>,
    driven: &'r Driven<'r>,
}

impl Runner for Driving<'_, '_> {
    fn observed(&self) -> &Observed {
        self.driven.observed
    }

    fn weights(&self) -> &[f64] {
        &self.predictor.weights
    }

    fn guess(&self, at: usize) -> Vec<f64> {
        self.predictor.guess(self.driven.observed, at)
    }

    fn run(&self, range: Range<usize>, x0: &[f64]) -> Series {
        self.predictor.run(self.driven, range, x0, self.predictor.substeps)
    }
}

/// Value at the first time and slope of the least-squares line through the finite samples.
fn line(times: &[f64], values: &[f64]) -> (f64, f64) {
    let points: Vec<_> = times
        .iter()
        .zip(values)
        .filter(|(_, y)| y.is_finite())
        .map(|(t, y)| (t - times[0], *y))
        .collect();
    let n = points.len() as f64;
    if points.is_empty() {
        return (0.0, 0.0);
    }
    let (mt, my) =
        (points.iter().map(|p| p.0).sum::<f64>() / n, points.iter().map(|p| p.1).sum::<f64>() / n);
    let stt: f64 = points.iter().map(|p| (p.0 - mt).powi(2)).sum();
    let sty: f64 = points.iter().map(|p| (p.0 - mt) * (p.1 - my)).sum();
    let slope = if stt > 0.0 { sty / stt } else { 0.0 };
    (my - slope * mt, slope)
}
