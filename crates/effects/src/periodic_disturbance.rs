//! A periodic disturbance: `amplitude sin(angular_frequency (t - begin) + phase)`.
//!
//! The phase is that at the time `begin`, where the recordings it was found on begin. At a time far from them, such
//! as 1970 of a log that counts seconds since, a phase could be anything, and no fit of it and the frequency
//! together could move.

use crate::sine::{sine_internal, sine_physical};
use crate::{
    Acts, At, Dimension, Effect, ForceLaw, GRID, Law, Nature, Number, Parameter, Prior, Range,
    Scales, Variable,
};

pub(crate) static EFFECT: Effect = Effect {
    class: "periodic_disturbance",
    words: "a periodic disturbance",
    formula: "amplitude sin(angular_frequency (t - begin) + phase)",
    parameters: &[
        Parameter::new("amplitude", Dimension::FORCE, Range::NonNegative),
        Parameter::new("angular_frequency", Dimension::RATE, Range::Positive),
        Parameter::new("phase", Dimension::ANGLE, Range::Any).or(0.0),
        Parameter::new("begin", Dimension::TIME, Range::Any).or(0.0).of_the_formula(),
    ],
    depends_on: &[Variable::Time],
    acts: Acts::CoordinatesAndStates,
    law: Law::Force(&PeriodicDisturbance),
    priors,
    shapes,
    nature: Nature::PLAIN,
};

#[derive(Debug)]
struct PeriodicDisturbance;

impl ForceLaw for PeriodicDisturbance {
    fn amplitudes(&self) -> usize {
        2
    }

    fn internal(&self, physical: &[f64]) -> Vec<f64> {
        let [sine @ .., begin] = physical else { unreachable!("four parameters") };
        [sine_internal(sine), vec![*begin]].concat()
    }

    fn physical(&self, internal: &[f64]) -> Vec<f64> {
        let [sine @ .., begin] = internal else { unreachable!("four parameters") };
        [sine_physical(sine), vec![*begin]].concat()
    }

    #[inline(always)]
    fn basis<T: Number>(&self, shape: &[T], at: &At<T>) -> impl AsRef<[T]> {
        let (sine, cosine) = (shape[0] * (-shape[1] + at.t)).sin_cos();
        [sine, cosine]
    }
}

fn priors(scales: &Scales) -> Vec<Prior> {
    let turn = std::f64::consts::TAU / scales.duration();
    let fastest = scales.lines.into_iter().fold(GRID * turn, |most, line| most.max(line + turn));
    let rate = Prior::order(6.0 * turn, std::f64::consts::E, (1.5 * turn, fastest));
    vec![Prior::amplitude(scales.force), Prior::amplitude(scales.force), rate, Prior::Fixed]
}

/// Steps of 0.4 periods over the recording, as wide as a spectral line; beyond them those lines that stand out.
fn shapes(scales: &Scales) -> Vec<Vec<f64>> {
    let line = std::f64::consts::TAU / scales.duration();
    let slow = (0..200).map(|k| line * (1.5 + 0.4 * f64::from(k)));
    let fast = scales.lines.into_iter().filter(|w| *w > 0.0);
    slow.chain(fast).map(|w| vec![w, scales.time.0]).collect()
}
