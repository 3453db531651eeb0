//! An end stop that also dissipates: `-stiffness d max(1 + dissipation d', 0)` at a depth d > 0.
//!
//! Rubber, a gas spring, the soft limits of simulators. What is pressed in resists more, and less on its way
//! out; it pushes and never pulls (K. H. Hunt, F. R. E. Crossley, *Coefficient of restitution interpreted as
//! damping in vibroimpact*, 1975), and begins gently, as a damper beside the spring would not. With
//! `side = 1` the depth is `q - position`, with -1 its mirror image. As it is the stop in another
//! formula, it is told as an end stop.

use crate::end_stop::{FAMILY, position_prior, stands, stiffness};
use crate::{
    Acts, At, Dimension, Effect, ForceLaw, Kin, Law, Nature, Number, Parameter, Prior, Range,
    Scales, Variable, end_stop,
};

pub(crate) static EFFECT: Effect = Effect {
    class: "damped_stop",
    words: "an end stop that dissipates",
    formula: "-stiffness d max(1 + dissipation v, 0), d = max(q - position, 0), or its mirror image \
              for side = -1",
    parameters: &[
        Parameter::new("stiffness", Dimension::new(1, -1, 0), Range::NonNegative),
        Parameter::new("dissipation", Dimension::new(0, -1, 1), Range::NonNegative),
        Parameter::new("position", Dimension::COORDINATE, Range::Any),
        Parameter::side("side"),
    ],
    depends_on: &[Variable::Coordinate, Variable::Velocity],
    acts: Acts::Coordinates,
    law: Law::Force(&DampedStop),
    priors,
    // Along a path on which no stop acts it looks like an elastic one, from which it begins.
    shapes: |_| vec![],
    nature: Nature {
        kin: Some(Kin { family: &FAMILY, shared: |p, _| vec![p[0], p[2], p[3]], begun }),
        variation_of: Some(&end_stop::EFFECT),
        edge: true,
        ..Nature::PLAIN
    },
};

#[derive(Debug)]
struct DampedStop;

impl ForceLaw for DampedStop {
    #[inline(always)]
    fn basis<T: Number>(&self, shape: &[T], at: &At<T>) -> impl AsRef<[T]> {
        let [dissipation, position, side] = [shape[0], shape[1], shape[2]];
        let nothing = T::constant(0.0);
        let depth = (side * (at.q() - position)).max(nothing);
        let more = (side * dissipation * at.v() + 1.0).max(nothing);
        [-side * depth * more]
    }

    fn internal(&self, physical: &[f64]) -> Vec<f64> {
        let [stiffness, dissipation, position] = [physical[0], physical[1], physical[2]];
        vec![stiffness, dissipation, position, stands(position, physical[3])]
    }
}

/// Of the order of what doubles the force at the usual speed.
fn priors(scales: &Scales) -> Vec<Prior> {
    let dissipation = Prior::order(1.0 / scales.v, 5.0, (1e-3 / scales.v, 1e3 / scales.v));
    vec![Prior::magnitude(stiffness(scales)), dissipation, position_prior(scales), Prior::Fixed]
}

/// Little, and much.
fn begun(shared: &[f64], scales: &Scales) -> Vec<Vec<f64>> {
    let dissipations = [0.3, 3.0].map(|share| share / scales.v);
    dissipations.map(|d| vec![shared[0], d, shared[1], shared[2]]).to_vec()
}
