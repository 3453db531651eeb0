//! An elastic drive whose motor's side is measured: part of the inertia that the model fixes to the coordinate hangs on it
//! by a spring: `mass (a_q + a), a = frequency^2 (y - q) + 2 damping_ratio frequency (y' - v), y'' = -a`, a_q the
//! acceleration of the coordinate.
//!
//! `(M_ii - mass) q_i'' = F_i + mass a`. Where the spring is stiff y follows q, `a = -q''`, and the model is as it was.

use crate::{
    Acts, At, Dimension, Effect, ForceLaw, Kin, Law, Nature, Number, Parameter, Prior, Range,
    Scales, Variable, hidden_resonance,
};

pub(crate) static EFFECT: Effect = Effect {
    class: "elastic_drive",
    words: "an elastic drive (the load on a spring behind the motor that is measured)",
    formula: "mass (a_q + a), a = frequency^2 (y - q) + 2 damping_ratio frequency (y' - v), y'' = -a, a_q the acceleration",
    parameters: &[
        Parameter::new("mass", Dimension::new(1, -1, 2), Range::NonNegative),
        Parameter::new("frequency", Dimension::RATE, Range::Positive),
        Parameter::new("damping_ratio", Dimension::NUMBER, Range::NonNegative),
    ],
    depends_on: &[Variable::Coordinate, Variable::Velocity, Variable::Acceleration],
    acts: Acts::Coordinates,
    law: Law::Force(&ElasticDrive),
    priors,
    shapes: hidden_resonance::shapes,
    nature: Nature {
        kin: Some(Kin::of(&hidden_resonance::RESONANCES)),
        variation_of: Some(&hidden_resonance::EFFECT),
        memory_spread: hidden_resonance::memory_spread,
        ..Nature::PLAIN
    },
};

#[derive(Debug)]
struct ElasticDrive;

impl ForceLaw for ElasticDrive {
    #[inline(always)]
    fn basis<T: Number>(&self, shape: &[T], at: &At<T>) -> impl AsRef<[T]> {
        [hidden_resonance::pull(shape, at)]
    }

    #[inline(always)]
    fn inertia<T: Number>(&self, _shape: &[T], _at: &At<T>) -> impl AsRef<[T]> {
        [T::constant(-1.0)]
    }

    fn memory(&self) -> usize {
        2
    }

    fn memory_at_rest(&self, at: &At, memory: &mut [f64]) {
        memory.copy_from_slice(&[at.q(), at.v()]);
    }

    fn memory_rate<T: Number>(&self, shape: &[T], at: &At<T>) -> impl AsRef<[T]> {
        [at.memory[1], -hidden_resonance::pull(shape, at)]
    }
}

/// Some of the inertia that the model fixes to the coordinate, not all of it.
fn priors(scales: &Scales) -> Vec<Prior> {
    let [_, frequency, damping_ratio] = hidden_resonance::priors(scales)[..] else { return vec![] };
    let mass =
        Prior::near(0.5 * scales.inertia, 0.3 * scales.inertia, (0.0, 0.95 * scales.inertia));
    vec![mass, frequency, damping_ratio]
}
