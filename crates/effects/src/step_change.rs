//! A force that begins at a time: `force for t >= time`.

use crate::law::{Acts, Effect, ForceLaw, Law, Local, Parameter, Range, Scales, Variable};
use crate::{Dimension, Prior};

pub(crate) static EFFECT: Effect = Effect {
    class: "step_change",
    words: "a force that begins at a time",
    formula: "force for t >= time",
    parameters: &[
        Parameter::new("force", Dimension::FORCE, Range::Any),
        Parameter::new("time", Dimension::TIME, Range::Any),
    ],
    depends_on: &[Variable::Time],
    acts: Acts::CoordinatesAndStates,
    law: Law::Force(&StepChange),
};

#[derive(Debug)]
struct StepChange;

impl ForceLaw for StepChange {
    fn basis(&self, shape: &[f64], at: &Local, _memory: &[f64], basis: &mut [f64]) {
        basis[0] = if at.t >= shape[0] { 1.0 } else { 0.0 };
    }

    fn resolution(&self, _k: usize, sample: f64) -> f64 {
        sample
    }

    fn priors(&self, scales: &Scales) -> Vec<Prior> {
        let (begin, length) = (scales.time.0, scales.duration());
        let time = Prior::near(
            begin + 0.5 * length,
            0.25 * length,
            (begin + 0.03 * length, begin + 0.97 * length),
        );
        vec![Prior::amplitude(scales.force), time]
    }

    fn shapes(&self, scales: &Scales) -> Vec<Vec<f64>> {
        let begin = scales.time.0;
        (3..48).map(|k| vec![begin + 0.02 * f64::from(k) * scales.duration()]).collect()
    }
}
