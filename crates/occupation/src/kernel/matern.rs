use serde::{Deserialize, Serialize};

use super::{Form, Kernel, KernelError, Profile, positive_widths, scaled_squared_distance};
use super::{factor_of, inverse_widths};
use crate::simd::kernel_row;

/// Matern kernels, r^2 = sum_i ((x_i - y_i) / w_i)^2:
///
/// * smoothness 1/2: K = exp(-r)
/// * smoothness 3/2: K = (1 + sqrt(3) r) exp(-sqrt(3) r)
/// * smoothness 5/2: K = (1 + sqrt(5) r + 5 r^2 / 3) exp(-sqrt(5) r)
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Matern {
    /// How smooth the learned functions are.
    pub smoothness: Smoothness,
    /// Widths w_i > 0 in the units of the arguments: one per dimension, or one for all.
    pub widths: Vec<f64>,
}

/// Smoothness of a [`Matern`] kernel; its functions have 0, 1 or 2 mean-square derivatives.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum Smoothness {
    /// 1/2: continuous functions.
    #[serde(rename = "1/2")]
    Half,
    /// 3/2: once differentiable functions.
    #[serde(rename = "3/2")]
    ThreeHalves,
    /// 5/2: twice differentiable functions.
    #[serde(rename = "5/2")]
    FiveHalves,
}

impl Matern {
    pub(super) fn validate(&self, dimension: usize) -> Result<(), KernelError> {
        positive_widths(&self.widths, dimension)
    }
}

fn half(squared: f64) -> f64 {
    (-squared.sqrt()).exp()
}

fn three_halves(squared: f64) -> f64 {
    let r = (3.0 * squared).sqrt();
    (1.0 + r) * (-r).exp()
}

fn five_halves(squared: f64) -> f64 {
    let r = (5.0 * squared).sqrt();
    (1.0 + r + r * r / 3.0) * (-r).exp()
}

impl Kernel for Matern {
    fn evaluate(&self, x: &[f64], y: &[f64]) -> f64 {
        let squared = scaled_squared_distance(x, y, &self.widths);
        match self.smoothness {
            Smoothness::Half => half(squared),
            Smoothness::ThreeHalves => three_halves(squared),
            Smoothness::FiveHalves => five_halves(squared),
        }
    }

    fn evaluate_row(&self, x: &[f64], points: &[f64], values: &mut [f64]) {
        kernel_row(self.smoothness.profile(), factor_of(&self.widths), x, points, values);
    }

    fn form(&self, arguments: usize) -> Option<Form> {
        let profile = self.smoothness.profile();
        Some(Form { profile, scales: inverse_widths(&self.widths, arguments) })
    }
}

impl Smoothness {
    fn profile(self) -> Profile {
        match self {
            Self::Half => Profile::MaternHalf,
            Self::ThreeHalves => Profile::MaternThreeHalves,
            Self::FiveHalves => Profile::MaternFiveHalves,
        }
    }
}
