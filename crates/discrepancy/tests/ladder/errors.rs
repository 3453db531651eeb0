//! What cannot be diagnosed is refused in words.

use crate::driven::two_apart;
use crate::machines::{ON_PENDULUM, ON_TWO_MASS};
use lacuna_discrepancy::diagnose::{Options, diagnose, split};
use lacuna_discrepancy::{Dataset, DiagnoseError, Watch};
use lacuna_recordings::Recording;

fn recordings() -> Vec<Recording> {
    ON_TWO_MASS.record(&ON_TWO_MASS.model(), 1, 2)
}

fn without(column: &str) -> Vec<Recording> {
    let mut all = recordings();
    all.iter_mut().for_each(|r| r.columns.retain(|c| c.name != column));
    all
}

#[test]
fn a_coordinate_that_nothing_tells_of_is_named() {
    let model = two_apart();
    let dataset = Dataset::new(&model, &without("x2")).expect("simulation needs no x2");
    let (training, held_out) = split(&dataset);
    let error = diagnose(&model, &training, &held_out, Options::default(), &Watch::default())
        .err()
        .expect("nothing tells where x2 is");
    assert!(matches!(&error, DiagnoseError::Unmeasured { channel } if channel == "x2"), "{error}");
    assert!(error.to_string().contains("'x2'"), "{error}");
}

#[test]
fn a_missing_input_column_is_named_with_the_columns_there_are() {
    let error = Dataset::new(&ON_TWO_MASS.model(), &without("u")).expect_err("no input");
    let said = error.to_string();
    assert!(said.contains("'u'") && said.contains("x1, x2"), "{said}");
}

#[test]
fn recordings_of_something_else_are_refused() {
    let mut all = recordings();
    for r in &mut all {
        for c in r.columns.iter_mut().filter(|c| c.name != "u") {
            c.name.push_str("_raw");
        }
    }
    let error = Dataset::new(&ON_TWO_MASS.model(), &all).expect_err("nothing measured");
    assert!(matches!(error, DiagnoseError::NothingMeasured { .. }), "{error}");
    assert!(error.to_string().contains("(did you mean 'x1' by 'x1_raw'?)"), "{error}");
}

#[test]
fn too_few_samples_are_counted() {
    let mut all = ON_PENDULUM.record(&ON_PENDULUM.model(), 1, 1);
    all[0].time.truncate(60);
    all[0].columns.iter_mut().for_each(|c| c.values.truncate(60));
    let error = Dataset::new(&ON_PENDULUM.model(), &all).expect_err("too short");
    assert!(matches!(error, DiagnoseError::TooShort { found: 60, .. }), "{error}");
    assert!(error.to_string().contains(": 60 samples are too few"), "{error}");
    all[0].time.truncate(1);
    all[0].columns.iter_mut().for_each(|c| c.values.truncate(1));
    let error = Dataset::new(&ON_PENDULUM.model(), &all).expect_err("too short");
    assert!(error.to_string().contains(": 1 sample is too few"), "{error}");
}

#[test]
fn held_out_recordings_must_measure_the_same() {
    let model = ON_TWO_MASS.model();
    let all = Dataset::new(&model, &recordings()).expect("readable");
    let held_out = Dataset::new(&model, &without("x2")).expect("readable");
    let error = all.for_proof(held_out).expect_err("x2 is not held out");
    let said = error.to_string();
    assert!(matches!(error, DiagnoseError::OtherOutputs { .. }), "{said}");
    assert!(said.contains("measure x1, the others x1, x2"), "{said}");
}

#[test]
fn no_recording_is_an_error() {
    let error = Dataset::new(&ON_PENDULUM.model(), &[]).expect_err("none given");
    assert!(matches!(error, DiagnoseError::NoRecordings), "{error}");
}

#[test]
fn a_stuck_sensor_is_refused_by_name() {
    let mut all = recordings();
    for r in &mut all {
        r.columns.iter_mut().filter(|c| c.name == "x2").for_each(|c| c.values.fill(0.37));
    }
    let model = ON_TWO_MASS.model();
    let (training, held_out) = split(&Dataset::new(&model, &all).expect("readable"));
    let error = diagnose(&model, &training, &held_out, Options::default(), &Watch::default())
        .err()
        .expect("x2 is stuck");
    assert!(matches!(&error, DiagnoseError::Constant { channel } if channel == "x2"), "{error}");
}

/// One wild time stamp must not make the tool fill in rows up to it.
#[test]
fn a_leap_of_time_is_refused_with_its_place() {
    let mut all = ON_PENDULUM.record(&ON_PENDULUM.model(), 1, 1);
    let last = all[0].time.len() - 1;
    all[0].time[last] = 1e12;
    let error = Dataset::new(&ON_PENDULUM.model(), &all).expect_err("a leap");
    let expected = last - 1;
    assert!(
        matches!(error, DiagnoseError::Leap { after_row, .. } if after_row == expected),
        "{error}"
    );
}

#[test]
fn units_that_do_not_fit_name_the_column() {
    let text =
        format!("{}\n[[measurement]]\ncolumn = \"q\"\nof = \"q\"\nunit = \"kg\"", ON_PENDULUM.text);
    let model = lacuna_plants::Model::from_text(&text, "model.toml").expect("a model");
    let all = ON_PENDULUM.record(&ON_PENDULUM.model(), 1, 1);
    let error = Dataset::new(&model, &all).expect_err("a mass is no angle");
    assert!(matches!(&error, DiagnoseError::Unit { column, .. } if column == "q"), "{error}");
}

/// Degrees in the file, radians in the model: the same dataset.
#[test]
fn units_of_columns_are_converted() {
    let text = format!(
        "{}\n[[measurement]]\ncolumn = \"angle\"\nof = \"q\"\nunit = \"deg\"",
        ON_PENDULUM.text
    );
    let model = lacuna_plants::Model::from_text(&text, "model.toml").expect("a model");
    let radians = ON_PENDULUM.record(&ON_PENDULUM.model(), 1, 1);
    let mut degrees = radians.clone();
    let q = degrees[0].columns.iter_mut().find(|c| c.name == "q").expect("q is there");
    q.name = "angle".to_owned();
    q.values.iter_mut().for_each(|v| *v = v.to_degrees());
    let (a, b) = (
        Dataset::new(&ON_PENDULUM.model(), &radians).expect("a dataset"),
        Dataset::new(&model, &degrees).expect("a dataset"),
    );
    for (x, y) in a.recordings[0].outputs[0].iter().zip(&b.recordings[0].outputs[0]) {
        assert!((x - y).abs() < 1e-12);
    }
    assert!((a.noise[0].sd / b.noise[0].sd - 1.0).abs() < 1e-9);
}
