//! A constant force: `force`.

use crate::law::{Acts, Effect, ForceLaw, Law, Local, Parameter, Range, Scales};
use crate::{Dimension, Prior};

pub(crate) static EFFECT: Effect = Effect {
    class: "constant_force",
    words: "a constant force",
    formula: "force",
    parameters: &[Parameter::new("force", Dimension::FORCE, Range::Any)],
    depends_on: &[],
    acts: Acts::CoordinatesAndStates,
    law: Law::Force(&ConstantForce),
};

#[derive(Debug)]
struct ConstantForce;

impl ForceLaw for ConstantForce {
    fn priors(&self, scales: &Scales) -> Vec<Prior> {
        vec![Prior::amplitude(scales.force)]
    }

    fn basis(&self, _shape: &[f64], _at: &Local, _memory: &[f64], basis: &mut [f64]) {
        basis[0] = 1.0;
    }
}
