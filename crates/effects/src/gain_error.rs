//! A wrong actuator gain: `u_effective = gain u`.

use crate::law::{Acts, Effect, InputLaw, Law, Parameter, Range, Scales, Variable};
use crate::{Dimension, Prior};

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

    /// From half to twice; what lies between is refined.
    fn shapes(&self, _scales: &Scales) -> Vec<Vec<f64>> {
        [0.5, 0.6, 0.7, 0.8, 0.9, 1.1, 1.2, 1.35, 1.6, 2.0].map(|gain| vec![gain]).to_vec()
    }

    fn priors(&self, _scales: &Scales) -> Vec<Prior> {
        vec![Prior::near(1.0, 0.3, (0.2, 3.0))]
    }

    fn ideal(&self) -> Vec<f64> {
        vec![1.0]
    }
}
