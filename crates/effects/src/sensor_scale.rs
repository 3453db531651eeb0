//! A wrong scale of the sensor: `y = scale x`.

use crate::{
    Acts, Dimension, Effect, Law, Nature, Number, Parameter, Prior, Range, Scales, SeriesLaw,
    Variable, one_shape,
};

pub(crate) static EFFECT: Effect = Effect {
    class: "sensor_scale",
    words: "a wrong scale of the sensor",
    formula: "y = scale x",
    parameters: &[Parameter::new("scale", Dimension::NUMBER, Range::Any)],
    depends_on: &[Variable::Coordinate],
    acts: Acts::Sensors,
    law: Law::Sensor(&SensorScale),
    priors,
    shapes: one_shape,
    nature: Nature { ideal: &[1.0], absent: 1.0, ..Nature::PLAIN },
};

#[derive(Debug)]
struct SensorScale;

impl SeriesLaw for SensorScale {
    fn applied<T: Number>(&self, parameters: &[T], _times: &[f64], series: &[T]) -> Vec<T> {
        series.iter().map(|x| parameters[0] * *x).collect()
    }
}

fn priors(_scales: &Scales) -> Vec<Prior> {
    vec![Prior::near(1.0, 0.1, (0.5, 1.5))]
}
