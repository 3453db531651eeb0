//! A hidden resonance (a mass on a spring hung on the coordinate): `mass a, a = frequency^2 (y - q) + 2 damping_ratio frequency (y' - v), y'' = -a`.

use crate::law::{Acts, Effect, ForceLaw, Law, Local, Parameter, Range, Scales, Variable};
use crate::{Dimension, Prior};

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
};

#[derive(Debug)]
struct HiddenResonance;

impl ForceLaw for HiddenResonance {
    fn basis(&self, shape: &[f64], at: &Local, memory: &[f64], basis: &mut [f64]) {
        basis[0] = pull(shape, at, memory);
    }

    fn memory(&self) -> usize {
        2
    }

    fn memory_at_rest(&self, at: &Local, memory: &mut [f64]) {
        memory.copy_from_slice(&[at.q, at.v]);
    }

    fn memory_spread(&self, _shape: &[f64], scales: &Scales, spread: &mut [f64]) {
        spread.copy_from_slice(&[0.5 * scales.half_range(), 0.7 * scales.v]);
    }

    fn memory_rate(&self, shape: &[f64], at: &Local, memory: &[f64], rate: &mut [f64]) {
        rate[0] = memory[1];
        rate[1] = -pull(shape, at, memory);
    }

    fn priors(&self, scales: &Scales) -> Vec<Prior> {
        let rate = scales.rate();
        let frequency = Prior::order(3.0 * rate, 1.8, (0.8 * rate, 15.0 * rate));
        vec![
            Prior::magnitude(0.3 * scales.force / scales.acceleration),
            frequency,
            Prior::order(0.05, 2.0, (0.005, 0.25)),
        ]
    }

    fn shapes(&self, scales: &Scales) -> Vec<Vec<f64>> {
        let slowest = scales.v / scales.half_range();
        let frequencies = (0..21).map(move |k| slowest * 1.13f64.powi(k));
        frequencies.flat_map(|w| [0.02, 0.07, 0.2].map(|damping| vec![w, damping])).collect()
    }
}

/// Acceleration with which the hung mass pulls, per unit of its mass.
fn pull(shape: &[f64], at: &Local, memory: &[f64]) -> f64 {
    let (w, damping) = (shape[0], shape[1]);
    w * w * (memory[0] - at.q) + 2.0 * damping * w * (memory[1] - at.v)
}
