//! What says nothing of a machine changes nothing of its diagnosis: the study from end to end on one drawn case.

use experiments::cli::Common;
use experiments::invariance::{NAME, Results, Settings, TRANSFORMATIONS, run};
use std::path::PathBuf;

const SEED: u64 = 2;

fn settings(only: &[&str]) -> Settings {
    Settings {
        cases: 1,
        only: only.iter().map(|&name| name.to_owned()).collect(),
        timeout: 300,
        keep: None,
        lacuna: Some(PathBuf::from(env!("CARGO_BIN_EXE_lacuna"))),
    }
}

#[test]
fn a_case_that_is_told_otherwise_is_diagnosed_alike() {
    let directory = tempfile::tempdir().unwrap();
    let common = Common { seed: SEED, out: directory.path().to_path_buf(), quiet: true };
    let exact = ["order", "names", "twice", "split", "threads"];
    let close = ["units", "mirrored", "scaled up", "times"];
    run(&settings(&exact), &common).unwrap();
    let read = || -> Results {
        let text = std::fs::read_to_string(directory.path().join(format!("{NAME}.json"))).unwrap();
        serde_json::from_str(&text).unwrap()
    };
    let first = read();
    assert_eq!(first.rows.len(), 1 + exact.len());
    // A rerun goes on from what is there.
    run(&settings(&close), &common).unwrap();
    let all = read();
    assert_eq!(all.rows[..first.rows.len()], first.rows);
    assert_eq!(all.rows.len(), 1 + exact.len() + close.len());
    assert_eq!(all.counts.len(), exact.len() + close.len());
    let plain = all.rows[0].answer.as_ref().expect("a diagnosis");
    assert!(!plain.findings.is_empty(), "{plain}");
    for row in &all.rows[1..] {
        assert!(TRANSFORMATIONS.iter().any(|t| t.name() == row.transformation), "{row:?}");
    }
    assert!(all.defects().is_empty(), "{:#?}", all.defects());
}
