//! The map from evidence to probability, fitted to findings whose truth is known.
//!
//! With y = 1 for a finding that is right and features phi (see
//! [`lacuna_discrepancy::probability`]), theta is at the largest
//!
//! ```text
//! sum_i [ t_i log s_i + (1 - t_i) log(1 - s_i) ] - |slopes|^2 / 2,    s_i = 1 / (1 + exp(-theta . phi_i))
//! ```
//!
//! where t = (k + 1)/(k + 2) for the k findings that are right and 1/(n - k + 2) for the others (J. Platt,
//! 1999): the best claim that so many findings support, so that cases that a line parts have a finite
//! map, too. Slopes are normal a priori with standard deviation 1: a feature that is far from its
//! middle turns the odds by a factor of a few, not of thousands, unless many findings say so. A
//! slope whose sign says that more evidence is worse is set to zero.
//!
//! Nothing is run: what is needed stands in the files of [`super::study`]. A map is fitted to other seeds
//! than those that it is judged by.

use lacuna_discrepancy::diagnosis::{FormulaFit, Support};
use lacuna_discrepancy::probability::{Cases, ProbabilityMap, features};
use nalgebra::{Matrix4, Vector4};
use std::path::{Path, PathBuf};

use super::ConcealedError;
use super::print;
use super::reliability::{Claim, Reliability};
use super::row::Row;
use super::score::Match;
use super::study::Results;
use crate::{StudyError, output};

/// Name of the study.
pub const NAME: &str = "calibration";
/// Newton steps; a few suffice for a strictly concave function of four variables.
const STEPS: usize = 100;
/// A step below which the optimum is reached.
const CONVERGED: f64 = 1e-12;
/// Signs of the slopes: evidence for, what is left against, part of the gain for.
const SIGNS: [f64; 3] = [1.0, -1.0, 1.0];

/// A finding of a drawn case.
#[derive(Clone, Copy, Debug)]
pub struct Judged {
    /// What speaks for it.
    pub support: Support,
    /// How well the formulas of its case fit.
    pub formula: FormulaFit,
    /// Probability that it claimed.
    pub claimed: f64,
    /// Whether its class and channel are right.
    pub right: bool,
}

/// Findings of some files, and the seeds that their cases are of.
struct Sample {
    seeds: Vec<u64>,
    findings: Vec<Judged>,
}

/// Fit the map to files of the study, write it to `map`, and print how it does on them and on others.
///
/// # Errors
/// [`StudyError`] where a file cannot be read or holds no findings with their evidence, and where the map
/// cannot be written.
pub fn run(fit: &[PathBuf], check: &[PathBuf], map: &Path) -> Result<(), StudyError> {
    let sample = Sample::read(fit)?;
    let other = if check.is_empty() { None } else { Some(Sample::read(check)?) };
    let mut fitted = fitted(&sample.findings, command(fit, check));
    fitted.fitted_to = sample.cases(&fitted);
    fitted.checked_on = other.as_ref().map(|o| o.cases(&fitted));
    for (what, sample) in [("fitted to", Some(&sample)), ("checked on", other.as_ref())] {
        let Some(sample) = sample else { continue };
        println!("{what} {} findings, seeds {:?}", sample.findings.len(), sample.seeds);
        print::reliability("as claimed in the files", &sample.reliability(|j| j.claimed));
        print::reliability("by the evidence alone", &sample.reliability(by_evidence));
        print::reliability("by the map", &sample.reliability(|j| said(&fitted, j)));
    }
    output::write_json_to(map, &fitted)?;
    println!("wrote {}", map.display());
    Ok(())
}

fn command(fit: &[PathBuf], check: &[PathBuf]) -> String {
    let words =
        |files: &[PathBuf]| files.iter().map(|f| format!(" {}", f.display())).collect::<String>();
    let check = if check.is_empty() { String::new() } else { format!(" --check{}", words(check)) };
    format!("cargo run --release -p experiments -- {NAME}{}{check}", words(fit))
}

