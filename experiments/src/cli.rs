//! The command line of the studies.

use clap::{Args, Parser, Subcommand};
use std::path::PathBuf;
use std::process::ExitCode;

use crate::concealed::{self, sealed::Group};
use crate::manipulator_realtime::Evaluator;
use crate::{
    StudyError, ablation, duffing, duffing_montecarlo, fleet, invariance, lambda_ablation,
    manipulator, manipulator_ctc, manipulator_large, manipulator_realtime, noise_sweep, signatures,
    speed,
};

/// The studies of Lacuna. Statistics go to DIR/NAME.json, figures to DIR/figures.
#[derive(Debug, Parser)]
#[command(name = "experiments", version)]
struct Cli {
    #[command(subcommand)]
    study: Study,
}

#[derive(Debug, Subcommand)]
enum Study {
    /// Duffing oscillator: one trial.
    Duffing {
        #[command(flatten)]
        common: Common,
    },
    /// Duffing oscillator: the paper's recipe with lambda from 1e-13 to 1e7.
    LambdaAblation {
        /// Trials over which each lambda is judged.
        #[arg(long, default_value_t = 40, value_parser = clap::value_parser!(u64).range(1..))]
        trials: u64,
        /// Published curves to draw behind ours in the figure, where the file exists.
        #[arg(
            long,
            value_name = "FILE",
            default_value = "../shared/reference/paper_digitised.json"
        )]
        published: PathBuf,
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
    /// Duffing oscillator: errors against the noise on the position, from none to 0.1.
    NoiseSweep {
        /// Trials with each noise.
        #[arg(long, default_value_t = 20, value_parser = clap::value_parser!(u64).range(1..))]
        trials: u64,
        #[command(flatten)]
        common: Common,
    },
    /// Two-link manipulator: relative errors of drift and control effectiveness.
    Manipulator {
        /// Standard deviation of the noise on all states, rad and rad/s. Results with noise have
        /// files of their own.
        #[arg(long, value_name = "SD", default_value_t = 0.0)]
        noise: f64,
        #[command(flatten)]
        common: Common,
    },
    /// Two-link manipulator: the paper's regression on many trajectories, streamed.
    ManipulatorLarge {
        /// Numbers of trajectories.
        #[arg(long, value_delimiter = ',', default_values_t = [1000, 2000, 10_000, 100_000])]
        trajectories: Vec<usize>,
        /// Most landmarks.
        #[arg(long, default_value_t = 1000, value_parser = clap::value_parser!(u64).range(1..))]
        landmarks: u64,
        #[command(flatten)]
        common: Common,
    },
    /// Two-link manipulator regulated by computed torque: true against identified model.
    ManipulatorCtc {
        /// Close the loop at 10 kHz with this evaluation of the identified models, and print how long the control law
        /// takes; writes no results.
        #[arg(long)]
        evaluator: Option<Evaluator>,
        #[command(flatten)]
        common: Common,
    },
    /// Physics concealed in made-up recordings: is it found by `lacuna diagnose`, which sees files
    /// alone? Results go to DIR/concealed-physics.
    ConcealedPhysics {
        /// Number of cases; case k draws from random stream k.
        #[arg(long, default_value_t = 100, value_parser = clap::value_parser!(u64).range(1..))]
        cases: u64,
        /// Draw so many cases from each of these seeds, in place of --seed.
        #[arg(long, value_name = "SEED", value_delimiter = ',', conflicts_with = "seed")]
        seeds: Vec<u64>,
        /// Family of cases.
        #[arg(long, value_enum, default_value_t = Family::All)]
        group: Family,
        /// Cases diagnosed at once; they share the cores.
        #[arg(long, default_value_t = 1, value_parser = clap::value_parser!(u64).range(1..))]
        jobs: u64,
        /// The command under test; by default the one beside this executable.
        #[arg(long, value_name = "PATH")]
        lacuna: Option<PathBuf>,
        /// Longest that a diagnosis may take, in seconds.
        #[arg(long, default_value_t = 600)]
        timeout: u64,
        /// Keep the files of all cases, those under seal too, in this directory.
        #[arg(long, value_name = "DIR")]
        keep: Option<PathBuf>,
        /// Make DIR/concealed-physics/regression*.json again, which tests hold each change against: 24 cases from a
        /// seed of their own, and nine robots.
        #[arg(long, conflicts_with_all = ["cases", "group", "seed", "seeds", "timeout", "keep"])]
        regression: bool,
        #[command(flatten)]
        common: Common,
    },
    /// Drawn fleets of one make, some machines unlike the others: are these found by `lacuna fleet`, which sees files
    /// alone, and no other?
    Fleet {
        /// Number of fleets; machine k of all draws from random stream k.
        #[arg(long, default_value_t = 1, value_parser = clap::value_parser!(u64).range(1..))]
        fleets: u64,
        /// Machines of each fleet.
        #[arg(long, default_value_t = 200, value_parser = clap::value_parser!(u64).range(1..))]
        machines: u64,
        /// Of them, those that are unlike the others.
        #[arg(long, default_value_t = 20)]
        unlike: u64,
        /// Machines diagnosed at a time.
        #[arg(long, default_value_t = 2, value_parser = clap::value_parser!(u64).range(1..))]
        jobs: u64,
        /// The command under test; by default the one beside this executable.
        #[arg(long, value_name = "PATH")]
        lacuna: Option<PathBuf>,
        #[command(flatten)]
        common: Common,
    },
    /// What says nothing of a machine (units, order, names, times ...) changes nothing of its diagnosis. Results go to
    /// DIR/invariance.json after each diagnosis; a rerun does those that are not there.
    Invariance {
        /// Number of cases; case k draws from random stream k.
        #[arg(long, default_value_t = 50, value_parser = clap::value_parser!(u64).range(1..))]
        cases: u64,
        /// Transformations; by default all.
        #[arg(long, value_name = "NAME", value_delimiter = ',')]
        only: Vec<String>,
        /// Longest that a diagnosis may take, in seconds.
        #[arg(long, default_value_t = 600)]
        timeout: u64,
        /// Keep the files of all diagnoses in this directory.
        #[arg(long, value_name = "DIR")]
        keep: Option<PathBuf>,
        /// The command under test; by default the one beside this executable.
        #[arg(long, value_name = "PATH")]
        lacuna: Option<PathBuf>,
        #[command(flatten)]
        common: Common,
    },
    /// Fit the map from the evidence for a finding to the probability that is told of it, to files of
    /// results of concealed-physics; nothing is run. The map is part of the source: build again.
    Calibration {
        /// Files of results, statistics.json, of the seeds to fit to.
        #[arg(required = true, value_name = "FILE")]
        fit: Vec<PathBuf>,
        /// Files of other seeds, to see how the map does where it was not fitted.
        #[arg(long, value_name = "FILE", num_args = 1..)]
        check: Vec<PathBuf>,
        /// The map.
        #[arg(
            long,
            value_name = "FILE",
            default_value = "crates/discrepancy/src/probability.json"
        )]
        map: PathBuf,
    },
    /// Each number that decides what `lacuna diagnose` names, halved and doubled, on drawn cases:
    /// what becomes of names, verdicts and errors? Results go to DIR/ablation, anew after each setting.
    Ablation {
        /// Number of cases; case k draws from random stream k.
        #[arg(long, default_value_t = 100, value_parser = clap::value_parser!(u64).range(1..))]
        cases: u64,
        /// Numbers to move; by default all.
        #[arg(long, value_name = "NAME", value_delimiter = ',')]
        fields: Vec<String>,
        /// Threads, each with one case at a time.
        #[arg(long, default_value_t = 1, value_parser = clap::value_parser!(u64).range(1..))]
        jobs: u64,
        /// Go on behind the last setting that DIR/ablation has of the same cases.
        #[arg(long)]
        resume: bool,
        #[command(flatten)]
        common: Common,
    },
    /// Pictures of all effects of the catalogue for the guide, DIR/signatures/CLASS.svg, and the part of DIR/catalogue.md
    /// that shows them.
    Signatures {
        /// The guide.
        #[arg(long, value_name = "DIR", default_value = "docs/guide")]
        guide: PathBuf,
        /// Print nothing but errors.
        #[arg(long)]
        quiet: bool,
    },
    /// Times of the parts beside the same algorithms in NumPy (python3 with NumPy, where it is there).
    Speed {
        /// Trials of the Duffing study that are timed.
        #[arg(long, default_value_t = 10, value_parser = clap::value_parser!(u64).range(1..))]
        trials: u64,
        /// Numbers of trajectories of streamed fits; 100000 takes a minute or two.
        #[arg(long, value_delimiter = ',', default_values_t = [10_000])]
        trajectories: Vec<usize>,
        /// The script in NumPy.
        #[arg(long, value_name = "FILE", default_value = "benches/peer.py")]
        peer: PathBuf,
        /// Seed of all random draws.
        #[arg(long, default_value_t = 1)]
        seed: u64,
    },
}

