//! A constant force: `force`.

use crate::{
    Acts, At, Dimension, Effect, ForceLaw, Law, Nature, Number, Parameter, Prior, Quantity, Range,
    Scales, Stated, one_shape,
};

pub(crate) static EFFECT: Effect = Effect {
    class: "constant_force",
    words: "a constant force",
    formula: "force",
    parameters: &[Parameter::new("force", Dimension::FORCE, Range::Any)],
    depends_on: &[],
    acts: Acts::CoordinatesAndStates,
    law: Law::Force(&ConstantForce),
    priors,
    shapes: one_shape,
    nature: Nature { stated: Some(Stated::all(Quantity::Force)), ..Nature::PLAIN },
};

#[derive(Debug)]
struct ConstantForce;

impl ForceLaw for ConstantForce {
    #[inline(always)]
    fn basis<T: Number>(&self, _shape: &[T], _at: &At<T>) -> impl AsRef<[T]> {
        [T::constant(1.0)]
    }
}

fn priors(scales: &Scales) -> Vec<Prior> {
    vec![Prior::amplitude(scales.force)]
}