/// Probability by the evidence alone.
fn by_evidence(j: &Judged) -> f64 {
    logistic(j.support.log_odds)
}

fn said(map: &ProbabilityMap, j: &Judged) -> f64 {
    map.probability(&j.support, &j.formula)
}

impl Sample {
    fn read(files: &[PathBuf]) -> Result<Self, StudyError> {
        let (mut seeds, mut findings) = (vec![], vec![]);
        for file in files {
            let results: Results = output::read_json(file)?;
            let judged = judged(&results);
            if judged.is_empty() {
                return Err(ConcealedError::NoEvidence { path: file.clone() }.into());
            }
            seeds.extend(results.seeds);
            findings.extend(judged);
        }
        Ok(Self { seeds, findings })
    }

    fn reliability(&self, says: impl Fn(&Judged) -> f64) -> Reliability {
        let claim = |j: &Judged| Claim { probability: says(j), right: j.right };
        Reliability::of(&self.findings.iter().map(claim).collect::<Vec<_>>())
    }

    fn cases(&self, map: &ProbabilityMap) -> Cases {
        let reliability = self.reliability(|j| said(map, j));
        Cases {
            seeds: self.seeds.clone(),
            findings: self.findings.len(),
            right: self.findings.iter().filter(|j| j.right).count(),
            calibration_error: reliability.calibration_error.unwrap_or(0.0),
            brier: reliability.brier.unwrap_or(0.0),
        }
    }
}

/// The findings of a study that say what they rest on.
fn judged(results: &Results) -> Vec<Judged> {
    let of_row = |r: &Row| {
        let formula = r.formula;
        let judge = |m: &Match| {
            Some(Judged {
                support: m.support?,
                formula: formula?,
                claimed: m.probability?,
                right: m.right,
            })
        };
        r.score.matches.iter().filter_map(judge).collect::<Vec<_>>()
    };
    results.rows.iter().flat_map(of_row).collect()
}

/// The map of some findings; how it does is not in it yet.
fn fitted(findings: &[Judged], command: String) -> ProbabilityMap {
    let right = findings.iter().filter(|j| j.right).count() as f64;
    let wrong = findings.len() as f64 - right;
    // Platt's targets.
    let target = |y: bool| if y { (right + 1.0) / (right + 2.0) } else { 1.0 / (wrong + 2.0) };
    let row = |j: &Judged| {
        let f = features(&j.support, &j.formula);
        Vector4::new(1.0, SIGNS[0] * f[0], SIGNS[1] * f[1], SIGNS[2] * f[2])
    };
    let data: Vec<(Vector4<f64>, f64)> =
        findings.iter().map(|j| (row(j), target(j.right))).collect();
    let theta = monotone(&data);
    let mut map = ProbabilityMap {
        command,
        intercept: theta[0],
        log_odds: theta[1],
        left: theta[2],
        part: theta[3],
        ceiling: 1.0,
        fitted_to: Cases::default(),
        checked_on: None,
    };
    map.ceiling = ceiling(findings.iter().map(|j| (said(&map, j), j.right)).collect());
    map
}

/// The logistic regression with slopes that are not negative: the most negative one is set to zero as
/// long as there is one.
fn monotone(data: &[(Vector4<f64>, f64)]) -> Vector4<f64> {
    let mut free = [true; 4];
    loop {
        let theta = regression(data, free);
        let worst =
            (1..4).filter(|&k| theta[k] < 0.0).min_by(|&a, &b| theta[a].total_cmp(&theta[b]));
        match worst {
            None => return theta,
            Some(k) => free[k] = false,
        }
    }
}

