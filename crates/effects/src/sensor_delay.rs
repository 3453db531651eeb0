//! A delay of the sensor: `y(t) = x(t - delay)`.

use crate::{
    Acts, Dimension, Effect, Law, Nature, Number, Parameter, Prior, Range, Scales, SeriesLaw,
    Variable, one_shape,
};

pub(crate) static EFFECT: Effect = Effect {
    class: "sensor_delay",
    words: "a delay of the sensor",
    formula: "y(t) = x(t - delay)",
    parameters: &[Parameter::new("delay", Dimension::TIME, Range::NonNegative)],
    depends_on: &[Variable::Coordinate],
    acts: Acts::Sensors,
    law: Law::Sensor(&SensorDelay),
    priors,
    shapes: one_shape,
    nature: Nature::PLAIN,
};

#[derive(Debug)]
struct SensorDelay;

impl SeriesLaw for SensorDelay {
    fn applied<T: Number>(&self, parameters: &[T], times: &[f64], series: &[T]) -> Vec<T> {
        times.iter().map(|t| interpolate(times, series, -parameters[0] + *t)).collect()
    }
}

fn priors(scales: &Scales) -> Vec<Prior> {
    vec![Prior::near(0.0, 8.0 * scales.step, (0.0, 40.0 * scales.step))]
}

/// The series at `t` by straight lines, by its first slope before its beginning. At a sample the
/// line is that before it: a longer delay looks further back.
fn interpolate<T: Number>(times: &[f64], values: &[T], t: T) -> T {
    if times.len() < 2 {
        return values[0];
    }
    let k = times.partition_point(|&s| s < t.value()).clamp(1, times.len() - 1);
    let share = (t - times[k]) / (times[k] - times[k - 1]);
    values[k] + share * (values[k] - values[k - 1])
}
