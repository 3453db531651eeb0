//! A wrong actuator gain: `u_effective = gain u`.

use crate::{
    Acts, Dimension, Effect, Law, Nature, Number, Parameter, Prior, Quantity, Range, Scales,
    SeriesLaw, Stated, Variable,
};

pub(crate) static EFFECT: Effect = Effect {
    class: "gain_error",
    words: "a wrong actuator gain",
    formula: "u_effective = gain u",
    parameters: &[Parameter::new("gain", Dimension::NUMBER, Range::Any)],
    depends_on: &[Variable::Input],
    acts: Acts::Inputs,
    law: Law::Input(&GainError),
    priors,
    shapes,
    nature: Nature { absent: 1.0, stated: Some(Stated::all(Quantity::Gain)), ..Nature::PLAIN },
};

#[derive(Debug)]
struct GainError;

impl SeriesLaw for GainError {
    fn applied<T: Number>(&self, parameters: &[T], _times: &[f64], series: &[T]) -> Vec<T> {
        series.iter().map(|u| parameters[0] * *u).collect()
    }
}

fn priors(_scales: &Scales) -> Vec<Prior> {
    vec![Prior::near(1.0, 0.3, (0.2, 3.0))]
}

/// From half to twice; what lies between is refined.
fn shapes(_scales: &Scales) -> Vec<Vec<f64>> {
    [0.5, 0.6, 0.7, 0.8, 0.9, 1.1, 1.2, 1.35, 1.6, 2.0].map(|gain| vec![gain]).to_vec()
}
