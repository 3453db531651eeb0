//! A gravity torque: `-magnitude sin(q)`, q in radians whatever the coordinate's unit.

use crate::{
    Acts, At, Dimension, Effect, ForceLaw, Law, Nature, Number, Parameter, Prior, Range, Scales,
    Variable, one_shape,
};

pub(crate) static EFFECT: Effect = Effect {
    class: "gravity_torque",
    words: "a gravity torque",
    formula: "-magnitude sin(q)",
    parameters: &[Parameter::new("magnitude", Dimension::FORCE, Range::Any)],
    depends_on: &[Variable::Coordinate],
    acts: Acts::Coordinates,
    law: Law::Force(&GravityTorque),
    priors,
    shapes: one_shape,
    nature: Nature::PLAIN,
};

#[derive(Debug)]
struct GravityTorque;

impl ForceLaw for GravityTorque {
    #[inline(always)]
    fn basis<T: Number>(&self, _shape: &[T], at: &At<T>) -> impl AsRef<[T]> {
        [-at.angle().sin()]
    }
}

fn priors(scales: &Scales) -> Vec<Prior> {
    vec![Prior::amplitude(scales.force / (scales.si * scales.half_range()).min(1.0))]
}
