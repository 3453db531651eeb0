//! Friction of bristles (LuGre): `-coulomb z, travel z' = v - |v| z / (1 + (static_ratio - 1) exp(-(v / stribeck_velocity)^2))`.
//!
//! The surfaces touch by bristles that bend before they slip, as springs of stiffness
//! `coulomb / travel`. z is the friction in units of `coulomb`: at constant speed it settles within a
//! few travels on the Stribeck curve
//!
//! ```text
//! h(v) = 1 + (static_ratio - 1) exp(-(v / stribeck_velocity)^2),
//! ```
//!
//! which is `static_ratio` when it creeps and 1 when fast. With h = 1 it is Dahl's law. With the energy
//! `coulomb travel z^2 / 2` of the bristles, `coulomb |v| z^2 / h` dissipates. z changes at the rate
//! `|v| / travel`: travels that are covered well within a sample are not looked for.

use crate::dry_friction::{FAMILY, shared};
use crate::{
    Acts, At, Dimension, Effect, ForceLaw, Kin, Law, Nature, Number, Parameter, Prior, Range,
    Scales, Stated, Variable,
};

pub(crate) static EFFECT: Effect = Effect {
    class: "lugre_friction",
    words: "friction of bristles that bend before they slip (LuGre)",
    formula: "-coulomb z, travel z' = v - |v| z / (1 + (static_ratio - 1) exp(-(v / stribeck_velocity)^2))",
    parameters: &[
        Parameter::new("coulomb", Dimension::FORCE, Range::NonNegative),
        Parameter::new("static_ratio", Dimension::NUMBER, Range::Positive),
        Parameter::new("stribeck_velocity", Dimension::VELOCITY, Range::Positive),
        Parameter::new("travel", Dimension::COORDINATE, Range::Positive),
    ],
    depends_on: &[Variable::Velocity],
    acts: Acts::Coordinates,
    law: Law::Force(&LugreFriction),
    priors,
    shapes,
    nature: Nature {
        // A sign is sharp beside the peak.
        kin: Some(Kin { family: &FAMILY, shared: |p, _| shared(p[0], 0.0, 0.1 * p[2]), begun }),
        memory_spread: |_, _, spread| spread[0] = 0.7,
        stated: Some(Stated::friction(&[1.0], "what happens before it slips")),
        ..Nature::PLAIN
    },
};

#[derive(Debug)]
struct LugreFriction;

impl ForceLaw for LugreFriction {
    #[inline(always)]
    fn basis<T: Number>(&self, _shape: &[T], at: &At<T>) -> impl AsRef<[T]> {
        [-at.memory[0]]
    }

    fn memory(&self) -> usize {
        1
    }

    fn memory_rate<T: Number>(&self, shape: &[T], at: &At<T>) -> impl AsRef<[T]> {
        let [ratio, stribeck, travel] = [shape[0], shape[1], shape[2]];
        let (v, z) = (at.v(), at.memory[0]);
        let creep = (-(v / stribeck).powi(2)).exp();
        let settled = ratio * creep - (creep - 1.0);
        [(v - v.abs() * z / settled) / travel]
    }
}

fn priors(scales: &Scales) -> Vec<Prior> {
    vec![
        Prior::magnitude(scales.force),
        Prior::order(1.4, 1.4, (1.0, 4.0)),
        Prior::order(0.35 * scales.v, 2.5, (0.05 * scales.v, 4.0 * scales.v)),
        travel_prior(scales),
    ]
}

fn shapes(scales: &Scales) -> Vec<Vec<f64>> {
    let curves = [(1.0, 0.4), (1.7, 0.1), (1.7, 0.4), (1.7, 1.2)];
    let bent = |travel: f64| curves.map(|(ratio, v)| vec![ratio, v * scales.v, travel]);
    travels(scales).into_iter().flat_map(bent).collect()
}

/// The travel is not known from friction that slips at once.
fn begun(shared: &[f64], scales: &Scales) -> Vec<Vec<f64>> {
    let bent = |travel: f64| vec![0.9 * shared[0], 1.3, 0.4 * scales.v, travel];
    travels(scales).map(bent).to_vec()
}

/// Travels to begin from.
fn travels(scales: &Scales) -> [f64; 3] {
    let least = least_travel(scales);
    [0.01, 0.05, 0.2].map(|share| least + share * scales.half_range())
}

/// A small part of the range.
fn travel_prior(scales: &Scales) -> Prior {
    let (reach, least) = (scales.half_range(), least_travel(scales));
    Prior::order(least + 0.05 * reach, 3.0, (least, least + reach))
}

/// What the usual motion covers in half a sample. Where it turns it is slower, and bristles show that slip within a
/// sample elsewhere: at four times the usual speed that is eight time constants of z, which a few Runge-Kutta
/// steps a sample still follow. What slips sooner looks like plain dry friction.
fn least_travel(scales: &Scales) -> f64 {
    0.5 * scales.v * scales.step
}
