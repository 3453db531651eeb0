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

use crate::law::{Acts, Effect, ForceLaw, Law, Local, Parameter, Range, Scales, Variable};
use crate::{Dimension, Prior};

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
};

#[derive(Debug)]
struct UnknownFunction;

impl ForceLaw for UnknownFunction {
    fn amplitudes(&self) -> usize {
        KNOTS
    }

    fn basis(&self, shape: &[f64], at: &Local, _memory: &[f64], basis: &mut [f64]) {
        let x = match EFFECT.depends_on.get(shape[2] as usize) {
            Some(Variable::Velocity) => at.v,
            Some(Variable::Time) => at.t,
            _ => at.q,
        };
        basis.fill(0.0);
        let (from, to) = (shape[0], shape[1]);
        let place = ((x - from) / (to - from)).clamp(0.0, 1.0) * (KNOTS - 1) as f64;
        // A curve without a length has one force everywhere.
        let place = if place.is_nan() { 0.0 } else { place };
        let k = (place as usize).min(KNOTS - 2);
        let s = place - k as f64;
        let (ahead, behind) = (s * s * (3.0 - 2.0 * s), s * (1.0 - s) * (1.0 - s));
        basis[k] += 1.0 - ahead;
        basis[k + 1] += ahead;
        add_slope(basis, k, behind);
        add_slope(basis, k + 1, -s * s * (1.0 - s));
    }

    fn priors(&self, scales: &Scales) -> Vec<Prior> {
        let mut priors = vec![Prior::amplitude(0.6 * scales.force); KNOTS];
        priors.extend([Prior::Fixed; 3]);
        priors
    }

    /// A curve is learned, not screened beside formulas: it fits whatever they fit.
    fn shapes(&self, _scales: &Scales) -> Vec<Vec<f64>> {
        vec![]
    }
}

/// Add the slope at a knot with a weight: a difference of the values beside it.
fn add_slope(basis: &mut [f64], knot: usize, weight: f64) {
    if (1..KNOTS - 1).contains(&knot) {
        basis[knot + 1] += 0.5 * weight;
        basis[knot - 1] -= 0.5 * weight;
    }
}
