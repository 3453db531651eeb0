//! Cubic stiffness: `-stiffness q^3`.

use crate::{
    Acts, At, Dimension, Effect, ForceLaw, Law, Nature, Number, Parameter, Prior, Range, Scales,
    Variable, one_shape,
};

pub(crate) static EFFECT: Effect = Effect {
    class: "cubic_stiffness",
    words: "cubic stiffness",
    formula: "-stiffness q^3",
    parameters: &[Parameter::new("stiffness", Dimension::new(1, -3, 0), Range::Any)],
    depends_on: &[Variable::Coordinate],
    acts: Acts::Coordinates,
    law: Law::Force(&CubicStiffness),
    priors,
    shapes: one_shape,
    nature: Nature::PLAIN,
};

#[derive(Debug)]
struct CubicStiffness;

impl ForceLaw for CubicStiffness {
    #[inline(always)]
    fn basis<T: Number>(&self, _shape: &[T], at: &At<T>) -> impl AsRef<[T]> {
        [-at.q().powi(3)]
    }
}

fn priors(scales: &Scales) -> Vec<Prior> {
    vec![Prior::amplitude(scales.force / scales.half_range().powi(3))]
}
