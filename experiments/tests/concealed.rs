//! The proof on concealed physics: fair cases from a seed, and the study from end to end.

use experiments::cli::Common;
use experiments::concealed::case::{Case, Plan, plans};
use experiments::concealed::fair::LEAST_GAP;
use experiments::concealed::files::Folders;
use experiments::concealed::sealed::{Group, Matter};
use experiments::concealed::tool::Tool;
use experiments::concealed::{NAME, Results, Settings, run};
use lacuna_plants::Model;
use lacuna_recordings::RecordingSource;
use std::ffi::OsString;
use std::path::{Path, PathBuf};
use std::time::Duration;

const SEED: u64 = 5;

/// A few cases of every group.
fn some_plans() -> Vec<Plan> {
    let of = |(group, count)| plans(SEED, count, Some(group));
    let counts = [(Group::Catalogue, 6), (Group::OffFormula, 5), (Group::Local, 4)];
    counts.into_iter().chain([(Group::Null, 6)]).flat_map(of).collect()
}

/// The command under test where a build has put it.
fn lacuna() -> Option<PathBuf> {
    let test = std::env::current_exe().ok()?;
    let path = test.parent()?.parent()?.join(format!("lacuna{}", std::env::consts::EXE_SUFFIX));
    if !path.is_file() {
        println!("skipped: {} is not built", path.display());
        return None;
    }
    Some(path)
}

#[test]
fn a_seed_makes_the_same_case_again() {
    let draw = |seed| {
        let plan = &plans(seed, 8, None)[3];
        Case::draw(seed, plan).unwrap()
    };
    let (first, again, other) = (draw(SEED), draw(SEED), draw(SEED + 1));
    assert_eq!(first.sealed, again.sealed);
    assert_eq!(first.model, again.model);
    assert_eq!(first.recordings, again.recordings);
    assert_eq!(first.tests, again.tests);
    assert!(first.model != other.model || first.recordings != other.recordings);
}

#[test]
fn cases_are_fair_and_their_files_give_nothing_away() {
    let (open, sealed) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
    for plan in some_plans() {
        let case = Case::draw(SEED, &plan).unwrap();
        let truth = &case.sealed;
        assert_eq!(truth.group, plan.group);
        assert_eq!(truth.effects.is_empty(), plan.group == Group::Null, "{}", truth.topic);
        for effect in &truth.effects {
            assert!(effect.gap_over_noise >= LEAST_GAP, "{effect:?}");
        }
        match truth.matter {
            // The truth is integrated much more finely than the model.
            Matter::None => assert!(truth.model_gap_over_noise < 0.1, "{truth:?}"),
            _ => assert!(truth.model_gap_over_noise >= 0.5 * LEAST_GAP, "{truth:?}"),
        }
        let folders = Folders::of(open.path(), sealed.path(), &plan.id);
        folders.write(&case).unwrap();
        assert_eq!(folders.unseal().unwrap(), *truth);
        check_open_files(&folders, &case);
    }
}

/// The diagnosis gets a model without effects and recordings of its channels, and nothing else.
fn check_open_files(folders: &Folders, case: &Case) {
    let model = Model::read(&folders.open.join("model.toml")).unwrap();
    assert!(model.effects.is_empty());
    let names = Folders::recordings(case.recordings.len());
    for (name, drawn) in names.iter().zip(&case.recordings) {
        let source = RecordingSource::file(folders.open.join(name));
        let read = lacuna_recordings::read(&source, &model.time_column).unwrap();
        assert_eq!((&read.time, &read.columns), (&drawn.time, &drawn.columns));
    }
    let files = |folder: &Path| std::fs::read_dir(folder).unwrap().count();
    assert_eq!(files(&folders.open), 2);
    assert_eq!(files(&folders.open.join("recordings")), names.len());
}

#[test]
fn the_command_can_read_the_cases() {
    let Some(program) = lacuna() else { return };
    let tool = Tool::find(Some(&program), Duration::from_secs(60), 1).unwrap();
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
    let Some(program) = lacuna() else { return };
    let directory = tempfile::tempdir().unwrap();
    let settings = Settings {
        cases: 2,
        group: Some(Group::Null),
        jobs: 1,
        lacuna: Some(program),
        timeout: 300,
        keep: None,
    };
    let common = Common { seed: SEED, out: directory.path().to_path_buf(), quiet: true };
    run(&settings, &common).unwrap();
    let results = directory.path().join(NAME);
    let text = std::fs::read_to_string(results.join("statistics.json")).unwrap();
    let read: Results = serde_json::from_str(&text).unwrap();
    assert_eq!((read.cases, read.rows.len(), read.seed), (2, 2, SEED));
    assert!(read.command.contains("--group null"));
    for row in &read.rows {
        assert_eq!(row.crash, None);
        // The model of a null case is right but for its parameters, and so is the augmented one.
        assert!(row.before_over_noise.unwrap() > 0.8, "{row:?}");
        assert!(row.after_over_noise.unwrap() > 0.8, "{row:?}");
    }
    for figure in ["confusion", "reliability"] {
        assert!(results.join(format!("figures/{figure}.svg")).is_file());
    }
}

#[test]
fn a_command_that_is_not_there_is_named_with_the_remedy() {
    let missing = Path::new("no/such/lacuna");
    let said = Tool::find(Some(missing), Duration::from_secs(1), 1).unwrap_err().to_string();
    assert!(said.contains("no/such/lacuna") && said.contains("cargo build"), "{said}");
}
