//! What a model predicts of a recording: free runs and windows, the state at each start
//! estimated from the recording itself, never a parameter.

use crate::dataset::{Dataset, Observed};
use lacuna_plants::expression::Bound;
use lacuna_plants::model::{Equations, Measured, ModelEffect, Observation};
use lacuna_plants::{Model, Plant, SimulationError, System, rk4_sampled};
use nalgebra::{DMatrix, DVector};
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

/// Samples that the error of a free run leaves out: they estimate the initial state.
pub const DEFAULT_WARMUP: usize = 50;

/// Most RK4 steps between two samples.
const MOST_SUBSTEPS: usize = 32;

/// A recording with the inputs that the actuators make of its commands.
pub(crate) struct Driven<'b> {
    observed: &'b Observed,
    effective: Vec<f64>,
}

/// Predicted and measured series of one recording.
#[derive(Clone, Debug)]
pub struct Prediction {
    /// Predicted outputs, as [`Observed::outputs`]; NaN where the model diverged.
    pub outputs: Vec<Vec<f64>>,
    /// The samples that count for the error.
    pub counted: Range<usize>,
}

impl Prediction {
    /// Root mean square of measured minus predicted, over samples that were measured.
    /// Infinite where the model diverged, not a number where nothing was measured.
    #[must_use]
    pub fn rmse(&self, observed: &Observed, output: usize) -> f64 {
        let (sum, count) = self.squares(observed, output);
        (sum / count as f64).sqrt()
    }

    /// Sum of squares of measured minus predicted, and the number of samples.
    #[must_use]
    pub fn squares(&self, observed: &Observed, output: usize) -> (f64, usize) {
        let measured = &observed.outputs[output][self.counted.clone()];
        let predicted = &self.outputs[output][self.counted.clone()];
        let pairs = measured.iter().zip(predicted).filter(|(y, _)| y.is_finite());
        pairs.fold((0.0, 0), |(sum, n), (y, p)| {
            let e = y - p;
            (if e.is_finite() { sum + e * e } else { f64::INFINITY }, n + 1)
        })
    }
}

impl<'a> Predictor<'a> {
    /// A model with its own parameters and effects.
    #[must_use]
    pub fn new(model: &Model, dataset: &'a Dataset) -> Self {
        Self::with(model, &Equations::of(model), &model.values(), &model.effects, dataset)
    }

    /// A model with other parameters and effects.
    #[must_use]
    pub fn with(
        model: &Model,
        equations: &Equations,
        parameters: &[f64],
        effects: &[ModelEffect],
        dataset: &'a Dataset,
    ) -> Self {
        let mut this = Self::with_substeps(model, equations, parameters, effects, dataset, 1);
        this.substeps = this.choose_substeps();
        this
    }

    /// The same with a given number of RK4 steps a sample.
    pub(crate) fn with_substeps(
        model: &Model,
        equations: &Equations,
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
        let system = System::with(&model, equations, parameters, effects);
        Self { model, system, observation, bound, dataset, weights, substeps }
    }

    /// RK4 steps between two samples.
    pub(crate) fn substeps(&self) -> usize {
        self.substeps
    }

    /// Fewest RK4 steps a sample whose error over some stretches of the first recording stays
    /// well below the noise: doubled until doubling changes little.
    fn choose_substeps(&mut self) -> usize {
        const STRETCH: usize = 400;
        const TOLERANCE: f64 = 0.01;
        let Some(observed) = self.dataset.recordings.first() else { return 1 };
        let length = observed.len().min(STRETCH);
        let starts = [0, 1, 2].map(|k| k * (observed.len() - length) / 2);
        let driven = self.drive(observed);
        let states = starts.map(|start| self.guess(observed, start));
        let runs = |this: &Self| {
            let run = |k: usize| this.run(&driven, starts[k]..starts[k] + length, &states[k]);
            [run(0), run(1), run(2)]
        };
        let mut coarse = runs(self);
        while self.substeps < MOST_SUBSTEPS {
            self.substeps *= 2;
            let fine = runs(self);
            let pairs = coarse.iter().zip(&fine);
            let change = pairs.map(|(a, b)| self.weighted_distance(a, b)).fold(0.0, f64::max);
            if change < TOLERANCE {
                return self.substeps / 2;
            }
            coarse = fine;
        }
        self.substeps
    }

