//! A model run on a recording, and its error in each channel.

use super::kind::AnyModel;
use lacuna::discrepancy::{Dataset, Observed, Prediction};
use lacuna::recordings::RecordingSource;
use serde::Serialize;
use std::error::Error;
use std::path::Path;

/// How a model is run.
#[derive(Clone, Copy)]
pub struct Settings {
    /// Windows of so many seconds; a free run without.
    pub horizon: Option<f64>,
    /// Samples that estimate the state of a free run.
    pub warmup: usize,
}

impl Settings {
    /// What results call this way of running.
    pub fn mode(self) -> &'static str {
        if self.horizon.is_some() { "windowed" } else { "free_run" }
    }

    /// Samples that do not count for the error.
    pub fn warmup_samples(self) -> usize {
        if self.horizon.is_none() { self.warmup } else { 0 }
    }
}

/// A model's run on one recording.
pub struct Simulation {
    dataset: Dataset,
    prediction: Prediction,
}

impl Simulation {
    /// # Errors
    /// What is wrong with the recording or its use, with their names.
    pub fn of(
        (model, file): (&AnyModel, &Path),
        like: &RecordingSource,
        settings: Settings,
    ) -> Result<Self, Box<dyn Error>> {
        let dataset = model.dataset(like)?;
        let observed = &dataset.recordings[0];
        let Settings { horizon, warmup } = settings;
        if horizon.is_none() && !(2..observed.len()).contains(&warmup) {
            return Err(format!(
                "--warmup {warmup}: at least 2 samples estimate the state, and some of the {} of \
                 {} must be left for the error",
                observed.len(),
                observed.name
            )
            .into());
        }
        let prediction = model
            .predict(&dataset, horizon, warmup)
            .map_err(|e| format!("{}: {e}", file.display()))?;
        let simulation = Self { dataset, prediction };
        let empty = |k: &usize| simulation.squares(*k).1 == 0;
        match (0..simulation.dataset.outputs.len()).find(empty) {
            Some(k) => Err(format!(
                "{}: no sample of '{}' is left to compare with",
                simulation.observed().name,
                simulation.dataset.outputs[k].name
            )
            .into()),
            None => Ok(simulation),
        }
    }

    /// The recording in the model's channels.
    pub fn observed(&self) -> &Observed {
        &self.dataset.recordings[0]
    }

    /// What is measured.
    pub fn dataset(&self) -> &Dataset {
        &self.dataset
    }

    /// Predicted series of each channel.
    pub fn predicted(&self) -> &[Vec<f64>] {
        &self.prediction.outputs
    }

    /// Index of the channel of this name.
    pub fn channel(&self, name: &str) -> Option<usize> {
        self.dataset.outputs.iter().position(|o| o.name == name)
    }

    /// The first channel in which the model diverges.
    pub fn diverged(&self) -> Option<&str> {
        let infinite = |k: &usize| !self.squares(*k).0.is_finite();
        (0..self.dataset.outputs.len())
            .find(infinite)
            .map(|k| self.dataset.outputs[k].name.as_str())
    }

    fn squares(&self, channel: usize) -> (f64, usize) {
        self.prediction.squares(self.observed(), channel)
    }

    /// Measured values that count for the error.
    fn counted(&self, channel: usize) -> impl Iterator<Item = f64> {
        let series = &self.observed().outputs[channel][self.prediction.counted.clone()];
        series.iter().copied().filter(|v| v.is_finite())
    }
}

/// The error of one channel; infinite where the model diverges, which JSON writes as null.
#[derive(Clone, Copy, Serialize)]
pub struct ChannelError {
    /// Root mean square of measured minus predicted.
    pub rmse: f64,
    /// The same over the standard deviation of what was measured.
    pub nrmse: f64,
    /// 100 (1 - nrmse).
    pub fit_percent: f64,
}

impl ChannelError {
    /// Over all samples of some runs, each with the channel's index in it.
    pub fn pooled(runs: &[(&Simulation, usize)]) -> Self {
        let add = |(s, n), (s2, n2)| (s + s2, n + n2);
        let (squares, count) = runs.iter().map(|(run, k)| run.squares(*k)).fold((0.0, 0), add);
        let n = count.max(1) as f64;
        let rmse = (squares / n).sqrt();
        let measured = || runs.iter().flat_map(|(run, k)| run.counted(*k));
        let mean = measured().sum::<f64>() / n;
        let sd = (measured().map(|v| (v - mean).powi(2)).sum::<f64>() / n).sqrt();
        // A channel that does not move has no range to be relative to.
        let moves = sd > 1e-12 * mean.abs();
        let nrmse = if moves { rmse / sd } else { f64::from(u8::from(rmse > 0.0)) };
        Self { rmse, nrmse, fit_percent: 100.0 * (1.0 - nrmse) }
    }
}
