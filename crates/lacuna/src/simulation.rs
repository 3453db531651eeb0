//! What `simulate` does: a model run on a recording, and its error in each channel.

use crate::discrepancy::{Dataset, Observed, Output, Prediction};
use crate::models::AnyModel;
use crate::recordings::{Column, Recording, in_samples};
use serde::Serialize;
use std::collections::BTreeMap;
use std::error::Error;

/// How a model is run.
#[derive(Clone, Copy, Debug)]
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
#[derive(Debug)]
pub struct Simulation {
    dataset: Dataset,
    prediction: Prediction,
    /// Seconds in one unit of time of the model's recordings.
    time_seconds: f64,
}

impl Simulation {
    /// Run a model, called `called` in errors, on the inputs of a recording.
    ///
    /// # Errors
    /// What is wrong with the recording or its use, with their names.
    pub fn of(
        (model, called): (&AnyModel, &str),
        like: &Recording,
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
        let prediction =
            model.predict(&dataset, horizon, warmup).map_err(|e| format!("{called}: {e}"))?;
        let simulation = Self { dataset, prediction, time_seconds: model.time_seconds() };
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

    /// Complain of the first channel in which the model, called `called`, diverges.
    ///
    /// # Errors
    /// The channel, and what helps.
    pub fn check_finite(&self, called: &str) -> Result<(), Box<dyn Error>> {
        let infinite = |k: &usize| !self.squares(*k).0.is_finite();
        match (0..self.dataset.outputs.len()).find(infinite) {
            None => Ok(()),
            Some(k) => Err(format!(
                "{called}: the model diverges on {}: channel '{}' is no longer finite; a shorter --horizon \
                 restarts it more often",
                self.observed().name,
                self.dataset.outputs[k].name
            )
            .into()),
        }
    }

    /// What was simulated, as a recording with times in the unit in which the model's recordings have them.
    pub fn recording(&self) -> Recording {
        let observed = self.observed();
        let named = self.dataset.outputs.iter().zip(self.predicted());
        let column =
            |(o, v): (&Output, &Vec<f64>)| Column { name: o.name.clone(), values: v.clone() };
        let columns = named.map(column).collect();
        let time = observed.times.iter().map(|t| t / self.time_seconds).collect();
        Recording { name: observed.name.clone(), time, columns }
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
#[derive(Clone, Copy, Debug, Serialize)]
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

/// The errors of a simulation: what `simulate` prints.
#[derive(Debug, Serialize)]
pub struct Report {
    channels: BTreeMap<String, Channel>,
    mode: &'static str,
    model: String,
    recording: String,
    horizon_s: Option<f64>,
    warmup_samples: usize,
}

#[derive(Debug, Serialize)]
struct Channel {
    unit: String,
    /// Samples that do not count for the error since they are outliers.
    #[serde(skip_serializing_if = "is_none")]
    outliers: usize,
    #[serde(flatten)]
    error: ChannelError,
}

impl Report {
    /// The errors of a run of the model of this name.
    pub fn of(run: &Simulation, model: String, settings: Settings) -> Self {
        let channel = |(k, output): (usize, &Output)| {
            let error = ChannelError::pooled(&[(run, k)]);
            let outliers = run.observed().cleaned[k].outliers.len();
            (output.name.clone(), Channel { unit: output.unit.clone(), outliers, error })
        };
        Self {
            channels: run.dataset().outputs.iter().enumerate().map(channel).collect(),
            mode: settings.mode(),
            model,
            recording: run.observed().name.clone(),
            horizon_s: settings.horizon,
            warmup_samples: settings.warmup_samples(),
        }
    }

    /// The errors as a table.
    pub fn text(&self) -> String {
        let mut out = format!("{} on {}, {}:\n", self.model, self.recording, self.how());
        out += &format!(
            "{:<16} {:>14} {:<8} {:>8} {:>8}\n",
            "channel", "rms error", "unit", "nrmse", "fit %"
        );
        for (name, Channel { unit, error: e, .. }) in &self.channels {
            out += &format!(
                "{name:<16} {:>14.6e} {unit:<8} {:>8.4} {:>8.2}\n",
                e.rmse, e.nrmse, e.fit_percent
            );
        }
        for (name, channel) in self.channels.iter().filter(|(_, c)| c.outliers > 0) {
            out += &format!(
                "{} of {name} left out of the error: outliers\n",
                in_samples(channel.outliers)
            );
        }
        out
    }

    fn how(&self) -> String {
        match self.horizon_s {
            Some(horizon) => {
                format!("restarted every {horizon} s from the state that fits each window")
            }
            None => format!(
                "running free from the state that fits the first {} samples",
                self.warmup_samples
            ),
        }
    }
}

/// Whether there are none: they are only told where there are any.
#[allow(clippy::trivially_copy_pass_by_ref)]
fn is_none(count: &usize) -> bool {
    *count == 0
}
