//! A dead zone of the actuator: `u_effective = u - clamp(u, -half_width, half_width)`.

use crate::{
    Acts, Dimension, Effect, InServo, Law, Nature, Number, Parameter, Prior, Range, Scales,
    SeriesLaw, Variable,
};

pub(crate) static EFFECT: Effect = Effect {
    class: "dead_zone",
    words: "a dead zone of the actuator",
    formula: "u_effective = u - clamp(u, -half_width, half_width)",
    parameters: &[Parameter::new("half_width", Dimension::INPUT, Range::NonNegative)],
    depends_on: &[Variable::Input],
    acts: Acts::Inputs,
    law: Law::Input(&DeadZone),
    priors,
    shapes,
    nature: Nature { in_servo: Some(InServo::Error), ..Nature::PLAIN },
};

#[derive(Debug)]
struct DeadZone;

impl SeriesLaw for DeadZone {
    fn applied<T: Number>(&self, parameters: &[T], _times: &[f64], series: &[T]) -> Vec<T> {
        let w = parameters[0];
        series.iter().map(|u| *u - u.clamp(-w, w)).collect()
    }
}

fn priors(scales: &Scales) -> Vec<Prior> {
    let typical = scales.input.0;
    vec![Prior::near(0.0, 0.5 * typical, (0.0, 2.0 * typical))]
}

fn shapes(scales: &Scales) -> Vec<Vec<f64>> {
    [0.02, 0.05, 0.1, 0.2, 0.3, 0.45, 0.6].map(|share| vec![share * scales.input.0]).to_vec()
}