/// Newton's method; entries that are not free stay zero. The Hessian is that of a sum of convex functions and
/// of the prior of the slopes, and a step that is no improvement is halved.
fn regression(data: &[(Vector4<f64>, f64)], free: [bool; 4]) -> Vector4<f64> {
    let cost = |theta: &Vector4<f64>| -> f64 {
        let slopes = theta.fixed_rows::<3>(1).norm_squared();
        let one = |(x, t): &(Vector4<f64>, f64)| {
            let z = theta.dot(x);
            // -t log s - (1 - t) log(1 - s)
            (1.0 + (-z.abs()).exp()).ln() + z.max(0.0) - t * z
        };
        data.iter().map(one).sum::<f64>() + 0.5 * slopes
    };
    let mut theta = Vector4::zeros();
    for _ in 0..STEPS {
        let mut gradient = Vector4::new(0.0, theta[1], theta[2], theta[3]);
        let mut hessian = Matrix4::from_diagonal(&Vector4::new(0.0, 1.0, 1.0, 1.0));
        for (x, t) in data {
            let s = logistic(theta.dot(x));
            gradient += (s - t) * x;
            hessian += s * (1.0 - s) * x * x.transpose();
        }
        for k in (0..4).filter(|&k| !free[k]) {
            gradient[k] = 0.0;
            hessian.row_mut(k).fill(0.0);
            hessian.column_mut(k).fill(0.0);
            hessian[(k, k)] = 1.0;
        }
        let Some(cholesky) = hessian.cholesky() else { break };
        let mut step = cholesky.solve(&gradient);
        let now = cost(&theta);
        while cost(&(theta - step)) > now && step.norm() > CONVERGED {
            step *= 0.5;
        }
        theta -= step;
        if step.norm() < CONVERGED {
            break;
        }
    }
    theta
}

/// The most that findings support: Laplace's rule over the surest of them.
fn ceiling(mut claims: Vec<(f64, bool)>) -> f64 {
    claims.sort_by(|a, b| b.0.total_cmp(&a.0));
    let mut right = 0;
    let mut most: f64 = 0.5;
    for (n, (_, is_right)) in claims.iter().enumerate() {
        right += usize::from(*is_right);
        most = most.max((right as f64 + 1.0) / (n as f64 + 3.0));
    }
    most
}

