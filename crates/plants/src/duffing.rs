//! The paper's first plant: a Duffing oscillator whose input gain depends on the position.

use crate::Plant;

/// Duffing oscillator of order 2 with one input,
///
/// ```text
/// x'' = a x - b x^3 + (c + d sin x) u
/// ```
///
/// The defaults `a = b = d = 1`, `c = 2` are those of the paper: two stable equilibria at
/// `x = -1` and `x = 1`, an unstable one at 0, and an input gain between 1 and 3. The state
/// is `(x, x')`; all quantities are dimensionless but for time in seconds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Duffing {
    /// Coefficient `a` of the linear (destabilising) term.
    pub linear: f64,
    /// Coefficient `b` of the cubic (restoring) term.
    pub cubic: f64,
    /// Mean input gain `c`.
    pub gain: f64,
    /// Variation `d` of the input gain with the position.
    pub gain_variation: f64,
}

impl Default for Duffing {
    fn default() -> Self {
        Self { linear: 1.0, cubic: 1.0, gain: 2.0, gain_variation: 1.0 }
    }
}

impl Duffing {
    /// Drift `f(x) = a x - b x^3`.
    pub fn f(&self, x: f64) -> f64 {
        self.linear * x - self.cubic * x.powi(3)
    }

    /// Control effectiveness `g(x) = c + d sin x`.
    pub fn g(&self, x: f64) -> f64 {
        self.gain + self.gain_variation * x.sin()
    }
}

impl Plant for Duffing {
    fn order(&self) -> usize {
        2
    }

    fn dimension(&self) -> usize {
        1
    }

    fn inputs(&self) -> usize {
        1
    }

    fn derivative(&self, _t: f64, state: &[f64], u: &[f64], derivative: &mut [f64]) {
        derivative[0] = state[1];
        derivative[1] = self.f(state[0]) + self.g(state[0]) * u[0];
    }

    fn drift(&self, state: &[f64], f: &mut [f64]) {
        f[0] = self.f(state[0]);
    }

    fn control_effectiveness(&self, state: &[f64], g: &mut [f64]) {
        g[0] = self.g(state[0]);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{InputFn, rk4};

    #[test]
    fn energy_is_constant_without_input() {
        let plant = Duffing::default();
        let times: Vec<f64> = (0..=20).map(|k| k as f64).collect();
        let path = rk4(&plant, &[2.0, 0.5], &InputFn(|_, u| u[0] = 0.0), &times, 0.002).unwrap();
        let energy = |s: &[f64]| 0.5 * s[1].powi(2) - 0.5 * s[0].powi(2) + 0.25 * s[0].powi(4);
        for k in 1..times.len() {
            approx::assert_abs_diff_eq!(
                energy(path.state(k)),
                energy(path.state(0)),
                epsilon = 1e-8
            );
        }
    }

    #[test]
    fn derivative_is_drift_plus_effectiveness_times_input() {
        let plant = Duffing { linear: 0.7, cubic: 1.3, gain: 2.5, gain_variation: 0.4 };
        for x in [-2.0, -0.3, 0.0, 1.7] {
            let (mut f, mut g, mut d) = ([0.0], [0.0], [0.0; 2]);
            plant.drift(&[x, 0.2], &mut f);
            plant.control_effectiveness(&[x, 0.2], &mut g);
            plant.derivative(0.0, &[x, 0.2], &[1.5], &mut d);
            assert_eq!(d[0], 0.2);
            approx::assert_relative_eq!(d[1], f[0] + 1.5 * g[0], epsilon = 1e-12);
        }
    }
}
