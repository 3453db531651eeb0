//! Trajectories of the identified model itself, and what they owe to f, g and the initial state.
//!
//! ```text
//! z = (y, y', ..., y^(s-1)),   z' = A(z, u)
//! dz(t) = Psi(t, 0) dz(0) + int_0^t Psi(t, r) B [df + dg u](z(r)) dr,   Psi' = dA/dz Psi
//! ```
//!
//! To first order, so the weak form of [`super::weak`] again, along the model's own trajectory and with the model's
//! adjoint Psi(t, r) B for a test function where the weak form has (t - r)^(s-1) / (s-1)!. What it gains: it is right
//! between samples however stiff the motion is, and an error of the trajectory costs nothing to first order (errors in
//! variables).

use faer::Mat;

use super::field::{Field, Room};
use super::inputs::input_at;
use super::matrix::{Matrix, transition};
use super::motion::{InputPath, Motion};

/// Times the eigenvalue of largest modulus, the longest step of the classical Runge-Kutta method.
const STEP: f64 = 0.4;
/// Most steps from sample to sample.
const MOST_STEPS: usize = 64;
/// A trajectory is lost where it leaves the data by this many spreads.
const LOST: f64 = 20.0;

/// What all windows share.
#[derive(Debug, Clone)]
pub(crate) struct Setting {
    pub order: usize,
    pub path: InputPath,
    /// Middle and half range of each state in the data.
    pub middle: Vec<f64>,
    pub half_range: Vec<f64>,
}

/// A window with its initial state.
#[derive(Debug, Clone)]
pub(crate) struct Shot {
    pub motion: Motion,
    pub initial: Vec<f64>,
    /// Runge-Kutta steps from each sample to the next.
    pub steps: usize,
}

/// Model trajectory of a window at its samples.
pub(crate) struct Run {
    /// z, N x (s n).
    pub states: Vec<f64>,
    /// Psi(t_k, 0), N x (s n) x (s n).
    pub transitions: Vec<f64>,
}

impl Setting {
    pub fn states(&self) -> usize {
        self.middle.len()
    }

    fn is_lost(&self, z: &[f64]) -> bool {
        let states = z.iter().zip(&self.middle).zip(&self.half_range);
        let near = |((z, c), h): ((&f64, &f64), &f64)| (z - c).abs() <= LOST * h;
        // Not a number is not near.
        !states.into_iter().all(near)
    }
}

/// Works out trajectories of one window after another.
pub(crate) struct Integrator<'f> {
    field: &'f Field,
    setting: &'f Setting,
    room: Room,
    kernel_values: Vec<f64>,
    stages: [Vec<f64>; 4],
    trial: Vec<f64>,
    jacobian: Vec<f64>,
    u: Vec<f64>,
}

impl<'f> Integrator<'f> {
    pub fn new(field: &'f Field, setting: &'f Setting, inputs: usize) -> Self {
        let states = setting.states();
        Self {
            field,
            setting,
            room: field.room(),
            kernel_values: vec![0.0; field.features()],
            stages: std::array::from_fn(|_| vec![0.0; states]),
            trial: vec![0.0; states],
            jacobian: vec![0.0; field.dimension * field.arguments],
            u: vec![0.0; inputs],
        }
    }

    /// z' at z for the input in `self.u`, into stage `k`; kernel values stay in `self.kernel_values`.
    fn slope(&mut self, z: &[f64], k: usize) {
        let n = self.field.dimension;
        let lower = z.len() - n;
        let x = &z[..self.field.arguments];
        let (out, values) = (&mut self.stages[k], &mut self.kernel_values);
        out[..lower].copy_from_slice(&z[n..]);
        self.field.value(x, &self.u, values, &mut self.room, &mut out[lower..]);
    }

