//! Viscous friction: `-coefficient v`.

use crate::{
    Acts, At, Dimension, Effect, ForceLaw, Law, Nature, Number, Parameter, Prior, Quantity, Range,
    Scales, Stated, Variable, one_shape,
};

pub(crate) static EFFECT: Effect = Effect {
    class: "viscous_friction",
    words: "viscous friction",
    formula: "-coefficient v",
    parameters: &[Parameter::new("coefficient", Dimension::new(1, -1, 1), Range::NonNegative)],
    depends_on: &[Variable::Velocity],
    acts: Acts::Coordinates,
    law: Law::Force(&ViscousFriction),
    priors,
    shapes: one_shape,
    nature: Nature { stated: Some(Stated::all(Quantity::Damping)), ..Nature::PLAIN },
};

#[derive(Debug)]
struct ViscousFriction;

impl ForceLaw for ViscousFriction {
    #[inline(always)]
    fn basis<T: Number>(&self, _shape: &[T], at: &At<T>) -> impl AsRef<[T]> {
        [-at.v()]
    }
}

fn priors(scales: &Scales) -> Vec<Prior> {
    vec![Prior::magnitude(scales.force / scales.v)]
}
