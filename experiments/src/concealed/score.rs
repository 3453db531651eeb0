//! A diagnosis against the truth.

use serde::{Deserialize, Serialize};

use lacuna_discrepancy::diagnosis::Support;

use super::diagnosis::{Diagnosis, Finding};
use super::sealed::{Matter, Name, Sealed, SealedEffect};

/// The class of a free curve.
const UNKNOWN: &str = "unknown_function";
/// The class that stands for the verdict miscalibrated.
const PARAMETER: &str = "parameter_error";

/// How one effect fared, or one finding that answers to none.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
pub struct Match {
    /// The concealed class; none: nothing was there.
    pub truth: Option<String>,
    /// The found class; none: nothing was found.
    pub found: Option<Name>,
    /// Whether class and channel are right.
    pub right: bool,
    /// Claimed probability of the finding.
    pub probability: Option<f64>,
    /// What spoke for its class before calibration.
    #[serde(default)]
    pub support: Option<Support>,
}

/// The score of a case.
#[derive(Clone, Debug, Default, Deserialize, PartialEq, Serialize)]
pub struct Score {
    /// Whether the verdict is right.
    pub verdict_right: bool,
    /// Effects that are concealed.
    pub effects: usize,
    /// Effects whose class and channel are found.
    pub named: usize,
    /// The same, where the first alternative of a finding counts too.
    pub named_top2: usize,
    /// Effects whose channel is found.
    pub channel: usize,
    /// Findings that answer to no effect.
    pub false_findings: usize,
    /// What answered to what.
    pub matches: Vec<Match>,
}

/// Score findings and verdict against the truth.
///
/// Each effect is answered by the first finding with a right name. A finding that is left answers,
/// wrongly, to an effect that is left; findings that are left after that are false.
pub fn score(truth: &Sealed, diagnosis: &Diagnosis) -> Score {
    let mut score = Score { effects: truth.effects.len(), ..Score::default() };
    score.verdict_right = verdict_right(truth, diagnosis);
    let mut left: Vec<&Finding> = diagnosis.findings.iter().collect();
    let mut missed = Vec::new();
    for effect in &truth.effects {
        score.channel += usize::from(left.iter().any(|f| right_channel(effect, f)));
        let as_parameter = effect.accept.iter().any(|n| n.class == PARAMETER)
            && diagnosis.verdict == "miscalibrated"
            && diagnosis.findings.is_empty();
        let found = left.iter().position(|f| named(effect, &f.name(), f));
        match found {
            Some(k) => score.matches.push(answer(Some(effect), Some(left.remove(k)), true)),
            None if as_parameter => score.matches.push(Match {
                found: Some(Name::new(PARAMETER, "")),
                ..answer(Some(effect), None, true)
            }),
            None => missed.push(effect),
        }
    }
    score.named = score.matches.len();
    score.named_top2 = score.named;
    for effect in missed {
        let second =
            |f: &&Finding| f.alternatives.first().is_some_and(|a| named(effect, &a.name, f));
        score.named_top2 += usize::from(left.iter().any(second));
        let wrong = (!left.is_empty()).then(|| left.remove(0));
        score.matches.push(answer(Some(effect), wrong, false));
    }
    left.retain(|f| !harmless(truth, f));
    score.false_findings = left.len();
    score.matches.extend(left.into_iter().map(|f| answer(None, Some(f), false)));
    score
}

fn answer(effect: Option<&SealedEffect>, finding: Option<&Finding>, right: bool) -> Match {
    Match {
        truth: effect.map(|e| e.name.class.clone()),
        found: finding.map(Finding::name),
        right,
        probability: finding.and_then(|f| f.probability),
        support: finding.and_then(|f| f.support),
    }
}

/// Whether a name, that of a finding or of its alternative, is right for an effect.
fn named(effect: &SealedEffect, name: &Name, finding: &Finding) -> bool {
    let accepted = *name == effect.name || effect.accept.contains(name);
    // A free curve is an answer only if it is one of the right variables.
    let variables = |f: &Finding| {
        !f.depends_on.is_empty() && f.depends_on.iter().all(|v| effect.depends_on.contains(v))
    };
    accepted && (name.class != UNKNOWN || variables(finding))
}

fn right_channel(effect: &SealedEffect, finding: &Finding) -> bool {
    let names = std::iter::once(&effect.name).chain(&effect.accept);
    names.into_iter().any(|n| n.channel == finding.channel)
}

/// A constant beside a friction that differs between the directions is another way to write it.
fn harmless(truth: &Sealed, finding: &Finding) -> bool {
    let asymmetric = |e: &SealedEffect| {
        e.name.class == "asymmetric_friction" && e.name.channel == finding.channel
    };
    // Where the log is slow, what is held between its samples really comes late.
    let late = ["input_delay", "actuator_lag", "sensor_delay"].contains(&finding.class.as_str());
    finding.class == PARAMETER
        || (late && truth.concealment.thinned > 0)
        || (finding.class == "constant_force" && truth.effects.iter().any(asymmetric))
}

/// Unexplained is right only where the catalogue does not hold the law.
fn verdict_right(truth: &Sealed, diagnosis: &Diagnosis) -> bool {
    let beyond = truth.effects.iter().any(|e| !e.catalogue);
    let like_a_parameter =
        truth.effects.iter().any(|e| e.accept.iter().any(|n| n.class == PARAMETER));
    match (truth.matter, diagnosis.verdict.as_str()) {
        (Matter::None, verdict) => verdict == "no_mismatch",
        (Matter::Disturbed, verdict) => ["no_mismatch", "unexplained"].contains(&verdict),
        (Matter::Parameter, verdict) => verdict == "miscalibrated",
        (Matter::Sensor, "sensor_fault") | (_, "missing_physics") => true,
        (Matter::MissingPhysics, "unexplained") => beyond,
        (_, "miscalibrated") => like_a_parameter,
        _ => false,
    }
}

#[cfg(test)]
pub(crate) mod tests;
