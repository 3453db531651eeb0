//! What a channel lacks beside what is named, as a force of its own motion without a formula.
//!
//! ```text
//! f(q, v) = sum_kl a_kl h_k(q) h_l(v),   a ~ N(0, s^2 K_q (x) K_v),   K(d) = (1 + d) e^-d or e^(-d^2/2)
//! ```
//!
//! with hat functions h on equidistant knots and, over the distance d of two knots in lengths, a kernel
//! of Matern of smoothness 3/2 or one of Gauss: no law is exactly reality's, and what one leaves has
//! edges as friction has them or is as smooth as a spring. It may depend on one of the two alone, `f(q)` or
//! `f(v)`; its size s and the lengths are not known either. What it gains is the mean over all of these,
//! each as likely as the others. Of a first-order state it is `f(x)`.

use super::{Amplitudes, Over, Screen};
use crate::probability::log_sum_exp;
use crate::range::between_knots;
use lacuna_occupation::{Gaussian, Kernel, Matern, Smoothness};
use nalgebra::DMatrix;
use rayon::prelude::*;

/// Knots along each of two variables.
const KNOTS: usize = 10;
/// Knots along a variable that is alone.
const ALONE: usize = 48;
/// Sizes, relative to the force that moves the channel.
const SIZES: [f64; 5] = [0.003, 0.01, 0.03, 0.1, 0.3];
/// Lengths of the kernel, relative to the range of a variable.
const LENGTHS: [f64; 4] = [0.05, 0.2, 0.5, 1.5];

/// What the Gaussian kernel's matrix lacks to be positive in double precision: a noise of that variance
/// at every knot.
const ROUNDING: f64 = 1e-9;

/// The kernels of this length of a force that is once differentiable, and of one that is ever.
fn kernels(length: f64) -> [Box<dyn Kernel>; 2] {
    let widths = vec![3f64.sqrt() * length];
    let matern = Matern { smoothness: Smoothness::ThreeHalves, widths };
    [Box::new(matern), Box::new(Gaussian { widths: vec![length] })]
}

/// Equidistant knots over the range of an entry of the state.
struct Axis {
    state: usize,
    range: (f64, f64),
    knots: usize,
}

impl Axis {
    /// Between two knots, relative to the range: nothing shorter shows.
    fn spacing(&self) -> f64 {
        1.0 / (self.knots - 1) as f64
    }

    /// Root of a kernel's matrix at the knots.
    fn root(&self, kernel: &dyn Kernel) -> Option<DMatrix<f64>> {
        let at = |k: usize| [k as f64 * self.spacing()];
        let entry = |i, j| kernel.evaluate(&at(i), &at(j)) + if i == j { ROUNDING } else { 0.0 };
        Some(DMatrix::from_fn(self.knots, self.knots, entry).cholesky()?.unpack())
    }
}

impl Screen<'_> {
    /// Nats that a force of its own motion gains on a channel; none for one that never moves.
    #[must_use]
    pub fn remainder(&self, channel: usize) -> Option<f64> {
        let ways = self.ways(channel);
        let gains: Option<Vec<f64>> = ways.par_iter().map(|w| self.gain_over(channel, w)).collect();
        mean(&gains.filter(|g| !g.is_empty())?)
    }

    /// Nats that a force gains that depends on some variables.
    fn gain_over(&self, channel: usize, axes: &[Axis]) -> Option<f64> {
        let normal = self.of_channel(channel, axes)?;
        let force = self.problem.force_scale(channel);
        let mut roots = vec![];
        for smooth in 0..2 {
            let mut of_all = vec![DMatrix::identity(1, 1)];
            for axis in axes {
                let root = |length: &f64| axis.root(&*kernels(*length)[smooth]);
                let lengths = LENGTHS.iter().filter(|l| **l >= axis.spacing());
                let of_axis: Vec<DMatrix<f64>> = lengths.map(root).collect::<Option<_>>()?;
                let beside =
                    |r: &DMatrix<f64>| of_axis.iter().map(|a| r.kronecker(a)).collect::<Vec<_>>();
                of_all = of_all.iter().flat_map(beside).collect();
            }
            roots.extend(of_all);
        }
        let of_root = |root: &DMatrix<f64>| {
            let whitened = normal.through(root);
            let sizes = SIZES.iter().map(|size| vec![size * force; root.ncols()]);
            sizes.filter_map(|sd| Some(self.posterior(&whitened, &sd)?.gain)).collect::<Vec<_>>()
        };
        let gains: Vec<Vec<f64>> = roots.par_iter().map(of_root).collect();
        mean(&gains.concat())
    }

    /// What the force may depend on: the coordinate of a channel, its velocity, or both; its
    /// first-order state; each over its range.
    fn ways(&self, channel: usize) -> Vec<Vec<Axis>> {
        let model = self.problem.model;
        let place = model.place(channel);
        let axis = |over, state, knots| {
            let range = self.range(channel, over);
            (range.1 > range.0).then_some(Axis { state, range, knots })
        };
        let q = |knots| axis(Over::Coordinate, place.q, knots);
        if !model.is_coordinate(channel) {
            return q(ALONE).into_iter().map(|a| vec![a]).collect();
        }
        let v = |knots| axis(Over::Velocity, place.v, knots);
        let both = q(KNOTS).zip(v(KNOTS)).map(|(q, v)| vec![q, v]);
        let alone = [q(ALONE), v(ALONE)].into_iter().flatten().map(|a| vec![a]);
        alone.chain(both).collect()
    }

    /// Normal equations of the force at every knot.
    fn of_channel(&self, channel: usize, axes: &[Axis]) -> Option<Amplitudes> {
        let count = axes.iter().map(|a| a.knots).product();
        let parts = self.recordings.par_iter().map(|along| {
            let mut series = vec![vec![0.0; along.motion.len()]; count];
            let states = (0..along.motion.len()).map(|k| along.motion.state(k));
            for (k, state) in states.enumerate() {
                for (knot, weight) in weights(axes, state) {
                    series[knot][k] = weight;
                }
            }
            self.of_forces(channel, &series, along)
        });
        let parts: Vec<Amplitudes> = parts.collect();
        let sum = parts.into_iter().reduce(Amplitudes::plus)?;
        sum.is_finite().then_some(sum)
    }
}

/// Nats of one of several, each as likely as the others: `log mean exp`.
fn mean(gains: &[f64]) -> Option<f64> {
    let gain = log_sum_exp(gains.iter().copied()) - (gains.len() as f64).ln();
    gain.is_finite().then_some(gain)
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
