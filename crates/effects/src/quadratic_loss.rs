//! A loss with the square of the state: `-coefficient x |x|`.

use crate::{
    Acts, At, Dimension, Effect, ForceLaw, Law, Nature, Number, Parameter, Prior, Range, Scales,
    Variable, one_shape,
};

pub(crate) static EFFECT: Effect = Effect {
    class: "quadratic_loss",
    words: "a loss with the square of the state",
    formula: "-coefficient x |x|",
    parameters: &[Parameter::new("coefficient", Dimension::new(1, -2, 0), Range::NonNegative)],
    depends_on: &[Variable::Coordinate],
    acts: Acts::States,
    law: Law::Force(&QuadraticLoss),
    priors,
    shapes: one_shape,
    nature: Nature::PLAIN,
};

#[derive(Debug)]
struct QuadraticLoss;

impl ForceLaw for QuadraticLoss {
    #[inline(always)]
    fn basis<T: Number>(&self, _shape: &[T], at: &At<T>) -> impl AsRef<[T]> {
        [-at.q() * at.q().abs()]
    }
}

fn priors(scales: &Scales) -> Vec<Prior> {
    vec![Prior::magnitude(scales.force / scales.half_range().powi(2))]
}
