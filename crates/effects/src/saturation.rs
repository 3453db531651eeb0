//! Saturation of the actuator: `u_effective = clamp(u, -limit, limit)`.

use crate::law::{Acts, Effect, InputLaw, Law, Parameter, Range, Scales, Variable};
use crate::{Dimension, Prior};

pub(crate) static EFFECT: Effect = Effect {
    class: "saturation",
    words: "saturation of the actuator",
    formula: "u_effective = clamp(u, -limit, limit)",
    parameters: &[Parameter::new("limit", Dimension::INPUT, Range::Positive)],
    depends_on: &[Variable::Input],
    acts: Acts::Inputs,
    law: Law::Input(&Saturation),
};

#[derive(Debug)]
struct Saturation;

impl InputLaw for Saturation {
    fn transform(&self, parameters: &[f64], _times: &[f64], command: &[f64]) -> Vec<f64> {
        let limit = parameters[0];
        command.iter().map(|u| u.clamp(-limit, limit)).collect()
    }

    fn shapes(&self, scales: &Scales) -> Vec<Vec<f64>> {
        (3..19).map(|k| vec![0.05 * f64::from(k) * scales.input.1]).collect()
    }

    fn priors(&self, scales: &Scales) -> Vec<Prior> {
        let largest = scales.input.1;
        vec![Prior::near(0.8 * largest, 0.25 * largest, (0.15 * largest, largest))]
    }
}
