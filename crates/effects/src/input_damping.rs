//! Damping that an input sets: `-coefficient |u| v`.
//!
//! The current of a magnetorheological damper, the opening of a valve, the load of a bearing: u is an
//! input of the machine. Its size counts, not its sign, so that one coefficient cannot damp one
//! way and drive the other. A negative coefficient takes back damping that the model has: a valve
//! that opens. Damping at `u = 0` is viscous friction, a law of its own.

use crate::{
    Acts, At, Dimension, Effect, ForceLaw, Law, Nature, Number, Parameter, Prior, Range, Scales,
    Variable, one_shape,
};

pub(crate) static EFFECT: Effect = Effect {
    class: "input_damping",
    words: "damping that an input sets",
    formula: "-coefficient |u| v",
    parameters: &[Parameter::new("coefficient", Dimension::new(1, -1, 1).per_input(), Range::Any)],
    depends_on: &[Variable::Velocity, Variable::OtherInput],
    acts: Acts::Coordinates,
    law: Law::Force(&InputDamping),
    priors,
    shapes,
    nature: Nature::PLAIN,
};

#[derive(Debug)]
struct InputDamping;

impl ForceLaw for InputDamping {
    #[inline(always)]
    fn basis<T: Number>(&self, _shape: &[T], at: &At<T>) -> impl AsRef<[T]> {
        [-at.input().abs() * at.v()]
    }
}

fn priors(scales: &Scales) -> Vec<Prior> {
    vec![Prior::amplitude(scales.force / (scales.v * scales.usual_input()))]
}

/// An input that is always 0 sets nothing.
fn shapes(scales: &Scales) -> Vec<Vec<f64>> {
    if scales.usual_input() > 0.0 { one_shape(scales) } else { vec![] }
}
