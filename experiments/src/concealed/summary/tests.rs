//! Figures of a few rows.

use super::*;
use crate::concealed::sealed::{Group, Name};

fn row(matter: Matter, truth: &[&str], matches: Vec<Match>) -> Row {
    let named = matches.iter().filter(|m| m.right).count();
    let false_findings = matches.iter().filter(|m| m.truth.is_none()).count();
    Row {
        case: String::new(),
        plant: String::new(),
        group: Group::Catalogue,
        topic: String::new(),
        matter,
        truth: truth.iter().map(|c| Name::new(c, "q")).collect(),
        model_gap_over_noise: 5.0,
        verdict: Some("missing_physics".to_owned()),
        findings: vec![],
        formula: None,
        score: Score {
            verdict_right: true,
            effects: truth.len(),
            named,
            named_top2: named,
            channel: named,
            false_findings,
            matches,
        },
        f1: vec![0.5],
        deviations: vec![],
        before_over_noise: Some(10.0),
        after_over_noise: Some(1.1),
        seconds: 2.0,
        crash: None,
        peer: Score { effects: truth.len(), ..Score::default() },
        peer_failed: false,
    }
}

fn found(truth: Option<&str>, found: Option<&str>, right: bool, probability: f64) -> Match {
    let found = found.map(|c| Name::new(c, "q"));
    Match {
        truth: truth.map(str::to_owned),
        found,
        right,
        probability: Some(probability),
        support: None,
    }
}

fn rows() -> Vec<Row> {
    let right = found(Some("end_stop"), Some("end_stop"), true, 0.97);
    let wrong = found(Some("cogging"), Some("hysteresis"), false, 0.96);
    let invented = found(None, Some("cogging"), false, 1.0);
    vec![
        row(Matter::MissingPhysics, &["end_stop"], vec![right, invented.clone()]),
        row(Matter::MissingPhysics, &["cogging"], vec![wrong]),
        row(Matter::None, &[], vec![invented]),
        row(Matter::Parameter, &[], vec![]),
    ]
}

#[test]
fn counts_are_those_of_the_rows() {
    let rows = rows();
    let summary = Summary::of(&rows.iter().collect::<Vec<_>>());
    let names = &summary.names;
    assert_eq!((names.named.count, names.named.of, names.false_findings), (1, 2, 2));
    let null = names.null_with_findings;
    assert_eq!((null.count, null.of), (1, 2));
    assert_eq!((summary.exactly_right.count, summary.localisation_f1), (1, Some((0.5, 4))));
    assert_eq!((summary.after_within_1_2.count, summary.peer.named.of), (4, 2));
}

#[test]
fn the_confusion_matrix_holds_every_answer() {
    let matrix = confusion(&rows());
    assert_eq!(matrix["end_stop"]["end_stop"], 1);
    assert_eq!(matrix["cogging"]["hysteresis"], 1);
    assert_eq!(matrix[NOTHING]["cogging"], 2);
}
