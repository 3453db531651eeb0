//! `lacuna simulate`: run a model on a recording's inputs.

use super::Outcome;
use super::kind::AnyModel;
use super::simulation::{ChannelError, Settings, Simulation};
use crate::interrupt::uninterrupted;
use crate::say::sayln;
use clap::Args;
use lacuna::discrepancy::Output;
use lacuna::discrepancy::prediction::DEFAULT_WARMUP;
use lacuna::recordings::{Column, Recording, RecordingSource, in_samples, write_csv_with_time};
use serde::Serialize;
use std::collections::BTreeMap;
use std::io;
use std::path::PathBuf;
use std::process::ExitCode;

#[derive(Args)]
pub struct Arguments {
    /// The model: a TOML file of equations, or model.json of `lacuna identify`
    model: PathBuf,
    /// The recording whose inputs drive the model: FILE.csv, FILE.csv#rows=100..200 or
    /// FILE.csv#t=1.0..2.5
    #[arg(long)]
    like: RecordingSource,
    /// Restart every so many seconds from the state that fits the window best; without it the
    /// model runs free from the first samples to the end
    #[arg(long, value_parser = positive)]
    horizon: Option<f64>,
    /// Samples that estimate the initial state of a free run and do not count for its error
    #[arg(long, default_value_t = DEFAULT_WARMUP)]
    warmup: usize,
    /// Write the simulated channels to this CSV file
    #[arg(long)]
    out: Option<PathBuf>,
    /// Print the errors as JSON
    #[arg(long)]
    json: bool,
    /// No progress
    #[arg(long)]
    quiet: bool,
}

pub fn positive(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(v) if v > 0.0 && v.is_finite() => Ok(v),
        _ => Err(format!("expected a positive number of seconds, found '{text}'")),
    }
}

#[derive(Serialize)]
struct Report {
    channels: BTreeMap<String, Channel>,
    mode: &'static str,
    model: String,
    recording: String,
    horizon_s: Option<f64>,
    warmup_samples: usize,
}

#[derive(Serialize)]
struct Channel {
    unit: String,
    /// Samples that do not count for the error since they are outliers.
    #[serde(skip_serializing_if = "is_none")]
    outliers: usize,
    #[serde(flatten)]
    error: ChannelError,
}

pub fn run(a: &Arguments) -> Outcome {
    let model = AnyModel::read(&a.model)?;
    let settings = Settings { horizon: a.horizon, warmup: a.warmup };
    let run = Simulation::of((&model, &a.model), &a.like, settings)?;
    let recording = &run.observed().name;
    if let Some(channel) = run.diverged() {
        return Err(format!(
            "{}: the model diverges on {recording}: channel '{channel}' is no longer finite; \
             a shorter --horizon restarts it more often",
            a.model.display()
        )
        .into());
    }
    if let Some(path) = &a.out {
        let _writing = uninterrupted();
        write_csv_with_time(path, &simulated(&run), model.time_column())?;
    }
    let report = Report {
        channels: channels(&run),
        mode: settings.mode(),
        model: model.name(&a.model),
        recording: recording.clone(),
        horizon_s: a.horizon,
        warmup_samples: settings.warmup_samples(),
    };
    if a.json {
        sayln!("{}", serde_json::to_string_pretty(&report)?)?;
    } else {
        print(&report)?;
    }
    Ok(ExitCode::SUCCESS)
}

fn channels(run: &Simulation) -> BTreeMap<String, Channel> {
    let channel = |(k, output): (usize, &Output)| {
        let error = ChannelError::pooled(&[(run, k)]);
        let outliers = run.observed().cleaned[k].outliers.len();
        (output.name.clone(), Channel { unit: output.unit.clone(), outliers, error })
    };
    run.dataset().outputs.iter().enumerate().map(channel).collect()
}

fn simulated(run: &Simulation) -> Recording {
    let observed = run.observed();
    let columns = run
        .dataset()
        .outputs
        .iter()
        .zip(run.predicted())
        .map(|(o, values)| Column { name: o.name.clone(), values: values.clone() })
        .collect();
    Recording { name: observed.name.clone(), time: observed.times.clone(), columns }
}

fn print(report: &Report) -> io::Result<()> {
    match report.horizon_s {
        Some(horizon) => sayln!(
            "{} on {}, restarted every {horizon} s from the state that fits each window:",
            report.model,
            report.recording
        )?,
        None => sayln!(
            "{} on {}, running free from the state that fits the first {} samples:",
            report.model,
            report.recording,
            report.warmup_samples
        )?,
    }
    sayln!("{:<16} {:>14} {:<8} {:>8} {:>8}", "channel", "rms error", "unit", "nrmse", "fit %")?;
    for (name, Channel { unit, error: e, .. }) in &report.channels {
        sayln!("{name:<16} {:>14.6e} {unit:<8} {:>8.4} {:>8.2}", e.rmse, e.nrmse, e.fit_percent)?;
    }
    for (name, channel) in report.channels.iter().filter(|(_, c)| c.outliers > 0) {
        sayln!("{} of {name} left out of the error: outliers", in_samples(channel.outliers))?;
    }
    Ok(())
}

/// Whether there are none: they are only told where there are any.
#[allow(clippy::trivially_copy_pass_by_ref)]
fn is_none(count: &usize) -> bool {
    *count == 0
}
