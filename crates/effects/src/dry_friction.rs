//! What the laws of dry friction share: `-F(v) tanh(v / smoothing_velocity)`.

use crate::{Dimension, Family, Number, Parameter, Prior, Range, Scales};

/// The laws of dry friction. Their shared numbers: [`shared`].
pub(crate) static FAMILY: Family = Family { words: "dry friction" };

/// The family's shared numbers: mean magnitude, half of what the backward one is larger than the
/// forward one, smoothing velocity.
pub(crate) fn shared(magnitude: f64, offset: f64, smoothing_velocity: f64) -> Vec<f64> {
    vec![magnitude, offset, smoothing_velocity]
}

/// The smooth sign `tanh(v / v_s)`.
#[inline(always)]
pub(crate) fn smooth_sign<T: Number>(v: T, smoothing_velocity: T) -> T {
    (v / smoothing_velocity).tanh()
}

/// Default of `smoothing_velocity`: sharp for a machine that moves at about one unit a second.
pub(crate) const SMOOTHING_VELOCITY: Parameter =
    Parameter::new("smoothing_velocity", Dimension::VELOCITY, Range::Positive)
        .or(1e-3)
        .of_the_formula();

/// Smoothing velocities to begin from.
pub(crate) fn smoothing_velocities(scales: &Scales) -> [f64; 3] {
    [0.01, 0.04, 0.15].map(|share| share * scales.v)
}

/// Prior of a smoothing velocity.
pub(crate) fn smoothing_prior(scales: &Scales) -> Prior {
    Prior::order(0.03 * scales.v, 2.5, (1e-4 * scales.v, 0.4 * scales.v))
}
