//! The committed results can be reproduced: smaller runs with the same seeds must fall into
//! bands around them.

use experiments::duffing_data::TrialErrors;
use experiments::duffing_montecarlo::Statistics;
use experiments::statistics::OverTrials;
use experiments::{duffing, duffing_montecarlo, manipulator, manipulator_ctc};
use serde::de::DeserializeOwned;
use std::path::Path;

/// Trials of the smaller Monte-Carlo run.
const TRIALS: u64 = 24;

/// Numbers that do not depend on chance (same seed, same data) may differ by rounding alone,
/// amplified by the conditioning of the Gram matrix: relative 1e-6.
const ROUNDING: f64 = 1e-6;

fn committed<T: DeserializeOwned>(name: &str) -> T {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../results");
    let path = root.join(format!("{name}.json"));
    let text = std::fs::read_to_string(&path).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
    serde_json::from_str(&text).unwrap_or_else(|e| panic!("{}: {e}", path.display()))
}

/// The mean over `n` of the committed `N` trials has standard deviation
/// `sd sqrt(1/n - 1/N)` about the committed mean; three of those are allowed.
fn check_mean(what: &str, found: OverTrials, expected: OverTrials, n: u64, all: u64) {
    let band = 3.0 * expected.sd * (1.0 / n as f64 - 1.0 / all as f64).sqrt();
    let off = (found.mean - expected.mean).abs();
    assert!(off <= band, "{what}: mean {} is off {} by {off} > {band}", found.mean, expected.mean);
}

#[test]
fn duffing_montecarlo_stays_in_its_bands() {
    let expected: duffing_montecarlo::Results = committed(duffing_montecarlo::NAME);
    assert!(expected.trials > TRIALS, "a band needs more committed trials than {TRIALS}");
    let found = duffing_montecarlo::trials(TRIALS, expected.seed, true).unwrap();
    assert!(!expected.recipes.is_empty());
    for (recipe, s) in &expected.recipes {
        let f = Statistics::of(&found[recipe]);
        let pairs = [
            ("max_f", f.max_f, s.max_f),
            ("max_g", f.max_g, s.max_g),
            ("mean_f", f.mean_f, s.mean_f),
            ("mean_g", f.mean_g, s.mean_g),
        ];
        for (name, found, expected_over) in pairs {
            let what = format!("{recipe} {name}");
            check_mean(&what, found, expected_over, TRIALS, expected.trials);
        }
    }
}

/// Means over the committed trials against the targets set from an independent NumPy run.
#[test]
fn committed_duffing_results_meet_their_targets() {
    let results: duffing_montecarlo::Results = committed(duffing_montecarlo::NAME);
    let paper = results.recipes["paper"];
    assert!((0.95..=1.15).contains(&paper.max_f.mean), "{:?}", paper.max_f);
    assert!((0.4..=0.75).contains(&paper.max_g.mean), "{:?}", paper.max_g);
}

/// The single trial of `duffing` is trial 0 of the same seed.
#[test]
fn the_single_duffing_trial_is_reproduced() {
    let expected: duffing::Results = committed(duffing::NAME);
    let found = duffing_montecarlo::trials(1, expected.seed, true).unwrap();
    for (recipe, e) in &expected.recipes {
        let values = |t: &TrialErrors| [t.max_f, t.max_g, t.mean_f, t.mean_g];
        for (a, b) in values(&found[recipe][0]).into_iter().zip(values(e)) {
            close(&format!("{recipe} trial 0"), a, b, ROUNDING * b);
        }
    }
}

#[test]
fn manipulator_errors_are_reproduced() {
    let expected: manipulator::Results = committed(manipulator::NAME);
    let found = manipulator::errors(expected.seed).unwrap();
    for (recipe, s) in &expected.recipes {
        let f = found[recipe].summary();
        for (name, a, b) in [("f", f.f, s.f), ("g1", f.g1, s.g1), ("g2", f.g2, s.g2)] {
            close(&format!("{recipe} {name} max"), a.max, b.max, ROUNDING * b.max);
            close(&format!("{recipe} {name} median"), a.median, b.median, ROUNDING * b.median);
            close(&format!("{recipe} {name} mean"), a.mean, b.mean, ROUNDING * b.mean);
        }
    }
}

#[test]
fn regulators_are_reproduced_and_meet_their_targets() {
    let expected: manipulator_ctc::Results = committed(manipulator_ctc::NAME);
    let (truth, identified) = manipulator_ctc::runs(expected.seed).unwrap();
    for (recipe, e) in &expected.recipes {
        let found = manipulator_ctc::compare(&truth, &identified[recipe]);
        let angles = |c: &manipulator_ctc::Comparison| {
            [c.true_model, c.identified_model].map(|a| [a.q_5s, a.q_10s]).concat().concat()
        };
        for (a, b) in angles(&found).into_iter().zip(angles(e)) {
            close(&format!("{recipe} angle"), a, b, 1e-6);
        }
        close(recipe, found.largest_difference, e.largest_difference, 1e-6);
        for joint in 0..2 {
            close("q(5 s), true model", found.true_model.q_5s[joint], 0.0105, 5e-5);
            close("q(10 s), true model", found.true_model.q_10s[joint], 0.0003, 5e-5);
            close("q(10 s), identified model", found.identified_model.q_10s[joint], 0.0, 0.02);
        }
    }
}

fn close(what: &str, found: f64, expected: f64, within: f64) {
    assert!((found - expected).abs() <= within, "{what}: {found} is not {expected} +- {within}");
}
