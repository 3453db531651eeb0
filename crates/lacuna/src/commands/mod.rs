//! One module a command: its arguments, and what it does with the library.

pub mod check;
mod columns;
pub mod compare;
pub mod compile;
pub mod demo;
pub mod diagnose;
pub mod evaluate_fmu;
pub mod export;
pub mod fleet;
pub mod identify;
pub mod init;
pub mod simulate;
mod typed;

use std::process::ExitCode;

/// What a command returns: its exit code, or an error that is printed as it is.
pub type Outcome = Result<ExitCode, Box<dyn std::error::Error>>;
