//! The proof on concealed physics with the command: the study from end to end, and the product's
//! own rates held against those committed.

use experiments::cli::Common;
use experiments::concealed::case::{Case, plans};
use experiments::concealed::files::Folders;
use experiments::concealed::regression::{FEW, Few, Rates, rates};
use experiments::concealed::sealed::Group;
use experiments::concealed::tool::Tool;
use experiments::concealed::{NAME, Results, Settings, run};
use std::ffi::OsString;
use std::path::{Path, PathBuf};
use std::time::Duration;

const SEED: u64 = 5;

fn lacuna() -> PathBuf {
    PathBuf::from(env!("CARGO_BIN_EXE_lacuna"))
}

#[test]
fn the_command_can_read_the_cases() {
    let tool = Tool::find(Some(&lacuna()), Duration::from_secs(60), 1).unwrap();
    let (open, sealed) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
    for plan in plans(SEED, 3, None) {
        let case = Case::draw(SEED, &plan).unwrap();
        let folders = Folders::of(open.path(), sealed.path(), &plan.id);
        folders.write(&case).unwrap();
        let mut arguments: Vec<OsString> = vec!["check".into(), "model.toml".into()];
        let names = Folders::recordings(case.recordings.len());
        arguments.extend(names.into_iter().map(OsString::from));
        let answer = tool.run(&folders.open, &arguments).unwrap();
        assert_eq!(answer.code, Some(0), "{}", answer.complaint);
    }
}

#[test]
fn two_cases_from_end_to_end() {
    let directory = tempfile::tempdir().unwrap();
    let settings = Settings {
        cases: 1,
        seeds: vec![SEED, SEED + 1],
        group: Some(Group::Null),
        jobs: 1,
        lacuna: Some(lacuna()),
        timeout: 300,
        keep: None,
    };
    let common = Common { seed: SEED, out: directory.path().to_path_buf(), quiet: true };
    run(&settings, &common).unwrap();
    let results = directory.path().join(NAME);
    let text = std::fs::read_to_string(results.join("statistics.json")).unwrap();
    let read: Results = serde_json::from_str(&text).unwrap();
    assert_eq!((read.cases, read.rows.len(), &read.seeds), (2, 2, &settings.seeds));
    assert!(read.command.contains("--group null"));
    for row in &read.rows {
        assert_eq!(row.crash, None);
        // Nothing is missing: nothing is found, and the error stays at the noise. A model that is
        // wrong in parameters alone is calibrated down to it.
        assert!(row.findings.is_empty() && row.score.verdict_right, "{row:?}");
        let (before, after) = (row.before_over_noise.unwrap(), row.after_over_noise.unwrap());
        assert!(before > 0.8 && (0.8..1.2).contains(&after), "{row:?}");
        assert!(after < 1.05 * before, "{row:?}");
    }
    for figure in ["confusion", "reliability"] {
        assert!(results.join(format!("figures/{figure}.svg")).is_file());
    }
}

/// Names, false findings, verdicts and errors over the noise of a few cases, against the committed ones.
fn are_no_worse_than_those_committed(few: &Few) {
    let path = Path::new(env!("CARGO_MANIFEST_DIR"));
    let path = path.join(format!("../../results/{NAME}/{}.json", few.file));
    let committed: Rates = serde_json::from_str(&std::fs::read_to_string(path).unwrap()).unwrap();
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    let found = rates(few, Some(lacuna()), cores, true).unwrap();
    assert_eq!(
        (found.seed, found.cases, found.effects, found.null_cases),
        (committed.seed, committed.cases, committed.effects, committed.null_cases),
        "other cases than those of the committed rates: make them again by `{}`",
        committed.command
    );
    let worse = found.worse_than(&committed);
    assert!(worse.is_empty(), "{}\n{found:?}", worse.join("\n"));
}

#[test]
fn the_rates_of_machines_are_no_worse() {
    are_no_worse_than_those_committed(&FEW[0]);
}

#[test]
fn the_rates_of_robots_are_no_worse() {
    are_no_worse_than_those_committed(&FEW[1]);
}
