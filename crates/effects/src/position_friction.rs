//! Dry friction that depends on position: `-(magnitude + slope q) tanh(v / smoothing_velocity)`.
//!
//! `magnitude` is the friction where the coordinate is 0, and `slope` what it gains on the way: a
//! belt that is tighter at one end, a lip that rubs harder there. Friction it is where
//! `magnitude + slope q` is not negative.

use crate::dry_friction::{
    Dry, DryFriction, FAMILY, SMOOTHING_VELOCITY, shared, smoothing_prior, smoothing_velocities,
};
use crate::{
    Acts, At, Dimension, Effect, Kin, Law, Nature, Number, Parameter, Prior, Range, Scales, Stated,
    Variable,
};

pub(crate) static EFFECT: Effect = Effect {
    class: "position_friction",
    words: "dry friction that depends on position",
    formula: "-(magnitude + slope q) tanh(v / smoothing_velocity)",
    parameters: &[
        Parameter::new("magnitude", Dimension::FORCE, Range::Any),
        Parameter::new("slope", Dimension::new(1, -1, 0), Range::Any),
        SMOOTHING_VELOCITY,
    ],
    depends_on: &[Variable::Coordinate, Variable::Velocity],
    acts: Acts::Coordinates,
    law: Law::Force(&Dry(PositionFriction)),
    priors,
    shapes,
    nature: Nature {
        kin: Some(Kin {
            family: &FAMILY,
            shared: |p, _| shared(p[0], 0.0, p[2]),
            begun: |s, _| vec![vec![s[0], 0.0, s[2]]],
        }),
        // What is negative in the middle of the range drives over half of it or more.
        possible: Some(|p, scales| p[0] + p[1] * scales.centre() >= 0.0),
        stated: Some(Stated::friction(&[1.0], "the dependence on position")),
        ..Nature::PLAIN
    },
};

#[derive(Debug)]
struct PositionFriction;

impl DryFriction<2> for PositionFriction {
    const SMOOTHING: usize = 0;

    #[inline(always)]
    fn magnitudes<T: Number>(&self, _shape: &[T], at: &At<T>) -> [T; 2] {
        [T::constant(1.0), at.q()]
    }
}

/// The friction at 0 may lie outside the range of the coordinate, as far as the slope takes it.
fn priors(scales: &Scales) -> Vec<Prior> {
    let slope = scales.force / scales.half_range();
    let at_zero = scales.force + slope * scales.centre().abs();
    vec![Prior::amplitude(at_zero), Prior::amplitude(slope), smoothing_prior(scales)]
}

fn shapes(scales: &Scales) -> Vec<Vec<f64>> {
    smoothing_velocities(scales).map(|v_s| vec![v_s]).to_vec()
}
