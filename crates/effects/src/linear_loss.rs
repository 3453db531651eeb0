//! A loss in proportion to the state: `-rate x`.

use crate::law::{Acts, Effect, ForceLaw, Law, Local, Parameter, Range, Scales, Variable};
use crate::{Dimension, Prior};

pub(crate) static EFFECT: Effect = Effect {
    class: "linear_loss",
    words: "a loss in proportion to the state",
    formula: "-rate x",
    parameters: &[Parameter::new("rate", Dimension::new(1, -1, 0), Range::NonNegative)],
    depends_on: &[Variable::Coordinate],
    acts: Acts::States,
    law: Law::Force(&LinearLoss),
};

#[derive(Debug)]
struct LinearLoss;

impl ForceLaw for LinearLoss {
    fn priors(&self, scales: &Scales) -> Vec<Prior> {
        vec![Prior::amplitude(scales.force / scales.half_range())]
    }

    fn basis(&self, _shape: &[f64], at: &Local, _memory: &[f64], basis: &mut [f64]) {
        basis[0] = -at.q;
    }
}
