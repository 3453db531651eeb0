//! Friction with a Stribeck peak at low speed: `-(coulomb + (static - coulomb) exp(-(v / stribeck_velocity)^2)) tanh(v / smoothing_velocity)`.

use crate::dry_friction::{
    Dry, DryFriction, FAMILY, SMOOTHING_VELOCITY, shared, smoothing_prior, smoothing_velocities,
};
use crate::{
    Acts, At, Dimension, Effect, Kin, Law, Nature, Number, Parameter, Prior, Range, Scales, Stated,
    Variable,
};

pub(crate) static EFFECT: Effect = Effect {
    class: "stribeck_friction",
    words: "friction with a Stribeck peak at low speed",
    formula: "-(coulomb + (static - coulomb) exp(-(v / stribeck_velocity)^2)) tanh(v / smoothing_velocity)",
    parameters: &[
        Parameter::new("coulomb", Dimension::FORCE, Range::NonNegative),
        Parameter::new("static", Dimension::FORCE, Range::NonNegative),
        Parameter::new("stribeck_velocity", Dimension::VELOCITY, Range::Positive),
        SMOOTHING_VELOCITY,
    ],
    depends_on: &[Variable::Velocity],
    acts: Acts::Coordinates,
    law: Law::Force(&Dry(StribeckFriction)),
    priors,
    shapes,
    nature: Nature {
        kin: Some(Kin { family: &FAMILY, shared: |p, _| shared(p[0], 0.0, p[3]), begun }),
        stated: Some(Stated::friction(&[1.0], "the other friction at low speed")),
        ..Nature::PLAIN
    },
};

#[derive(Debug)]
struct StribeckFriction;

impl DryFriction<2> for StribeckFriction {
    const SMOOTHING: usize = 1;

    #[inline(always)]
    fn magnitudes<T: Number>(&self, shape: &[T], at: &At<T>) -> [T; 2] {
        [T::constant(1.0), (-(at.v() / shape[0]).powi(2)).exp()]
    }

    /// The friction at speed, and what it is more at rest: a peak is no hollow.
    fn internal(&self, physical: &[f64]) -> Vec<f64> {
        let mut internal = physical.to_vec();
        internal[1] -= physical[0];
        internal
    }

    fn physical(&self, internal: &[f64]) -> Vec<f64> {
        let mut physical = internal.to_vec();
        physical[1] += internal[0];
        physical
    }
}

fn priors(scales: &Scales) -> Vec<Prior> {
    vec![
        Prior::magnitude(scales.force),
        Prior::magnitude(scales.force),
        Prior::order(0.35 * scales.v, 2.5, (0.05 * scales.v, 4.0 * scales.v)),
        smoothing_prior(scales),
    ]
}

fn shapes(scales: &Scales) -> Vec<Vec<f64>> {
    let [sharp, medium, _] = smoothing_velocities(scales);
    let widths = [0.1, 0.2, 0.4, 0.8, 1.6].map(|share| share * scales.v);
    widths.iter().flat_map(|&w| [vec![w, sharp], vec![w, medium]]).collect()
}

/// The peak may be anywhere between creeping and full speed.
fn begun(shared: &[f64], scales: &Scales) -> Vec<Vec<f64>> {
    let (magnitude, smoothing) = (shared[0], shared[2]);
    let peak = |share| vec![0.8 * magnitude, 1.3 * magnitude, share * scales.v, smoothing];
    [0.15, 0.4, 1.2].map(peak).to_vec()
}
