//! The example of a model that is a closure, beside the same model as text.

#[path = "../crates/lacuna/examples/closure.rs"]
mod closure;

use closure::{FRICTION, believed, diagnosed, recordings};
use lacuna::discrepancy::diagnose::Outcome;
use lacuna::discrepancy::diagnosis::{Finding, Verdict};
use lacuna::plants::Model;

const TEXT: &str = r#"
name = "arm"
[parameters]
J = { value = 0.05, unit = "kg m^2", tolerance = 0.1 }
b = { value = 0.03, unit = "N m s/rad", tolerance = 0.1 }
k = { value = 0.4, unit = "N m", tolerance = 0.1 }
[[input]]
name = "tau"
unit = "N m"
[[coordinate]]
name = "theta"
velocity = "omega"
unit = "rad"
[mechanics]
mass = [["J"]]
force = ["tau - b*omega - k*sin(theta)"]
"#;

fn only_finding(outcome: &Outcome) -> &Finding {
    let diagnosis = &outcome.diagnosis;
    assert_eq!(diagnosis.verdict, Verdict::MissingPhysics);
    assert_eq!(diagnosis.findings.len(), 1, "{:?}", diagnosis.findings);
    let finding = &diagnosis.findings[0];
    assert_eq!((&*finding.class, &*finding.channel), ("coulomb_friction", "theta"));
    let magnitude = &finding.parameters["magnitude"];
    assert_eq!(magnitude.unit, "N m");
    let off = (magnitude.value - FRICTION).abs();
    assert!(magnitude.std > 0.0 && off < 3.0 * magnitude.std, "{magnitude:?}");
    let fit = &diagnosis.fit.held_out["theta"];
    assert!(fit.rmse_after < 1.2 * fit.noise && fit.rmse_before > 2.0 * fit.noise, "{fit:?}");
    finding
}

#[test]
fn a_closure_and_the_same_text_have_the_same_diagnosis() {
    let recordings = recordings().unwrap();
    let by_closure = diagnosed(&believed().unwrap(), &recordings).unwrap();
    let text = Model::from_text(TEXT, "arm.toml").unwrap();
    let by_text = diagnosed(&text, &recordings).unwrap();
    let (a, b) = (only_finding(&by_closure), only_finding(&by_text));
    assert_eq!(a.depends_on, b.depends_on);
    for (name, found) in &a.parameters {
        let same = &b.parameters[name];
        assert_eq!(found.unit, same.unit);
        assert!((found.value - same.value).abs() < 0.01 * same.std, "{name}: {found:?} {same:?}");
    }
    let names = |o: &Outcome| o.diagnosis.calibration.keys().cloned().collect::<Vec<_>>();
    assert_eq!(names(&by_closure), ["J", "b", "k"]);
    assert_eq!(names(&by_closure), names(&by_text));
    // Only the closure's derivatives are differences, and it says so.
    let told = |o: &Outcome| o.diagnosis.notes.iter().any(|n| n.contains("differences"));
    assert!(told(&by_closure) && !told(&by_text));
}

#[test]
fn the_example_runs() {
    closure::main().unwrap();
}
