//! What is found where the search begins afresh: parameters and a constant force hide it from where it began.

use crate::machines::{ON_SERVO, diagnosed};
use lacuna_discrepancy::diagnosis::Verdict;
use lacuna_plants::Model;

const DROOP: f64 = 0.3;
const FRICTION: f64 = 0.1;

/// The parameters swallow the friction as far as they can, and what is left looks like an offset of the sensor.
#[test]
fn a_servo_that_droops_and_sticks() {
    let text = ON_SERVO.text.replace("17.8", "10").replace("value = 0.6", "value = 0.9");
    let truth = format!(
        "{text}\n[[effect]]\nclass = \"constant_force\"\nchannel = \"q\"\nforce = {DROOP}\n\
         [[effect]]\nclass = \"coulomb_friction\"\nchannel = \"q\"\nmagnitude = {FRICTION}\n\
         smoothing_velocity = 0.002"
    );
    let truth = Model::from_text(&truth, "truth.toml").expect("the truth is right");
    let bench = ON_SERVO;
    let d = diagnosed(&bench.model(), &bench.record(&truth, 401, 4)).diagnosis;
    assert_eq!(d.verdict, Verdict::MissingPhysics, "{:?}", d.notes);
    let of = |class: &str| d.findings.iter().find(|f| f.class == class);
    let (Some(droop), Some(friction)) = (of("constant_force"), of("coulomb_friction")) else {
        panic!("{:?}", d.findings.iter().map(|f| &f.says).collect::<Vec<_>>())
    };
    assert_eq!(d.findings.len(), 2);
    // All forces of a servo that logs no torque may be so many times as large, and its inertia with them.
    let (force, magnitude) = (&droop.parameters["force"], &friction.parameters["magnitude"]);
    let ratio = force.value / magnitude.value;
    assert!((ratio / (DROOP / FRICTION) - 1.0).abs() < 0.05, "{} {}", droop.says, friction.says);
    // Friction that turns within a step of the search goes astray there: what is known of it is asked in finer ones.
    let std = magnitude.std;
    assert!(std > 1e-3 * magnitude.value && std < magnitude.value, "{}", friction.says);
    let fit = &d.fit.held_out["q"];
    assert!(fit.rmse_after < 1.2 * fit.noise, "{} over {}", fit.rmse_after, fit.noise);
}
