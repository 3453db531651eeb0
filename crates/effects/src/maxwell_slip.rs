//! Friction that is a spring before it slips and remembers where the motion turned (Maxwell slip):
//! `-coulomb (z_1 + z_2 + z_3 + z_4) / 4`.
//!
//! The surfaces touch by four springs in parallel, each of which slips at a quarter of the dry
//! friction `coulomb`, the k-th after a travel of `s_k travel`:
//!
//! ```text
//! s_k travel z_k' = v - max(v z_k, 0) z_k
//! ```
//!
//! A spring that is being loaded gives way as `1 - z_k^2` and one that is being unloaded not at all, so
//! that small loops within large ones are closed by what the springs remember. Together their
//! stiffness is `coulomb / travel`. The `s_k` are the quarters of equal friction of the law whose
//! force grows as `coulomb (1 - exp(-x / travel))` along a path x from rest (Al-Bender, Lampaert
//! and Swevers, The generalized Maxwell-slip model, IEEE Trans. Automatic Control 50, 2005).
//!
//! With the energy `coulomb s_k travel z_k^2 / 8` of a spring, `coulomb max(v z_k, 0) z_k^2 / 4`
//! dissipates. It differs from bristles (`lugre_friction`), whose one state forgets all turning points
//! but the last.

use crate::dry_friction::{FAMILY, shared, smoothing_velocities};
use crate::{
    Acts, At, Dimension, Effect, ForceLaw, Kin, Law, Nature, Number, Parameter, Prior, Range,
    Scales, Stated, Variable,
};

pub(crate) static EFFECT: Effect = Effect {
    class: "maxwell_slip",
    words: "friction of springs that slip one after the other (Maxwell slip)",
    formula: "-coulomb mean(z_k), s_k travel z_k' = v - max(v z_k, 0) z_k, k = 1 to 4",
    parameters: &[
        Parameter::new("coulomb", Dimension::FORCE, Range::NonNegative),
        Parameter::new("travel", Dimension::COORDINATE, Range::Positive),
    ],
    depends_on: &[Variable::Velocity],
    acts: Acts::Coordinates,
    law: Law::Force(&MaxwellSlip),
    priors,
    shapes,
    nature: Nature {
        kin: Some(Kin {
            family: &FAMILY,
            shared: |p, scales| shared(p[0], 0.0, smoothing_velocities(scales)[1]),
            begun,
        }),
        memory_spread: |_, _, spread| spread.fill(0.7),
        stated: Some(Stated::friction(&[1.0], "what happens before it slips")),
        ..Nature::PLAIN
    },
};

/// Number of springs.
const SPRINGS: usize = 4;

/// The travel at which each spring slips, as a share of `travel`. Of the springs of an exponential
/// law those that slip after x to x + dx carry the share `x exp(-x) dx` of the friction, and
/// `exp(-x) dx` of the stiffness; between the quartiles 0.9613, 1.6783 and 2.6926 of the former
/// lies a quarter of the friction, over so much of the stiffness.
const SLIP: [f64; SPRINGS] = [0.404_795, 1.277_327, 2.101_194, 3.692_635];

#[derive(Debug)]
struct MaxwellSlip;

impl ForceLaw for MaxwellSlip {
    #[inline(always)]
    fn basis<T: Number>(&self, _shape: &[T], at: &At<T>) -> impl AsRef<[T]> {
        let sum = at.memory.iter().fold(T::constant(0.0), |sum, z| sum + *z);
        [sum * (-1.0 / SPRINGS as f64)]
    }

    fn memory(&self) -> usize {
        SPRINGS
    }

    fn memory_rate<T: Number>(&self, shape: &[T], at: &At<T>) -> impl AsRef<[T]> {
        let v = at.v();
        let loaded = |z: T| (v * z).max(T::constant(0.0)) * z;
        let rate = |k: usize| (v - loaded(at.memory[k])) / (shape[0] * SLIP[k]);
        [rate(0), rate(1), rate(2), rate(3)]
    }
}

fn priors(scales: &Scales) -> Vec<Prior> {
    let (reach, least) = (scales.half_range(), least_travel(scales));
    let travel = Prior::order(least + 0.05 * reach, 3.0, (least, least + reach));
    vec![Prior::magnitude(scales.force), travel]
}

fn shapes(scales: &Scales) -> Vec<Vec<f64>> {
    travels(scales).map(|travel| vec![travel]).to_vec()
}

/// The travel is not known from friction that slips at once.
fn begun(shared: &[f64], scales: &Scales) -> Vec<Vec<f64>> {
    travels(scales).map(|travel| vec![shared[0], travel]).to_vec()
}

/// Travels to begin from.
fn travels(scales: &Scales) -> [f64; 3] {
    let least = least_travel(scales);
    [0.01, 0.05, 0.2].map(|share| least + share * scales.half_range())
}

/// The first spring to slip settles at the rate `2 |v| / (s_1 travel)`, which Runge-Kutta's steps follow
/// up to 2.78 a step: at twice the usual speed, with a step a sample. What slips sooner looks like plain
/// dry friction.
fn least_travel(scales: &Scales) -> f64 {
    4.0 * scales.v * scales.step
}
