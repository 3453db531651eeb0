//! Probability of a class: the evidence, and how often it was right.
//!
//! Let a class lead its rivals by b_1, b_2, ... nats and gain G nats over nothing at all, whose prior
//! odds are e^B to one ([`Decision::prior_odds`](crate::Decision::prior_odds)). By the evidence alone
//! its log odds are
//!
//! ```text
//! L = -log( sum_i e^(-b_i) + e^(B - G) )
//! ```
//!
//! They would be what they say if one of the formulas were reality's, and the noise as it is modelled.
//! Neither is so, and nats grow with the number of samples: thousands of them may stand behind a
//! wrong name. How often names are right is therefore measured, on cases with a sealed truth, and the
//! probability that is told is
//!
//! ```text
//! p = min( 1 / (1 + e^-z), C ),   z = theta_0 + theta_1 asinh L - theta_2 sqrt(left) + theta_3 sqrt(part)
//! ```
//!
//! | on paper | in code |
//! | --- | --- |
//! | L, and what the finding gains relative to the one that gains most | [`Support`] |
//! | left: share of the mismatch that the findings leave | [`FormulaFit::left`] |
//! | theta, C | [`ProbabilityMap`] |
//!
//! asinh L is L where nats are few and its logarithm where they are many; the square roots make
//! ratios of squares ratios of amplitudes. theta_1, theta_2, theta_3 >= 0: more evidence never says less. The map is
//! fitted by `experiments -- calibration` (logistic regression with Platt's targets), C is the
//! most that its cases support: Laplace's (k + 1)/(n + 2) for the n surest findings, of which k
//! are right, at the n where that is largest.

use crate::diagnosis::{FormulaFit, Support};
use serde::{Deserialize, Serialize};
use std::sync::LazyLock;

/// The map as a file, and where it is in the source.
const FITTED: &str = include_str!("probability.json");

/// What is told of a finding as numbers that weigh alike: asinh L, sqrt(left), sqrt(part).
pub type Features = [f64; 3];

/// From what speaks for a class to its probability.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
pub struct ProbabilityMap {
    /// The command that made it.
    pub command: String,
    /// theta_0.
    pub intercept: f64,
    /// theta_1: for the evidence.
    pub log_odds: f64,
    /// theta_2: against what is left.
    pub left: f64,
    /// theta_3: for the part of all that the findings gain.
    pub part: f64,
    /// C: the most that is ever claimed.
    pub ceiling: f64,
    /// The cases that it was fitted to, and how it does on them.
    pub fitted_to: Cases,
    /// Cases that it was not fitted to, and how it does on them.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub checked_on: Option<Cases>,
}

/// Drawn cases with a sealed truth, and how a map does on them.
#[derive(Clone, Debug, Default, Deserialize, PartialEq, Serialize)]
pub struct Cases {
    /// Seeds that they are drawn from.
    pub seeds: Vec<u64>,
    /// Number of findings in them.
    pub findings: usize,
    /// Those of them that are right.
    pub right: usize,
    /// Expected calibration error: mean over the findings of how far the share of right ones in a
    /// bin of claimed probability is off the mean claim.
    pub calibration_error: f64,
    /// Mean square of what is claimed minus what is so.
    pub brier: f64,
}

/// The numbers that the map looks at.
#[must_use]
pub fn features(support: &Support, formula: &FormulaFit) -> Features {
    [support.log_odds.asinh(), formula.left.max(0.0).sqrt(), support.part.max(0.0).sqrt()]
}

impl ProbabilityMap {
    /// The map that findings are told by.
    ///
    /// # Panics
    /// Never: the file is part of the source, and a test reads it.
    #[must_use]
    pub fn fitted() -> &'static Self {
        static MAP: LazyLock<ProbabilityMap> =
            LazyLock::new(|| serde_json::from_str(FITTED).expect("probability.json is a map"));
        &MAP
    }

    /// Probability that the class is right.
    #[must_use]
    pub fn probability(&self, support: &Support, formula: &FormulaFit) -> f64 {
        let [log_odds, left, part] = features(support, formula);
        let z = self.intercept + self.log_odds * log_odds - self.left * left + self.part * part;
        (1.0 / (1.0 + (-z).exp())).min(self.ceiling)
    }
}

/// Log odds (nats) of what leads others by so many nats: -log sum exp(-nats).
pub(crate) fn log_odds(ahead_of: impl Iterator<Item = f64> + Clone) -> f64 {
    -log_sum_exp(ahead_of.map(|nats| -nats))
}

/// log sum exp of some nats, whatever their size.
pub(crate) fn log_sum_exp(nats: impl Iterator<Item = f64> + Clone) -> f64 {
    let top = nats.clone().fold(f64::NEG_INFINITY, f64::max);
    top + nats.map(|nats| (nats - top).exp()).sum::<f64>().ln()
}

