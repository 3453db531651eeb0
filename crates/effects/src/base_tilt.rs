//! A base that does not stand as the model says: level, as a rule.
//!
//! It is turned by `roll` about the x axis of the root's frame as the model has it, and then by `pitch`
//! about its y axis. Gravity, as the root sees it, is turned back:
//!
//! ```text
//! g <- R_x(-roll) R_y(-pitch) g
//! ```
//!
//! A turn about the vertical axis changes nothing.

use crate::{
    Acts, Dimension, Effect, Law, Nature, Number, Parameter, Prior, Range, Scales, StructureLaw,
    one_shape,
};

pub(crate) static EFFECT: Effect = Effect {
    class: "base_tilt",
    words: "a tilt",
    formula: "gravity turned by -pitch about y, then by -roll about x",
    parameters: &[
        Parameter::new("roll", Dimension::ANGLE, Range::Any).or(0.0),
        Parameter::new("pitch", Dimension::ANGLE, Range::Any).or(0.0),
    ],
    depends_on: &[],
    acts: Acts::Base,
    law: Law::Structure(&BaseTilt),
    priors,
    shapes: one_shape,
    nature: Nature::PLAIN,
};

#[derive(Debug)]
struct BaseTilt;

impl StructureLaw for BaseTilt {
    fn amplitudes(&self) -> usize {
        2
    }

    fn numbers<T: Number>(&self, parameters: &[T]) -> impl AsRef<[T]> {
        [parameters[0], parameters[1]]
    }
}

/// A table that is not level or a foot that was not shimmed: some degrees.
fn priors(_scales: &Scales) -> Vec<Prior> {
    vec![Prior::amplitude(0.1); 2]
}
