//! A delay of the sensor: `y(t) = x(t - delay)`.

use crate::law::{Acts, Effect, Law, Parameter, Range, Scales, SensorLaw, Variable};
use crate::{Dimension, Prior};

pub(crate) static EFFECT: Effect = Effect {
    class: "sensor_delay",
    words: "a delay of the sensor",
    formula: "y(t) = x(t - delay)",
    parameters: &[Parameter::new("delay", Dimension::TIME, Range::NonNegative)],
    depends_on: &[Variable::Coordinate],
    acts: Acts::Sensors,
    law: Law::Sensor(&SensorDelay),
};

#[derive(Debug)]
struct SensorDelay;

impl SensorLaw for SensorDelay {
    fn observe(&self, parameters: &[f64], times: &[f64], truth: &[f64]) -> Vec<f64> {
        times.iter().map(|t| interpolate(times, truth, t - parameters[0])).collect()
    }

    fn priors(&self, scales: &Scales) -> Vec<Prior> {
        vec![Prior::near(0.0, 8.0 * scales.step, (0.0, 40.0 * scales.step))]
    }
}

/// The series at `t` by straight lines, by its first slope before its beginning.
fn interpolate(times: &[f64], values: &[f64], t: f64) -> f64 {
    if times.len() < 2 {
        return values[0];
    }
    let k = times.partition_point(|&s| s <= t).clamp(1, times.len() - 1);
    let share = (t - times[k - 1]) / (times[k] - times[k - 1]);
    values[k - 1] + share * (values[k] - values[k - 1])
}
