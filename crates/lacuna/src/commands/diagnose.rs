//! `lacuna diagnose`: find the physics that a model leaves out.

use super::Outcome;
use super::kind::read_equations;
use super::typed::typed;
use crate::interrupt::Cancellable;
use crate::output::{colour, spinner, write_together};
use crate::say::{say, sayln};
use clap::Args;
use lacuna::discrepancy::diagnose::{self, Options, Proof};
use lacuna::discrepancy::diagnosis::{Diagnosis, Verdict};
use lacuna::discrepancy::robot_file::{Augmented, augmented};
use lacuna::discrepancy::{Dataset, Observed, Output, Scope, Selector, Watch};
use lacuna::plants::Model;
use lacuna::plants::model::Measured;
use lacuna::recordings::RecordingSource;
use lacuna::report;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::time::Duration;

#[derive(Args)]
pub struct Arguments {
    /// The model file
    model: PathBuf,
    /// Recordings to fit: FILE.csv, FILE.csv#rows=100..200 or FILE.csv#t=1.0..2.5
    #[arg(required = true)]
    recordings: Vec<RecordingSource>,
    /// Recordings for proof alone; without any, one in four (or the last quarter of a single
    /// one) is kept
    #[arg(long, num_args = 1..)]
    held_out: Vec<RecordingSource>,
    /// Write diagnosis.json, augmented.toml, report.html and, of a robot, augmented.urdf or augmented.xml
    /// to this folder
    #[arg(long)]
    out: Option<PathBuf>,
    /// Write the report's pictures as SVG files to figures/ in the folder of --out
    #[arg(long, requires = "out")]
    figures: bool,
    /// Keep what is left after the named effects as learned curves in augmented.toml; never
    /// instead of a name
    #[arg(long)]
    learn_remainder: bool,
    /// Do not look for these classes of effects, on all channels or on one
    #[arg(long, num_args = 1.., value_name = "CLASS[@CHANNEL]")]
    exclude: Vec<Selector>,
    /// Look for nothing but these
    #[arg(long, num_args = 1.., value_name = "CLASS[@CHANNEL]")]
    only: Vec<Selector>,
    /// These recorded inputs are exactly what the machine got: no noise on them is estimated
    #[arg(long, num_args = 1.., value_name = "INPUT")]
    exact: Vec<String>,
    /// End the search after so many seconds with the best that it has found; the proof of that
    /// comes on top
    #[arg(long, value_name = "SECONDS", value_parser = seconds)]
    time_budget: Option<Duration>,
    /// Return 1 where there is a mismatch
    #[arg(long)]
    exit_code: bool,
    /// Print diagnosis.json instead of the summary
    #[arg(long)]
    json: bool,
    /// Print nothing but errors
    #[arg(long)]
    quiet: bool,
}

pub fn run(a: &Arguments) -> Outcome {
    let model = read_equations(&a.model)?;
    let (training, held_out) = datasets(&model, &a.recordings, &a.held_out)?;
    let bar = spinner(a.quiet || a.json);
    let options = Options {
        learn_remainder: a.learn_remainder,
        scope: Scope { only: a.only.clone(), exclude: a.exclude.clone() },
        exact: a.exact.clone(),
        ..Options::default()
    };
    let progress = |doing: &str| bar.set_message(doing.to_owned());
    let running = Cancellable::begin();
    let watch = Watch::new(&progress, running.token());
    let watch = match a.time_budget {
        Some(budget) => watch.within(budget),
        None => watch,
    };
    let outcome = diagnose::diagnose(&model, &training, &held_out, options, &watch);
    bar.finish_and_clear();
    if let Some(cancelled) = running.end() {
        return Ok(cancelled);
    }
    let outcome = outcome?;
    let robot = match a.out {
        Some(_) => augmented(&model, &outcome.augmentation, &outcome.diagnosis.findings)?,
        None => None,
    };
    if let Some(folder) = &a.out {
        let text = model.augmented_text(&outcome.augmentation)?;
        let proofs = proofs(&model, &training, &outcome.proofs);
        write(folder, &outcome.diagnosis, (&text, robot.as_ref()), &proofs)?;
        if a.figures {
            write_figures(folder, &outcome.diagnosis, &proofs)?;
        }
    }
    if a.json {
        sayln!("{}", serde_json::to_string_pretty(&outcome.diagnosis)?)?;
    } else if !a.quiet {
        say!("{}", report::summary(&outcome.diagnosis, colour()))?;
        if let Some(folder) = &a.out {
            sayln!("Written: {}", folder.join("report.html").display())?;
            say!("{}", robot.iter().filter_map(left_out).collect::<String>())?;
        }
    }
    let mismatch = outcome.diagnosis.verdict != Verdict::NoMismatch;
    Ok(ExitCode::from(u8::from(a.exit_code && mismatch)))
}

