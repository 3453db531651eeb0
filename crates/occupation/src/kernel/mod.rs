//! Scalar kernels K: R^d x R^d -> R, one file each.
//!
//! A kernel knows its formula only; Gram matrices are computed in [`crate::gram`].
//! The regression uses the same scalar kernel on each of the m + 1 blocks
//! (1, u_1, ..., u_m) of the diagonal operator kernel K(x, y) I.

mod exponential_dot_product;
mod gaussian;
mod matern;
mod polynomial;
mod spec;

pub use exponential_dot_product::ExponentialDotProduct;
pub use gaussian::Gaussian;
pub use matern::{Matern, Smoothness};
pub use polynomial::Polynomial;
pub use spec::KernelSpec;

pub use crate::simd::{Form, Profile};

/// A symmetric positive semi-definite function of two points of R^d.
pub trait Kernel: Send + Sync {
    /// K(x, y), for two points with the same number of coordinates d.
    fn evaluate(&self, x: &[f64], y: &[f64]) -> f64;

    /// The kernel by its parts, for d arguments: with it all sums are vectorised. None for a kernel of another form.
    fn form(&self, _arguments: usize) -> Option<Form> {
        None
    }

    /// Writes `values[k]` = K(x, p_k) for as many points p_k as there are values, stored coordinate by coordinate:
    /// `points[i * values.len() + k]` is coordinate i of p_k.
    fn evaluate_row(&self, x: &[f64], points: &[f64], values: &mut [f64]) {
        let (count, mut point) = (values.len(), vec![0.0; x.len()]);
        for (k, value) in values.iter_mut().enumerate() {
            point
                .iter_mut()
                .enumerate()
                .for_each(|(i, coordinate)| *coordinate = points[i * count + k]);
            *value = self.evaluate(x, &point);
        }
    }
}

/// A kernel whose parameters make no kernel.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum KernelError {
    /// A width, scale or mu that is not a positive finite number.
    #[error("the kernel's {parameter} must be positive and finite, found {found}")]
    NotPositive {
        /// Name of the parameter.
        parameter: &'static str,
        /// Its value.
        found: f64,
    },
    /// An offset below zero, with which the polynomial kernel is not positive semi-definite.
    #[error("the kernel's {parameter} must be zero or more and finite, found {found}")]
    Negative {
        /// Name of the parameter.
        parameter: &'static str,
        /// Its value.
        found: f64,
    },
    /// Neither one width for all dimensions nor one per dimension.
    #[error("the kernel needs 1 width or {expected} (one per argument), found {found}")]
    Widths {
        /// Dimension d of the kernel's arguments.
        expected: usize,
        /// Number of widths given.
        found: usize,
    },
}

fn positive(parameter: &'static str, found: f64) -> Result<(), KernelError> {
    if found > 0.0 && found.is_finite() {
        Ok(())
    } else {
        Err(KernelError::NotPositive { parameter, found })
    }
}

fn positive_widths(widths: &[f64], dimension: usize) -> Result<(), KernelError> {
    if widths.len() != 1 && widths.len() != dimension {
        return Err(KernelError::Widths { expected: dimension, found: widths.len() });
    }
    widths.iter().try_for_each(|&width| positive("width", width))
}

/// 1 / w for each of d arguments.
fn inverse_widths(widths: &[f64], arguments: usize) -> Vec<f64> {
    widths.iter().cycle().take(arguments).map(|width| 1.0 / width).collect()
}

/// What squared distances are multiplied by where one width is for all, else the widths.
fn factor_of(widths: &[f64]) -> (f64, Option<&[f64]>) {
    match widths {
        [width] => (1.0 / (width * width), None),
        _ => (1.0, Some(widths)),
    }
}

fn dot(x: &[f64], y: &[f64]) -> f64 {
    x.iter().zip(y).map(|(a, b)| a * b).sum()
}

/// sum_i ((x_i - y_i) / w_i)^2, with one width for all dimensions or one per dimension.
fn scaled_squared_distance(x: &[f64], y: &[f64], widths: &[f64]) -> f64 {
    let scaled =
        x.iter().zip(y).zip(widths.iter().cycle()).map(|((a, b), width)| (a - b) * (1.0 / width));
    scaled.map(|difference| difference * difference).sum()
}
