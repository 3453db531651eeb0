//! A lag of the actuator: `time_constant u_effective' = u - u_effective`.
//!
//! Where a recording begins, the actuator has reached the share `settled` of the first command:
//! all of it (1) if that was held long before, nothing (0) if the machine was just switched on.

use crate::{
    Acts, Dimension, Effect, Law, Nature, Number, Parameter, Prior, Range, Scales, SeriesLaw,
    Variable,
};

pub(crate) static EFFECT: Effect = Effect {
    class: "actuator_lag",
    words: "a lag of the actuator",
    formula: "time_constant u_effective' = u - u_effective, u_effective(0) = settled u(0)",
    parameters: &[
        Parameter::new("time_constant", Dimension::TIME, Range::Positive),
        Parameter::new("settled", Dimension::NUMBER, Range::NonNegative).or(1.0),
    ],
    depends_on: &[Variable::Input],
    acts: Acts::Inputs,
    law: Law::Input(&ActuatorLag),
    priors,
    shapes,
    nature: Nature::PLAIN,
};

#[derive(Debug)]
struct ActuatorLag;

impl SeriesLaw for ActuatorLag {
    fn applied<T: Number>(&self, parameters: &[T], times: &[f64], series: &[T]) -> Vec<T> {
        let (tau, settled) = (parameters[0], parameters[1]);
        let mut state = series.first().map_or(T::constant(0.0), |u| settled * *u);
        let mut step = 0.0;
        let mut out = Vec::with_capacity(series.len());
        for (k, &u) in series.iter().enumerate() {
            if k + 1 < times.len() {
                step = times[k + 1] - times[k];
            }
            // What of the difference has gone by the step's end; of a slow lag hardly any.
            let gone = -(T::constant(-step) / tau).exp_m1();
            // The mean over the step of u + (state - u) exp(-t / tau).
            let share = if step > 0.0 { tau / step * gone } else { T::constant(1.0) };
            out.push(u + (state - u) * share);
            state = state + (u - state) * gone;
        }
        out
    }
}

fn priors(scales: &Scales) -> Vec<Prior> {
    let step = scales.step;
    let time_constant = Prior::order(6.0 * step, 2.5, (0.8 * step, 60.0 * step));
    vec![time_constant, Prior::near(1.0, 0.5, (0.0, 1.0))]
}

fn shapes(scales: &Scales) -> Vec<Vec<f64>> {
    let steps = [1.0, 2.0, 4.0, 7.0, 11.0, 15.0, 22.0];
    steps.iter().flat_map(|k| [1.0, 0.0].map(|settled| vec![k * scales.step, settled])).collect()
}
