//! A wrong actuator gain: `u_effective = gain u`.

use crate::Dimension;
use crate::law::{Acts, Effect, InputLaw, Law, Parameter, Range, Scales, Variable};

pub(crate) static EFFECT: Effect = Effect {
    class: "gain_error",
    words: "a wrong actuator gain",
    formula: "u_effective = gain u",
    parameters: &[Parameter::new("gain", Dimension::NUMBER, Range::Any)],
    depends_on: &[Variable::Input],
    acts: Acts::Inputs,
    law: Law::Input(&GainError),
};

#[derive(Debug)]
struct GainError;

impl InputLaw for GainError {
    fn transform(&self, parameters: &[f64], _times: &[f64], command: &[f64]) -> Vec<f64> {
        command.iter().map(|u| parameters[0] * u).collect()
    }

    fn shapes(&self, _scales: &Scales) -> Vec<Vec<f64>> {
        vec![vec![1.1]]
    }

    fn linear_about(&self) -> Option<f64> {
        Some(1.0)
    }
}
