//! Sliding windows of phi = (1 - tau^2)^p.

use faer::Mat;

use super::TestFunctionError;
use crate::functional::Functional;
use crate::linear::solve_positive_definite;
use crate::quadrature::{Quadrature, check_increasing};

/// The functionals are exact for polynomials y of degree up to the derivative plus this.
const EXTRA_DEGREE: usize = 3;

/// A window may end this part of its width after the last sample, to allow for rounded times.
const ROUNDING: f64 = 1e-6;

pub(super) struct Windows {
    pub exponent: u32,
    pub width: f64,
    pub stride: usize,
}

impl Windows {
    pub(super) fn functionals(
        &self,
        times: &[f64],
        quadrature: Quadrature,
        derivative: usize,
    ) -> Result<Vec<Functional>, TestFunctionError> {
        self.validate(derivative)?;
        check_increasing(times)?;
        let bump = BumpDerivative::new(self.exponent as usize, derivative);
        let mut functionals = Vec::new();
        for first in (0..times.len()).step_by(self.stride) {
            let Some(last) = self.last_sample(times, first) else { break };
            let weights = bump.weights(&times[first..=last], quadrature)?;
            functionals.push(Functional { first, weights });
        }
        if functionals.is_empty() {
            let duration = times.last().zip(times.first()).map_or(0.0, |(end, start)| end - start);
            return Err(TestFunctionError::WindowTooLong { width: self.width, duration });
        }
        Ok(functionals)
    }

    fn validate(&self, derivative: usize) -> Result<(), TestFunctionError> {
        if !(self.width > 0.0 && self.width.is_finite()) {
            return Err(TestFunctionError::Width { found: self.width });
        }
        if self.stride == 0 {
            return Err(TestFunctionError::Zero { name: "the stride" });
        }
        let highest = (self.exponent as usize)
            .checked_sub(1)
            .ok_or(TestFunctionError::Zero { name: "the exponent" })?;
        if derivative > highest {
            return Err(TestFunctionError::Derivative { highest, found: derivative });
        }
        Ok(())
    }

    /// The sample nearest to the end of the window that starts at sample `first`; none where it ends after the recording.
    fn last_sample(&self, times: &[f64], first: usize) -> Option<usize> {
        let end = times[first] + self.width;
        if end > times[times.len() - 1] + ROUNDING * self.width {
            return None;
        }
        let after = times.partition_point(|&time| time < end).min(times.len() - 1);
        let before = after.max(first + 1) - 1;
        Some(if end - times[before] < times[after] - end { before } else { after })
    }
}

/// d^k/dtau^k (1 - tau^2)^p = (1 - tau^2)^(p-k) q(tau), which is exactly zero at both ends.
struct BumpDerivative {
    exponent: usize,
    derivative: usize,
    /// Coefficients of q, lowest power first.
    factor: Vec<f64>,
    /// int (1 - tau^2)^p tau^j dtau over \[-1, 1\] for j = 0, ..., [`EXTRA_DEGREE`].
    bump_moments: Vec<f64>,
}

impl BumpDerivative {
    fn new(exponent: usize, derivative: usize) -> Self {
        let factor = (0..derivative).fold(vec![1.0], |q, k| next_factor(&q, exponent - k));
        Self { exponent, derivative, factor, bump_moments: bump_moments(exponent) }
    }

    fn value(&self, tau: f64) -> f64 {
        let polynomial =
            self.factor.iter().rev().fold(0.0, |sum, coefficient| sum * tau + coefficient);
        self.envelope(tau) * polynomial
    }

    /// (1 - tau^2)^(p-k): how fast the derivative vanishes at the ends.
    fn envelope(&self, tau: f64) -> f64 {
        (1.0 - tau * tau).powi((self.exponent - self.derivative) as i32)
    }

    /// Exact int phi^(k) tau^j dtau = (-1)^k j! / (j-k)! int phi tau^(j-k) dtau.
    fn moment(&self, j: usize) -> f64 {
        let Some(power) = j.checked_sub(self.derivative) else { return 0.0 };
        let falling: f64 = (power + 1..=j).map(|factor| factor as f64).product();
        let sign = if self.derivative % 2 == 1 { -1.0 } else { 1.0 };
        sign * falling * self.bump_moments[power]
    }

