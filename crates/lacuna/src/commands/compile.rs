//! `lacuna compile`: an identified model for real-time control.

mod report;
mod sides;
mod timing;

use super::Outcome;
use crate::output::spinner;
use crate::say::sayln;
use clap::Args;
use lacuna::files::write_whole;
use lacuna::models::LearnedModel;
use lacuna::occupation::compile::{Compiled, compile};
use lacuna::occupation::{IdentifiedModel, Names};
use report::Report;
use sides::Sides;
use std::error::Error;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

#[derive(Args)]
pub struct Arguments {
    /// model.json of `lacuna identify`
    model: PathBuf,
    #[command(flatten)]
    target: Target,
    /// Write the compiled model to this file [default: compiled.json beside the model]
    #[arg(long)]
    out: Option<PathBuf>,
    /// Print the report as JSON
    #[arg(long)]
    json: bool,
    /// No progress
    #[arg(long)]
    quiet: bool,
}

/// Where a model is compiled, and how well.
#[derive(Args)]
pub struct Target {
    /// Range of an argument, such as q1=-2..2; those that are not given have the range of the data
    #[arg(long = "box", value_name = "NAME=LOW..HIGH", allow_hyphen_values = true)]
    sides: Vec<String>,
    /// Largest error of each function, relative to its largest value on the box [default: 1e-6]
    #[arg(long)]
    tolerance: Option<f64>,
}

impl Target {
    /// Whether anything was asked for.
    pub fn is_given(&self) -> bool {
        !self.sides.is_empty() || self.tolerance.is_some()
    }

    /// Compile a model to it.
    ///
    /// # Errors
    /// A box that does not fit the model, a tolerance out of range.
    pub fn compile(
        &self,
        path: &Path,
        model: &IdentifiedModel,
        names: &Names,
        quiet: bool,
    ) -> Result<(Compiled, Sides), Box<dyn Error>> {
        let sides = Sides::read(&self.sides, model, names)?;
        let progress = spinner(quiet);
        progress.set_message(format!("compiling {}", path.display()));
        let tolerance = self.tolerance.unwrap_or(1e-6);
        let compiled = compile(model, &sides.domain, tolerance)
            .map_err(|e| format!("{}: {e}", path.display()));
        progress.finish_and_clear();
        Ok((compiled?, sides))
    }
}

pub fn run(a: &Arguments) -> Outcome {
    let LearnedModel::Identified(identified) = LearnedModel::read(&a.model)? else {
        let said = "a compiled model already; expected model.json of `lacuna identify`";
        return Err(format!("{}: {said}", a.model.display()).into());
    };
    let (model, names) = &*identified;
    let (compiled, sides) = a.target.compile(&a.model, model, names, a.quiet || a.json)?;
    let out = a.out.clone().unwrap_or_else(|| a.model.with_file_name("compiled.json"));
    write_whole(&out, &compiled.to_json())?;
    let times = timing::measure(model, &compiled);
    let report = Report::new(&a.model, &out, &compiled, names, &sides, times);
    if a.json {
        sayln!("{}", serde_json::to_string_pretty(&report)?)?;
    } else {
        report.print()?;
    }
    Ok(ExitCode::SUCCESS)
}
