//! A gravity torque: `-magnitude sin(q)`.

use crate::law::{Acts, Effect, ForceLaw, Law, Local, Parameter, Range, Scales, Variable};
use crate::{Dimension, Prior};

pub(crate) static EFFECT: Effect = Effect {
    class: "gravity_torque",
    words: "a gravity torque",
    formula: "-magnitude sin(q)",
    parameters: &[Parameter::new("magnitude", Dimension::FORCE, Range::Any)],
    depends_on: &[Variable::Coordinate],
    acts: Acts::Coordinates,
    law: Law::Force(&GravityTorque),
};

#[derive(Debug)]
struct GravityTorque;

impl ForceLaw for GravityTorque {
    fn priors(&self, scales: &Scales) -> Vec<Prior> {
        vec![Prior::amplitude(scales.force / scales.half_range().min(1.0))]
    }

    fn basis(&self, _shape: &[f64], at: &Local, _memory: &[f64], basis: &mut [f64]) {
        basis[0] = -at.q.sin();
    }
}
