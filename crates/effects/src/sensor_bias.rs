//! An offset of the sensor: `y = x + bias`.

use crate::law::{Acts, Effect, Law, Parameter, Range, Scales, SensorLaw, Variable};
use crate::{Dimension, Prior};

pub(crate) static EFFECT: Effect = Effect {
    class: "sensor_bias",
    words: "an offset of the sensor",
    formula: "y = x + bias",
    parameters: &[Parameter::new("bias", Dimension::COORDINATE, Range::Any)],
    depends_on: &[Variable::Coordinate],
    acts: Acts::Sensors,
    law: Law::Sensor(&SensorBias),
};

#[derive(Debug)]
struct SensorBias;

impl SensorLaw for SensorBias {
    fn observe(&self, parameters: &[f64], _times: &[f64], truth: &[f64]) -> Vec<f64> {
        truth.iter().map(|x| x + parameters[0]).collect()
    }

    fn priors(&self, scales: &Scales) -> Vec<Prior> {
        vec![Prior::amplitude(scales.half_range())]
    }
}
