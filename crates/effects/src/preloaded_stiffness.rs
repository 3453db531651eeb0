//! A spring that is at rest elsewhere than at 0: `-stiffness (q - reference)`.
//!
//! Its amplitudes are the stiffness and the preload `stiffness reference`, the force at 0: linear in
//! both, it can be told of a spring however weak.

use crate::{
    Acts, At, Dimension, Effect, ForceLaw, Law, Nature, Number, Parameter, Prior, Range, Scales,
    Variable, linear_stiffness, one_shape,
};

pub(crate) static EFFECT: Effect = Effect {
    class: "preloaded_stiffness",
    words: "a spring about a place",
    formula: "-stiffness (q - reference)",
    parameters: &[
        Parameter::new("stiffness", Dimension::new(1, -1, 0), Range::Any),
        Parameter::new("reference", Dimension::COORDINATE, Range::Any),
    ],
    depends_on: &[Variable::Coordinate],
    acts: Acts::Coordinates,
    law: Law::Force(&PreloadedStiffness),
    priors,
    shapes: one_shape,
    nature: Nature { variation_of: Some(&linear_stiffness::EFFECT), ..Nature::PLAIN },
};

#[derive(Debug)]
struct PreloadedStiffness;

impl ForceLaw for PreloadedStiffness {
    fn amplitudes(&self) -> usize {
        2
    }

    fn internal(&self, physical: &[f64]) -> Vec<f64> {
        vec![physical[0], physical[0] * physical[1]]
    }

    fn physical(&self, internal: &[f64]) -> Vec<f64> {
        let [stiffness, preload] = [internal[0], internal[1]];
        // A force that nothing brings back has no place of rest.
        let reference = if stiffness == 0.0 { 0.0 } else { preload / stiffness };
        vec![stiffness, reference]
    }

    fn basis<T: Number>(&self, _shape: &[T], at: &At<T>) -> impl AsRef<[T]> {
        [-at.q(), T::constant(1.0)]
    }
}

fn priors(scales: &Scales) -> Vec<Prior> {
    vec![Prior::amplitude(scales.force / scales.half_range()), Prior::amplitude(scales.force)]
}