    /// One step of the classical Runge-Kutta method from `z` at time t in interval k; stage 0 holds z' at the start.
    fn step(&mut self, shot: &Shot, k: usize, t: f64, h: f64, z: &[f64], next: &mut [f64]) {
        let path = self.setting.path;
        let at = |s: &mut Self, t: f64| input_at(&shot.motion, path, k, t, &mut s.u);
        at(self, t);
        self.slope(z, 0);
        at(self, t + 0.5 * h);
        for (stage, share) in [(1, 0.5), (2, 0.5), (3, 1.0)] {
            if stage == 3 {
                at(self, t + h);
            }
            let mut trial = std::mem::take(&mut self.trial);
            let before = &self.stages[stage - 1];
            trial.iter_mut().zip(z).zip(before).for_each(|((y, z), d)| *y = z + share * h * d);
            self.slope(&trial, stage);
            self.trial = trial;
        }
        let [a, b, c, d] = &self.stages;
        for (i, next) in next.iter_mut().enumerate() {
            *next = z[i] + h / 6.0 * (a[i] + 2.0 * (b[i] + c[i]) + d[i]);
        }
    }

    /// States at the samples; none where the trajectory leaves the data.
    pub fn states(&mut self, shot: &Shot) -> Option<Vec<f64>> {
        let count = self.setting.states();
        let times = shot.motion.times();
        let mut states = Vec::with_capacity(times.len() * count);
        let (mut z, mut next) = (shot.initial.clone(), vec![0.0; count]);
        states.extend_from_slice(&z);
        for k in 0..times.len() - 1 {
            let h = (times[k + 1] - times[k]) / shot.steps as f64;
            for j in 0..shot.steps {
                self.step(shot, k, times[k] + j as f64 * h, h, &z, &mut next);
                std::mem::swap(&mut z, &mut next);
                if self.setting.is_lost(&z) {
                    return None;
                }
            }
            states.extend_from_slice(&z);
        }
        Some(states)
    }

    /// States at the samples, and at these shares of every interval, ascending: cubics with the slopes of the
    /// Runge-Kutta steps. None where the trajectory leaves the data.
    pub fn between(&mut self, shot: &Shot, shares: &[f64]) -> Option<[Vec<f64>; 2]> {
        let (times, count) = (shot.motion.times(), shot.initial.len());
        let mut inner = Vec::with_capacity((times.len() - 1) * shares.len() * count);
        let (mut z, mut next) = (shot.initial.clone(), vec![0.0; count]);
        let mut states = z.clone();
        for k in 0..times.len() - 1 {
            let h = (times[k + 1] - times[k]) / shot.steps as f64;
            for j in 0..shot.steps {
                let t = times[k] + j as f64 * h;
                self.step(shot, k, t, h, &z, &mut next);
                if self.setting.is_lost(&next) {
                    return None;
                }
                let start = self.stages[0].clone();
                input_at(&shot.motion, self.setting.path, k, t + h, &mut self.u);
                self.slope(&next, 0);
                let place = |share: &f64| share * shot.steps as f64 - j as f64;
                let here = |s: &f64| (0.0..1.0).contains(s);
                for s in shares.iter().map(place).filter(here) {
                    let at = |i: usize| {
                        hermite([z[i], next[i]], [h * start[i], h * self.stages[0][i]], s)
                    };
                    inner.extend((0..count).map(at));
                }
                std::mem::swap(&mut z, &mut next);
            }
            states.extend_from_slice(&z);
        }
        Some([states, inner])
    }

    /// dA/dz at z, row-major.
    fn matrix(&mut self, z: &[f64], u: &[f64]) -> Matrix {
        let (n, d, count) = (self.field.dimension, self.field.arguments, z.len());
        let x = &z[..d];
        self.field.jacobian(x, u, &mut self.room, &mut self.jacobian);
        let mut matrix = Matrix::zeros(count);
        for i in 0..count - n {
            matrix.set(i, i + n, 1.0);
        }
        for i in 0..n {
            (0..d).for_each(|j| matrix.set(count - n + i, j, self.jacobian[i * d + j]));
        }
        matrix
    }

    /// dA/dz at z, row-major.
    pub fn derivative(&mut self, z: &[f64], u: &[f64]) -> Vec<f64> {
        self.matrix(z, u).entries
    }

