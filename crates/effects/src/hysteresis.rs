//! Hysteresis (Bouc-Wen): `-stiffness z, z' = v - beta |v| z - gamma v |z|`.
//!
//! `gamma` bends the spring and `beta` makes the loop: with `S = int z / (1 - gamma |z|) dz` stored,
//!
//! ```text
//! z v = S' + beta |v| z^2 / (1 - gamma |z|),   |z| < 1 / gamma where gamma > 0,
//! ```
//!
//! so that it dissipates whatever the sign of gamma. A positive one softens: z saturates after a
//! travel of `1 / (beta + gamma)`. A negative one stiffens, as dampers do whose loop is pinched; where
//! `beta + gamma` is negative, z grows with the travel and has no limit of its own.
//!
//! Without beta there is no loop but a spring that is bent, which is another effect. So what is fitted of
//! gamma is its ratio to beta, which has bounds; and what is fitted of the stiffness is the force
//! `stiffness / beta` that the loop is as high as: where it saturates after a small travel, as bristles
//! do, the spring is stiff beyond all that moves the machine, but the force is one of its forces.

use crate::{
    Acts, At, Dimension, Effect, ForceLaw, Law, Nature, Number, Parameter, Prior, Range, Scales,
    Variable,
};

pub(crate) static EFFECT: Effect = Effect {
    class: "hysteresis",
    words: "hysteresis (Bouc-Wen)",
    formula: "-stiffness z, z' = v - beta |v| z - gamma v |z|",
    parameters: &[
        Parameter::new("stiffness", Dimension::new(1, -1, 0), Range::NonNegative),
        Parameter::new("beta", Dimension::new(0, -1, 0), Range::Positive),
        Parameter::new("gamma", Dimension::new(0, -1, 0), Range::Any),
    ],
    depends_on: &[Variable::Velocity],
    acts: Acts::Coordinates,
    law: Law::Force(&Hysteresis),
    priors,
    shapes,
    nature: Nature { memory_spread, ..Nature::PLAIN },
};

#[derive(Debug)]
struct Hysteresis;

impl ForceLaw for Hysteresis {
    #[inline(always)]
    fn basis<T: Number>(&self, shape: &[T], at: &At<T>) -> impl AsRef<[T]> {
        [-(at.memory[0] * shape[0])]
    }

    fn internal(&self, physical: &[f64]) -> Vec<f64> {
        let [stiffness, beta, gamma] = [physical[0], physical[1], physical[2]];
        vec![stiffness / beta, beta, gamma / beta]
    }

    fn physical(&self, internal: &[f64]) -> Vec<f64> {
        let [height, beta, ratio] = [internal[0], internal[1], internal[2]];
        vec![height * beta, beta, ratio * beta]
    }

    fn memory(&self) -> usize {
        1
    }

    fn memory_rate<T: Number>(&self, shape: &[T], at: &At<T>) -> impl AsRef<[T]> {
        let (v, z) = (at.v(), at.memory[0]);
        let (beta, gamma) = (shape[0], shape[1] * shape[0]);
        [v - beta * v.abs() * z - gamma * v * z.abs()]
    }
}

/// How far the loop is from saturation is open, and the sign of gamma. Materials have a gamma of at most beta
/// either way (Erlicher and Point, 2004); pinched dampers may have more.
fn priors(scales: &Scales) -> Vec<Prior> {
    let bend = 0.5 / (0.3 * scales.stroke);
    vec![
        Prior::magnitude(2.0 * scales.force / (scales.half_range() * bend)),
        Prior::order(bend, 3.0, (0.03 / scales.half_range(), 25.0 / scales.stroke)),
        Prior::near(0.0, 1.0, (-3.0, 3.0)),
    ]
}

/// Loops that unload elastically (equal beta and gamma), as they load (no gamma), and faster than
/// that. With beta alone they saturate after a travel of `1 / (beta + gamma)`.
fn shapes(scales: &Scales) -> Vec<Vec<f64>> {
    let travel = [0.05, 0.1, 0.2, 0.4, 0.8].map(|share| share * scales.half_range());
    let loops = |d: f64| [(0.5, 1.0), (1.0, 0.0), (0.5, -1.0)].map(|(b, ratio)| vec![b / d, ratio]);
    travel.into_iter().flat_map(loops).collect()
}

/// Up to saturation, or through the range where there is none.
fn memory_spread(shape: &[f64], scales: &Scales, spread: &mut [f64]) {
    let saturated = 1.0 / (shape[0] * (1.0 + shape[1])).max(f64::MIN_POSITIVE);
    spread[0] = saturated.min(scales.half_range());
}
