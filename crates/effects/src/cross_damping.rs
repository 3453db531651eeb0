//! A force against another coordinate's velocity: `-coefficient v_j`.
//!
//! Where one drive turns through another's joint (a wrist whose last motor sits behind the joint before it), its
//! viscous friction acts on that joint too.

use crate::{
    Acts, At, Dimension, Effect, ForceLaw, Law, Nature, Number, Parameter, Prior, Range, Scales,
    Variable, one_shape,
};

pub(crate) static EFFECT: Effect = Effect {
    class: "cross_damping",
    words: "damping by another velocity",
    formula: "-coefficient v_j",
    parameters: &[Parameter::new("coefficient", Dimension::new(1, -1, 1), Range::Any)],
    depends_on: &[Variable::OtherVelocity],
    acts: Acts::Coordinates,
    law: Law::Force(&CrossDamping),
    priors,
    shapes: one_shape,
    nature: Nature::PLAIN,
};

#[derive(Debug)]
struct CrossDamping;

impl ForceLaw for CrossDamping {
    #[inline(always)]
    fn basis<T: Number>(&self, _shape: &[T], at: &At<T>) -> impl AsRef<[T]> {
        [-at.other_v(0)]
    }
}

fn priors(scales: &Scales) -> Vec<Prior> {
    vec![Prior::amplitude(scales.force / scales.other.1)]
}