/// What the robot's file that was written does not say, in a line.
fn left_out(robot: &Augmented) -> Option<String> {
    let all: Vec<&str> = robot.left_out.iter().map(|l| &*l.what).collect();
    (!all.is_empty()).then(|| format!("Not in {}: {}.\n", robot.name, all.join("; ")))
}

/// A positive number of seconds.
fn seconds(text: &str) -> Result<Duration, String> {
    let seconds = text.parse::<f64>().ok().filter(|s| *s > 0.0);
    let duration = seconds.and_then(|s| Duration::try_from_secs_f64(s).ok());
    duration.ok_or_else(|| "expected a positive number of seconds".to_owned())
}

/// Training and held-out data, the noise of the training recordings in both.
fn datasets(
    model: &Model,
    recordings: &[RecordingSource],
    held_out: &[RecordingSource],
) -> Result<(Dataset, Dataset), Box<dyn std::error::Error>> {
    let all = Dataset::read(model, recordings)?;
    if held_out.is_empty() {
        return Ok(diagnose::split(&all));
    }
    let held = all.for_proof(Dataset::read(model, held_out)?)?;
    Ok((all, held))
}

/// Write the results of a diagnosis to a folder.
pub fn write(
    folder: &Path,
    diagnosis: &Diagnosis,
    (augmented, robot): (&str, Option<&Augmented>),
    proofs: &[report::Proof],
) -> Result<(), Box<dyn std::error::Error>> {
    let page = report::page(diagnosis, augmented, proofs, &typed());
    let json = serde_json::to_string_pretty(diagnosis)?;
    let mut files =
        vec![("diagnosis.json", &*json), ("augmented.toml", augmented), ("report.html", &page)];
    files.extend(robot.map(|file| (&*file.name, &*file.text)));
    let files = files.into_iter().map(|(name, text)| (folder.join(name), text));
    let files: Vec<_> = files.collect();
    let files = files.iter().map(|(path, text)| (path.as_path(), *text));
    Ok(write_together(&files.collect::<Vec<_>>())?)
}

/// Write the report's pictures to files of their own.
fn write_figures(
    folder: &Path,
    diagnosis: &Diagnosis,
    proofs: &[report::Proof],
) -> std::io::Result<()> {
    let folder = folder.join("figures");
    let files = report::files(diagnosis, proofs);
    let paths: Vec<_> = files.iter().map(|f| folder.join(&f.name)).collect();
    let texts = files.iter().map(|f| f.svg.as_str());
    write_together(&paths.iter().map(PathBuf::as_path).zip(texts).collect::<Vec<_>>())
}

/// The series that the report draws.
pub fn proofs(model: &Model, data: &Dataset, proofs: &[Proof]) -> Vec<report::Proof> {
    let series = |p: &Proof, k: usize, output: &Output| report::Proof {
        recording: p.observed.name.clone(),
        channel: output.name.clone(),
        unit: output.unit.clone(),
        time: p.observed.times.clone(),
        measured: p.observed.outputs[k].clone(),
        before: p.before.outputs[k].clone(),
        after: p.after.outputs[k].clone(),
        imposed: imposed(model, output, &p.observed),
    };
    proofs
        .iter()
        .flat_map(|p| data.outputs.iter().enumerate().map(move |(k, o)| series(p, k, o)))
        .collect()
}

/// The imposed motion that an output is drawn against: all of it, where it may be a force on it.
fn imposed(model: &Model, output: &Output, observed: &Observed) -> Vec<report::Imposed> {
    let n = model.coordinates.len();
    let of = |c: usize| {
        let motion = model.motion_index(c)?;
        Some([(c, motion), (c + n, motion + 1)].map(|(state, column)| report::Imposed {
            name: model.state_name(state).to_owned(),
            unit: model.state_unit(state),
            values: observed.command(column),
        }))
    };
    let all = || model.imposed().filter_map(of).flatten().collect();
    match output.of {
        Measured::Force(c) => of(c).into_iter().flatten().collect(),
        Measured::Output(_) => all(),
        Measured::State(_) | Measured::Input(_) => vec![],
    }
}
