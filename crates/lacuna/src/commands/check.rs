//! `lacuna check`: what is in the recordings, do they fit the model, is the excitation rich
//! enough.

use super::Outcome;
use crate::say::{say, sayln};
use clap::Args;
use lacuna::check::Report;
use lacuna::diagnosed::logs;
use lacuna::models::read_equations;
use lacuna::recordings::RecordingSource;
use std::path::PathBuf;
use std::process::ExitCode;

#[derive(Args)]
pub struct Arguments {
    /// The model file
    model: PathBuf,
    /// Recordings: FILE.csv, FILE.csv#rows=100..200 or FILE.csv#t=1.0..2.5
    #[arg(required = true)]
    recordings: Vec<RecordingSource>,
    /// Print the report as JSON
    #[arg(long)]
    json: bool,
    /// Print nothing but warnings and errors
    #[arg(long)]
    quiet: bool,
}

pub fn run(a: &Arguments) -> Outcome {
    let model = read_equations(&a.model, a.recordings.first())?;
    let report = Report::of(&model, logs(&model, &a.recordings)?)?;
    if a.json {
        sayln!("{}", serde_json::to_string_pretty(&report)?)?;
    } else {
        if !a.quiet {
            say!("{}", report.text())?;
        }
        for warning in report.warnings() {
            sayln!("warning: {warning}")?;
        }
    }
    Ok(ExitCode::SUCCESS)
}
