//! An inertia that the model leaves out: `-inertia a`, a the acceleration.
//!
//! It moves with the coordinate and belongs to its entry of the mass matrix,
//! `(M_ii + inertia) q_i'' = F_i`: as a force it can be told only along a given motion.

use crate::{
    Acts, At, Dimension, Effect, ForceLaw, Law, Nature, Number, Parameter, Prior, Quantity, Range,
    Scales, Stated, Variable, one_shape,
};

pub(crate) static EFFECT: Effect = Effect {
    class: "added_inertia",
    words: "an added inertia",
    formula: "-inertia a, a the acceleration",
    parameters: &[Parameter::new("inertia", Dimension::new(1, -1, 2), Range::NonNegative)],
    depends_on: &[Variable::Acceleration],
    acts: Acts::Coordinates,
    law: Law::Force(&AddedInertia),
    priors,
    shapes: one_shape,
    nature: Nature { stated: Some(Stated::all(Quantity::RotorInertia)), ..Nature::PLAIN },
};

#[derive(Debug)]
struct AddedInertia;

impl ForceLaw for AddedInertia {
    #[inline(always)]
    fn basis<T: Number>(&self, _shape: &[T], _at: &At<T>) -> impl AsRef<[T]> {
        [T::constant(0.0)]
    }

    fn inertia<T: Number>(&self, _shape: &[T], _at: &At<T>) -> impl AsRef<[T]> {
        [T::constant(1.0)]
    }
}

/// As large as what the force moves already.
fn priors(scales: &Scales) -> Vec<Prior> {
    vec![Prior::magnitude(scales.force / scales.acceleration)]
}
