//! What a channel lacks beside what is named, as a force of its own motion without a formula.
//!
//! ```text
//! f(q, v) = sum_kl a_kl h_k(q) h_l(v),   a ~ N(0, s^2 K_q (x) K_v),   K(d) = (1 + d) e^-d
//! ```
//!
//! with hat functions h on equidistant knots and the kernel of Matern of smoothness 3/2 over the
//! distance d, in lengths, of two knots: no law is exactly reality's, and what one leaves is about as
//! smooth as this. Its size s and the lengths are not known: what it gains is the mean over some of
//! either, each as likely as the others. Of a first-order state it is `f(x)`.

use super::{Amplitudes, Over, Screen};
use crate::probability::log_sum_exp;
use crate::range::between_knots;
use lacuna_occupation::{Kernel, Matern, Smoothness};
use nalgebra::DMatrix;

/// Knots along each of two variables.
const KNOTS: usize = 10;
/// Knots along a variable that is alone.
const ALONE: usize = 24;
/// Sizes, relative to the force that moves the channel.
const SIZES: [f64; 5] = [0.003, 0.01, 0.03, 0.1, 0.3];
/// Lengths of the kernel, relative to the range of a variable.
const LENGTHS: [f64; 3] = [0.2, 0.5, 1.5];

/// Equidistant knots over the range of an entry of the state.
struct Axis {
    state: usize,
    range: (f64, f64),
    knots: usize,
}

impl Axis {
    /// Root of the kernel's matrix at the knots.
    fn root(&self, length: f64) -> Option<DMatrix<f64>> {
        let widths = vec![3f64.sqrt() * length];
        let kernel = Matern { smoothness: Smoothness::ThreeHalves, widths };
        let at = |k: usize| [k as f64 / (self.knots - 1) as f64];
        let gram = |i, j| kernel.evaluate(&at(i), &at(j));
        Some(DMatrix::from_fn(self.knots, self.knots, gram).cholesky()?.unpack())
    }
}

impl Screen<'_> {
    /// Nats that a force of its own motion gains on a channel; none for one that never moves.
    #[must_use]
    pub fn remainder(&self, channel: usize) -> Option<f64> {
        let axes = self.axes(channel)?;
        let normal = self.of_channel(channel, &axes)?;
        let force = self.problem.force_scale(channel);
        let lengths = |axis: &Axis| -> Option<Vec<DMatrix<f64>>> {
            LENGTHS.iter().map(|length| axis.root(*length)).collect()
        };
        let first = lengths(&axes[0])?;
        let second = match axes.get(1) {
            Some(axis) => lengths(axis)?,
            None => vec![DMatrix::identity(1, 1)],
        };
        let mut gains = vec![];
        for root in first.iter().flat_map(|a| second.iter().map(move |b| a.kronecker(b))) {
            let whitened = normal.through(&root);
            let sizes = SIZES.iter().map(|size| vec![size * force; root.ncols()]);
            gains.extend(sizes.filter_map(|sd| Some(self.posterior(&whitened, &sd)?.gain)));
        }
        let gain = log_sum_exp(gains.iter().copied()) - (gains.len() as f64).ln();
        gain.is_finite().then_some(gain)
    }

    /// The coordinate and the velocity of a channel, or its first-order state, over their ranges.
    fn axes(&self, channel: usize) -> Option<Vec<Axis>> {
        let model = self.problem.model;
        let place = model.place(channel);
        let axis = |over, state, knots| {
            let range = self.range(channel, over);
            (range.1 > range.0).then_some(Axis { state, range, knots })
        };
        if !model.is_coordinate(channel) {
            return Some(vec![axis(Over::Coordinate, place.q, ALONE)?]);
        }
        Some(vec![axis(Over::Coordinate, place.q, KNOTS)?, axis(Over::Velocity, place.v, KNOTS)?])
    }

    /// Normal equations of the force at every knot.
    fn of_channel(&self, channel: usize, axes: &[Axis]) -> Option<Amplitudes> {
        let count = axes.iter().map(|a| a.knots).product();
        let parts = self.recordings.iter().map(|along| {
            let mut series = vec![vec![0.0; along.motion.len()]; count];
            let states = (0..along.motion.len()).map(|k| along.motion.state(k));
            for (k, state) in states.enumerate() {
                for (knot, weight) in weights(axes, state) {
                    series[knot][k] = weight;
                }
            }
            self.of_forces(channel, &series, along)
        });
        let sum = parts.reduce(Amplitudes::plus)?;
        sum.is_finite().then_some(sum)
    }
}

/// The knots around a state, the last variable's side by side, with their weights.
fn weights(axes: &[Axis], state: &[f64]) -> Vec<(usize, f64)> {
    axes.iter().fold(vec![(0, 1.0)], |around, axis| {
        let (k, share) = between_knots(state[axis.state], axis.range, axis.knots);
        let both = |(at, weight): (usize, f64)| {
            let first = at * axis.knots + k;
            [(first, weight * (1.0 - share)), (first + 1, weight * share)]
        };
        around.into_iter().flat_map(both).collect()
    })
}
