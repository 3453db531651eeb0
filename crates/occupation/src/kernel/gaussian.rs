use serde::{Deserialize, Serialize};

use super::{Kernel, KernelError, positive_widths, scaled_squared_distance};
use crate::vector::{exp, map_squared_distances};

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
        exp(-0.5 * scaled_squared_distance(x, y, &self.widths))
    }

    fn evaluate_row(&self, x: &[f64], points: &[f64], values: &mut [f64]) {
        map_squared_distances(x, points, &self.widths, values, |squared| exp(-0.5 * squared));
    }
}
