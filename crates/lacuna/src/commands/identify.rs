//! `lacuna identify`: drift and control effectiveness from recordings alone.
//!
//! ```text
//! q^(s) = f(x) + g(x) u,    x = (q, q', ..., q^(s-1))
//! ```
//!
//! by occupation-kernel regression with free initial values ([`lacuna::occupation::Identification`]); proved on
//! held-out recordings by compact test functions, whitened by the measurement noise.

mod choice;
mod files;
mod proof;
mod settings;
mod slices;

use super::Outcome;
use super::columns::ColumnArguments;
use crate::output::spinner;
use crate::say::{say, sayln};
use clap::Args;
use lacuna::identification::{Columns, Conditioning, Motion, input_hold};
use lacuna::occupation::Arguments::State;
use lacuna::occupation::identification::Report as Chosen;
use lacuna::occupation::{
    Family, Identification, IdentificationError, Identified, InputPath, Names,
};
use lacuna::recordings::{Recording, RecordingSource};
use lacuna::table::{Table, number};
use proof::Proof;
use serde::Serialize;
use settings::Settings;
use std::error::Error;
use std::path::PathBuf;
use std::process::ExitCode;

#[derive(Args)]
pub struct Arguments {
    /// Recordings: FILE.csv, FILE.csv#rows=100..200 or FILE.csv#t=1.0..2.5; one in four (or the
    /// last quarter of a single one) is kept for proof
    #[arg(required = true)]
    recordings: Vec<RecordingSource>,
    /// Write model.json, drift.csv, effectiveness.csv and functions.svg to this folder
    #[arg(long)]
    out: Option<PathBuf>,
    #[command(flatten)]
    columns: ColumnArguments,
    /// Kernel of all functions; without, the family that makes the recordings most likely, for
    /// each function (exponential is never chosen unasked: it grows without bound where there
    /// are no data); of polynomials the recordings choose the degree, 3 at most
    #[arg(long, value_parser = Family::NAMED.map(|(name, _)| name))]
    kernel: Option<String>,
    /// Kernel widths, one for each argument, separated by commas; without, those that make the
    /// recordings most likely
    #[arg(long, value_delimiter = ',', value_parser = positive_number)]
    widths: Vec<f64>,
    /// Noise variance over prior variance; without, what makes the recordings most likely
    #[arg(long, value_parser = positive_number)]
    lambda: Option<f64>,
    /// Length of the windows with free initial values, about (recordings are cut into equal parts) and
    /// at least 24 samples; without, a typical period
    #[arg(long, value_name = "SECONDS", value_parser = positive_number)]
    window: Option<f64>,
    /// Print the result as JSON
    #[arg(long)]
    json: bool,
    /// Print nothing but errors
    #[arg(long)]
    quiet: bool,
}

fn positive_number(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(v) if v > 0.0 && v.is_finite() => Ok(v),
        _ => Err(format!("expected a positive number, found '{text}'")),
    }
}

/// What is printed.
#[derive(Serialize)]
struct Report<'a> {
    #[serde(flatten)]
    columns: &'a Columns,
    #[serde(flatten)]
    settings: &'a Settings,
    training_recordings: Vec<String>,
    held_out_recordings: Vec<String>,
    /// Samples left out as outliers or at a sensor's limit, and how often angles leapt by whole turns.
    #[serde(flatten)]
    conditioning: &'a Conditioning,
    #[serde(flatten)]
    proof: &'a Proof,
    chosen: &'a Chosen,
    notes: Vec<String>,
    files: Vec<String>,
}

pub fn run(a: &Arguments) -> Outcome {
    let bar = spinner(a.quiet || a.json);
    bar.set_message("reading the recordings");
    let asked = a.columns.asked();
    let (time, notes) = asked.time_of(&a.recordings[0])?;
    let recordings = a
        .recordings
        .iter()
        .map(|s| lacuna::recordings::read(s, &time))
        .collect::<Result<Vec<_>, _>>()?;
    let columns = Columns::choose(&asked, &recordings[0], time, notes)?;
    let path = a.columns.input_path();
    let hold = input_hold(path);
    let (mut training, mut held_out) = split(recordings);
    bar.set_message("conditioning and smoothing the recordings");
    let mut conditioning = Conditioning::default();
    let noise = conditioning.condition(&columns, &asked.units, &mut training)?;
    conditioning.condition(&columns, &asked.units, &mut held_out)?;
    let training = Motion::of(&columns, &noise, &training, hold)?;
    let held_out = Motion::of(&columns, &noise, &held_out, hold)?;
    let settings = Settings::choose(a, &columns, &training)?;
    bar.set_message("choosing kernels and fitting");
    let usable = settings.long_enough(&training);
    let Identified { model, report: chosen } = fit(a, path, &columns, &training)?;
    bar.set_message("proving on what was held out");
    let proof = Proof::of(&model, &settings, &columns, &noise, &usable, &held_out)?;
    bar.finish_and_clear();
    let mut report = Report {
        columns: &columns,
        settings: &settings,
        training_recordings: training.names.clone(),
        held_out_recordings: held_out.names.clone(),
        notes: [
            columns.notes.clone(),
            conditioning.notes(),
            proof.warnings(&columns),
            choice::warnings(&chosen, &columns),
        ]
        .concat(),
        conditioning: &conditioning,
        proof: &proof,
        chosen: &chosen,
        files: Vec::new(),
    };
    if let Some(folder) = &a.out {
        report.files = files::write(folder, &model, &chosen, &columns, &usable)?;
    }
    if a.json {
        sayln!("{}", serde_json::to_string_pretty(&report)?)?;
    } else if !a.quiet {
        say!("{}", report.text())?;
    }
    Ok(ExitCode::SUCCESS)
}