    /// Largest difference of two sets of series in units of the noise, or of a thousandth of
    /// the channel's range where the noise is finer than any model follows.
    fn weighted_distance(&self, a: &[Vec<f64>], b: &[Vec<f64>]) -> f64 {
        let mut largest = 0.0f64;
        for (k, (a, b)) in a.iter().zip(b).enumerate() {
            let w = self.weights[k].min(1e3 / self.dataset.half_range(k));
            for (x, y) in a.iter().zip(b) {
                // Where both diverge nothing can be compared.
                if x.is_finite() || y.is_finite() {
                    let d = ((x - y) * w).abs();
                    largest = if d.is_nan() { f64::INFINITY } else { largest.max(d) };
                }
            }
        }
        largest
    }

    pub(crate) fn drive<'b>(&self, observed: &'b Observed) -> Driven<'b> {
        let effective = self.model.effective_inputs(&observed.times, &observed.commands);
        Driven { observed, effective }
    }

    /// Outputs over `range` from the whole state `x0`, memory included; NaN from where the model diverges.
    fn run(&self, driven: &Driven, range: Range<usize>, x0: &[f64]) -> Vec<Vec<f64>> {
        let Driven { observed, effective } = driven;
        let m = self.model.inputs.len();
        let n = range.len();
        let times = &observed.times[range.clone()];
        let inputs = &effective[range.start * m..range.end * m];
        let width = self.system.states();
        let simulate = |count: usize| {
            let (times, inputs) = (&times[..count], &inputs[..count * m]);
            rk4_sampled(&self.system, x0, times, inputs, self.model.hold, self.substeps)
        };
        let (states, reached) = match simulate(n) {
            Ok(trajectory) => (trajectory.states, n),
            Err(SimulationError::Diverged { time, .. }) => {
                let reached = times.partition_point(|&t| t < time);
                match simulate(reached) {
                    Ok(trajectory) => (trajectory.states, reached),
                    Err(_) => (vec![], 0),
                }
            }
            Err(_) => (vec![], 0),
        };
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

    /// A state of this model for one of the same machine with other effects: their memory is
    /// at rest.
    pub(crate) fn with_memory_at_rest(&self, state: &[f64]) -> Vec<f64> {
        self.system.at_rest(&state[..self.model.machine_states()])
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

    /// The state (memory of effects included) at the beginning of `range` that fits its samples best
    /// (Levenberg-Marquardt on the state alone).
    pub(crate) fn fit_state(&self, driven: &Driven, range: Range<usize>) -> Vec<f64> {
        let mut x = self.guess(driven.observed, range.start);
        let mut residual = self.residual(driven, &range, &x);
        let mut damping = 1e-3;
        for _ in 0..20 {
            let jacobian = self.jacobian(driven, &range, &x, &residual);
            let gradient = jacobian.tr_mul(&residual);
            let normal = jacobian.tr_mul(&jacobian);
            let before = residual.norm_squared();
            let mut improved = false;
            for _ in 0..8 {
                let Some(step) = damped_step(&normal, &gradient, damping) else { break };
                let candidate: Vec<f64> = x.iter().zip(step.iter()).map(|(x, d)| x + d).collect();
                let trial = self.residual(driven, &range, &candidate);
                if trial.norm_squared() < before {
                    (x, residual) = (candidate, trial);
                    damping = (damping * 0.1).max(1e-9);
                    improved = true;
                    break;
                }
                damping *= 10.0;
            }
            if !improved || before - residual.norm_squared() < 1e-4 * before.min(1e3) {
                break;
            }
        }
        x
    }

    /// Weighted residual over a range; a large finite number where the model diverges, so
    /// that the fit can still compare.
    pub(crate) fn residual(
        &self,
        driven: &Driven,
        range: &Range<usize>,
        x: &[f64],
    ) -> DVector<f64> {
        let predicted = self.run(driven, range.clone(), x);
        let mut out = Vec::new();
        for (k, series) in predicted.iter().enumerate() {
            let measured = &driven.observed.outputs[k][range.clone()];
            for (y, p) in measured.iter().zip(series).filter(|(y, _)| y.is_finite()) {
                let e = (y - p) * self.weights[k];
                out.push(if e.is_finite() { e.clamp(-1e6, 1e6) } else { 1e6 });
            }
        }
        DVector::from_vec(out)
    }

    /// Derivative of the prediction with respect to the state at the beginning, by forward
    /// differences.
    fn jacobian(
        &self,
        driven: &Driven,
        range: &Range<usize>,
        x: &[f64],
        residual: &DVector<f64>,
    ) -> DMatrix<f64> {
        let columns: Vec<_> = (0..x.len())
            .map(|i| {
                let mut moved = x.to_vec();
                let h = state_step(x[i]);
                moved[i] += h;
                (residual - self.residual(driven, range, &moved)) / h
            })
            .collect();
        DMatrix::from_columns(&columns)
    }

    /// A run to the end from the state that fits the first `warmup` samples, which do not
    /// count for the error.
    #[must_use]
    pub fn free_run(&self, observed: &Observed, warmup: usize) -> Prediction {
        let warmup = warmup.clamp(2, observed.len());
        let driven = self.drive(observed);
        let x0 = self.fit_state(&driven, 0..warmup);
        let counted = if warmup < observed.len() { warmup..observed.len() } else { 0..warmup };
        Prediction { outputs: self.run(&driven, 0..observed.len(), &x0), counted }
    }

    /// Runs of `horizon` seconds, the state at the beginning of each fitted to that window.
    #[must_use]
    pub fn windowed(&self, observed: &Observed, horizon: f64) -> Prediction {
        let mut outputs = vec![Vec::with_capacity(observed.len()); self.weights.len()];
        let driven = self.drive(observed);
        for range in windows(&observed.times, horizon) {
            let x0 = self.fit_state(&driven, range.clone());
            for (all, part) in outputs.iter_mut().zip(self.run(&driven, range, &x0)) {
                all.extend(part);
            }
        }
        Prediction { outputs, counted: 0..observed.len() }
    }
}

/// Windows of about `horizon` seconds that cover all samples; a short rest joins the last.
#[must_use]
pub fn windows(times: &[f64], horizon: f64) -> Vec<Range<usize>> {
    let n = times.len();
    let span = times[n - 1] - times[0];
    let count = (span / horizon).round().clamp(1.0, (n / 4).max(1) as f64) as usize;
    let edge = |k: usize| {
        if k == count {
            return n;
        }
        let t = times[0] + span * k as f64 / count as f64;
        times.partition_point(|&s| s < t - 1e-9 * span)
    };
    // On uneven sampling a window may hold too little to run through: it joins its neighbour.
    let mut out: Vec<Range<usize>> = Vec::new();
    for end in (1..=count).map(edge) {
        let start = out.last().map_or(0, |r| r.end);
        match out.last_mut() {
            Some(last) if end - start < 2 => last.end = end,
            _ if end - start < 2 => {}
            _ => out.push(start..end),
        }
    }
    out
}

fn damped_step(
    normal: &DMatrix<f64>,
    gradient: &DVector<f64>,
    damping: f64,
) -> Option<DVector<f64>> {
    let mut damped = normal.clone();
    let largest = normal.diagonal().max();
    for i in 0..damped.nrows() {
        // A state that leaves no trace in the window stays where it is.
        damped[(i, i)] += damping * normal[(i, i)] + 1e-14 * largest + f64::MIN_POSITIVE;
    }
    damped.cholesky().map(|c| c.solve(gradient))
}

/// Step of a forward difference with respect to a state.
pub(crate) fn state_step(x: f64) -> f64 {
    1e-6 * (1e-2 + x.abs())
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
