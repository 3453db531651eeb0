use serde::{Deserialize, Serialize};

use super::{Form, Kernel, KernelError, Profile, dot, positive};
use crate::simd::kernel_row;

/// K(x, y) = exp(x . y / mu), the paper's kernel.
///
/// It is the limit of [`super::Polynomial`] kernels of growing degree: every monomial is among its features.
/// Its values grow as exp(|x|^2 / mu), so mu should not be far below the largest |x|^2.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ExponentialDotProduct {
    /// Scale mu > 0, in squared units of the arguments.
    pub mu: f64,
}

impl ExponentialDotProduct {
    pub(super) fn validate(&self) -> Result<(), KernelError> {
        positive("mu", self.mu)
    }
}

impl Kernel for ExponentialDotProduct {
    fn evaluate(&self, x: &[f64], y: &[f64]) -> f64 {
        (dot(x, y) * (1.0 / self.mu)).exp()
    }

    fn evaluate_row(&self, x: &[f64], points: &[f64], values: &mut [f64]) {
        kernel_row(Profile::Exponential, (1.0 / self.mu, None), x, points, values);
    }

    fn form(&self, arguments: usize) -> Option<Form> {
        let scales = vec![1.0 / self.mu.sqrt(); arguments];
        Some(Form { profile: Profile::Exponential, scales })
    }
}
