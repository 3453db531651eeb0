//! A viscoelastic (Maxwell) element: `-stiffness z, z' = v - z / time_constant`.

use crate::law::{Acts, Effect, ForceLaw, Law, Local, Parameter, Range, Scales, Variable};
use crate::{Dimension, Prior};

pub(crate) static EFFECT: Effect = Effect {
    class: "viscoelastic",
    words: "a viscoelastic (Maxwell) element",
    formula: "-stiffness z, z' = v - z / time_constant",
    parameters: &[
        Parameter::new("stiffness", Dimension::new(1, -1, 0), Range::NonNegative),
        Parameter::new("time_constant", Dimension::TIME, Range::Positive),
    ],
    depends_on: &[Variable::Velocity],
    acts: Acts::Coordinates,
    law: Law::Force(&Viscoelastic),
};

#[derive(Debug)]
struct Viscoelastic;

impl ForceLaw for Viscoelastic {
    fn basis(&self, _shape: &[f64], _at: &Local, memory: &[f64], basis: &mut [f64]) {
        basis[0] = -memory[0];
    }

    fn memory(&self) -> usize {
        1
    }

    fn memory_rate(&self, shape: &[f64], at: &Local, memory: &[f64], rate: &mut [f64]) {
        rate[0] = at.v - memory[0] / shape[0];
    }

    fn priors(&self, scales: &Scales) -> Vec<Prior> {
        let time = 1.0 / scales.rate();
        let time_constant = Prior::order(time, 2.5, (0.1 * time, 8.0 * time));
        vec![Prior::magnitude(scales.force / scales.half_range()), time_constant]
    }

    fn shapes(&self, scales: &Scales) -> Vec<Vec<f64>> {
        let time = scales.half_range() / scales.v;
        [0.25, 0.6, 1.2, 2.5, 5.0].map(|share| vec![share * time]).to_vec()
    }
}
