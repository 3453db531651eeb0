//! `lacuna diagnose`: find the physics that a model leaves out, or a simulator of which there are but recordings.

use super::Outcome;
use super::columns::ColumnArguments;
use super::typed::typed;
use crate::interrupt::Cancellable;
use crate::output::{colour, spinner, steps};
use crate::say::{say, sayln};
use clap::Args;
use lacuna::diagnosed::{Diagnosed, datasets, recordings};
use lacuna::difference::{Runs, compare_runs};
use lacuna::discrepancy::diagnose::{self, Options};
use lacuna::discrepancy::diagnosis::Verdict;
use lacuna::discrepancy::robot_file::Augmented;
use lacuna::discrepancy::{Scope, Selector, Watch};
use lacuna::files::check_folder;
use lacuna::models::read_equations;
use lacuna::recordings::RecordingSource;
use lacuna::report;
use std::path::PathBuf;
use std::process::ExitCode;
use std::time::Duration;

#[derive(Args)]
pub struct Arguments {
    /// The model file; with --simulated the first recording
    model: PathBuf,
    /// Recordings to fit: FILE.csv, FILE.csv#rows=100..200 or FILE.csv#t=1.0..2.5
    #[arg(required_unless_present = "simulated")]
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
    /// No model: a recording of the simulator, with the columns of the others; may be given several
    /// times. Both are identified and compared; --out is given difference.json and difference.html
    #[arg(long, value_name = "RECORDING", conflicts_with_all = WITH_A_MODEL)]
    simulated: Vec<RecordingSource>,
    #[command(flatten)]
    columns: ColumnArguments,
    /// Tell every step of the search on standard error, a line each
    #[arg(long, conflicts_with_all = ["quiet", "simulated"])]
    steps: bool,
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

/// What says how a model is diagnosed.
const WITH_A_MODEL: [&str; 7] =
    ["held_out", "figures", "learn_remainder", "exclude", "only", "exact", "time_budget"];

pub fn run(a: &Arguments) -> Outcome {
    a.out.as_deref().map_or(Ok(()), check_folder)?;
    if !a.simulated.is_empty() {
        return beside_simulated(a);
    }
    if a.columns.are_said() {
        return Err("--channels, --inputs, --time, --order, --units and --input-hold are said of recordings without \
                    a model (--simulated RECORDING); with one, the model file says it"
            .into());
    }
    let model = read_equations(&a.model, a.recordings.first())?;
    let of = |sources: &[RecordingSource]| recordings(&model, sources);
    let (training, held_out) = datasets(&model, &of(&a.recordings)?, &of(&a.held_out)?)?;
    let bar = spinner(a.quiet || a.json || a.steps);
    let options = Options {
        learn_remainder: a.learn_remainder,
        scope: Scope { only: a.only.clone(), exclude: a.exclude.clone() },
        exact: a.exact.clone(),
        ..Options::default()
    };
    let steps = steps();
    let progress = |doing: &str| match a.steps {
        true => steps(doing),
        false => bar.set_message(doing.to_owned()),
    };
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
    let found = Diagnosed::new(model, &training, outcome?);
    let robot = match &a.out {
        Some(folder) => found.write(folder, &typed())?,
        None => None,
    };
    if let Some(folder) = a.out.as_ref().filter(|_| a.figures) {
        found.write_figures(folder)?;
    }
    if a.json {
        sayln!("{}", found.json()?)?;
    } else if !a.quiet {
        say!("{}", report::summary(found.diagnosis(), colour()))?;
        if let Some(folder) = &a.out {
            sayln!("Written: {}", folder.join("report.html").display())?;
            say!("{}", robot.iter().filter_map(left_out).collect::<String>())?;
        }
    }
    let mismatch = found.diagnosis().verdict != Verdict::NoMismatch;
    Ok(ExitCode::from(u8::from(a.exit_code && mismatch)))
}

/// The recordings beside those of a simulator.
fn beside_simulated(a: &Arguments) -> Outcome {
    let bar = spinner(a.quiet || a.json);
    let first: RecordingSource = a.model.to_string_lossy().parse()?;
    let recorded = [&[first][..], &a.recordings].concat();
    let (asked, path) = (a.columns.asked(), a.columns.input_path());
    let runs = Runs::read(&a.simulated, &recorded, &asked)?;
    let progress = |doing: &str| bar.set_message(doing.to_owned());
    let found = compare_runs(runs, (&asked, path), &progress)?;
    bar.finish_and_clear();
    if let Some(folder) = &a.out {
        found.write(folder)?;
    }
    if a.json {
        sayln!("{}", found.json()?)?;
    } else if !a.quiet {
        say!("{}", found.text())?;
        if let Some(folder) = &a.out {
            sayln!("Written: {}", folder.join("difference.html").display())?;
        }
    }
    Ok(ExitCode::from(u8::from(a.exit_code && found.is_mismatch())))
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
