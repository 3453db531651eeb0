//! Bayesian linear regression in closed form.
//!
//! ```text
//! y = Phi c + e,   c ~ N(0, D^2),   e ~ N(0, sigma^2 I)
//! -2 log p(y) = R ln(2 pi sigma^2) + ln det B + (y . y - |C^-1 D Phi^T y|^2 / sigma^2) / sigma^2
//! B = I + D Phi^T Phi D / sigma^2 = C C^T
//! ```
//!
//! It needs the inner products Phi^T Phi, Phi^T y, y . y alone, so that data stream through.

use faer::linalg::matmul::matmul;
use faer::linalg::matmul::triangular::{BlockStructure, matmul as triangular};
use faer::{Accum, Mat, MatRef, Par};

use crate::{Factor, NonPositivePivot};

/// Phi^T Phi (lower triangle), Phi^T y, y . y, and the number R of equations.
#[derive(Debug, Clone)]
pub struct Normal {
    /// Phi^T Phi: its lower triangle.
    pub gram: Mat<f64>,
    /// Phi^T y.
    pub moment: Vec<f64>,
    /// y . y.
    pub square: f64,
    /// R.
    pub equations: usize,
}

impl Normal {
    /// No equation yet, for so many coefficients.
    pub fn new(columns: usize) -> Self {
        Self {
            gram: Mat::zeros(columns, columns),
            moment: vec![0.0; columns],
            square: 0.0,
            equations: 0,
        }
    }

    /// Adds equations y = Phi c.
    pub fn add(&mut self, design: MatRef<'_, f64>, right: &[f64]) {
        let transposed = design.transpose();
        triangular(
            &mut self.gram,
            BlockStructure::TriangularLower,
            Accum::Add,
            transposed,
            BlockStructure::Rectangular,
            design,
            BlockStructure::Rectangular,
            1.0,
            Par::Seq,
        );
        let column = MatRef::from_column_major_slice(right, right.len(), 1);
        let mut moment = Mat::zeros(self.moment.len(), 1);
        matmul(&mut moment, Accum::Replace, transposed, column, 1.0, Par::Seq);
        self.moment.iter_mut().zip(moment.col_as_slice(0)).for_each(|(sum, add)| *sum += add);
        self.square += right.iter().map(|y| y * y).sum::<f64>();
        self.equations += right.len();
    }

    /// The same equations with errors `factor` times as large.
    pub fn scaled(mut self, factor: f64) -> Self {
        let square = factor.powi(-2);
        self.gram *= faer::Scale(square);
        self.moment.iter_mut().for_each(|moment| *moment *= square);
        self.square *= square;
        self
    }

    /// Adds what others have summed.
    pub fn merge(&mut self, other: &Self) {
        self.gram += &other.gram;
        self.moment.iter_mut().zip(&other.moment).for_each(|(sum, add)| *sum += add);
        self.square += other.square;
        self.equations += other.equations;
    }

    /// The posterior for prior standard deviations D of the coefficients and noise sigma.
    ///
    /// # Errors
    /// A matrix B that is not positive definite: numbers that are not finite.
    pub fn posterior(&self, prior: &[f64], sigma: f64) -> Result<Posterior, NonPositivePivot> {
        let (p, variance) = (self.moment.len(), sigma * sigma);
        let matrix = || {
            Mat::from_fn(p, p, |i, j| {
                let (low, high) = (i.max(j), i.min(j));
                let unit = if i == j { 1.0 } else { 0.0 };
                unit + prior[i] * self.gram[(low, high)] * prior[j] / variance
            })
        };
        // With noise as small as the numbers' rounding, that of the inner products is larger than the prior's identity.
        let factor = Factor::of_nearly(matrix)?;
        let mut solved = Mat::from_fn(p, 1, |i, _| prior[i] * self.moment[i] / variance);
        factor.solve_lower(&mut solved);
        let explained: f64 = solved.col_as_slice(0).iter().map(|v| v * v).sum();
        factor.solve_lower_transposed(&mut solved);
        let coefficients = (0..p).map(|i| prior[i] * solved[(i, 0)]).collect();
        let misfit = self.square / variance - explained;
        let constant = (2.0 * std::f64::consts::PI * variance).ln();
        let log_evidence =
            -0.5 * (self.equations as f64 * constant + factor.log_determinant() + misfit);
        Ok(Posterior { coefficients, log_evidence, factor })
    }
}

/// Mean of the coefficients, log p(y), and the factor C of B: the covariance is D B^-1 D.
#[derive(Debug, Clone)]
pub struct Posterior {
    /// Mean of the coefficients.
    pub coefficients: Vec<f64>,
    /// log p(y).
    pub log_evidence: f64,
    /// C.
    pub factor: Factor,
}