/// Families of cases of the proof on concealed physics.
#[derive(Clone, Copy, Debug, clap::ValueEnum)]
enum Family {
    /// Effects of the catalogue.
    Catalogue,
    /// Effects by other formulas, or under noise that is not white.
    OffFormula,
    /// Effects that act in a region or from a time on.
    Local,
    /// No missing physics.
    Null,
    /// What real machines do beside: noisy inputs, random forces, hidden coordinates, glitches, slow
    /// logs, laws of several variables, three effects.
    Machines,
    /// Robots of two to five joints, described by a URDF.
    Robots,
    /// All but the last two.
    All,
}

impl Family {
    fn group(self) -> Option<Group> {
        match self {
            Self::Catalogue => Some(Group::Catalogue),
            Self::OffFormula => Some(Group::OffFormula),
            Self::Local => Some(Group::Local),
            Self::Null => Some(Group::Null),
            Self::Machines => Some(Group::Machines),
            Self::Robots => Some(Group::Robots),
            Self::All => None,
        }
    }
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
        Study::Duffing { common } => duffing::run(&common),
        Study::LambdaAblation { trials, published, common } => {
            lambda_ablation::run(trials, &published, &common)
        }
        Study::DuffingMontecarlo { trials, common } => duffing_montecarlo::run(trials, &common),
        Study::NoiseSweep { trials, common } => noise_sweep::run(trials, &common),
        Study::Manipulator { noise, common } => manipulator::run(noise, &common),
        Study::ManipulatorLarge { trajectories, landmarks, common } => {
            manipulator_large::run(&trajectories, landmarks as usize, &common)
        }
        Study::ManipulatorCtc { evaluator: None, common } => manipulator_ctc::run(&common),
        Study::ManipulatorCtc { evaluator: Some(evaluator), common } => {
            manipulator_realtime::run(evaluator, &common)
        }
        Study::ConcealedPhysics { regression: true, jobs, lacuna, common, .. } => {
            concealed::regression::run(lacuna.as_ref(), jobs as usize, &common)
        }
        Study::ConcealedPhysics {
            cases,
            seeds,
            group,
            jobs,
            lacuna,
            timeout,
            keep,
            common,
            ..
        } => {
            let (cases, jobs) = (cases as usize, jobs as usize);
            let seeds = if seeds.is_empty() { vec![common.seed] } else { seeds };
            let group = group.group();
            concealed::run(
                &concealed::Settings { cases, seeds, group, jobs, lacuna, timeout, keep },
                &common,
            )
        }
        Study::Fleet { fleets, machines, unlike, jobs, lacuna, common } => {
            let (unlike, jobs) = (unlike.min(machines), jobs as usize);
            fleet::run(&fleet::Settings { fleets, machines, unlike, jobs, lacuna }, &common)
        }
        Study::Invariance { cases, only, timeout, keep, lacuna, common } => {
            let cases = cases as usize;
            invariance::run(&invariance::Settings { cases, only, timeout, keep, lacuna }, &common)
        }
        Study::Calibration { fit, check, map } => concealed::calibration::run(&fit, &check, &map),
        Study::Ablation { cases, fields, jobs, resume, common } => {
            let (cases, jobs) = (cases as usize, jobs as usize);
            ablation::run(&ablation::Settings { cases, fields, jobs, resume }, &common)
        }
        Study::Signatures { guide, quiet } => signatures::run(&guide, quiet),
        Study::Speed { trials, trajectories, peer, seed } => {
            speed::run(&speed::Settings { trials, trajectories, peer, seed })
        }
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
