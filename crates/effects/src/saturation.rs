//! Saturation of the actuator: `u_effective = clamp(u, -limit, limit)`.

use crate::{
    Acts, Dimension, Effect, InServo, Law, Nature, Number, Parameter, Prior, Range, Scales,
    SeriesLaw, Variable,
};

pub(crate) static EFFECT: Effect = Effect {
    class: "saturation",
    words: "saturation of the actuator",
    formula: "u_effective = clamp(u, -limit, limit)",
    parameters: &[Parameter::new("limit", Dimension::INPUT, Range::Positive)],
    depends_on: &[Variable::Input],
    acts: Acts::Inputs,
    law: Law::Input(&Saturation),
    priors,
    shapes,
    nature: Nature { absent: f64::INFINITY, in_servo: Some(InServo::Force), ..Nature::PLAIN },
};

#[derive(Debug)]
struct Saturation;

impl SeriesLaw for Saturation {
    fn applied<T: Number>(&self, parameters: &[T], _times: &[f64], series: &[T]) -> Vec<T> {
        let limit = parameters[0];
        series.iter().map(|u| u.clamp(-limit, limit)).collect()
    }
}

fn priors(scales: &Scales) -> Vec<Prior> {
    let largest = scales.input.1;
    // One recording may command far more than the others, and more where the limit keeps it from its aim.
    vec![Prior::near(0.8 * largest, 0.25 * largest, (0.02 * largest, largest))]
}

fn shapes(scales: &Scales) -> Vec<Vec<f64>> {
    let few = [0.03, 0.05, 0.07, 0.1].into_iter();
    few.chain((3..19).map(|k| 0.05 * f64::from(k)))
        .map(|share| vec![share * scales.input.1])
        .collect()
}
