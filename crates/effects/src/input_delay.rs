//! A delay of the actuator: `u_effective(t) = u(t - delay)`.

use crate::law::{Acts, Effect, InputLaw, Law, Parameter, Range, Scales, Variable, delayed};
use crate::{Dimension, Prior};

pub(crate) static EFFECT: Effect = Effect {
    class: "input_delay",
    words: "a delay of the actuator",
    formula: "u_effective(t) = u(t - delay)",
    parameters: &[Parameter::new("delay", Dimension::TIME, Range::NonNegative)],
    depends_on: &[Variable::Input],
    acts: Acts::Inputs,
    law: Law::Input(&InputDelay),
};

#[derive(Debug)]
struct InputDelay;

impl InputLaw for InputDelay {
    fn transform(&self, parameters: &[f64], times: &[f64], command: &[f64]) -> Vec<f64> {
        delayed(times, command, parameters[0])
    }

    fn shapes(&self, scales: &Scales) -> Vec<Vec<f64>> {
        [0.5, 1.0, 2.0, 3.0, 4.0, 6.0, 8.0, 10.0, 13.0, 17.0]
            .map(|k| vec![k * scales.step])
            .to_vec()
    }

    fn priors(&self, scales: &Scales) -> Vec<Prior> {
        vec![Prior::near(0.0, 8.0 * scales.step, (0.0, 40.0 * scales.step))]
    }
}