fn logistic(z: f64) -> f64 {
    1.0 / (1.0 + (-z).exp())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::concealed::score::Score;
    use crate::concealed::sealed::{Group, Matter};
    use rand::RngExt;
    use std::collections::BTreeMap;

    fn judged(log_odds: f64, left: f64, part: f64, right: bool) -> Judged {
        Judged {
            support: Support { log_odds, part },
            formula: FormulaFit { left, residual_over_noise: 1.0 },
            claimed: 0.5,
            right,
        }
    }

    /// Findings drawn from a known map: what is fitted says what it says, to the error of so many draws.
    #[test]
    fn a_map_is_recovered_from_what_it_says() {
        let mut rng = lacuna_excitation::rng(4, 0);
        let truth = |log_odds: f64, left: f64, part: f64| {
            logistic(-0.5 + 0.8 * log_odds.asinh() - 2.0 * left.sqrt() + 1.2 * part.sqrt())
        };
        let findings: Vec<Judged> = (0..4000)
            .map(|_| {
                let log_odds = rng.random_range(0.0f64..6.0).sinh();
                let (left, part) = (rng.random_range(0.0..0.6), rng.random_range(0.0..1.0));
                let right = rng.random_range(0.0..1.0) < truth(log_odds, left, part);
                judged(log_odds, left, part, right)
            })
            .collect();
        let map = fitted(&findings, String::new());
        for j in findings.iter().step_by(40) {
            let p = truth(j.support.log_odds, j.formula.left, j.support.part);
            let q = said(&map, j);
            assert!((p - q).abs() < 0.04, "{j:?}: {p} {q}");
        }
        let claims: Vec<Claim> =
            findings.iter().map(|j| Claim { probability: said(&map, j), right: j.right }).collect();
        assert!(Reliability::of(&claims).calibration_error.unwrap() < 0.02);
    }

    /// A feature that points the wrong way is not used, and the gradient of what is left vanishes.
    #[test]
    fn more_evidence_never_says_less() {
        let findings: Vec<Judged> = (0..60)
            .map(|k| judged(f64::from(k), 0.1 + 0.01 * f64::from(k % 7), 1.0, k < 30 || k % 2 == 0))
            .collect();
        let map = fitted(&findings, String::new());
        assert_eq!(map.log_odds, 0.0);
        assert!(map.left >= 0.0 && map.part >= 0.0);
    }

    /// Where all are right nothing is certain: Laplace's rule.
    #[test]
    fn as_much_is_claimed_as_the_cases_support() {
        let all = vec![(0.9, true); 98];
        assert!((ceiling(all) - 99.0 / 100.0).abs() < 1e-12);
        // The tenth surest is wrong: 10 of 11, or all of them but one.
        let few: Vec<_> = (0..20).map(|k| (1.0 - 0.01 * f64::from(k), k != 9)).collect();
        assert!((ceiling(few) - 10.0 / 11.0).abs() < 1e-12);
        let findings: Vec<Judged> =
            (0..98).map(|k| judged(100.0 + f64::from(k), 0.0, 1.0, true)).collect();
        let map = fitted(&findings, String::new());
        let p = said(&map, &findings[97]);
        assert!(p <= 99.0 / 100.0 && p > 0.97, "{p}");
    }

    /// Results of three cases of a seed, each with a right finding.
    fn results(seed: u64, support: Option<Support>) -> Results {
        let row = || Row {
            case: String::new(),
            plant: String::new(),
            group: Group::Catalogue,
            topic: String::new(),
            matter: Matter::MissingPhysics,
            truth: vec![],
            model_gap_over_noise: 5.0,
            verdict: None,
            findings: vec![],
            formula: Some(FormulaFit { left: 0.01, residual_over_noise: 1.0 }),
            score: Score {
                matches: vec![Match {
                    truth: None,
                    found: None,
                    right: true,
                    probability: Some(0.9),
                    support,
                }],
                ..Score::default()
            },
            f1: vec![],
            deviations: vec![],
            before_over_noise: None,
            after_over_noise: None,
            seconds: 1.0,
            crash: None,
            peer: Score::default(),
            peer_failed: false,
        };
        Results {
            experiment: String::new(),
            command: String::new(),
            tool: String::new(),
            seeds: vec![seed],
            cases: 3,
            groups: BTreeMap::new(),
            reliability: Reliability::of(&[]),
            confusion: BTreeMap::new(),
            rows: vec![row(), row(), row()],
        }
    }

    #[test]
    fn files_make_a_map_that_says_what_it_is_of() {
        let folder = tempfile::tempdir().unwrap();
        let write = |name: &str, results: &Results| {
            output::write_json(folder.path(), name, results).unwrap()
        };
        let support = Some(Support { log_odds: 40.0, part: 1.0 });
        let fit = [write("a", &results(101, support)), write("b", &results(102, support))];
        let check = [write("c", &results(103, support))];
        let map = folder.path().join("map.json");
        run(&fit, &check, &map).unwrap();
        let read: ProbabilityMap = output::read_json(&map).unwrap();
        assert_eq!((&read.fitted_to.seeds[..], read.fitted_to.right), (&[101, 102][..], 6));
        let checked = read.checked_on.as_ref().unwrap();
        assert_eq!((&checked.seeds[..], checked.findings), (&[103][..], 3));
        // Six of six: Laplace's rule says seven of eight.
        assert!((read.ceiling - 7.0 / 8.0).abs() < 1e-12);
        assert!(read.command.contains("--check") && read.command.contains("a.json"));
        let bare = write("bare", &results(104, None));
        let said = run(&[bare], &[], &map).unwrap_err().to_string();
        assert!(said.contains("bare.json") && said.contains("evidence"), "{said}");
    }
}
