//! Motion between samples, once there is a model.
//!
//! ```text
//! x(t) ~ z(t) + d(t),   z' = A(z, u),   d = what the smoother makes of y - z
//! ```
//!
//! The model's own trajectory z knows what happens between samples, however quick; what the samples know better is
//! smoothed like a motion of its own and added. With it the weak form has hardly an error of quadrature left, and kernels
//! can be chosen anew without mistaking one for a property of f or g. What is left goes with how much d changes over an
//! interval: within it, d may run otherwise than smoothly.

use std::sync::Arc;

use lacuna_recordings::MeanPath;
use rayon::prelude::*;

use super::field::Field;
use super::flow::{Flow, Integrator, Setting, Shot};
use super::motion::Motion;
use super::smoothing;
use super::weak::{WeakWindow, shares_within};

/// Runge-Kutta steps that one Gauss-Legendre rule of four nodes spans.
const STEPS_OF_A_RULE: usize = 4;

/// Share of the change of d over an interval by which the path may be wrong within it.
const UNKNOWN_SHARE: f64 = 0.1;

/// The windows of a refinement as weak equations along its trajectories.
pub(super) fn along(field: &Field, setting: &Setting, shots: &[Shot]) -> Vec<WeakWindow> {
    let run = |shot| {
        let parts = parts(shot);
        let mut integrator = Integrator::new(field, setting, shot);
        let [states, inner] = integrator.between(&shot.initial, &shares_within(parts))?;
        Some((shot, shot.motion.less(&states), inner))
    };
    let runs: Vec<(&Shot, Motion, Vec<f64>)> = shots.par_iter().filter_map(run).collect();
    let left: Vec<&Motion> = runs.iter().map(|(_, left, _)| left).collect();
    let residuals = Residual::all(&left, field.dimension, setting.states());
    let window = |((shot, left, mut inner), residual): ((&Shot, Motion, Vec<f64>), Residual)| {
        let jumps = jumps(field, setting, shot, &residual.at(left.times()), &inner);
        let nodes = times_within(left.times(), parts(shot));
        inner.iter_mut().zip(residual.at(&nodes)).for_each(|(z, d)| *z += d);
        let inner = inner.chunks_exact(setting.states());
        let arguments = inner.flat_map(|z| &z[..field.arguments]).copied().collect();
        let motion = Arc::clone(&shot.motion);
        WeakWindow::along(motion, arguments, setting.order, setting.path, parts(shot), jumps)
    };
    runs.into_par_iter().zip(residuals).map(window).collect()
}

fn parts(shot: &Shot) -> usize {
    shot.steps.div_ceil(STEPS_OF_A_RULE)
}

/// The times of the nodes of all intervals.
fn times_within(times: &[f64], parts: usize) -> Vec<f64> {
    let shares = shares_within(parts);
    let between = |t: &[f64]| {
        let (start, step) = (t[0], t[1] - t[0]);
        shares.iter().map(move |share| start + share * step)
    };
    times.windows(2).flat_map(between).collect()
}

/// d, what the smoother makes of what a trajectory leaves of each coordinate; none where it cannot be smoothed.
struct Residual {
    coordinates: Vec<Option<MeanPath>>,
    states: usize,
}

impl Residual {
    fn all(left: &[&Motion], n: usize, states: usize) -> Vec<Self> {
        let empty = || Self { coordinates: Vec::with_capacity(n), states };
        let mut all: Vec<Self> = left.iter().map(|_| empty()).collect();
        for i in 0..n {
            // Where nothing is left there is nothing to smooth.
            let paths = match smoothing::judge(left, i) {
                Ok(channel) => smoothing::smooth(left, i, channel, None),
                Err(_) => Vec::new(),
            };
            let mut paths = paths.into_iter();
            for residual in &mut all {
                residual.coordinates.push(paths.next().and_then(Result::ok));
            }
        }
        all
    }

    /// Rows of states at ascending times.
    fn at(&self, at: &[f64]) -> Vec<f64> {
        let n = self.coordinates.len();
        let mut rows = vec![0.0; at.len() * self.states];
        for (i, path) in self.coordinates.iter().enumerate() {
            let Some(path) = path else { continue };
            for (row, found) in rows.chunks_exact_mut(self.states).zip(path.at(at)) {
                let to = row.iter_mut().skip(i).step_by(n);
                to.zip(found).for_each(|(to, value)| *to = value);
            }
        }
        rows
    }
}

/// What the path's error may do to the integral over each interval: |dA/dz| times a share of what d, given at the
/// samples, changes over it.
fn jumps(field: &Field, setting: &Setting, shot: &Shot, d: &[f64], inner: &[f64]) -> Vec<f64> {
    let (n, m, count) = (field.dimension, shot.motion.input_count(), setting.states());
    let times = shot.motion.times();
    let nodes = inner.len() / count / (times.len() - 1);
    let mut flow = Flow::new(field);
    let mut jacobian = vec![0.0; count * count];
    let mut of_interval = |k: usize| -> Vec<f64> {
        let middle = (k * nodes + nodes / 2) * count;
        let u = &shot.motion.inputs()[k * m..(k + 1) * m];
        flow.derivative(&inner[middle..middle + count], u, &mut jacobian);
        let changes = d[k * count..].iter().zip(&d[(k + 1) * count..]).take(count);
        let changes: Vec<f64> = changes.map(|(before, after)| (after - before).abs()).collect();
        let force = |row: &[f64]| row.iter().zip(&changes).map(|(a, c)| a.abs() * c).sum::<f64>();
        let forces = jacobian.chunks_exact(count).skip(count - n).map(force);
        forces.map(|force| UNKNOWN_SHARE * (times[k + 1] - times[k]) * force).collect()
    };
    (0..times.len() - 1).flat_map(&mut of_interval).collect()
}
