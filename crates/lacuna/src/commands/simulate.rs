//! `lacuna simulate`: run a model on a recording's inputs.

use super::Outcome;
use super::kind::AnyModel;
use clap::Args;
use lacuna::discrepancy::prediction::DEFAULT_WARMUP;
use lacuna::discrepancy::{Dataset, Observed, Prediction};
use lacuna::recordings::{Column, Recording, RecordingSource, write_csv_with_time};
use serde::Serialize;
use std::collections::BTreeMap;
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
    channels: BTreeMap<String, ChannelError>,
    mode: String,
    model: String,
    recording: String,
    horizon_s: Option<f64>,
    warmup_samples: usize,
}

#[derive(Serialize)]
struct ChannelError {
    unit: String,
    rmse: f64,
    nrmse: f64,
    fit_percent: f64,
}

pub fn run(a: &Arguments) -> Outcome {
    let model = AnyModel::read(&a.model)?;
    let dataset = model.dataset(&a.like)?;
    let observed = &dataset.recordings[0];
    if a.horizon.is_none() && !(2..observed.len()).contains(&a.warmup) {
        return Err(format!(
            "--warmup {}: at least 2 samples estimate the state, and some of the {} of {} must be \
             left for the error",
            a.warmup,
            observed.len(),
            observed.name
        )
        .into());
    }
    let prediction = model
        .predict(&dataset, a.horizon, a.warmup)
        .map_err(|e| format!("{}: {e}", a.model.display()))?;
    let mode = if a.horizon.is_some() { "windowed" } else { "free_run" };
    let empty = |k: &usize| prediction.squares(observed, *k).1 == 0;
    if let Some(k) = (0..dataset.outputs.len()).find(empty) {
        return Err(format!(
            "{}: no sample of '{}' is left to compare with",
            observed.name, dataset.outputs[k].name
        )
        .into());
    }
    if let Some(channel) = diverged(&dataset, observed, &prediction) {
        return Err(format!(
            "{}: the model diverges on {}: channel '{channel}' is no longer finite; \
             a shorter --horizon restarts it more often",
            a.model.display(),
            observed.name
        )
        .into());
    }
    if let Some(path) = &a.out {
        write_csv_with_time(
            path,
            &simulated(&dataset, observed, &prediction),
            model.time_column(),
        )?;
    }
    let report = Report {
        channels: channels(&dataset, observed, &prediction),
        mode: mode.to_owned(),
        model: model.name(&a.model),
        recording: observed.name.clone(),
        horizon_s: a.horizon,
        warmup_samples: if a.horizon.is_none() { a.warmup } else { 0 },
    };
    if a.json {
        println!("{}", serde_json::to_string_pretty(&report)?);
    } else {
        print(&report);
    }
    Ok(ExitCode::SUCCESS)
}

fn diverged(dataset: &Dataset, observed: &Observed, prediction: &Prediction) -> Option<String> {
    (0..dataset.outputs.len())
        .find(|&k| !prediction.rmse(observed, k).is_finite())
        .map(|k| dataset.outputs[k].name.clone())
}

fn channels(
    dataset: &Dataset,
    observed: &Observed,
    prediction: &Prediction,
) -> BTreeMap<String, ChannelError> {
    let counted = prediction.counted.clone();
    dataset
        .outputs
        .iter()
        .enumerate()
        .map(|(k, output)| {
            let measured: Vec<f64> = observed.outputs[k][counted.clone()]
                .iter()
                .copied()
                .filter(|v| v.is_finite())
                .collect();
            let n = measured.len().max(1) as f64;
            let mean = measured.iter().sum::<f64>() / n;
            let sd = (measured.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / n).sqrt();
            let rmse = prediction.rmse(observed, k);
            // A channel that does not move has no range to be relative to.
            let moves = sd > 1e-12 * mean.abs();
            let nrmse = if moves { rmse / sd } else { f64::from(u8::from(rmse > 0.0)) };
            let error = ChannelError {
                unit: output.unit.clone(),
                rmse,
                nrmse,
                fit_percent: 100.0 * (1.0 - nrmse),
            };
            (output.name.clone(), error)
        })
        .collect()
}

fn simulated(dataset: &Dataset, observed: &Observed, prediction: &Prediction) -> Recording {
    let columns = dataset
        .outputs
        .iter()
        .zip(&prediction.outputs)
        .map(|(o, values)| Column { name: o.name.clone(), values: values.clone() })
        .collect();
    Recording { name: observed.name.clone(), time: observed.times.clone(), columns }
}

fn print(report: &Report) {
    match report.horizon_s {
        Some(horizon) => println!(
            "{} on {}, restarted every {horizon} s from the state that fits each window:",
            report.model, report.recording
        ),
        None => println!(
            "{} on {}, running free from the state that fits the first {} samples:",
            report.model, report.recording, report.warmup_samples
        ),
    }
    println!("{:<16} {:>14} {:<8} {:>8} {:>8}", "channel", "rms error", "unit", "nrmse", "fit %");
    for (name, e) in &report.channels {
        println!(
            "{name:<16} {:>14.6e} {:<8} {:>8.4} {:>8.2}",
            e.rmse, e.unit, e.nrmse, e.fit_percent
        );
    }
}
