//! The cases of the proof on concealed physics: fair, and from a seed. The study from end to end, with
//! the command, is in `tests/concealed_physics.rs` beside the command's other tests.

use experiments::concealed::case::{Case, Plan, plans};
use experiments::concealed::fair::LEAST_GAP;
use experiments::concealed::files::Folders;
use experiments::concealed::sealed::{Group, Matter};
use experiments::concealed::tool::Tool;
use lacuna_plants::Model;
use lacuna_recordings::RecordingSource;
use std::path::Path;
use std::time::Duration;

const SEED: u64 = 5;

/// A few cases of every group.
fn some_plans() -> Vec<Plan> {
    let of = |(group, count)| plans(SEED, count, Some(group));
    let counts = [(Group::Catalogue, 6), (Group::OffFormula, 5), (Group::Local, 4)];
    counts.into_iter().chain([(Group::Null, 6)]).flat_map(of).collect()
}

#[test]
fn a_seed_makes_the_same_case_again() {
    let draw = |seed| {
        let plan = &plans(seed, 8, None)[3];
        Case::draw(seed, plan).unwrap()
    };
    let (first, again, other) = (draw(SEED), draw(SEED), draw(SEED + 1));
    assert_eq!(first.sealed, again.sealed);
    assert_eq!(first.files, again.files);
    assert_eq!(first.recordings, again.recordings);
    assert_eq!(first.tests, again.tests);
    assert!(first.files != other.files || first.recordings != other.recordings);
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
fn a_command_that_is_not_there_is_named_with_the_remedy() {
    let missing = Path::new("no/such/lacuna");
    let said = Tool::find(Some(missing), Duration::from_secs(1), 1).unwrap_err().to_string();
    assert!(said.contains("no/such/lacuna") && said.contains("cargo build"), "{said}");
}
