//! Many trajectories of the two-link manipulator: the paper's regression with the whole Gram matrix where that fits, and
//! with landmarks, streamed, for any number.

use lacuna_excitation::rng;
use lacuna_occupation::{Fitted, Limits, StreamError, Way};
use serde::{Deserialize, Serialize};
use std::time::Instant;

use crate::cli::Common;
use crate::manipulator_data::{Errors, Summary, initial_states, trajectory};
use crate::recipes::paper;
use crate::{StudyError, output};

/// Name of the study and of its results.
pub const NAME: &str = "manipulator-large";
/// Samples of a trajectory: 1 s every 0.02 s.
const SAMPLES: usize = 51;
/// The paper's regularisation.
const LAMBDA: f64 = 1e-3;

/// What the study found.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
pub struct Results {
    /// [`NAME`].
    pub experiment: String,
    /// Number of data sets of each size: one.
    pub trials: u64,
    /// Seed of all draws.
    pub seed: u64,
    /// Most landmarks.
    pub landmarks: usize,
    /// One for each fit.
    pub fits: Vec<Fit>,
}

/// A fit and its errors.
#[derive(Clone, Copy, Debug, Deserialize, PartialEq, Serialize)]
pub struct Fit {
    /// Number of trajectories.
    pub trajectories: usize,
    /// Landmarks that were taken; none for a dense fit.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub landmarks: Option<usize>,
    /// Relative errors on the evaluation points.
    pub errors: Summary,
}

/// Fits the first `count` trajectories; the data are simulated when the fit asks for them and never stored. The initial
/// states are those of the manipulator study, and go on from there.
///
/// # Errors
/// [`StudyError`] when simulation or regression fails.
pub fn fit(count: usize, seed: u64, limits: Limits) -> Result<(Fitted, Fit), StudyError> {
    let states = initial_states(count)?;
    let one = |k: usize| trajectory(&states[k], SAMPLES, 0.0, &mut rng(seed, k as u64));
    let fitted =
        paper(1, LAMBDA).fit_streamed(count, one, limits).map_err(|error| match error {
            StreamError::Trajectory { source, .. } => source,
            StreamError::Fit(error) => error.into(),
        })?;
    let landmarks = match fitted.way {
        Way::Dense { .. } => None,
        Way::LowRank(low_rank) => Some(low_rank.landmarks),
    };
    let errors = Errors::of(&fitted.model)?.summary();
    Ok((fitted, Fit { trajectories: count, landmarks, errors }))
}

/// Carry out the study, write its results and print them, with times and the most memory that was used.
///
/// # Errors
/// [`StudyError`] when a fit fails or results cannot be written.
pub fn run(counts: &[usize], landmarks: usize, common: &Common) -> Result<(), StudyError> {
    let limits = Limits { landmarks, ..Limits::default() };
    let mut fits = Vec::new();
    for &count in counts {
        let dense = (count <= limits.dense).then_some(limits);
        let low_rank = Limits { dense: 0, ..limits };
        for limits in dense.into_iter().chain([low_rank]) {
            let start = Instant::now();
            let (fitted, fit) = fit(count, common.seed, limits)?;
            if !common.quiet {
                print(&fitted, &fit, start.elapsed().as_secs_f64());
            }
            fits.push(fit);
        }
    }
    let experiment = NAME.to_owned();
    let results = Results { experiment, trials: 1, seed: common.seed, landmarks, fits };
    let file = output::write_json(&common.out, NAME, &results)?;
    if !common.quiet {
        println!("wrote {}", file.display());
    }
    Ok(())
}

fn print(fitted: &Fitted, fit: &Fit, seconds: f64) {
    let Summary { f, g1, g2 } = fit.errors;
    println!("{} trajectories of {SAMPLES} samples: {}", fit.trajectories, fitted.way);
    let memory =
        peak_memory().map_or(String::new(), |gib| format!(", {gib:.2} GiB at most so far"));
    println!("  {seconds:.1} s with simulation{memory}");
    println!(
        "  relative errors, median / greatest: f {:.4} / {:.4}, g1 {:.4} / {:.4}, g2 {:.4} / {:.4}",
        f.median, f.max, g1.median, g1.max, g2.median, g2.max
    );
}

/// The most memory that this process has used, in GiB, where the system tells.
fn peak_memory() -> Option<f64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find(|line| line.starts_with("VmHWM:"))?;
    let kib: f64 = line.split_whitespace().nth(1)?.parse().ok()?;
    Some(kib / (1024.0 * 1024.0))
}
