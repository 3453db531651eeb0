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

mod accumulation;
mod integrator;

use std::sync::Arc;

use super::field::{Field, Room};
use super::matrix::{multiply, norm};
use super::motion::{InputPath, Motion};
pub(crate) use integrator::Integrator;

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
    pub motion: Arc<Motion>,
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

/// z' = A(z, u) and its derivatives.
pub(crate) struct Flow<'f> {
    field: &'f Field,
    room: Room,
    jacobian: Vec<f64>,
}

impl<'f> Flow<'f> {
    pub fn new(field: &'f Field) -> Self {
        let jacobian = vec![0.0; field.dimension * field.arguments];
        Self { field, room: field.room(), jacobian }
    }

    fn slope(&mut self, z: &[f64], u: &[f64], slope: &mut [f64]) {
        let n = self.field.dimension;
        let (lower, highest) = slope.split_at_mut(z.len() - n);
        lower.copy_from_slice(&z[n..]);
        self.field.value(&z[..self.field.arguments], u, &mut self.room, highest);
    }

    /// Writes dA/dz, row-major.
    pub fn derivative(&mut self, z: &[f64], u: &[f64], matrix: &mut [f64]) {
        let (n, d, count) = (self.field.dimension, self.field.arguments, z.len());
        self.field.jacobian(&z[..d], u, &mut self.room, &mut self.jacobian);
        matrix.fill(0.0);
        for i in 0..count - n {
            matrix[i * count + i + n] = 1.0;
        }
        for (i, row) in self.jacobian.chunks_exact(d).enumerate() {
            let first = (count - n + i) * count;
            matrix[first..first + d].copy_from_slice(row);
        }
    }

    /// Modulus of the largest eigenvalue of dA/dz, from the eighth power's norm.
    pub fn stiffness(&mut self, z: &[f64], u: &[f64]) -> f64 {
        let size = z.len();
        let mut power = vec![0.0; size * size];
        let mut square = power.clone();
        self.derivative(z, u, &mut power);
        for _ in 0..3 {
            multiply(size, &power, &power, &mut square);
            std::mem::swap(&mut power, &mut square);
        }
        norm(&power).powf(0.125)
    }
}

/// Runge-Kutta steps from sample to sample that this stiffness needs at the longest interval.
pub(crate) fn steps_for(stiffness: f64, times: &[f64]) -> usize {
    let longest = times.windows(2).map(|t| t[1] - t[0]).fold(0.0, f64::max);
    let needed = (stiffness * longest / STEP).ceil();
    if needed.is_finite() { (needed as usize).clamp(1, MOST_STEPS) } else { MOST_STEPS }
}
