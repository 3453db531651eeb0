//! Small truths against small diagnoses.

use super::*;
use crate::concealed::score::tests::{diagnosis, effect, finding, truth};
use crate::concealed::sealed::Matter;
use lacuna_discrepancy::diagnosis::Calibration;
use serde_json::json;

fn number(value: f64, std: f64) -> Estimate {
    Estimate { value, std, unit: String::new(), at_bound: false }
}

fn calibrated(nominal: f64, value: f64, std: f64) -> Calibration {
    Calibration { nominal, value, std, unit: String::new(), at_bound: false }
}

fn cogging(phase: f64) -> Finding {
    let numbers = [("phase", number(phase, 0.1)), ("amplitude", number(2.5, 0.2))];
    let parameters = numbers.map(|(name, n)| (name.to_owned(), n)).into();
    Finding { parameters, ..finding("cogging", "q") }
}

fn of(deviations: &[Deviation], class: Option<&str>, name: &str) -> f64 {
    let own = |d: &&Deviation| d.class.as_deref() == class && d.of == name;
    deviations.iter().find(own).map(|d| d.deviation).unwrap()
}

fn case() -> (Sealed, Diagnosis) {
    let parameters = json!({"phase": 0.1, "amplitude": 2.0});
    let concealed = SealedEffect { parameters, ..effect("cogging", "q", &[]) };
    let mut sealed = truth(Matter::MissingPhysics, vec![concealed]);
    sealed.miscalibrated.insert("m".to_owned(), 1.1);
    let mut found = diagnosis("missing_physics", vec![cogging(TAU - 0.1)]);
    let (mass, spring) = (calibrated(2.0, 2.3, 0.05), calibrated(5.0, 4.9, 0.1));
    // Robots' parameters have points in their names.
    found.calibration = [("m".to_owned(), mass), ("link.k".to_owned(), spring)].into();
    (sealed, found)
}

#[test]
fn numbers_are_told_in_their_standard_deviations() {
    let (sealed, found) = case();
    let all = deviations(&sealed, &found);
    assert_eq!(all.len(), 4);
    let cogging = Some("cogging");
    let of_finding = [(cogging, "phase", -2.0), (cogging, "amplitude", 2.5)];
    let of_model = [(None, "m", 2.0), (None, "link.k", -1.0)];
    for (class, name, deviation) in of_finding.into_iter().chain(of_model) {
        let told = of(&all, class, name);
        assert!((told - deviation).abs() < 1e-9, "{name}: {told}");
    }
}

#[test]
fn beside_a_wrong_or_a_further_law_no_number_has_a_true_value() {
    let (sealed, found) = case();
    let further =
        Diagnosis { findings: vec![cogging(0.0), finding("end_stop", "q")], ..found.clone() };
    assert_eq!(deviations(&sealed, &further), []);
    let other = Finding { channel: "r".to_owned(), ..cogging(0.0) };
    assert_eq!(deviations(&sealed, &Diagnosis { findings: vec![other], ..found.clone() }), []);
    let mut beyond = sealed.clone();
    beyond.effects[0].catalogue = false;
    assert_eq!(deviations(&beyond, &found), []);
}

#[test]
fn what_sits_on_its_bound_or_is_given_has_no_standard_deviation() {
    let (sealed, mut found) = case();
    found.calibration.get_mut("m").unwrap().at_bound = true;
    found.calibration.get_mut("link.k").unwrap().std = 0.0;
    let all = deviations(&sealed, &found);
    assert!(all.len() == 2 && all.iter().all(|d| d.class.as_deref() == Some("cogging")));
}
