//! A window and its quadrature.

use std::ops::Range;
use std::sync::Arc;

use super::super::inputs::{first_of_four, input_at, lagrange};
use super::super::motion::{InputPath, Motion};

/// Nodes and weights of the Gauss-Legendre rule of four points on \[0, 1\], exact to degree 7: a cubic times a cubic
/// times (t - r).
pub(in crate::identification) const GAUSS: [(f64, f64); 4] = [
    (0.069_431_844_202_973_71, 0.173_927_422_568_726_93),
    (0.330_009_478_207_571_87, 0.326_072_577_431_273_07),
    (0.669_990_521_792_428_1, 0.326_072_577_431_273_07),
    (0.930_568_155_797_026_3, 0.173_927_422_568_726_93),
];

/// Where the quadrature's error is above this share of the integral, the interval says nothing.
const UNRESOLVED: f64 = 0.03;
/// What the integral over such an interval may be, relative to that of a typical y^(s).
const SAYS_NOTHING: f64 = 20.0;
/// Least jump over an interval of a window with intervals that say nothing, relative to the integral of a typical
/// y^(s): without it, kernels chosen on stiff motion that is nearly free of noise follow the errors of quadrature.
const NUGGET: f64 = 5e-3;

/// A window: a stretch of motion with free initial values.
#[derive(Debug, Clone)]
pub(crate) struct WeakWindow {
    pub motion: Arc<Motion>,
    /// Estimated kernel arguments at the nodes of the quadrature, rows of d.
    pub arguments: Vec<f64>,
    /// Error of the quadrature over each interval, for each coordinate: (N - 1) x n, units of y^(s-1).
    pub(super) jumps: Vec<f64>,
    /// Whether the quadrature resolves the motion on every interval.
    resolved: bool,
    nodes: Nodes,
    /// Interval k, block j, moment r: weights of its nodes, at ((k (m + 1) + j) s + r) times their number.
    weights: Vec<f64>,
    pub(super) order: usize,
}

/// Where the integrand of an interval is known.
#[derive(Debug, Clone, Copy)]
enum Nodes {
    /// At the four samples around it.
    Samples,
    /// At the nodes of a Gauss-Legendre rule on each of so many equal parts.
    Within(usize),
}

impl Nodes {
    /// Number of nodes of an interval.
    fn count(self) -> usize {
        match self {
            Self::Samples => 4,
            Self::Within(parts) => GAUSS.len() * parts,
        }
    }

    /// Index of the first node of interval k.
    fn first(self, k: usize, samples: usize) -> usize {
        match self {
            Self::Samples => first_of_four(k, samples),
            Self::Within(_) => k * self.count(),
        }
    }
}

/// Shares of an interval at which [`WeakWindow::along`] wants the arguments, ascending.
pub(crate) fn shares_within(parts: usize) -> Vec<f64> {
    let part = |p: usize| GAUSS.iter().map(move |(node, _)| (p as f64 + node) / parts as f64);
    (0..parts).flat_map(part).collect()
}

impl WeakWindow {
    /// A window with arguments at its samples (N x d), the smoothed derivatives y^(s-1) and y^(s) of its coordinates, N x n
    /// each, and the typical size (`scale`) of each y^(s).
    pub fn sampled(
        motion: Arc<Motion>,
        arguments: Vec<f64>,
        order: usize,
        path: InputPath,
        [below, highest]: [&[f64]; 2],
        scale: &[f64],
    ) -> Self {
        let nodes = Nodes::Samples;
        let weights = interval_weights(&motion, order, path, nodes);
        let (jumps, resolved) = (Vec::new(), true);
        let mut window = Self { motion, arguments, jumps, resolved, nodes, weights, order };
        (window.jumps, window.resolved) = window.quadrature_errors(below, highest, scale);
        window
    }

    /// A window with arguments at [`shares_within`] `parts` of each interval, and what their errors may do to the integral
    /// over it.
    pub fn along(
        motion: Arc<Motion>,
        arguments: Vec<f64>,
        order: usize,
        path: InputPath,
        parts: usize,
        jumps: Vec<f64>,
    ) -> Self {
        let nodes = Nodes::Within(parts);
        let weights = interval_weights(&motion, order, path, nodes);
        Self { motion, arguments, jumps, resolved: true, nodes, weights, order }
    }

    /// Whether cubics between samples follow the motion everywhere.
    pub fn is_resolved(&self) -> bool {
        self.resolved
    }

