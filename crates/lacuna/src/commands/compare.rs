//! `lacuna compare`: two models against the same recordings.

mod pair;
mod results;

use super::Outcome;
use super::kind::AnyModel;
use super::simulate::positive;
use super::simulation::Settings;
use crate::output::{spinner, write_together};
use crate::say::{say, sayln};
use clap::Args;
use lacuna::discrepancy::prediction::DEFAULT_WARMUP;
use lacuna::recordings::RecordingSource;
use lacuna::report;
use pair::{Named, Pair};
use results::Results;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

#[derive(Args)]
pub struct Arguments {
    /// A: a TOML file of equations, or model.json of `lacuna identify`
    model_a: PathBuf,
    /// B: of either kind; it must have the same measured channels
    model_b: PathBuf,
    /// Recordings whose inputs drive the models: FILE.csv, FILE.csv#rows=100..200 or
    /// FILE.csv#t=1.0..2.5
    #[arg(required = true)]
    recordings: Vec<RecordingSource>,
    /// Restart every so many seconds from the state that fits the window best; without it the
    /// models run free from the first samples to the end
    #[arg(long, value_parser = positive)]
    horizon: Option<f64>,
    /// Samples that estimate the initial state of a free run and do not count for its error
    #[arg(long, default_value_t = DEFAULT_WARMUP)]
    warmup: usize,
    /// Write compare.html and compare.json to this folder
    #[arg(long)]
    out: Option<PathBuf>,
    /// Print compare.json; an error that is null is that of a model that diverges
    #[arg(long)]
    json: bool,
    /// Print nothing but errors
    #[arg(long)]
    quiet: bool,
}

pub fn run(a: &Arguments) -> Outcome {
    let settings = Settings { horizon: a.horizon, warmup: a.warmup };
    let [label_a, label_b] = labels(&a.model_a, &a.model_b);
    let model = |file: &Path, label| -> Result<Named, Box<dyn std::error::Error>> {
        Ok(Named { model: AnyModel::read(file)?, file: file.to_owned(), label })
    };
    let models = [model(&a.model_a, label_a)?, model(&a.model_b, label_b)?];
    let bar = spinner(a.quiet || a.json);
    let pairs = a.recordings.iter().map(|like| {
        bar.set_message(format!("simulating both on {}", like.name()));
        Pair::of(&models, like, settings)
    });
    let pairs = pairs.collect::<Result<Vec<_>, _>>();
    bar.finish_and_clear();
    let pairs = pairs?;
    pair::same_channels(&pairs)?;
    let results = Results::of(&models, &pairs, settings);
    let json = serde_json::to_string_pretty(&results)?;
    let comparison = results.comparison(&pairs);
    if let Some(folder) = &a.out {
        let page = report::compare_page(&comparison);
        let (data, html) = (folder.join("compare.json"), folder.join("compare.html"));
        write_together(&[(&data, &json), (&html, &page)])?;
    }
    if a.json {
        sayln!("{json}")?;
    } else if !a.quiet {
        say!("{}", results.text(&comparison))?;
        if let Some(folder) = &a.out {
            sayln!("Written: {}", folder.join("compare.html").display())?;
        }
    }
    Ok(ExitCode::SUCCESS)
}

/// The names of the two files; their whole paths where the names are the same.
fn labels(a: &Path, b: &Path) -> [String; 2] {
    let name = |p: &Path| p.file_name().map(|n| n.to_string_lossy().into_owned());
    match (name(a), name(b)) {
        (Some(a), Some(b)) if a != b => [a, b],
        _ => [a, b].map(|p| p.display().to_string()),
    }
}
