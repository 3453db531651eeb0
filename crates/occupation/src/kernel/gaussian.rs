use serde::{Deserialize, Serialize};

use super::{Form, Kernel, KernelError, Profile, positive_widths, scaled_squared_distance};
use super::{factor_of, inverse_widths};
use crate::simd::kernel_row;

/// K(x, y) = exp(-r^2 / 2), r^2 = sum_i ((x_i - y_i) / w_i)^2.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Gaussian {
    /// Widths w_i > 0 in the units of the arguments: one per dimension, or one for all.
    pub widths: Vec<f64>,
}

impl Gaussian {
    pub(super) fn validate(&self, dimension: usize) -> Result<(), KernelError> {
        positive_widths(&self.widths, dimension)
    }
}

impl Kernel for Gaussian {
    fn evaluate(&self, x: &[f64], y: &[f64]) -> f64 {
        (-0.5 * scaled_squared_distance(x, y, &self.widths)).exp()
    }

    fn evaluate_row(&self, x: &[f64], points: &[f64], values: &mut [f64]) {
        kernel_row(Profile::Gaussian, factor_of(&self.widths), x, points, values);
    }

    fn form(&self, arguments: usize) -> Option<Form> {
        Some(Form { profile: Profile::Gaussian, scales: inverse_widths(&self.widths, arguments) })
    }
}
