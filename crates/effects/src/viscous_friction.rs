//! Viscous friction: `-coefficient v`.

use crate::law::{Acts, Effect, ForceLaw, Law, Local, Parameter, Range, Scales, Variable};
use crate::{Dimension, Prior};

pub(crate) static EFFECT: Effect = Effect {
    class: "viscous_friction",
    words: "viscous friction",
    formula: "-coefficient v",
    parameters: &[Parameter::new("coefficient", Dimension::new(1, -1, 1), Range::NonNegative)],
    depends_on: &[Variable::Velocity],
    acts: Acts::Coordinates,
    law: Law::Force(&ViscousFriction),
};

#[derive(Debug)]
struct ViscousFriction;

impl ForceLaw for ViscousFriction {
    fn priors(&self, scales: &Scales) -> Vec<Prior> {
        vec![Prior::magnitude(scales.force / scales.v)]
    }

    fn basis(&self, _shape: &[f64], at: &Local, _memory: &[f64], basis: &mut [f64]) {
        basis[0] = -at.v;
    }
}
