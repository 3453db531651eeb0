//! Quadratic drag: `-coefficient v |v|`.

use crate::{
    Acts, At, Dimension, Effect, ForceLaw, Law, Nature, Number, Parameter, Prior, Range, Scales,
    Variable, one_shape,
};

pub(crate) static EFFECT: Effect = Effect {
    class: "quadratic_drag",
    words: "quadratic drag",
    formula: "-coefficient v |v|",
    parameters: &[Parameter::new("coefficient", Dimension::new(1, -2, 2), Range::NonNegative)],
    depends_on: &[Variable::Velocity],
    acts: Acts::Coordinates,
    law: Law::Force(&QuadraticDrag),
    priors,
    shapes: one_shape,
    nature: Nature::PLAIN,
};

#[derive(Debug)]
struct QuadraticDrag;

impl ForceLaw for QuadraticDrag {
    #[inline(always)]
    fn basis<T: Number>(&self, _shape: &[T], at: &At<T>) -> impl AsRef<[T]> {
        [-at.v() * at.v().abs()]
    }
}

fn priors(scales: &Scales) -> Vec<Prior> {
    vec![Prior::magnitude(scales.force / scales.v.powi(2))]
}
