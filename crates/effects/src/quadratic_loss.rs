//! A loss with the square of the state: `-coefficient x |x|`.

use crate::law::{Acts, Effect, ForceLaw, Law, Local, Parameter, Range, Scales, Variable};
use crate::{Dimension, Prior};

pub(crate) static EFFECT: Effect = Effect {
    class: "quadratic_loss",
    words: "a loss with the square of the state",
    formula: "-coefficient x |x|",
    parameters: &[Parameter::new("coefficient", Dimension::new(1, -2, 0), Range::NonNegative)],
    depends_on: &[Variable::Coordinate],
    acts: Acts::States,
    law: Law::Force(&QuadraticLoss),
};

#[derive(Debug)]
struct QuadraticLoss;

impl ForceLaw for QuadraticLoss {
    fn priors(&self, scales: &Scales) -> Vec<Prior> {
        vec![Prior::magnitude(scales.force / scales.half_range().powi(2))]
    }

    fn basis(&self, _shape: &[f64], at: &Local, _memory: &[f64], basis: &mut [f64]) {
        basis[0] = -at.q * at.q.abs();
    }
}