fn fit(
    a: &Arguments,
    path: InputPath,
    columns: &Columns,
    training: &Motion,
) -> Result<Identified, Box<dyn Error>> {
    let mut identification = Identification::new(columns.order, State, path);
    if let Some(families) = a.kernel.as_deref().and_then(Family::named) {
        identification.families = families;
    }
    identification.widths = (!a.widths.is_empty()).then(|| a.widths.clone());
    identification.lambda = a.lambda;
    identification.window = a.window;
    let motions: Vec<_> = training.stretches.iter().map(|s| s.measured.clone()).collect();
    let mut found = identification.identify(&motions).map_err(|e| in_words(columns, &e))?;
    found.model = found.model.with_names(Names {
        coordinates: columns.channels.clone(),
        rates: columns.velocities.clone(),
        inputs: columns.inputs.clone(),
        arguments: columns.arguments.clone(),
        time: columns.time.clone(),
        input_path: path,
    });
    Ok(found)
}

/// Errors count coordinates from 0; users know them by name.
fn in_words(columns: &Columns, error: &IdentificationError) -> String {
    match error {
        IdentificationError::Still { coordinate }
        | IdentificationError::Signal { coordinate, .. } => {
            format!("column '{}': {error}", columns.channels[*coordinate])
        }
        _ => format!("the identification failed: {error}"),
    }
}

/// Training and held-out recordings.
fn split(mut recordings: Vec<Recording>) -> (Vec<Recording>, Vec<Recording>) {
    if let [only] = &recordings[..] {
        let cut = only.len() * 3 / 4;
        return (vec![part(only, 0..cut)], vec![part(only, cut..only.len())]);
    }
    let kept = recordings.len().div_ceil(4);
    let held_out = recordings.split_off(recordings.len() - kept);
    (recordings, held_out)
}

fn part(recording: &Recording, rows: std::ops::Range<usize>) -> Recording {
    let mut part = recording.clone();
    part.name = format!("{} (rows {} to {})", part.name, rows.start, rows.end);
    part.time = part.time[rows.clone()].to_vec();
    part.columns.iter_mut().for_each(|c| c.values = c.values[rows.clone()].to_vec());
    part
}

impl Report<'_> {
    fn text(&self) -> String {
        let c = self.columns;
        let s = self.settings;
        let list = |names: &[String]| names.join(", ");
        let mut out = format!(
            "Order {}: {} of {}, driven by {}\n",
            c.order,
            if c.order == 1 { "first derivatives" } else { "accelerations" },
            list(&c.channels),
            list(&c.inputs)
        );
        out += &choice::text(self.chosen, c);
        out += &format!("\nResiduals in windows of {} s:\n", number(s.window_s));
        let mut table =
            Table::new(&["channel", "residual on", "recordings", "relative", "noise alone"]);
        let sets = [
            ("training", &self.training_recordings, &self.proof.training),
            ("held out", &self.held_out_recordings, &self.proof.held_out),
        ];
        for (k, channel) in c.channels.iter().enumerate() {
            for (name, recordings, set) in sets {
                table.row(vec![
                    channel.clone(),
                    name.to_owned(),
                    recordings.len().to_string(),
                    number(set[k].relative),
                    number(set[k].noise),
                ]);
            }
        }
        out += &table.text();
        out += "  Relative: rms of (observed - predicted) over rms of observed, of the whitened weak \
                form.\n  Noise alone: what the measurement noise leaves of a perfect model.\n\n";
        let mut table = Table::new(&["input", "share that is its own"]);
        for (input, share) in c.inputs.iter().zip(&self.proof.own_share) {
            table.row(vec![input.clone(), number(*share)]);
        }
        out += &table.text();
        out += "  Share of the input that neither the state nor other inputs explain; g is learned \
                from it.\n";
        for note in &self.notes {
            out += &format!("note: {note}\n");
        }
        if !self.files.is_empty() {
            out += &format!("Written: {}\n", list(&self.files));
            out += "  functions.svg shows f and g against their arguments, one at a time with the others at \
                    their\n  median, within two standard deviations.\n";
        }
        out
    }
}
