use serde::{Deserialize, Serialize};

use super::{ExponentialDotProduct, Form, Gaussian, Kernel, KernelError, Matern, Polynomial};

/// The kernels that a saved model can name, tagged in JSON: `{"kernel": "gaussian", "widths": [1.0]}`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(tag = "kernel", rename_all = "snake_case")]
pub enum KernelSpec {
    /// exp(x . y / mu)
    ExponentialDotProduct(ExponentialDotProduct),
    /// exp(-r^2 / 2)
    Gaussian(Gaussian),
    /// Matern 1/2, 3/2, 5/2
    Matern(Matern),
    /// (x . y / scale + offset)^degree
    Polynomial(Polynomial),
}

impl KernelSpec {
    /// Checks the parameters against arguments of dimension d.
    ///
    /// # Errors
    /// Names the parameter that is not positive, or the wrong number of widths.
    pub fn validate(&self, dimension: usize) -> Result<(), KernelError> {
        match self {
            Self::ExponentialDotProduct(kernel) => kernel.validate(),
            Self::Gaussian(kernel) => kernel.validate(dimension),
            Self::Matern(kernel) => kernel.validate(dimension),
            Self::Polynomial(kernel) => kernel.validate(),
        }
    }
}

impl KernelSpec {
    /// Its parts: every kernel of the crate has them.
    pub(crate) fn parts(&self, arguments: usize) -> Form {
        self.form(arguments).expect("every kernel of the crate has a form")
    }
}

impl Kernel for KernelSpec {
    fn evaluate(&self, x: &[f64], y: &[f64]) -> f64 {
        match self {
            Self::ExponentialDotProduct(kernel) => kernel.evaluate(x, y),
            Self::Gaussian(kernel) => kernel.evaluate(x, y),
            Self::Matern(kernel) => kernel.evaluate(x, y),
            Self::Polynomial(kernel) => kernel.evaluate(x, y),
        }
    }

    fn evaluate_row(&self, x: &[f64], points: &[f64], values: &mut [f64]) {
        match self {
            Self::ExponentialDotProduct(kernel) => kernel.evaluate_row(x, points, values),
            Self::Gaussian(kernel) => kernel.evaluate_row(x, points, values),
            Self::Matern(kernel) => kernel.evaluate_row(x, points, values),
            Self::Polynomial(kernel) => kernel.evaluate_row(x, points, values),
        }
    }

    fn form(&self, arguments: usize) -> Option<Form> {
        match self {
            Self::ExponentialDotProduct(kernel) => kernel.form(arguments),
            Self::Gaussian(kernel) => kernel.form(arguments),
            Self::Matern(kernel) => kernel.form(arguments),
            Self::Polynomial(kernel) => kernel.form(arguments),
        }
    }
}

impl From<ExponentialDotProduct> for KernelSpec {
    fn from(kernel: ExponentialDotProduct) -> Self {
        Self::ExponentialDotProduct(kernel)
    }
}

impl From<Gaussian> for KernelSpec {
    fn from(kernel: Gaussian) -> Self {
        Self::Gaussian(kernel)
    }
}

impl From<Matern> for KernelSpec {
    fn from(kernel: Matern) -> Self {
        Self::Matern(kernel)
    }
}

impl From<Polynomial> for KernelSpec {
    fn from(kernel: Polynomial) -> Self {
        Self::Polynomial(kernel)
    }
}
