//! `lacuna simulate`: run a model on a recording's inputs.

use super::Outcome;
use crate::say::{say, sayln};
use clap::Args;
use lacuna::discrepancy::prediction::DEFAULT_WARMUP;
use lacuna::files::uninterrupted;
use lacuna::models::AnyModel;
use lacuna::recordings::{RecordingSource, write_csv_with_time};
use lacuna::simulation::{Report, Settings, Simulation};
use std::path::PathBuf;
use std::process::ExitCode;

#[derive(Args)]
pub struct Arguments {
    /// The model: a TOML file of equations, a robot's file, an FMU, or model.json of `lacuna identify`
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

pub fn run(a: &Arguments) -> Outcome {
    let model = AnyModel::read(&a.model, Some(&a.like))?;
    let file = a.model.display().to_string();
    let settings = Settings { horizon: a.horizon, warmup: a.warmup };
    let run = Simulation::of((&model, &file), &model.recording(&a.like)?, settings)?;
    run.check_finite(&file)?;
    if let Some(path) = &a.out {
        let _writing = uninterrupted();
        write_csv_with_time(path, &run.recording(), model.time_column())?;
    }
    let report = Report::of(&run, model.name(&file), settings);
    if a.json {
        sayln!("{}", serde_json::to_string_pretty(&report)?)?;
    } else {
        say!("{}", report.text())?;
    }
    Ok(ExitCode::SUCCESS)
}
