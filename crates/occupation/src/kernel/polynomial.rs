use serde::{Deserialize, Serialize};

use super::{Kernel, KernelError, dot, positive};

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

impl Kernel for Polynomial {
    fn evaluate(&self, x: &[f64], y: &[f64]) -> f64 {
        let base = dot(x, y) / self.scale + self.offset;
        // Repeated squaring by hand: `powi` takes an i32, and its rounding is unspecified.
        let (mut power, mut square, mut degree) = (1.0, base, self.degree);
        while degree > 0 {
            if degree & 1 == 1 {
                power *= square;
            }
            square *= square;
            degree >>= 1;
        }
        power
    }
}
