//! A dead zone of the sensor: `y = x - clamp(x, -half_width, half_width)`.

use crate::{
    Acts, Dimension, Effect, Law, Nature, Number, Parameter, Prior, Range, Scales, SeriesLaw,
    Variable, one_shape,
};

pub(crate) static EFFECT: Effect = Effect {
    class: "sensor_dead_zone",
    words: "a dead zone of the sensor",
    formula: "y = x - clamp(x, -half_width, half_width)",
    parameters: &[Parameter::new("half_width", Dimension::COORDINATE, Range::NonNegative)],
    depends_on: &[Variable::Coordinate],
    acts: Acts::Sensors,
    law: Law::Sensor(&SensorDeadZone),
    priors,
    shapes: one_shape,
    nature: Nature::PLAIN,
};

#[derive(Debug)]
struct SensorDeadZone;

impl SeriesLaw for SensorDeadZone {
    fn applied<T: Number>(&self, parameters: &[T], _times: &[f64], series: &[T]) -> Vec<T> {
        let w = parameters[0];
        series.iter().map(|x| *x - x.clamp(-w, w)).collect()
    }
}

fn priors(scales: &Scales) -> Vec<Prior> {
    let reach = scales.half_range();
    vec![Prior::near(0.0, 0.2 * reach, (0.0, reach))]
}
