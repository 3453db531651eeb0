//! A wrong scale of the sensor: `y = scale x`.

use crate::law::{Acts, Effect, Law, Parameter, Range, Scales, SensorLaw, Variable};
use crate::{Dimension, Prior};

pub(crate) static EFFECT: Effect = Effect {
    class: "sensor_scale",
    words: "a wrong scale of the sensor",
    formula: "y = scale x",
    parameters: &[Parameter::new("scale", Dimension::NUMBER, Range::Any)],
    depends_on: &[Variable::Coordinate],
    acts: Acts::Sensors,
    law: Law::Sensor(&SensorScale),
};

#[derive(Debug)]
struct SensorScale;

impl SensorLaw for SensorScale {
    fn observe(&self, parameters: &[f64], _times: &[f64], truth: &[f64]) -> Vec<f64> {
        truth.iter().map(|x| parameters[0] * x).collect()
    }

    fn priors(&self, _scales: &Scales) -> Vec<Prior> {
        vec![Prior::near(1.0, 0.1, (0.5, 1.5))]
    }

    fn ideal(&self) -> Vec<f64> {
        vec![1.0]
    }
}
