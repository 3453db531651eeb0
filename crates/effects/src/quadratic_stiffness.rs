//! Quadratic stiffness: `-stiffness q^2`.

use crate::{
    Acts, At, Dimension, Effect, ForceLaw, Law, Nature, Number, Parameter, Prior, Range, Scales,
    Variable, one_shape,
};

pub(crate) static EFFECT: Effect = Effect {
    class: "quadratic_stiffness",
    words: "quadratic stiffness",
    formula: "-stiffness q^2",
    parameters: &[Parameter::new("stiffness", Dimension::new(1, -2, 0), Range::Any)],
    depends_on: &[Variable::Coordinate],
    acts: Acts::Coordinates,
    law: Law::Force(&QuadraticStiffness),
    priors,
    shapes: one_shape,
    nature: Nature::PLAIN,
};

#[derive(Debug)]
struct QuadraticStiffness;

impl ForceLaw for QuadraticStiffness {
    #[inline(always)]
    fn basis<T: Number>(&self, _shape: &[T], at: &At<T>) -> impl AsRef<[T]> {
        [-at.q().powi(2)]
    }
}

fn priors(scales: &Scales) -> Vec<Prior> {
    vec![Prior::amplitude(scales.force / scales.half_range().powi(2))]
}
