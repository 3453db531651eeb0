//! Figures over many cases.

use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

use super::deviations::Coverage;
use super::proportion::Proportion;
use super::row::Row;
use super::score::{Match, Score};
use super::sealed::Matter;
use crate::statistics::quantile;

/// An augmented model within this many noise standard deviations counts as right.
const RIGHT: f64 = 1.2;
/// What stands for nothing in the confusion matrix.
pub const NOTHING: &str = "nothing";

/// How findings fare against effects.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
pub struct Names {
    /// Effects whose class and channel are found, of all effects.
    pub named: Proportion,
    /// The same, the first alternative counted too.
    pub named_top2: Proportion,
    /// Effects whose channel is found.
    pub channel: Proportion,
    /// Findings that answer to no effect.
    pub false_findings: usize,
    /// Cases without missing physics on which anything is found, of all such cases that got an
    /// answer.
    pub null_with_findings: Proportion,
}

/// Figures of a family of cases.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
pub struct Summary {
    /// Cases.
    pub cases: usize,
    /// What the tool finds.
    pub names: Names,
    /// Right verdicts.
    pub verdicts: Proportion,
    /// Cases with every effect named, nothing false and the right verdict.
    pub exactly_right: Proportion,
    /// Cases without an answer.
    pub crashes: usize,
    /// Median error of the nominal model on the recordings for the proof, over the noise, of the
    /// cases that conceal an effect.
    pub before_over_noise: Option<f64>,
    /// That of the augmented model.
    pub after_over_noise: Option<f64>,
    /// Cases whose augmented model is within 1.2 noise standard deviations.
    pub after_within_1_2: Proportion,
    /// Cases whose augmented model predicts the recordings for the proof worse than the model that
    /// was given.
    #[serde(default)]
    pub made_worse: usize,
    /// Mean F1 of local effects, and how many there are.
    pub localisation_f1: Option<(f64, usize)>,
    /// Reported numbers within two of their standard deviations.
    #[serde(default)]
    pub coverage: Option<Coverage>,
    /// Median and greatest wall time of a diagnosis (s).
    pub seconds: [f64; 2],
    /// What the peers' way finds on the same files.
    pub peer: Names,
    /// Cases on which the peers' way gave no answer.
    pub peer_failed: usize,
}

impl Summary {
    /// Figures of some rows.
    pub fn of(rows: &[&Row]) -> Self {
        let answers = |of: fn(&Row) -> (&Score, bool)| {
            let answer = |r: &&Row| (r.matter, of(r).0.clone(), of(r).1);
            rows.iter().map(answer).collect::<Vec<_>>()
        };
        let with_effect = || rows.iter().filter(|r| !r.truth.is_empty());
        let median = |values: Vec<f64>| (!values.is_empty()).then(|| quantile(&values, 0.5));
        let f1: Vec<f64> = rows.iter().flat_map(|r| r.f1.iter().copied()).collect();
        let seconds: Vec<f64> = rows.iter().map(|r| r.seconds).collect();
        let count = |f: &dyn Fn(&Row) -> bool| {
            Proportion::new(rows.iter().filter(|r| f(r)).count(), rows.len())
        };
        Self {
            cases: rows.len(),
            names: Names::of(&answers(|r| (&r.score, r.crash.is_none()))),
            verdicts: count(&|r| r.score.verdict_right && r.crash.is_none()),
            exactly_right: count(&exactly_right),
            crashes: rows.iter().filter(|r| r.crash.is_some()).count(),
            before_over_noise: median(with_effect().filter_map(|r| r.before_over_noise).collect()),
            after_over_noise: median(with_effect().filter_map(|r| r.after_over_noise).collect()),
            after_within_1_2: count(&|r| r.after_over_noise.is_some_and(|a| a <= RIGHT)),
            made_worse: rows.iter().filter(|r| made_worse(r)).count(),
            localisation_f1: (!f1.is_empty())
                .then(|| (f1.iter().sum::<f64>() / f1.len() as f64, f1.len())),
            coverage: Some(Coverage::of(rows)),
            seconds: [quantile(&seconds, 0.5), quantile(&seconds, 1.0)],
            peer: Names::of(&answers(|r| (&r.peer, !r.peer_failed))),
            peer_failed: rows.iter().filter(|r| r.peer_failed).count(),
        }
    }
}

/// By a tenth, and beyond the noise.
fn made_worse(row: &Row) -> bool {
    let errors = row.before_over_noise.zip(row.after_over_noise);
    errors.is_some_and(|(before, after)| after > 1.1 * before.max(1.0))
}

fn exactly_right(row: &Row) -> bool {
    let s = &row.score;
    row.crash.is_none() && s.verdict_right && s.named == s.effects && s.false_findings == 0
}

impl Names {
    /// Figures of scores, each with what is the matter and whether there was an answer at all.
    fn of(scores: &[(Matter, Score, bool)]) -> Self {
        let effects: usize = scores.iter().map(|(_, s, _)| s.effects).sum();
        let sum = |f: fn(&Score) -> usize| scores.iter().map(|(_, s, _)| f(s)).sum();
        let null = scores.iter().filter(|(matter, _, answered)| {
            *answered && matches!(matter, Matter::None | Matter::Disturbed | Matter::Parameter)
        });
        let found = null.clone().filter(|(_, s, _)| s.false_findings > 0).count();
        Self {
            named: Proportion::new(sum(|s| s.named), effects),
            named_top2: Proportion::new(sum(|s| s.named_top2), effects),
            channel: Proportion::new(sum(|s| s.channel), effects),
            false_findings: sum(|s| s.false_findings),
            null_with_findings: Proportion::new(found, null.count()),
        }
    }
}

/// The confusion matrix: how often what is found in the place of each true class. An accepted
/// name counts as the true class.
pub fn confusion(rows: &[Row]) -> BTreeMap<String, BTreeMap<String, usize>> {
    let mut matrix: BTreeMap<String, BTreeMap<String, usize>> = BTreeMap::new();
    for m in rows.iter().flat_map(|r| &r.score.matches) {
        let truth = m.truth.clone().unwrap_or_else(|| NOTHING.to_owned());
        *matrix.entry(truth).or_default().entry(found(m)).or_default() += 1;
    }
    matrix
}

fn found(m: &Match) -> String {
    match (&m.truth, &m.found) {
        (Some(truth), Some(_)) if m.right => truth.clone(),
        (_, Some(name)) => name.class.clone(),
        (_, None) => NOTHING.to_owned(),
    }
}

#[cfg(test)]
mod tests;
