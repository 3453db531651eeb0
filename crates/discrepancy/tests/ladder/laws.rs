//! Laws that stand beside simpler ones: each is named where it acts, with its size.

use crate::findings::{conceal, names};
use crate::machines::ON_PENDULUM;

/// An entry of a model file.
fn effect(class: &str, channel: &str, numbers: &str) -> String {
    format!("[[effect]]\nclass = \"{class}\"\nchannel = \"{channel}\"\n{numbers}")
}

#[test]
fn a_damper_whose_loop_stiffens() {
    let truth = effect("hysteresis", "q", "stiffness = 0.3\nbeta = 2\ngamma = -2.6");
    let d = conceal(ON_PENDULUM, 305, &truth);
    names(&d, "hysteresis", "q", &[("stiffness", 0.3), ("beta", 2.0), ("gamma", -2.6)]);
}