    /// Weights c_k with sum_k c_k y(t_k) = int phi^(derivative) y dt on the window that the times span.
    fn weights(
        &self,
        times: &[f64],
        quadrature: Quadrature,
    ) -> Result<Vec<f64>, TestFunctionError> {
        let degree = self.derivative + EXTRA_DEGREE;
        let (start, end) = (times[0], times[times.len() - 1]);
        // The two end samples have no weight: the others must settle degree + 1 moments.
        if times.len() < degree + 3 {
            let what = "a window of the test function";
            return Err(TestFunctionError::TooFewSamples {
                what,
                start,
                expected: degree + 3,
                found: times.len(),
            });
        }
        let half_width = 0.5 * (end - start);
        let taus: Vec<f64> =
            times.iter().map(|time| ((time - start) - (end - time)) / (end - start)).collect();
        let steps: Vec<f64> =
            quadrature.weights(times)?.iter().map(|step| step / half_width).collect();
        let mut weights: Vec<f64> =
            taus.iter().zip(&steps).map(|(&tau, step)| step * self.value(tau)).collect();
        self.correct_moments(&taus, &steps, &mut weights)
            .ok_or(TestFunctionError::Degenerate { start })?;
        // dt = half_width dtau, and each derivative in time divides by half_width.
        let scale = half_width / half_width.powi(self.derivative as i32);
        weights.iter_mut().for_each(|weight| *weight *= scale);
        Ok(weights)
    }

    /// The smallest change of the weights, relative to step x envelope, that makes the first moments exact.
    fn correct_moments(&self, taus: &[f64], steps: &[f64], weights: &mut [f64]) -> Option<()> {
        let moments = self.derivative + EXTRA_DEGREE + 1;
        let scales: Vec<f64> =
            taus.iter().zip(steps).map(|(&tau, step)| step * self.envelope(tau)).collect();
        let weighted_power_sum = |values: &[f64], j: usize| -> f64 {
            taus.iter().zip(values).map(|(tau, v)| v * tau.powi(j as i32)).sum()
        };
        let mut normal = Mat::from_fn(moments, moments, |i, j| weighted_power_sum(&scales, i + j));
        let mut multipliers =
            Mat::from_fn(moments, 1, |j, _| self.moment(j) - weighted_power_sum(weights, j));
        solve_positive_definite(&mut normal, &mut multipliers).ok()?;
        for ((weight, tau), scale) in weights.iter_mut().zip(taus).zip(&scales) {
            let polynomial = multipliers
                .col(0)
                .iter()
                .rev()
                .fold(0.0, |sum, coefficient| sum * tau + coefficient);
            *weight += scale * polynomial;
        }
        Some(())
    }
}

/// q_{k+1} = (1 - tau^2) q_k' - 2 (p - k) tau q_k, from the product rule; `power` is p - k.
fn next_factor(q: &[f64], power: usize) -> Vec<f64> {
    let mut next = vec![0.0; q.len() + 1];
    for (j, &coefficient) in q.iter().enumerate() {
        if j > 0 {
            next[j - 1] += j as f64 * coefficient;
        }
        next[j + 1] -= (j + 2 * power) as f64 * coefficient;
    }
    next
}

/// int_{-1}^{1} (1 - tau^2)^p tau^j dtau: zero for odd j, the beta function B((j+1)/2, p+1) for even j.
fn bump_moments(exponent: usize) -> Vec<f64> {
    let zeroth =
        (1..=exponent).fold(2.0, |product, i| product * (2 * i) as f64 / (2 * i + 1) as f64);
    let mut moments = vec![0.0; EXTRA_DEGREE + 1];
    moments[0] = zeroth;
    for j in (2..=EXTRA_DEGREE).step_by(2) {
        moments[j] = moments[j - 2] * (j - 1) as f64 / (j + 1 + 2 * exponent) as f64;
    }
    moments
}