/// Probabilities of rivals that lie so many nats behind a class of a probability: their odds against it are
/// those of the evidence, e^-b, as far as it leaves them room. What all of them leave is the
/// probability that none is right.
pub(crate) fn rivals(probability: f64, behind: &[f64]) -> Vec<f64> {
    let odds: Vec<f64> = behind.iter().map(|nats| (-nats).exp()).collect();
    let all: f64 = odds.iter().sum();
    let scale = if all > 0.0 { probability.min((1.0 - probability) / all) } else { 0.0 };
    odds.into_iter().map(|o| scale * o).collect()
}

#[cfg(test)]
mod tests {
    use super::{ProbabilityMap, log_odds, rivals};
    use crate::diagnosis::{FormulaFit, Support};

    fn says(log_odds: f64, left: f64, part: f64) -> f64 {
        let formula = FormulaFit { left, residual_over_noise: 1.0 };
        ProbabilityMap::fitted().probability(&Support { log_odds, part }, &formula)
    }

    /// One rival at b nats: odds e^b. Two at the same: half as much. A distant one counts for nothing,
    /// and thousands of nats do not overflow.
    #[test]
    fn log_odds_are_those_of_the_posterior() {
        let of = |nats: &[f64]| log_odds(nats.iter().copied());
        assert!((of(&[3.0]) - 3.0).abs() < 1e-12);
        assert!((of(&[3.0, 3.0]) - (3.0 - 2f64.ln())).abs() < 1e-12);
        assert!((of(&[2.0, 5000.0]) - 2.0).abs() < 1e-12);
        assert!((of(&[5000.0, 5001.0]) - (5000.0 - (1.0 + (-1f64).exp()).ln())).abs() < 1e-9);
        let posterior = 1.0 / (1.0 + (-0.4f64).exp() + (-1.7f64).exp());
        assert!((of(&[0.4, 1.7]) - (posterior / (1.0 - posterior)).ln()).abs() < 1e-12);
    }

    #[test]
    fn more_evidence_never_says_less() {
        let map = ProbabilityMap::fitted();
        let grid = |n: usize| (0..=n).map(move |k| k as f64 / n as f64);
        for left in grid(5) {
            for part in grid(5) {
                let p: Vec<f64> =
                    grid(40).map(|t| says(-5.0 + 4000.0 * t.powi(3), left, part)).collect();
                assert!(p.windows(2).all(|w| w[0] <= w[1]), "{p:?}");
                assert!(p.iter().all(|p| *p > 0.0 && *p <= map.ceiling));
            }
        }
        for log_odds in [0.0, 3.0, 300.0] {
            assert!(says(log_odds, 0.5, 1.0) <= says(log_odds, 0.1, 1.0));
            assert!(says(log_odds, 0.1, 0.1) <= says(log_odds, 0.1, 1.0));
        }
    }

    /// Nothing is claimed that the cases of the map do not support: not more than Laplace's rule would
    /// give if all of them were right.
    #[test]
    fn the_map_is_of_its_cases() {
        let map = ProbabilityMap::fitted();
        let cases = &map.fitted_to;
        let laplace = |k: usize, n: usize| (k as f64 + 1.0) / (n as f64 + 2.0);
        assert!(cases.right <= cases.findings && !cases.seeds.is_empty());
        assert!(map.ceiling <= laplace(cases.right, cases.right) + 1e-12);
        assert!(map.ceiling >= laplace(cases.right, cases.findings) - 1e-12);
        assert!([map.log_odds, map.left, map.part].iter().all(|slope| *slope >= 0.0));
        // The seeds of the proof are drawn for nothing else.
        let seeds = cases.seeds.iter().chain(map.checked_on.iter().flat_map(|c| &c.seeds));
        assert!(seeds.into_iter().all(|seed| ![1, 2, 3].contains(seed)));
    }

    #[test]
    fn rivals_have_the_odds_of_the_evidence_in_the_room_that_is_left() {
        let near = |a: f64, b: f64| (a - b).abs() < 1e-12;
        let far = rivals(0.9, &[4.0, 9.0]);
        assert!(near(far[0], 0.9 * (-4f64).exp()) && near(far[1], 0.9 * (-9f64).exp()));
        // A draw with little room: what there is, evenly.
        let draw = rivals(0.6, &[0.0, 0.0]);
        assert!(near(draw[0], 0.2) && near(draw[1], 0.2));
        assert!(rivals(0.9, &[]).is_empty());
        assert!(near(rivals(0.9, &[1e4])[0], 0.0));
    }
}
