//! Motion between samples, once there is a model.
//!
//! ```text
//! x(t) ~ z(t) + d(t),   z' = A(z, u),   d = what the smoother makes of y - z
//! ```
//!
//! The model's own trajectory z knows what happens between samples, however quick; what the samples know better is
//! smoothed like a motion of its own and added. With it the weak form has no error of quadrature left, and kernels can
//! be chosen anew without mistaking one for a property of f or g.

use rayon::prelude::*;

use super::field::Field;
use super::flow::{Integrator, Setting, Shot};
use super::motion::Motion;
use super::smoothing::{self, Channel};
use super::weak::{WeakWindow, shares_within};

/// Runge-Kutta steps that one Gauss-Legendre rule of four nodes spans.
const STEPS_OF_A_RULE: usize = 4;

/// Share of the change of d over an interval by which the path may be wrong within it.
const UNKNOWN_SHARE: f64 = 0.1;

/// The windows of a refinement as weak equations along its trajectories.
pub(super) fn along(field: &Field, setting: &Setting, shots: &[Shot]) -> Vec<WeakWindow> {
    let run = |shot| {
        let parts = parts(shot);
        let mut integrator = Integrator::new(field, setting, shot.motion.input_count());
        let [states, inner] = integrator.between(shot, &shares_within(parts))?;
        Some((shot, shot.motion.less(&states), inner))
    };
    let runs: Vec<(&Shot, Motion, Vec<f64>)> = shots.par_iter().filter_map(run).collect();
    let left: Vec<&Motion> = runs.iter().map(|(_, left, _)| left).collect();
    // Where nothing is left there is nothing to smooth.
    let channels: Vec<Option<Channel>> =
        (0..field.dimension).map(|i| smoothing::judge(&left, i).ok()).collect();
    let window = |(shot, left, mut inner): (&Shot, Motion, Vec<f64>)| {
        let jumps = jumps(field, setting, shot, &left, &channels, &inner);
        add_smoothed(&left, &channels, parts(shot), &mut inner);
        let inner = inner.chunks_exact(setting.states());
        let arguments = inner.flat_map(|z| &z[..field.arguments]).copied().collect();
        let motion = shot.motion.clone();
        WeakWindow::along(motion, arguments, setting.order, setting.path, parts(shot), jumps)
    };
    runs.into_par_iter().map(window).collect()
}

/// What the path's error may do to the integral over each interval: |dA/dz| times a share of what d changes over it.
fn jumps(
    field: &Field,
    setting: &Setting,
    shot: &Shot,
    left: &Motion,
    channels: &[Option<Channel>],
    inner: &[f64],
) -> Vec<f64> {
    let (n, count) = (field.dimension, setting.states());
    let samples = left.samples();
    let mut d = vec![0.0; samples * count];
    for (i, channel) in channels.iter().enumerate() {
        let path = channel.and_then(|c| smoothing::one(left, i, c, left.times()));
        for (p, values) in path.iter().flatten().enumerate().take(count / n) {
            let column = d.iter_mut().skip(p * n + i).step_by(count);
            column.zip(values).for_each(|(d, v)| *d = *v);
        }
    }
    let mut integrator = Integrator::new(field, setting, shot.motion.input_count());
    let per = inner.len() / (samples - 1) / count;
    let mut jumps = Vec::with_capacity((samples - 1) * n);
    for k in 0..samples - 1 {
        let h = left.times()[k + 1] - left.times()[k];
        let node = (k * per + per / 2) * count;
        let u = &shot.motion.inputs()[k * shot.motion.input_count()..][..shot.motion.input_count()];
        let jacobian = integrator.derivative(&inner[node..node + count], u);
        for i in 0..n {
            let row = &jacobian[(count - n + i) * count..][..count];
            let change = |j: usize| (d[(k + 1) * count + j] - d[k * count + j]).abs();
            let sum: f64 = row.iter().enumerate().map(|(j, a)| a.abs() * change(j)).sum();
            jumps.push(UNKNOWN_SHARE * h * sum);
        }
    }
    jumps
}

fn parts(shot: &Shot) -> usize {
    shot.steps.div_ceil(STEPS_OF_A_RULE)
}

/// Adds what the smoother makes of what is left, and its rate for second order, to the states at the nodes.
fn add_smoothed(left: &Motion, channels: &[Option<Channel>], parts: usize, inner: &mut [f64]) {
    let shares = shares_within(parts);
    let between = |t: &[f64]| {
        let (start, step) = (t[0], t[1] - t[0]);
        shares.iter().map(move |share| start + share * step)
    };
    let at: Vec<f64> = left.times().windows(2).flat_map(between).collect();
    let n = channels.len();
    let count = inner.len() / at.len();
    for (i, channel) in channels.iter().enumerate() {
        let path = channel.and_then(|channel| smoothing::one(left, i, channel, &at));
        let Some(path) = path else { continue };
        for (p, values) in path.iter().enumerate().take(count / n) {
            let column = inner.iter_mut().skip(p * n + i).step_by(count);
            column.zip(values).for_each(|(z, d)| *z += d);
        }
    }
}
