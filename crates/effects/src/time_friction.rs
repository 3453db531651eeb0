//! Dry friction that changes with time: `-(final + (initial - final) exp(-(t - begin) / time_constant)) tanh(v / smoothing_velocity)`.
//!
//! Grease that warms up, a bearing that wears: the friction goes from `initial` at the time
//! `begin` to `final`. Before `begin` it is `initial`. Both are magnitudes, so that it dissipates at
//! any time.

use crate::dry_friction::{
    Dry, DryFriction, FAMILY, SMOOTHING_VELOCITY, shared, smoothing_prior, smoothing_velocities,
};
use crate::{
    Acts, At, Dimension, Effect, Kin, Law, Nature, Number, Parameter, Prior, Range, Scales, Stated,
    Variable, coulomb_friction,
};

pub(crate) static EFFECT: Effect = Effect {
    class: "time_friction",
    words: "dry friction that changes with time",
    formula: "-(final + (initial - final) exp(-(t - begin) / time_constant)) tanh(v / smoothing_velocity)",
    parameters: &[
        Parameter::new("initial", Dimension::FORCE, Range::NonNegative),
        Parameter::new("final", Dimension::FORCE, Range::NonNegative),
        Parameter::new("time_constant", Dimension::TIME, Range::Positive),
        SMOOTHING_VELOCITY,
        Parameter::new("begin", Dimension::TIME, Range::Any).or(0.0).of_the_formula(),
    ],
    depends_on: &[Variable::Velocity, Variable::Time],
    acts: Acts::Coordinates,
    law: Law::Force(&Dry(TimeFriction)),
    priors,
    shapes,
    nature: Nature {
        kin: Some(Kin {
            family: &FAMILY,
            shared: |p, _| shared(0.5 * (p[0] + p[1]), 0.0, p[3]),
            begun,
        }),
        variation_of: Some(&coulomb_friction::EFFECT),
        stated: Some(Stated::friction(&[0.0, 1.0], "the change with time")),
        ..Nature::PLAIN
    },
};

#[derive(Debug)]
struct TimeFriction;

impl DryFriction<2> for TimeFriction {
    const SMOOTHING: usize = 1;

    #[inline(always)]
    fn magnitudes<T: Number>(&self, shape: &[T], at: &At<T>) -> [T; 2] {
        let [time_constant, begin] = [shape[0], shape[2]];
        let since = (-begin + at.t).max(T::constant(0.0));
        let left = (-since / time_constant).exp();
        [left, T::constant(1.0) - left]
    }
}

fn priors(scales: &Scales) -> Vec<Prior> {
    let length = scales.duration();
    vec![
        Prior::magnitude(scales.force),
        Prior::magnitude(scales.force),
        Prior::order(0.3 * length, 3.0, (0.02 * length, 5.0 * length)),
        smoothing_prior(scales),
        Prior::Fixed,
    ]
}

/// From what settles at the beginning to what drifts all along.
const SHARES: [f64; 3] = [0.08, 0.3, 1.5];

fn shapes(scales: &Scales) -> Vec<Vec<f64>> {
    let (begin, length) = (scales.time.0, scales.duration());
    let [sharp, medium, _] = smoothing_velocities(scales);
    let times = SHARES.iter().map(|share| share * length);
    times.flat_map(|time| [sharp, medium].map(|v_s| vec![time, v_s, begin])).collect()
}

/// It may have changed at any pace.
fn begun(shared: &[f64], scales: &Scales) -> Vec<Vec<f64>> {
    let (magnitude, smoothing) = (shared[0], shared[2]);
    let change = |share: f64| {
        vec![magnitude, magnitude, share * scales.duration(), smoothing, scales.time.0]
    };
    SHARES.map(change).to_vec()
}
