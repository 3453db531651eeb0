//! A lag of the actuator: `time_constant u_effective' = u - u_effective`.

use crate::Dimension;
use crate::law::{Acts, Effect, InputLaw, Law, Parameter, Range, Scales, Variable};

pub(crate) static EFFECT: Effect = Effect {
    class: "actuator_lag",
    words: "a lag of the actuator",
    formula: "time_constant u_effective' = u - u_effective",
    parameters: &[Parameter::new("time_constant", Dimension::TIME, Range::Positive)],
    depends_on: &[Variable::Input],
    acts: Acts::Inputs,
    law: Law::Input(&ActuatorLag),
};

#[derive(Debug)]
struct ActuatorLag;

impl InputLaw for ActuatorLag {
    fn transform(&self, parameters: &[f64], times: &[f64], command: &[f64]) -> Vec<f64> {
        let tau = parameters[0];
        let mut state = command.first().copied().unwrap_or(0.0);
        let mut step = 0.0;
        let mut out = Vec::with_capacity(command.len());
        for (k, &u) in command.iter().enumerate() {
            if k + 1 < times.len() {
                step = times[k + 1] - times[k];
            }
            // What of the difference has gone by the step's end; of a slow lag hardly any.
            let gone = -(-step / tau).exp_m1();
            // The mean over the step of u + (state - u) exp(-t / tau).
            let share = if step > 0.0 { tau / step * gone } else { 1.0 };
            out.push(u + (state - u) * share);
            state += (u - state) * gone;
        }
        out
    }

    fn shapes(&self, scales: &Scales) -> Vec<Vec<f64>> {
        [1.0, 2.0, 4.0, 7.0, 11.0, 15.0, 22.0].map(|k| vec![k * scales.step]).to_vec()
    }
}
