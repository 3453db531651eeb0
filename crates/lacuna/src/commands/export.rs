//! `lacuna export`: an identified or compiled model as one source file.

use super::Outcome;
use super::compile::Target;
use crate::say::sayln;
use clap::{Args, ValueEnum};
use lacuna::files::write_whole;
use lacuna::models::LearnedModel;
use lacuna::occupation::compile::source::Language;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

#[derive(Args)]
pub struct Arguments {
    /// model.json of `lacuna identify`, compiled on the way, or what `lacuna compile` wrote
    model: PathBuf,
    /// The language
    #[arg(long)]
    target: Choice,
    #[command(flatten)]
    place: Target,
    /// Write the source to this file [default: model.rs or model.c beside the model]
    #[arg(long)]
    out: Option<PathBuf>,
    /// No progress
    #[arg(long)]
    quiet: bool,
}

#[derive(Clone, Copy, ValueEnum)]
enum Choice {
    /// Rust, no_std
    Rust,
    /// C99
    C,
}

pub fn run(a: &Arguments) -> Outcome {
    let compiled = match LearnedModel::read(&a.model)? {
        LearnedModel::Identified(identified) => {
            let (model, names) = &*identified;
            a.place.compile(&a.model, model, names, a.quiet)?.0
        }
        LearnedModel::Compiled(_) if a.place.is_given() => {
            let said =
                "compiled already: --box and --tolerance are for a model of `lacuna identify`";
            return Err(format!("{}: {said}", a.model.display()).into());
        }
        LearnedModel::Compiled(compiled) => *compiled,
    };
    let (language, file) = match a.target {
        Choice::Rust => (Language::Rust, "model.rs"),
        Choice::C => (Language::C, "model.c"),
    };
    let out = a.out.clone().unwrap_or_else(|| a.model.with_file_name(file));
    write_whole(&out, &compiled.source(language, &identifier(&out)))?;
    sayln!(
        "{}: f and g of {} to a relative error of {:.1e} on the box ({} numbers)",
        out.display(),
        a.model.display(),
        compiled.relative_error(),
        compiled.evaluator().numbers()
    )?;
    match compiled.acceleration_rows() {
        Ok(_) => sayln!("with M = g^-1 and c = -g^-1 f for computed torque: u = M q'' + c")?,
        Err(why) => sayln!("without M and c for computed torque: {why}")?,
    }
    Ok(ExitCode::SUCCESS)
}

/// The file's name as the beginning of names in C.
fn identifier(path: &Path) -> String {
    let stem = path.file_stem().map(|s| s.to_string_lossy().into_owned()).unwrap_or_default();
    let letters = stem.chars().map(|c| if c.is_ascii_alphanumeric() { c } else { '_' });
    let name: String = letters.collect();
    if name.starts_with(|c: char| c.is_ascii_alphabetic()) { name } else { format!("model_{name}") }
}
