//! A learned curve over one variable of its channel: `f(over), through force at equidistant knots`.
//!
//! With `n` knots `x_k = from + k h`, `h = (to - from) / (n - 1)`, and the force `a_k` there, the
//! curve between two knots is the cubic with the values `a_k` and the slopes
//!
//! ```text
//! m_k = (a_{k+1} - a_{k-1}) / (2 h) inside,  0 at both ends
//! ```
//!
//! (the cardinal spline of Catmull and Rom, Computer Aided Geometric Design, 1974, with tension 0).
//! It is constant beyond the ends and has a continuous slope everywhere, is linear in the
//! values, and a value changes the force of its four neighbouring intervals alone.

use crate::{
    Acts, At, Dimension, Effect, ForceLaw, Law, Nature, Number, Parameter, Prior, Range, Scales,
    Variable,
};

/// Number of knots.
pub(crate) const KNOTS: usize = 24;

pub(crate) static EFFECT: Effect = Effect {
    class: "unknown_function",
    words: "a force that no formula of the catalogue describes",
    formula: "f(over), through force at equidistant knots between from and to, constant beyond",
    parameters: &[
        Parameter::numbers("force", Dimension::FORCE, Range::Any, KNOTS),
        Parameter::new("from", Dimension::VARIABLE, Range::Any),
        Parameter::new("to", Dimension::VARIABLE, Range::Any),
        Parameter::variable("over"),
    ],
    depends_on: &[Variable::Coordinate, Variable::Velocity, Variable::Time],
    acts: Acts::CoordinatesAndStates,
    law: Law::Force(&UnknownFunction),
    priors,
    shapes,
    nature: Nature::PLAIN,
};

#[derive(Debug)]
struct UnknownFunction;

impl ForceLaw for UnknownFunction {
    fn amplitudes(&self) -> usize {
        KNOTS
    }

    #[inline(always)]
    fn basis<T: Number>(&self, shape: &[T], at: &At<T>) -> impl AsRef<[T]> {
        let (k, s) = place(shape, at);
        let mut basis = [T::constant(0.0); KNOTS];
        for (i, weight) in (0..).zip(weights(k, s)) {
            // Beside either end there is no knot, and no weight.
            if let Some(b) = (k + i).checked_sub(1).and_then(|knot| basis.get_mut(knot)) {
                *b = weight;
            }
        }
        basis
    }

    /// Few knots have a weight.
    #[inline(always)]
    fn force<T: Number>(&self, amplitudes: &[T], shape: &[T], at: &At<T>) -> T {
        let (k, s) = place(shape, at);
        let value = |i: usize| (k + i).checked_sub(1).and_then(|knot| amplitudes.get(knot));
        let terms = (0..4).zip(weights(k, s));
        terms.fold(T::constant(0.0), |sum, (i, w)| value(i).map_or(sum, |a| sum + *a * w))
    }
}

fn priors(scales: &Scales) -> Vec<Prior> {
    let mut priors = vec![Prior::amplitude(0.6 * scales.force); KNOTS];
    priors.extend([Prior::Fixed; 3]);
    priors
}

/// A curve is learned, not screened beside formulas: it fits whatever they fit.
fn shapes(_scales: &Scales) -> Vec<Vec<f64>> {
    vec![]
}

/// The interval in which a curve of this shape is evaluated, and how far into it, from 0 to 1.
#[inline(always)]
fn place<T: Number>(shape: &[T], at: &At<T>) -> (usize, T) {
    let x = match EFFECT.depends_on.get(shape[2].value() as usize) {
        Some(Variable::Velocity) => at.v(),
        Some(Variable::Time) => T::constant(at.t),
        _ => at.q(),
    };
    let (none, all) = (T::constant(0.0), T::constant(1.0));
    let share = ((x - shape[0]) / (shape[1] - shape[0])).clamp(none, all);
    // A curve without a length has one force everywhere.
    let share = if share.value().is_nan() { none } else { share };
    let place = share * (KNOTS - 1) as f64;
    let k = (place.value() as usize).min(KNOTS - 2);
    (k, place - k as f64)
}

/// Weights of the knots k - 1, k, k + 1 and k + 2 at `s` of the way from k to k + 1. The slope at
/// a knot is a difference of the values beside it, and 0 at both ends.
#[inline(always)]
fn weights<T: Number>(k: usize, s: T) -> [T; 4] {
    let rest = -s + 1.0;
    let ahead = s * s * (-s * 2.0 + 3.0);
    let none = T::constant(0.0);
    let behind = if k > 0 { s * rest * rest * 0.5 } else { none };
    let beyond = if k + 2 < KNOTS { s * s * rest * -0.5 } else { none };
    [-behind, -ahead + 1.0 - beyond, ahead + behind, beyond]
}