    /// Modulus of the largest eigenvalue of dA/dz, from the eighth power's norm.
    pub fn stiffness(&mut self, z: &[f64], u: &[f64]) -> f64 {
        let matrix = self.matrix(z, u);
        let square = matrix.times(&matrix);
        let fourth = square.times(&square);
        fourth.times(&fourth).norm().powf(0.125)
    }

    /// Runge-Kutta steps from sample to sample that this stiffness needs at the longest interval.
    pub fn steps_for(stiffness: f64, times: &[f64]) -> usize {
        let longest = times.windows(2).map(|t| t[1] - t[0]).fold(0.0, f64::max);
        let needed = (stiffness * longest / STEP).ceil();
        if needed.is_finite() { (needed as usize).clamp(1, MOST_STEPS) } else { MOST_STEPS }
    }

    /// States at the samples and their transitions from the initial state.
    pub fn run(&mut self, shot: &Shot) -> Option<Run> {
        self.linearise(shot, None)
    }

    /// The same, and int Psi(t_k, r) B k(z(r)) u dr for the kernel values of all landmarks: N x (s n) rows.
    pub fn run_with_design(&mut self, shot: &Shot) -> Option<(Run, Mat<f64>)> {
        let features = self.field.features();
        let rows = shot.motion.samples() * self.setting.states();
        // Column-major transposed: a row of the design is contiguous.
        let mut design = Mat::zeros(features, rows);
        let run = self.linearise(shot, Some(&mut design))?;
        Some((run, design))
    }

    fn linearise(&mut self, shot: &Shot, mut design: Option<&mut Mat<f64>>) -> Option<Run> {
        let count = self.setting.states();
        let times = shot.motion.times();
        let mut run = Run { states: shot.initial.clone(), transitions: Vec::new() };
        let mut total = Matrix::identity(count);
        run.transitions.extend_from_slice(&total.entries);
        let mut z = shot.initial.clone();
        for k in 0..times.len() - 1 {
            let nodes = self.nodes(shot, k, &mut z, design.is_some())?;
            let step = nodes[0].to_end.clone();
            total = step.times(&total);
            run.states.extend_from_slice(&z);
            run.transitions.extend_from_slice(&total.entries);
            if let Some(design) = design.as_deref_mut() {
                self.accumulate(k, &nodes, &step, design);
            }
        }
        Some(run)
    }

    /// Nodes of the integrals over interval k, with Simpson's weights; `z` goes from its start to its end.
    fn nodes(
        &mut self,
        shot: &Shot,
        k: usize,
        z: &mut Vec<f64>,
        values: bool,
    ) -> Option<Vec<Node>> {
        let times = shot.motion.times();
        let h = (times[k + 1] - times[k]) / shot.steps as f64;
        let mut nodes: Vec<Node> = Vec::with_capacity(2 * shot.steps + 1);
        let mut matrices = Vec::with_capacity(2 * shot.steps + 1);
        let mut next = vec![0.0; z.len()];
        for j in 0..shot.steps {
            let t = times[k] + j as f64 * h;
            self.step(shot, k, t, h, z, &mut next);
            let start = self.stages[0].clone();
            self.node(shot, k, t, h / 6.0, z, values, &mut nodes, &mut matrices);
            // The cubic through both ends with their slopes.
            input_at(&shot.motion, self.setting.path, k, t + h, &mut self.u);
            self.slope(&next, 0);
            let end = &self.stages[0];
            let middle: Vec<f64> = (0..z.len())
                .map(|i| 0.5 * (z[i] + next[i]) + h / 8.0 * (start[i] - end[i]))
                .collect();
            self.node(shot, k, t + 0.5 * h, h / 1.5, &middle, values, &mut nodes, &mut matrices);
            std::mem::swap(z, &mut next);
            if self.setting.is_lost(z) {
                return None;
            }
        }
        self.node(shot, k, times[k + 1], h / 6.0, z, values, &mut nodes, &mut matrices);
        // Inner ends belong to two steps.
        nodes.iter_mut().step_by(2).skip(1).take(shot.steps - 1).for_each(|n| n.weight *= 2.0);
        back_to_start(&mut nodes, &matrices, h);
        Some(nodes)
    }

