//! `lacuna compare`: two models against the same recordings.

use super::Outcome;
use super::simulate::positive;
use crate::output::spinner;
use crate::say::{say, sayln};
use clap::Args;
use lacuna::comparison::{Compared, Named, Pair, labels};
use lacuna::discrepancy::prediction::DEFAULT_WARMUP;
use lacuna::files::check_folder;
use lacuna::models::AnyModel;
use lacuna::recordings::RecordingSource;
use lacuna::simulation::Settings;
use std::error::Error;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

#[derive(Args)]
pub struct Arguments {
    /// A: a model file (TOML), of equations or of a robot; a URDF or MJCF; or model.json of `lacuna identify`
    model_a: PathBuf,
    /// B: of any of these kinds; it must have the same measured channels
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
    a.out.as_deref().map_or(Ok(()), check_folder)?;
    let settings = Settings { horizon: a.horizon, warmup: a.warmup };
    let [label_a, label_b] = labels([&a.model_a, &a.model_b]);
    let model = |file: &Path, label| -> Result<Named, Box<dyn Error>> {
        let model = AnyModel::read(file, a.recordings.first())?;
        Ok(Named { model, file: file.display().to_string(), label })
    };
    let models = [model(&a.model_a, label_a)?, model(&a.model_b, label_b)?];
    let bar = spinner(a.quiet || a.json);
    let pairs = a.recordings.iter().map(|like| {
        bar.set_message(format!("simulating both on {}", like.name()));
        let recordings = [models[0].model.recording(like)?, models[1].model.recording(like)?];
        Pair::of(&models, recordings.each_ref(), settings)
    });
    let pairs = pairs.collect::<Result<Vec<_>, _>>();
    bar.finish_and_clear();
    let compared = Compared::of(&models, &pairs?, settings)?;
    if let Some(folder) = &a.out {
        compared.write(folder)?;
    }
    if a.json {
        sayln!("{}", compared.json()?)?;
    } else if !a.quiet {
        say!("{}", compared.text())?;
        if let Some(folder) = &a.out {
            sayln!("Written: {}", folder.join("compare.html").display())?;
        }
    }
    Ok(ExitCode::SUCCESS)
}
