//! The command line of the studies.

use clap::{Args, Parser, Subcommand};
use std::path::PathBuf;
use std::process::ExitCode;

use crate::{StudyError, duffing, duffing_montecarlo, manipulator, manipulator_ctc};

/// The studies of Lacuna. Statistics go to DIR/NAME.json, figures to DIR/figures.
#[derive(Debug, Parser)]
#[command(name = "experiments", version)]
struct Cli {
    #[command(subcommand)]
    study: Study,
}

#[derive(Debug, Subcommand)]
enum Study {
    /// Duffing oscillator: one trial, and the choice of lambda from 1e-13 to 1e7.
    Duffing {
        /// Trials over which each lambda is judged.
        #[arg(long, default_value_t = 40, value_parser = clap::value_parser!(u64).range(1..))]
        trials: u64,
        #[command(flatten)]
        common: Common,
    },
    /// Duffing oscillator: errors of drift and control effectiveness over many trials.
    DuffingMontecarlo {
        /// Number of trials; trial k draws from random stream k.
        #[arg(long, default_value_t = 1000, value_parser = clap::value_parser!(u64).range(1..))]
        trials: u64,
        #[command(flatten)]
        common: Common,
    },
    /// Two-link manipulator: relative errors of drift and control effectiveness.
    Manipulator {
        #[command(flatten)]
        common: Common,
    },
    /// Two-link manipulator regulated by computed torque: true against identified model.
    ManipulatorCtc {
        #[command(flatten)]
        common: Common,
    },
}

/// What every study takes.
#[derive(Args, Clone, Debug)]
pub struct Common {
    /// Seed of all random draws.
    #[arg(long, default_value_t = 1)]
    pub seed: u64,
    /// Directory of the results.
    #[arg(long, value_name = "DIR", default_value = "results")]
    pub out: PathBuf,
    /// Show no progress bar and print nothing but errors.
    #[arg(long)]
    pub quiet: bool,
}

/// Read the command line, carry out the study and report errors on standard error.
pub fn run() -> ExitCode {
    let outcome = match Cli::parse().study {
        Study::Duffing { trials, common } => duffing::run(trials, &common),
        Study::DuffingMontecarlo { trials, common } => duffing_montecarlo::run(trials, &common),
        Study::Manipulator { common } => manipulator::run(&common),
        Study::ManipulatorCtc { common } => manipulator_ctc::run(&common),
    };
    match outcome {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            report(&error);
            ExitCode::FAILURE
        }
    }
}

fn report(error: &StudyError) {
    eprintln!("error: {error}");
    let mut cause = std::error::Error::source(error);
    while let Some(source) = cause {
        eprintln!("  because: {source}");
        cause = source.source();
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::CommandFactory;

    #[test]
    fn the_command_line_is_consistent() {
        Cli::command().debug_assert();
    }

    #[test]
    fn a_study_without_trials_is_refused() {
        let parse = |n| Cli::try_parse_from(["experiments", "duffing-montecarlo", "--trials", n]);
        assert!(parse("0").is_err());
        assert!(parse("3").is_ok());
    }
}
