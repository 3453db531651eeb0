//! Backlash (a spring reached through play): `-stiffness z, z follows q through a play of width gap`.
//!
//! The play operator holds its far side `z` while `|q - z| < gap / 2` and takes it along with q
//! at the edge. Here its edge is a ramp of a twentieth of half the gap, so that the law is
//! continuous: with `d = q - z`
//!
//! ```text
//! z' = |v| sign(d) clamp(e + p, 0, 1 + p),  e = (|d| - gap/2) / (gap/40),  p = 1 if v pushes (v d > 0), else 0
//! ```
//!
//! Pushed, `d` settles on the edge itself, so that after a reversal the whole gap is lost
//! motion. Outside the play, where only a step of an integrator or a wrong initial state can
//! put it, z runs back as fast as q moves and no faster: every rate is bounded by `2 |v|`, which
//! no step makes unstable however narrow the gap, and the law keeps no time scale of its own.
//!
//! The force lags behind the coordinate: a cycle of amplitude `A` puts
//! `stiffness gap (2 A - gap)` in. It is what a spring-like restoring force does that sees the
//! coordinate behind play, such as a servo with its sensor there: it makes limit cycles.

use crate::{
    Acts, At, Dimension, Effect, ForceLaw, Law, Nature, Number, Parameter, Prior, Range, Scales,
    Variable,
};

pub(crate) static EFFECT: Effect = Effect {
    class: "backlash",
    words: "backlash (a spring reached through play)",
    formula: "-stiffness z, z stays while |q - z| < gap/2 and then moves with q",
    parameters: &[
        Parameter::new("stiffness", Dimension::new(1, -1, 0), Range::NonNegative),
        Parameter::new("gap", Dimension::COORDINATE, Range::Positive),
    ],
    depends_on: &[Variable::Coordinate, Variable::Velocity],
    acts: Acts::Coordinates,
    law: Law::Force(&Backlash),
    priors,
    shapes,
    nature: Nature { memory_spread, ..Nature::PLAIN },
};

/// Width of the edge in halves of the gap.
const EDGE: f64 = 0.05;

#[derive(Debug)]
struct Backlash;

impl ForceLaw for Backlash {
    #[inline(always)]
    fn basis<T: Number>(&self, _shape: &[T], at: &At<T>) -> impl AsRef<[T]> {
        [-at.memory[0]]
    }

    fn memory(&self) -> usize {
        1
    }

    /// In the middle of the play.
    fn memory_at_rest(&self, at: &At, memory: &mut [f64]) {
        memory[0] = at.q();
    }

    fn memory_rate<T: Number>(&self, shape: &[T], at: &At<T>) -> impl AsRef<[T]> {
        let half = (shape[0] * 0.5).max(T::constant(f64::MIN_POSITIVE));
        let offset = at.q() - at.memory[0];
        let excess = (offset.abs() / half - 1.0) / EDGE;
        let pushed = if at.v().value() * offset.value() > 0.0 { 1.0 } else { 0.0 };
        let share = (excess + pushed).clamp(T::constant(0.0), T::constant(1.0 + pushed));
        [at.v().abs() * share * offset.value().signum()]
    }
}

fn priors(scales: &Scales) -> Vec<Prior> {
    let reach = scales.half_range();
    let gap = Prior::order(0.15 * reach, 3.0, (0.005 * reach, 1.8 * reach));
    vec![Prior::magnitude(scales.force / reach), gap]
}

/// From a hundredth of the coordinate's range to most of it.
fn shapes(scales: &Scales) -> Vec<Vec<f64>> {
    let gaps = [0.02, 0.05, 0.1, 0.2, 0.4, 0.8, 1.4];
    gaps.map(|share| vec![share * scales.half_range()]).to_vec()
}

fn memory_spread(shape: &[f64], _scales: &Scales, spread: &mut [f64]) {
    spread[0] = 0.5 * shape[0];
}
