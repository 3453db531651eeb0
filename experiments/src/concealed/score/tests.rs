//! Small truths against small diagnoses.

use super::*;
use crate::concealed::diagnosis::Alternative;
use crate::concealed::sealed::Group;
use crate::concealed::sensor::Concealment;

pub(crate) fn effect(class: &str, channel: &str, accept: &[(&str, &str)]) -> SealedEffect {
    SealedEffect {
        name: Name::new(class, channel),
        other: None,
        depends_on: vec!["dq".to_owned()],
        parameters: serde_json::Value::Null,
        accept: accept.iter().map(|(class, channel)| Name::new(class, channel)).collect(),
        catalogue: class != "lugre_friction",
        area: None,
        gap_over_noise: 5.0,
    }
}

pub(crate) fn truth(matter: Matter, effects: Vec<SealedEffect>) -> Sealed {
    Sealed {
        case: "1".to_owned(),
        plant: "p".to_owned(),
        group: Group::Catalogue,
        topic: String::new(),
        matter,
        drive: String::new(),
        effects,
        miscalibrated: Default::default(),
        noise_sd: Default::default(),
        model_gap_over_noise: 0.0,
        concealment: Concealment::default(),
        horizon_s: 1.0,
    }
}

pub(crate) fn finding(class: &str, channel: &str) -> Finding {
    Finding {
        class: class.to_owned(),
        channel: channel.to_owned(),
        probability: Some(0.9),
        ..Finding::default()
    }
}

pub(crate) fn diagnosis(verdict: &str, findings: Vec<Finding>) -> Diagnosis {
    Diagnosis { verdict: verdict.to_owned(), findings, ..Diagnosis::default() }
}

#[test]
fn a_right_name_is_found_whatever_its_place() {
    let truth = truth(Matter::MissingPhysics, vec![effect("coulomb_friction", "q", &[])]);
    let found = vec![finding("cogging", "q"), finding("coulomb_friction", "q")];
    let score = score(&truth, &diagnosis("missing_physics", found));
    assert_eq!((score.named, score.false_findings, score.verdict_right), (1, 1, true));
    let last = score.matches.last().unwrap();
    assert_eq!((last.truth.as_deref(), last.right), (None, false));
}

#[test]
fn a_wrong_name_counts_once_and_its_rival_in_the_top_two() {
    let truth = truth(Matter::MissingPhysics, vec![effect("coulomb_friction", "q", &[])]);
    let name = Name::new("coulomb_friction", "q");
    let wrong = Finding { alternatives: vec![Alternative { name }], ..finding("hysteresis", "q") };
    let score = score(&truth, &diagnosis("missing_physics", vec![wrong]));
    let counts = (score.named, score.named_top2, score.channel, score.false_findings);
    assert_eq!(counts, (0, 1, 1, 0));
    assert_eq!(score.matches[0].found.as_ref().unwrap().class, "hysteresis");
}

#[test]
fn two_effects_are_answered_by_two_findings() {
    let effects = vec![effect("coulomb_friction", "q", &[]), effect("end_stop", "q", &[])];
    let truth = truth(Matter::MissingPhysics, effects);
    let once = score(&truth, &diagnosis("missing_physics", vec![finding("end_stop", "q")]));
    assert_eq!((once.named, once.effects, once.false_findings), (1, 2, 0));
    let twice = vec![finding("end_stop", "q"), finding("coulomb_friction", "q")];
    assert_eq!(score(&truth, &diagnosis("missing_physics", twice)).named, 2);
}

#[test]
fn a_free_curve_must_be_one_of_the_right_variables() {
    let law = effect("lugre_friction", "q", &[(UNKNOWN, "q")]);
    let truth = truth(Matter::MissingPhysics, vec![law]);
    let of = |v: &str| Finding { depends_on: vec![v.to_owned()], ..finding(UNKNOWN, "q") };
    let named = |f| score(&truth, &diagnosis("missing_physics", vec![f])).named;
    assert_eq!((named(of("dq")), named(of("q")), named(finding(UNKNOWN, "q"))), (1, 0, 0));
}

#[test]
fn verdicts_are_judged_by_what_is_the_matter() {
    let right = |matter, effects: Vec<SealedEffect>, verdict: &str| {
        score(&truth(matter, effects), &diagnosis(verdict, vec![])).verdict_right
    };
    assert!(right(Matter::None, vec![], "no_mismatch"));
    assert!(!right(Matter::None, vec![], "missing_physics"));
    assert!(!right(Matter::Parameter, vec![], "missing_physics"));
    let (known, beyond) = (effect("end_stop", "q", &[]), effect("lugre_friction", "q", &[]));
    assert!(!right(Matter::MissingPhysics, vec![known], "unexplained"));
    assert!(right(Matter::MissingPhysics, vec![beyond], "unexplained"));
    let gain = effect("gain_error", "u", &[(PARAMETER, "")]);
    assert!(right(Matter::MissingPhysics, vec![gain.clone()], "miscalibrated"));
    let silent = diagnosis("miscalibrated", vec![]);
    assert_eq!(score(&truth(Matter::MissingPhysics, vec![gain]), &silent).named, 1);
}

#[test]
fn a_constant_beside_asymmetric_friction_is_no_false_finding() {
    let truth = truth(Matter::MissingPhysics, vec![effect("asymmetric_friction", "q", &[])]);
    let found = vec![finding("asymmetric_friction", "q"), finding("constant_force", "q")];
    assert_eq!(score(&truth, &diagnosis("missing_physics", found)).false_findings, 0);
}
