//! A delay of the actuator: `u_effective(t) = u(t - delay)`.

use crate::held::delayed;
use crate::{
    Acts, Dimension, Effect, Law, Nature, Number, Parameter, Prior, Range, Scales, SeriesLaw,
    Variable,
};

pub(crate) static EFFECT: Effect = Effect {
    class: "input_delay",
    words: "a delay of the actuator",
    formula: "u_effective(t) = u(t - delay)",
    parameters: &[Parameter::new("delay", Dimension::TIME, Range::NonNegative)],
    depends_on: &[Variable::Input],
    acts: Acts::Inputs,
    law: Law::Input(&InputDelay),
    priors,
    shapes,
    nature: Nature::PLAIN,
};

#[derive(Debug)]
struct InputDelay;

impl SeriesLaw for InputDelay {
    fn applied<T: Number>(&self, parameters: &[T], times: &[f64], series: &[T]) -> Vec<T> {
        delayed(times, series, parameters[0])
    }
}

fn priors(scales: &Scales) -> Vec<Prior> {
    vec![Prior::near(0.0, 8.0 * scales.step, (0.0, 40.0 * scales.step))]
}

fn shapes(scales: &Scales) -> Vec<Vec<f64>> {
    [0.5, 1.0, 2.0, 3.0, 4.0, 6.0, 8.0, 10.0, 13.0, 17.0].map(|k| vec![k * scales.step]).to_vec()
}