    #[allow(clippy::too_many_arguments)]
    fn node(
        &mut self,
        shot: &Shot,
        k: usize,
        t: f64,
        weight: f64,
        z: &[f64],
        values: bool,
        nodes: &mut Vec<Node>,
        matrices: &mut Vec<Matrix>,
    ) {
        input_at(&shot.motion, self.setting.path, k, t, &mut self.u);
        let u = self.u.clone();
        matrices.push(self.matrix(z, &u));
        if values {
            self.slope(z, 1);
        }
        let values = if values { self.kernel_values.clone() } else { Vec::new() };
        nodes.push(Node { weight, u, values, to_end: Matrix::identity(z.len()) });
    }

    /// Rows of sample k + 1: step times the rows of sample k, plus the integral over the interval.
    fn accumulate(&self, k: usize, nodes: &[Node], step: &Matrix, design: &mut Mat<f64>) {
        let (count, n) = (self.setting.states(), self.field.dimension);
        let (before, mut after) = design.as_mut().split_at_col_mut((k + 1) * count);
        for a in 0..count {
            let Some(row) = after.as_mut().col_mut(a).try_as_col_major_mut() else { continue };
            let row = row.as_slice_mut();
            for b in 0..count {
                let factor = step.get(a, b);
                let Some(old) = before.as_ref().col(k * count + b).try_as_col_major() else {
                    continue;
                };
                row.iter_mut().zip(old.as_slice()).for_each(|(r, o)| *r += factor * o);
            }
            for node in nodes {
                let mut first = 0;
                for term in &self.field.terms {
                    let rank = term.basis.rank();
                    let u = if term.block == 0 { 1.0 } else { node.u[term.block - 1] };
                    let factor = node.weight * u * node.to_end.get(a, count - n + term.row);
                    let values = &node.values[first..first + rank];
                    let part = &mut row[first..first + rank];
                    part.iter_mut().zip(values).for_each(|(r, v)| *r += factor * v);
                    first += rank;
                }
            }
        }
    }
}

/// The cubic on \[0, 1\] with these values and slopes at its ends.
fn hermite(values: [f64; 2], slopes: [f64; 2], s: f64) -> f64 {
    let r = 1.0 - s;
    let inner = r * slopes[0] - s * slopes[1] - (r - s) * (values[1] - values[0]);
    r * values[0] + s * values[1] + r * s * inner
}

/// A node of an integral over the time between two samples.
struct Node {
    weight: f64,
    u: Vec<f64>,
    values: Vec<f64>,
    /// Psi(end of the interval, node).
    to_end: Matrix,
}

/// Psi(end, node) for all nodes, backwards, by the Runge-Kutta method on Psi' = dA/dz Psi.
fn back_to_start(nodes: &mut [Node], matrices: &[Matrix], h: f64) {
    let mut node = nodes.len() - 1;
    while node > 0 {
        let end = nodes[node].to_end.clone();
        let (first, middle, last) = (&matrices[node - 2], &matrices[node - 1], &matrices[node]);
        let between = middle.plus(last, 1.0).scaled(0.5);
        nodes[node - 1].to_end = end.times(&transition(middle, &between, last, 0.5 * h));
        nodes[node - 2].to_end = end.times(&transition(first, middle, last, h));
        node -= 2;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_cubic_is_its_own_interpolation() {
        let (value, slope) = (|s: f64| 2.0 - s + 3.0 * s * s * s, |s: f64| -1.0 + 9.0 * s * s);
        for s in [0.0, 0.2, 0.7, 1.0] {
            let found = hermite([value(0.0), value(1.0)], [slope(0.0), slope(1.0)], s);
            assert!((found - value(s)).abs() < 1e-14, "{s}: {found}");
        }
    }
}
