//! `lacuna evaluate-fmu`: what the command calls itself for, so that an FMU's code runs in a process of its own.

use super::Outcome;
use std::path::PathBuf;
use std::process::ExitCode;

const NAME: &str = "evaluate-fmu";

/// Arguments of the command.
#[derive(clap::Args)]
pub struct Arguments {
    /// The folder that the FMU is unpacked in
    folder: PathBuf,
}

/// That this program evaluates FMUs for itself.
pub fn name_this_program() {
    if let Ok(program) = std::env::current_exe() {
        lacuna::fmu::evaluate_with(program, [NAME]);
    }
}

/// Run the command.
pub fn run(a: &Arguments) -> Outcome {
    lacuna::fmu::serve(&a.folder)?;
    Ok(ExitCode::SUCCESS)
}
