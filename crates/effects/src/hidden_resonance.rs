//! A hidden resonance (a mass on a spring hung on the coordinate): `mass a, a = frequency^2 (y - q) + 2 damping_ratio frequency (y' - v), y'' = -a`.

use std::f64::consts::TAU;

use crate::{
    Acts, At, Dimension, Effect, Family, ForceLaw, Kin, Law, Nature, Number, Parameter, Prior,
    Range, Scales, Variable,
};

pub(crate) static EFFECT: Effect = Effect {
    class: "hidden_resonance",
    words: "a hidden resonance (a mass on a spring hung on the coordinate)",
    formula: "mass a, a = frequency^2 (y - q) + 2 damping_ratio frequency (y' - v), y'' = -a",
    parameters: &[
        Parameter::new("mass", Dimension::new(1, -1, 2), Range::NonNegative),
        Parameter::new("frequency", Dimension::RATE, Range::Positive),
        Parameter::new("damping_ratio", Dimension::NUMBER, Range::NonNegative),
    ],
    depends_on: &[Variable::Coordinate, Variable::Velocity],
    acts: Acts::Coordinates,
    law: Law::Force(&HiddenResonance),
    priors,
    shapes,
    nature: Nature { kin: Some(Kin::of(&RESONANCES)), memory_spread, ..Nature::PLAIN },
};

/// Of a mass that hangs on the coordinate by a spring, and one that the model fixed to it, one is there.
pub(crate) static RESONANCES: Family = Family { words: "a mass on a spring" };

#[derive(Debug)]
struct HiddenResonance;

impl ForceLaw for HiddenResonance {
    #[inline(always)]
    fn basis<T: Number>(&self, shape: &[T], at: &At<T>) -> impl AsRef<[T]> {
        [pull(shape, at)]
    }

    fn memory(&self) -> usize {
        2
    }

    fn memory_at_rest(&self, at: &At, memory: &mut [f64]) {
        memory.copy_from_slice(&[at.q(), at.v()]);
    }

    fn memory_rate<T: Number>(&self, shape: &[T], at: &At<T>) -> impl AsRef<[T]> {
        [at.memory[1], -pull(shape, at)]
    }
}

pub(crate) fn priors(scales: &Scales) -> Vec<Prior> {
    let (slowest, fastest) = band(scales);
    vec![
        Prior::magnitude(0.3 * scales.force / scales.acceleration),
        Prior::order((slowest * fastest).sqrt(), 1.8, (0.8 * slowest, 1.3 * fastest)),
        Prior::order(0.05, 2.0, (0.005, 0.25)),
    ]
}

pub(crate) fn shapes(scales: &Scales) -> Vec<Vec<f64>> {
    let (slowest, fastest) = band(scales);
    let frequencies = (0..64).map(|k| slowest * 1.13f64.powi(k)).take_while(|w| *w <= fastest);
    frequencies.flat_map(|w| [0.02, 0.07, 0.2].map(|damping| vec![w, damping])).collect()
}

/// Frequencies that could show: from that at which the coordinate moves through its range, or once in the recordings, to a
/// decade above it, or to a dozen samples a period. What is driven in steps rings far above the frequencies at which it moves.
fn band(scales: &Scales) -> (f64, f64) {
    let slowest = scales.rate().max(TAU / scales.duration());
    (slowest, (11.6 * slowest).max(0.5 / scales.step))
}

pub(crate) fn memory_spread(_shape: &[f64], scales: &Scales, spread: &mut [f64]) {
    spread.copy_from_slice(&[0.5 * scales.half_range(), 0.7 * scales.v]);
}

/// Acceleration with which the hung mass pulls, per unit of its mass.
#[inline(always)]
pub(crate) fn pull<T: Number>(shape: &[T], at: &At<T>) -> T {
    let (w, damping) = (shape[0], shape[1]);
    w * w * (at.memory[0] - at.q()) + damping * 2.0 * w * (at.memory[1] - at.v())
}
