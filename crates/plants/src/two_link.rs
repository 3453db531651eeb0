//! The paper's second plant: a two-link robot arm with friction.

use crate::Plant;

/// Two-link arm moving in a horizontal plane,
///
/// ```text
/// M(q) q'' + V(q, q') q' + Fd q' + Fs tanh(q') = tau
///
/// M = | p1 + 2 p3 cos q2   p2 + p3 cos q2 |     V = | -p3 sin q2 dq2   -p3 sin q2 (dq1 + dq2) |
///     | p2 + p3 cos q2     p2             |         |  p3 sin q2 dq1    0                     |
/// ```
///
/// written as a first-order plant of the four states `(q1, q2, dq1, dq2)` (rad, rad/s) with
/// two inputs, the joint torques (N m), as the paper treats it: drift and control
/// effectiveness have four rows, of which the upper two are `q' = dq` without input.
///
/// The friction that the paper calls static is the smooth `fs_i tanh(dq_i)` with velocities
/// in rad/s and no further sharpness factor, as in the authors' other public examples of
/// this arm. That form, `M` and `V` were checked against an independent simulation of the
/// paper's data (1000 trajectories of 1 s, sampled every 0.05 s): integrated along a cubic
/// spline through the recorded torques, this plant agrees to 5e-7 in every state, whereas
/// torques held or joined by straight lines between the samples are off by up to 4e-2 and
/// 5e-4. The recorded torques are therefore samples of a smooth signal.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TwoLinkArm {
    /// Inertia of both links about the first joint, kg m^2.
    pub p1: f64,
    /// Inertia of the second link about its joint, kg m^2.
    pub p2: f64,
    /// Coupling inertia, kg m^2.
    pub p3: f64,
    /// Viscous friction of each joint, N m s/rad.
    pub fd: [f64; 2],
    /// Static friction of each joint, N m.
    pub fs: [f64; 2],
}

impl Default for TwoLinkArm {
    /// The paper's parameters.
    fn default() -> Self {
        Self { p1: 3.473, p2: 0.196, p3: 0.242, fd: [5.3, 1.1], fs: [8.45, 2.35] }
    }
}

impl TwoLinkArm {
    /// Inverse of the mass matrix, as `(m11, m12, m22)` of the symmetric inverse.
    fn inverse_mass(&self, q2: f64) -> (f64, f64, f64) {
        let cos = q2.cos();
        let (a, b, c) = (self.p1 + 2.0 * self.p3 * cos, self.p2 + self.p3 * cos, self.p2);
        let determinant = a * c - b * b;
        (c / determinant, -b / determinant, a / determinant)
    }

    /// Joint accelerations under the torques `tau`.
    fn accelerations(&self, state: &[f64], tau: [f64; 2]) -> [f64; 2] {
        let (d1, d2) = (state[2], state[3]);
        let s = self.p3 * state[1].sin();
        let r1 = tau[0] + s * d2 * d1 + s * (d1 + d2) * d2 - self.friction(0, d1);
        let r2 = tau[1] - s * d1 * d1 - self.friction(1, d2);
        let (m11, m12, m22) = self.inverse_mass(state[1]);
        [m11 * r1 + m12 * r2, m12 * r1 + m22 * r2]
    }

    fn friction(&self, joint: usize, velocity: f64) -> f64 {
        self.fd[joint] * velocity + self.fs[joint] * velocity.tanh()
    }
}

impl Plant for TwoLinkArm {
    fn order(&self) -> usize {
        1
    }

    fn dimension(&self) -> usize {
        4
    }

    fn inputs(&self) -> usize {
        2
    }

    fn derivative(&self, _t: f64, state: &[f64], u: &[f64], derivative: &mut [f64]) {
        derivative[..2].copy_from_slice(&state[2..4]);
        derivative[2..].copy_from_slice(&self.accelerations(state, [u[0], u[1]]));
    }

    fn drift(&self, state: &[f64], f: &mut [f64]) {
        self.derivative(0.0, state, &[0.0, 0.0], f);
    }

    fn control_effectiveness(&self, state: &[f64], g: &mut [f64]) {
        let (m11, m12, m22) = self.inverse_mass(state[1]);
        g.copy_from_slice(&[0.0, 0.0, 0.0, 0.0, m11, m12, m12, m22]);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{InputFn, rk4};

    fn frictionless() -> TwoLinkArm {
        TwoLinkArm { fd: [0.0; 2], fs: [0.0; 2], ..TwoLinkArm::default() }
    }

    /// Without friction and torque the kinetic energy and the angular momentum about the
    /// first joint are constant, which pins M and V against one another.
    #[test]
    fn energy_and_momentum_are_constant_without_friction() {
        let arm = frictionless();
        let times: Vec<f64> = (0..=10).map(|k| 0.5 * k as f64).collect();
        let path =
            rk4(&arm, &[0.3, -0.8, 1.2, -2.0], &InputFn(|_, u| u.fill(0.0)), &times, 1e-3).unwrap();
        let invariants = |s: &[f64]| {
            let cos = s[1].cos();
            let (a, b, c) = (arm.p1 + 2.0 * arm.p3 * cos, arm.p2 + arm.p3 * cos, arm.p2);
            let energy = 0.5 * (a * s[2] * s[2] + 2.0 * b * s[2] * s[3] + c * s[3] * s[3]);
            (energy, a * s[2] + b * s[3])
        };
        let (energy, momentum) = invariants(path.state(0));
        for k in 1..times.len() {
            let (e, p) = invariants(path.state(k));
            approx::assert_abs_diff_eq!(e, energy, epsilon = 1e-8);
            approx::assert_abs_diff_eq!(p, momentum, epsilon = 1e-8);
        }
    }

    #[test]
    fn friction_takes_exactly_the_power_it_should() {
        let (arm, free) = (TwoLinkArm::default(), frictionless());
        let state = [0.1, 0.9, 0.7, -1.1];
        let (mut with, mut without) = ([0.0; 4], [0.0; 4]);
        arm.drift(&state, &mut with);
        free.drift(&state, &mut without);
        let friction = [-(5.3 * 0.7 + 8.45 * 0.7_f64.tanh()), 1.1 * 1.1 + 2.35 * 1.1_f64.tanh()];
        let mut g = [0.0; 8];
        arm.control_effectiveness(&state, &mut g);
        for i in 0..4 {
            let expected = g[2 * i] * friction[0] + g[2 * i + 1] * friction[1];
            approx::assert_abs_diff_eq!(with[i] - without[i], expected, epsilon = 1e-12);
        }
    }
}
