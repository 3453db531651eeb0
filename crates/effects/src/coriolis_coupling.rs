//! A Coriolis-like coupling to another velocity: `coefficient v_i v_j`.

use crate::law::{Acts, Effect, ForceLaw, Law, Local, Parameter, Range, Scales, Variable};
use crate::{Dimension, Prior};

pub(crate) static EFFECT: Effect = Effect {
    class: "coriolis_coupling",
    words: "a Coriolis-like coupling to another velocity",
    formula: "coefficient v_i v_j",
    parameters: &[Parameter::new("coefficient", Dimension::new(1, -2, 2), Range::Any)],
    depends_on: &[Variable::Velocity, Variable::OtherVelocity],
    acts: Acts::Coordinates,
    law: Law::Force(&CoriolisCoupling),
};

#[derive(Debug)]
struct CoriolisCoupling;

impl ForceLaw for CoriolisCoupling {
    fn priors(&self, scales: &Scales) -> Vec<Prior> {
        vec![Prior::amplitude(scales.force / (scales.v * scales.other.1))]
    }

    fn basis(&self, _shape: &[f64], at: &Local, _memory: &[f64], basis: &mut [f64]) {
        basis[0] = at.v * at.other_v;
    }
}
