//! Recordings that do not mean what the model reads: no physics is named for them, and how they are meant is.

use crate::machines::{Bench, ON_PENDULUM, ON_TWO_MASS, diagnosed};
use lacuna_discrepancy::diagnosis::{Diagnosis, Verdict};
use lacuna_recordings::Recording;

const FRICTION: &str = "[[effect]]\nclass = \"coulomb_friction\"\nchannel = \"q\"\n\
    magnitude = 0.05\nsmoothing_velocity = 0.02";
const DRAG: &str = "[[effect]]\nclass = \"quadratic_drag\"\nchannel = \"x2\"\ncoefficient = 1.5";

/// What is said of recordings of a bench with an effect after `mistake` was made in each.
fn mistaken(bench: &Bench, effect: &str, mistake: impl Fn(&mut Recording)) -> Diagnosis {
    let mut recordings = bench.record(&bench.truth(effect), 611, 3);
    recordings.iter_mut().for_each(mistake);
    diagnosed(&bench.model(), &recordings).diagnosis
}

fn times(recording: &mut Recording, column: &str, factor: f64) {
    let column = recording.columns.iter_mut().find(|c| c.name == column).expect("a column");
    column.values.iter_mut().for_each(|v| *v *= factor);
}

/// Nothing is named, nothing handed back, and the first of what the recordings may mean is this.
fn is_told(d: &Diagnosis, with: &str) {
    assert_eq!(d.verdict, Verdict::Unexplained, "{with}");
    assert!(d.findings.is_empty() && d.calibration.is_empty(), "{with}: {:?}", d.findings);
    let otherwise = d.otherwise.as_ref().unwrap_or_else(|| panic!("{with} is not told"));
    assert!(otherwise.with.iter().any(|w| w == with), "{with}: {otherwise:?}");
    assert!(
        otherwise.found_leaves.is_none_or(|found| found > 2.0 * otherwise.leaves),
        "{otherwise:?}"
    );
}

#[test]
fn a_sign_a_unit_or_a_clock_is_told_beside_what_is_missing() {
    let bench = ON_PENDULUM;
    let told = |mistake: &dyn Fn(&mut Recording), with| {
        is_told(&mistaken(&bench, FRICTION, mistake), with);
    };
    told(&|r| times(r, "tau", -1.0), "the sign of tau reversed");
    told(&|r| times(r, "tau", 1000.0), "tau in thousandths of N m");
    told(&|r| times(r, "q", 1f64.to_degrees()), "q in deg where rad is read");
    told(&|r| r.time.iter_mut().for_each(|t| *t *= 1000.0), "times in ms where s are read");
    let right = mistaken(&bench, FRICTION, |_| ());
    assert_eq!(right.otherwise, None);
    assert_eq!(right.findings[0].class, "coulomb_friction");
}

#[test]
fn two_columns_that_stand_in_the_place_of_each_other_are_told() {
    let exchanged = |r: &mut Recording| {
        for column in &mut r.columns {
            column.name = match column.name.as_str() {
                "x1" => "x2".into(),
                "x2" => "x1".into(),
                _ => column.name.clone(),
            };
        }
    };
    is_told(&mistaken(&ON_TWO_MASS, DRAG, exchanged), "x1 and x2 exchanged");
}
