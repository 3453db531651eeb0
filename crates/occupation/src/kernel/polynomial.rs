use serde::{Deserialize, Serialize};

use super::{Form, Kernel, KernelError, Profile, dot, positive};
use crate::simd::kernel_row;

/// K(x, y) = (x . y / scale + offset)^degree.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Polynomial {
    /// Highest degree of the learned polynomials.
    pub degree: u32,
    /// Offset c >= 0; with 0 only the monomials of exactly `degree` are learned.
    pub offset: f64,
    /// Scale > 0, in squared units of the arguments.
    pub scale: f64,
}

impl Polynomial {
    pub(super) fn validate(&self) -> Result<(), KernelError> {
        positive("scale", self.scale)?;
        if self.offset >= 0.0 && self.offset.is_finite() {
            Ok(())
        } else {
            Err(KernelError::Negative { parameter: "offset", found: self.offset })
        }
    }
}

impl Polynomial {
    fn profile(&self) -> Profile {
        Profile::Power { degree: self.degree, offset: self.offset }
    }
}

impl Kernel for Polynomial {
    fn evaluate(&self, x: &[f64], y: &[f64]) -> f64 {
        power(dot(x, y) * (1.0 / self.scale) + self.offset, self.degree)
    }

    fn evaluate_row(&self, x: &[f64], points: &[f64], values: &mut [f64]) {
        kernel_row(self.profile(), (1.0 / self.scale, None), x, points, values);
    }

    fn form(&self, arguments: usize) -> Option<Form> {
        let scales = vec![1.0 / self.scale.sqrt(); arguments];
        Some(Form { profile: self.profile(), scales })
    }
}

/// Repeated squaring: `powi` takes an i32, and its rounding differs between platforms.
fn power(base: f64, mut degree: u32) -> f64 {
    let (mut power, mut square) = (1.0, base);
    while degree > 0 {
        if degree & 1 == 1 {
            power *= square;
        }
        square *= square;
        degree >>= 1;
    }
    power
}