    /// Error of the integral of the smoothed y^(s) over each interval, the largest of three intervals: what is missing to
    /// the difference of y^(s-1), or what the integral changes if the cubic gives way to a parabola; and
    /// whether it is small against the integral everywhere.
    fn quadrature_errors(&self, below: &[f64], highest: &[f64], scale: &[f64]) -> (Vec<f64>, bool) {
        let (n, samples) = (self.motion.dimension(), self.motion.samples());
        let times = self.motion.times();
        let error = |k: usize, i: usize| -> (f64, bool) {
            let first = first_of_four(k, samples);
            let weights = self.weights(k, 0, 0);
            let values: [f64; 4] = std::array::from_fn(|l| highest[(first + l) * n + i]);
            let integral: f64 = weights.iter().zip(values).map(|(w, v)| w * v).sum();
            let missing = below[(k + 1) * n + i] - below[k * n + i] - integral;
            let rougher = integral - parabola(times, first, k, values);
            let found = missing.abs().max(rougher.abs());
            let largest = values.iter().fold(0.1 * scale[i], |m, v| m.max(v.abs()));
            let unresolved = found > UNRESOLVED * (times[k + 1] - times[k]) * largest;
            let most = SAYS_NOTHING * (times[k + 1] - times[k]) * scale[i];
            (if unresolved { found.max(most) } else { found }, unresolved)
        };
        let mut jumps = vec![0.0; (samples - 1) * n];
        let mut resolved = true;
        for i in 0..n {
            let found: Vec<(f64, bool)> = (0..samples - 1).map(|k| error(k, i)).collect();
            let unresolved = found.iter().any(|(_, unresolved)| *unresolved);
            let nugget = if unresolved { NUGGET } else { 0.0 };
            resolved &= !unresolved;
            for k in 0..samples - 1 {
                let near = &found[k.saturating_sub(1)..(k + 2).min(samples - 1)];
                let least = nugget * (times[k + 1] - times[k]) * scale[i];
                jumps[k * n + i] = near.iter().map(|(jump, _)| *jump).fold(least, f64::max);
            }
        }
        (jumps, resolved)
    }

    /// Number of nodes of the quadrature.
    pub fn nodes(&self) -> usize {
        self.nodes.first(self.motion.samples() - 2, self.motion.samples()) + self.nodes.count()
    }

    /// First node of interval k.
    pub(super) fn first_node(&self, k: usize) -> usize {
        self.nodes.first(k, self.motion.samples())
    }

    /// Nodes over which a slowly varying function hardly changes: those of one rule, or each sample.
    pub(super) fn groups(&self) -> Vec<Range<usize>> {
        let size = match self.nodes {
            Nodes::Samples => 1,
            Nodes::Within(_) => GAUSS.len(),
        };
        (0..self.nodes() / size).map(|g| g * size..(g + 1) * size).collect()
    }

    /// Arguments of a node of each group, in its middle.
    pub(super) fn middle_arguments(&self) -> Vec<f64> {
        let d = self.arguments.len() / self.nodes();
        let of = |g: Range<usize>| {
            let node = (g.start + g.end) / 2;
            self.arguments[node * d..(node + 1) * d].to_vec()
        };
        self.groups().into_iter().flat_map(of).collect()
    }

    /// Weights of the nodes of interval k for input `block`: int (t_(k+1) - r)^moment / moment! u(r) ... dr.
    pub(super) fn weights(&self, k: usize, block: usize, moment: usize) -> &[f64] {
        let at = (k * (self.motion.input_count() + 1) + block) * self.order + moment;
        let count = self.nodes.count();
        &self.weights[at * count..(at + 1) * count]
    }
}

/// Integral over interval k of the parabola through three of the four samples from `first` on, those around the interval.
fn parabola(times: &[f64], first: usize, k: usize, values: [f64; 4]) -> f64 {
    let from = (k - first).min(1);
    let (t, v) = (&times[first + from..first + from + 3], &values[from..from + 3]);
    let step = times[k + 1] - times[k];
    let value = |time: f64| -> f64 {
        let share = |l: usize| {
            (0..3).filter(|&j| j != l).map(|j| (time - t[j]) / (t[l] - t[j])).product::<f64>()
        };
        (0..3).map(|l| v[l] * share(l)).sum()
    };
    GAUSS.iter().map(|&(node, weight)| weight * step * value(times[k] + node * step)).sum()
}

/// int (t_(k+1) - r)^moment / moment! u_block(r) l(r) dr for the functions l of the interval: the Lagrange polynomials of
/// four samples, or those of the Gauss-Legendre nodes.
fn interval_weights(motion: &Motion, order: usize, path: InputPath, nodes: Nodes) -> Vec<f64> {
    let (times, m) = (motion.times(), motion.input_count());
    let (samples, count) = (times.len(), nodes.count());
    let parts = if let Nodes::Within(parts) = nodes { parts } else { 1 };
    let mut weights = vec![0.0; (samples - 1) * (m + 1) * order * count];
    let mut u = vec![1.0; m + 1];
    let mut shares = vec![0.0; count];
    for k in 0..samples - 1 {
        let (start, step) = (times[k], times[k + 1] - times[k]);
        for (place, share) in shares_within(parts).into_iter().enumerate() {
            let weight = GAUSS[place % GAUSS.len()].1 / parts as f64;
            let t = start + share * step;
            input_at(motion, path, k, t, &mut u[1..]);
            shares.fill(0.0);
            match nodes {
                Nodes::Samples => {
                    let first = first_of_four(k, samples);
                    shares.copy_from_slice(&lagrange(&times[first..first + 4], t));
                }
                Nodes::Within(_) => shares[place] = 1.0,
            }
            for (j, u) in u.iter().enumerate() {
                let mut factor = weight * step * u;
                for moment in 0..order {
                    let entry = ((k * (m + 1) + j) * order + moment) * count;
                    let entries = &mut weights[entry..entry + count];
                    entries.iter_mut().zip(&shares).for_each(|(w, share)| *w += factor * share);
                    factor *= (times[k + 1] - t) / (moment + 1) as f64;
                }
            }
        }
    }
    weights
}
