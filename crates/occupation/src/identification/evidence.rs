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
#[derive(Debug, Clone, PartialEq)]
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

    /// |y - Phi c|^2.
    pub fn left(&self, coefficients: &[f64]) -> f64 {
        let size = coefficients.len();
        let column = MatRef::from_column_major_slice(coefficients, size, 1);
        let mut lower = Mat::zeros(size, 1);
        triangular(
            &mut lower,
            BlockStructure::Rectangular,
            Accum::Replace,
            &self.gram,
            BlockStructure::TriangularLower,
            column,
            BlockStructure::Rectangular,
            1.0,
            Par::Seq,
        );
        let terms = coefficients
            .iter()
            .enumerate()
            .map(|(i, c)| c * (2.0 * (lower[(i, 0)] - self.moment[i]) - self.gram[(i, i)] * c));
        self.square + terms.sum::<f64>()
    }

    /// Appends the numbers of columns and equations, y . y, Phi^T y and the lower triangle of Phi^T Phi, row after row; all
    /// little-endian.
    pub fn write(&self, bytes: &mut Vec<u8>) {
        let size = self.moment.len();
        bytes.extend((size as u64).to_le_bytes());
        bytes.extend((self.equations as u64).to_le_bytes());
        let lower = (0..size).flat_map(|i| (0..=i).map(move |j| self.gram[(i, j)]));
        let numbers = std::iter::once(self.square).chain(self.moment.iter().copied()).chain(lower);
        numbers.for_each(|number| bytes.extend(number.to_le_bytes()));
    }

    /// What [`Normal::write`] wrote, and the bytes behind it; none where they end too soon.
    pub fn read(bytes: &[u8]) -> Option<(Self, &[u8])> {
        let (head, rest) = bytes.split_at_checked(16)?;
        let [size, equations] = [0, 1].map(|k| u64::from_le_bytes(head.as_chunks::<8>().0[k]));
        let (size, equations) = (usize::try_from(size).ok()?, usize::try_from(equations).ok()?);
        let entries = size.checked_mul(size.checked_add(1)?)? / 2;
        let length = entries.checked_add(size)?.checked_add(1)?.checked_mul(8)?;
        let (numbers, rest) = rest.split_at_checked(length)?;
        let mut numbers = numbers.as_chunks::<8>().0.iter().map(|b| f64::from_le_bytes(*b));
        let square = numbers.next()?;
        let moment: Vec<f64> = numbers.by_ref().take(size).collect();
        let lower: Vec<f64> = numbers.collect();
        let entry = |i: usize, j: usize| if j > i { 0.0 } else { lower[i * (i + 1) / 2 + j] };
        let gram = Mat::from_fn(size, size, entry);
        Some((Self { gram, moment, square, equations }, rest))
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
