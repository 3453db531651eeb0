//! Linear stiffness: `-stiffness q`.

use crate::{
    Acts, At, Dimension, Effect, ForceLaw, Law, Nature, Number, Parameter, Prior, Quantity, Range,
    Scales, Stated, Variable, one_shape,
};

pub(crate) static EFFECT: Effect = Effect {
    class: "linear_stiffness",
    words: "linear stiffness",
    formula: "-stiffness q",
    parameters: &[Parameter::new("stiffness", Dimension::new(1, -1, 0), Range::Any)],
    depends_on: &[Variable::Coordinate],
    acts: Acts::Coordinates,
    law: Law::Force(&LinearStiffness),
    priors,
    shapes: one_shape,
    nature: Nature { stated: Some(Stated::all(Quantity::Stiffness)), ..Nature::PLAIN },
};

#[derive(Debug)]
struct LinearStiffness;

impl ForceLaw for LinearStiffness {
    #[inline(always)]
    fn basis<T: Number>(&self, _shape: &[T], at: &At<T>) -> impl AsRef<[T]> {
        [-at.q()]
    }
}

fn priors(scales: &Scales) -> Vec<Prior> {
    vec![Prior::amplitude(scales.force / scales.half_range())]
}
