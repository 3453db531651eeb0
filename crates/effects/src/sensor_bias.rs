//! An offset of the sensor: `y = x + bias`.

use crate::{
    Acts, Dimension, Effect, Law, Nature, Number, Parameter, Prior, Range, Scales, SeriesLaw,
    Variable, one_shape,
};

pub(crate) static EFFECT: Effect = Effect {
    class: "sensor_bias",
    words: "an offset of the sensor",
    formula: "y = x + bias",
    parameters: &[Parameter::new("bias", Dimension::COORDINATE, Range::Any)],
    depends_on: &[Variable::Coordinate],
    acts: Acts::Sensors,
    law: Law::Sensor(&SensorBias),
    priors,
    shapes: one_shape,
    nature: Nature::PLAIN,
};

#[derive(Debug)]
struct SensorBias;

impl SeriesLaw for SensorBias {
    fn applied<T: Number>(&self, parameters: &[T], _times: &[f64], series: &[T]) -> Vec<T> {
        series.iter().map(|x| *x + parameters[0]).collect()
    }
}

fn priors(scales: &Scales) -> Vec<Prior> {
    vec![Prior::amplitude(scales.half_range())]
}
