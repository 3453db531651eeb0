//! The rates of a few cases, small enough for every change to be held against them.

use serde::{Deserialize, Serialize};
use std::path::PathBuf;

use super::row::Row;
use super::sealed::{Group, Matter};
use super::study::{NAME, Settings, diagnosed};
use crate::cli::Common;
use crate::statistics::quantile;
use crate::{StudyError, output};

/// Cases that every change is held against.
#[derive(Clone, Copy, Debug)]
pub struct Few {
    /// Name of the file with their rates, beside those of the study.
    pub file: &'static str,
    cases: usize,
    seed: u64,
    group: Option<Group>,
}

/// Machines described by equations, of all groups, whose seed no other run uses; and robots.
pub const FEW: [Few; 2] = [
    Few { file: "regression", cases: 24, seed: 11, group: None },
    Few { file: "regression-robots", cases: 9, seed: 202, group: Some(Group::Robots) },
];
/// The command that makes the file.
const COMMAND: &str = "cargo run --release -p experiments -- concealed-physics --regression";

/// The rates of the tool on the cases.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
pub struct Rates {
    /// [`NAME`].
    pub experiment: String,
    /// The command that produced this file.
    pub command: String,
    /// Seed of all draws.
    pub seed: u64,
    /// Number of cases.
    pub cases: usize,
    /// Concealed effects.
    pub effects: usize,
    /// Those whose class and channel are found.
    pub named: usize,
    /// Findings that answer to no effect.
    pub false_findings: usize,
    /// Cases without missing physics.
    pub null_cases: usize,
    /// Those on which anything is found.
    pub null_with_findings: usize,
    /// Cases with the right verdict.
    pub verdicts: usize,
    /// Cases without an answer.
    pub crashes: usize,
    /// Error of the augmented model on the recordings for the proof, over the noise, of each case
    /// that conceals an effect, in increasing order; a case without an answer is left out.
    pub errors_over_noise: Vec<f64>,
    /// Their median.
    pub median_error_over_noise: f64,
}

/// Draw the cases and diagnose them with a `lacuna` command, or the one beside the running
/// executable, `jobs` at once.
///
/// # Errors
/// [`StudyError`] when the tool is not there, or a case cannot be drawn or written.
pub fn rates(
    few: &Few,
    lacuna: Option<PathBuf>,
    jobs: usize,
    quiet: bool,
) -> Result<Rates, StudyError> {
    let Few { cases, seed, group, .. } = *few;
    let seeds = vec![seed];
    let settings = Settings { cases, seeds, group, jobs, lacuna, timeout: 600, keep: None };
    let common = Common { seed, out: PathBuf::new(), quiet };
    Ok(Rates::of(seed, &diagnosed(&settings, &common)?.rows))
}

/// Make the files of the rates again.
///
/// # Errors
/// As [`rates`], and when a file cannot be written.
pub fn run(lacuna: Option<&PathBuf>, jobs: usize, common: &Common) -> Result<(), StudyError> {
    for few in &FEW {
        let rates = rates(few, lacuna.cloned(), jobs, common.quiet)?;
        let file = output::write_json(&common.out.join(NAME), few.file, &rates)?;
        if !common.quiet {
            println!("wrote {}", file.display());
        }
    }
    Ok(())
}

impl Rates {
    fn of(seed: u64, rows: &[Row]) -> Self {
        let sum = |count: fn(&Row) -> usize| rows.iter().map(count).sum::<usize>();
        let null = |r: &&Row| matches!(r.matter, Matter::None | Matter::Parameter);
        let with_effect = rows.iter().filter(|r| !r.truth.is_empty());
        let mut errors: Vec<f64> = with_effect.filter_map(|r| r.after_over_noise).collect();
        errors.sort_by(f64::total_cmp);
        Self {
            experiment: NAME.to_owned(),
            command: COMMAND.to_owned(),
            seed,
            cases: rows.len(),
            effects: sum(|r| r.score.effects),
            named: sum(|r| r.score.named),
            false_findings: sum(|r| r.score.false_findings),
            null_cases: rows.iter().filter(null).count(),
            null_with_findings: rows
                .iter()
                .filter(null)
                .filter(|r| r.score.false_findings > 0)
                .count(),
            verdicts: sum(|r| usize::from(r.score.verdict_right && r.crash.is_none())),
            crashes: sum(|r| usize::from(r.crash.is_some())),
            median_error_over_noise: quantile(&errors, 0.5),
            errors_over_noise: errors,
        }
    }

    /// What is worse than `before` by more than one case, in words. Rounding differs from machine
    /// to machine, and may turn a case that is close; it does not turn two.
    #[must_use]
    pub fn worse_than(&self, before: &Self) -> Vec<String> {
        let fewer = [
            ("effects named", self.named, before.named),
            ("right verdicts", self.verdicts, before.verdicts),
        ];
        let more = [
            ("false findings", self.false_findings, before.false_findings),
            ("null cases with findings", self.null_with_findings, before.null_with_findings),
            ("cases without an answer", self.crashes, before.crashes),
        ];
        let fewer = fewer.into_iter().filter(|(_, now, then)| now + 1 < *then);
        let more = more.into_iter().filter(|(_, now, then)| *now > then + 1);
        let counts =
            fewer.chain(more).map(|(what, now, then)| format!("{what}: {now}, not {then}"));
        let (error, most) = (self.median_error_over_noise, before.median_but_for_one());
        let error = (error.is_nan() || error > most)
            .then(|| format!("median error over noise: {error}, more than {most}"));
        counts.chain(error).collect()
    }

    /// The median of the errors if the best of them were the worst.
    fn median_but_for_one(&self) -> f64 {
        let mut errors = self.errors_over_noise.clone();
        if let (Some(best), Some(worst)) = (errors.first().copied(), errors.last().copied()) {
            errors[0] = best.max(worst);
        }
        quantile(&errors, 0.5)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn before() -> Rates {
        Rates {
            experiment: String::new(),
            command: String::new(),
            seed: 11,
            cases: 24,
            effects: 20,
            named: 18,
            false_findings: 1,
            null_cases: 4,
            null_with_findings: 0,
            verdicts: 22,
            crashes: 0,
            errors_over_noise: vec![0.9, 1.0, 1.2, 1.5, 4.0],
            median_error_over_noise: 1.2,
        }
    }

    #[test]
    fn one_case_may_turn_and_two_may_not() {
        let committed = before();
        assert!(committed.worse_than(&committed).is_empty());
        let one = Rates { named: 17, verdicts: 21, false_findings: 2, ..before() };
        assert!(Rates { median_error_over_noise: 1.5, ..one }.worse_than(&committed).is_empty());
        for worse in [
            Rates { named: 16, ..before() },
            Rates { verdicts: 20, ..before() },
            Rates { false_findings: 3, ..before() },
            Rates { null_with_findings: 2, ..before() },
            Rates { crashes: 2, ..before() },
            Rates { median_error_over_noise: 1.51, ..before() },
            Rates { median_error_over_noise: f64::NAN, ..before() },
        ] {
            assert_eq!(worse.worse_than(&committed).len(), 1, "{worse:?}");
        }
        let better = Rates { named: 20, false_findings: 0, verdicts: 24, ..before() };
        assert!(better.worse_than(&committed).is_empty());
    }
}
