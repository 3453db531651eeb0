//! A wrong scale of the sensor: `y = scale x`.

use crate::Dimension;
use crate::law::{Acts, Effect, Law, Parameter, Range, SensorLaw, Variable};

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
}
