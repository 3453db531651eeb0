//! A loss in proportion to the state: `-rate x`.

use crate::{
    Acts, At, Dimension, Effect, ForceLaw, Law, Nature, Number, Parameter, Prior, Range, Scales,
    Variable, one_shape,
};

pub(crate) static EFFECT: Effect = Effect {
    class: "linear_loss",
    words: "a loss in proportion to the state",
    formula: "-rate x",
    parameters: &[Parameter::new("rate", Dimension::new(1, -1, 0), Range::NonNegative)],
    depends_on: &[Variable::Coordinate],
    acts: Acts::States,
    law: Law::Force(&LinearLoss),
    priors,
    shapes: one_shape,
    nature: Nature::PLAIN,
};

#[derive(Debug)]
struct LinearLoss;

impl ForceLaw for LinearLoss {
    #[inline(always)]
    fn basis<T: Number>(&self, _shape: &[T], at: &At<T>) -> impl AsRef<[T]> {
        [-at.q()]
    }
}

fn priors(scales: &Scales) -> Vec<Prior> {
    vec![Prior::amplitude(scales.force / scales.half_range())]
}
