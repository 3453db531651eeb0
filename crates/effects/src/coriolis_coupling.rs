//! A Coriolis-like coupling to another velocity: `coefficient v_i v_j`.

use crate::{
    Acts, At, Dimension, Effect, ForceLaw, Law, Nature, Number, Parameter, Prior, Range, Scales,
    Variable, one_shape,
};

pub(crate) static EFFECT: Effect = Effect {
    class: "coriolis_coupling",
    words: "a Coriolis-like coupling to another velocity",
    formula: "coefficient v_i v_j",
    parameters: &[Parameter::new("coefficient", Dimension::new(1, -2, 2), Range::Any)],
    depends_on: &[Variable::Velocity, Variable::OtherVelocity],
    acts: Acts::Coordinates,
    law: Law::Force(&CoriolisCoupling),
    priors,
    shapes: one_shape,
    nature: Nature::PLAIN,
};

#[derive(Debug)]
struct CoriolisCoupling;

impl ForceLaw for CoriolisCoupling {
    #[inline(always)]
    fn basis<T: Number>(&self, _shape: &[T], at: &At<T>) -> impl AsRef<[T]> {
        [at.v() * at.other_v(0)]
    }
}

fn priors(scales: &Scales) -> Vec<Prior> {
    vec![Prior::amplitude(scales.force / (scales.v * scales.other.1))]
}
