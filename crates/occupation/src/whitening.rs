//! Noise covariance of weak right-hand sides, and its inverse square root.
//!
//! White noise of variance sigma^2 on the samples gives the right-hand sides Y_a = sum_k c_a(k) y_k the covariance
//!
//! ```text
//! S_ab = sigma^2 sum_k c_a(k) c_b(k) = (L L^T)_ab
//! ```
//!
//! which is banded, as only windows that overlap share samples. L^-1 Y then has white noise of unit variance.
//! Test: `tests/whitening.rs`.

use crate::functional::Functional;

/// A symmetric banded matrix: the entries (a, b) with a - bandwidth <= b <= a, row after row.
#[derive(Debug, Clone, PartialEq)]
pub struct SymmetricBanded {
    size: usize,
    bandwidth: usize,
    /// Row a holds the entries (a, a - bandwidth) to (a, a); those left of the first column are zero.
    rows: Vec<f64>,
}

impl SymmetricBanded {
    /// The zero matrix with `size` rows, and room for `bandwidth` entries left of the diagonal.
    pub fn zeros(size: usize, bandwidth: usize) -> Self {
        let bandwidth = bandwidth.min(size.saturating_sub(1));
        Self { size, bandwidth, rows: vec![0.0; size * (bandwidth + 1)] }
    }

    /// S_ab = sum_k c_a(k) c_b(k): the covariance of the functionals of white noise of unit variance.
    ///
    /// # Errors
    /// Functionals that are not in the order of their first samples: the band would be as wide as the matrix.
    pub fn covariance(functionals: &[Functional]) -> Result<Self, WhiteningError> {
        if let Some(k) = functionals.windows(2).position(|pair| pair[1].first < pair[0].first) {
            return Err(WhiteningError::NotSorted { index: k + 1 });
        }
        let mut covariance = Self::zeros(functionals.len(), overlap_bandwidth(functionals));
        for a in 0..functionals.len() {
            for b in covariance.first_column(a)..=a {
                *covariance.entry_mut(a, b) = functionals[a].overlap(&functionals[b]);
            }
        }
        Ok(covariance)
    }

    /// Number of rows.
    pub fn size(&self) -> usize {
        self.size
    }

    /// Largest a - b of an entry that is stored.
    pub fn bandwidth(&self) -> usize {
        self.bandwidth
    }

    /// Entry (a, b); zero outside the band and outside the matrix.
    pub fn get(&self, a: usize, b: usize) -> f64 {
        let (a, b) = (a.max(b), a.min(b));
        if a >= self.size || a - b > self.bandwidth { 0.0 } else { self.rows[self.position(a, b)] }
    }

    /// The sum of this and `scale` times another matrix of the same size, of any bandwidth.
    ///
    /// # Errors
    /// Different sizes.
    pub fn plus(&self, other: &Self, scale: f64) -> Result<Self, WhiteningError> {
        if self.size != other.size {
            return Err(WhiteningError::Size { expected: self.size, found: other.size });
        }
        let mut sum = Self::zeros(self.size, self.bandwidth.max(other.bandwidth));
        for a in 0..sum.size {
            for b in sum.first_column(a)..=a {
                *sum.entry_mut(a, b) = self.get(a, b) + scale * other.get(a, b);
            }
        }
        Ok(sum)
    }

    /// Adds `value` to each diagonal entry.
    pub fn add_diagonal(&mut self, value: f64) {
        (0..self.size).for_each(|a| *self.entry_mut(a, a) += value);
    }

    /// Largest diagonal entry; zero for an empty matrix.
    pub fn largest_diagonal(&self) -> f64 {
        (0..self.size).map(|a| self.get(a, a)).fold(0.0, f64::max)
    }

    /// The factor L of L L^T, in place of the matrix.
    ///
    /// # Errors
    /// A pivot that is not positive: the matrix is not positive definite in floating point. A small ridge
    /// ([`SymmetricBanded::add_diagonal`]) mends near-singular covariances.
    pub fn cholesky(mut self) -> Result<BandedCholesky, WhiteningError> {
        for a in 0..self.size {
            for b in self.first_column(a)..=a {
                let common = self.first_column(a).max(self.first_column(b));
                let remainder =
                    self.get(a, b) - dot(self.row_part(a, common, b), self.row_part(b, common, b));
                if a == b && (remainder.is_nan() || remainder <= 0.0) {
                    return Err(WhiteningError::NotPositiveDefinite { index: a, pivot: remainder });
                }
                let value = if a == b { remainder.sqrt() } else { remainder / self.get(b, b) };
                *self.entry_mut(a, b) = value;
            }
        }
        Ok(BandedCholesky { factor: self })
    }

    fn first_column(&self, row: usize) -> usize {
        row.saturating_sub(self.bandwidth)
    }

    fn position(&self, a: usize, b: usize) -> usize {
        a * (self.bandwidth + 1) + self.bandwidth + b - a
    }

    fn entry_mut(&mut self, a: usize, b: usize) -> &mut f64 {
        let position = self.position(a, b);
        &mut self.rows[position]
    }

    /// Entries (row, from) to (row, to - 1).
    fn row_part(&self, row: usize, from: usize, to: usize) -> &[f64] {
        let start = self.position(row, from);
        &self.rows[start..start + (to - from)]
    }
}

fn dot(x: &[f64], y: &[f64]) -> f64 {
    x.iter().zip(y).map(|(a, b)| a * b).sum()
}

/// Largest a - b of two functionals that share samples, for functionals in the order of their first samples.
fn overlap_bandwidth(functionals: &[Functional]) -> usize {
    let reach = |(b, functional): (usize, &Functional)| {
        functionals.partition_point(|other| other.first < functional.end()).saturating_sub(b + 1)
    };
    functionals.iter().enumerate().map(reach).max().unwrap_or(0)
}

/// The lower factor L of a banded covariance S = L L^T; it has the bandwidth of S.
#[derive(Debug, Clone, PartialEq)]
pub struct BandedCholesky {
    factor: SymmetricBanded,
}

impl BandedCholesky {
    /// Diagonal that [`BandedCholesky::of_functionals`] adds, relative to the largest diagonal entry.
    ///
    /// Windows that slide by one sample make nearly dependent functionals: combinations of many of them cancel to
    /// rounding errors. The ridge is the variance of such errors, 10^-6 of the noise in size, and changes nothing else.
    pub const RELATIVE_RIDGE: f64 = 1e-12;

    /// Factor of the covariance of functionals of white noise of unit variance, with the ridge
    /// [`BandedCholesky::RELATIVE_RIDGE`].
    ///
    /// # Errors
    /// Functionals that are not in the order of their first samples; a covariance that is singular despite the ridge
    /// (all weights zero, or not finite).
    pub fn of_functionals(functionals: &[Functional]) -> Result<Self, WhiteningError> {
        let mut covariance = SymmetricBanded::covariance(functionals)?;
        covariance.add_diagonal(Self::RELATIVE_RIDGE * covariance.largest_diagonal());
        covariance.cholesky()
    }

    /// Number of rows.
    pub fn size(&self) -> usize {
        self.factor.size
    }

    /// Entry (a, b) of L; zero above the diagonal.
    pub fn get(&self, a: usize, b: usize) -> f64 {
        if b > a { 0.0 } else { self.factor.get(a, b) }
    }

    /// L^-1 y in place of y: whitens right-hand sides, or a column of a regressor.
    ///
    /// # Errors
    /// A vector of another size.
    pub fn solve_lower_in_place(&self, vector: &mut [f64]) -> Result<(), WhiteningError> {
        self.check(vector)?;
        for a in 0..self.size() {
            let first = self.factor.first_column(a);
            let known = dot(self.factor.row_part(a, first, a), &vector[first..a]);
            vector[a] = (vector[a] - known) / self.factor.get(a, a);
        }
        Ok(())
    }

    fn check(&self, vector: &[f64]) -> Result<(), WhiteningError> {
        if vector.len() == self.size() {
            Ok(())
        } else {
            Err(WhiteningError::Size { expected: self.size(), found: vector.len() })
        }
    }
}

/// A covariance that does not whiten.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum WhiteningError {
    /// A pivot that is not positive.
    #[error(
        "the noise covariance is not positive definite: pivot {index} is {pivot:e}, expected a positive number"
    )]
    NotPositiveDefinite {
        /// Row of the pivot.
        index: usize,
        /// Its value.
        pivot: f64,
    },
    /// A matrix or a vector of another size.
    #[error("expected {expected} rows, as the covariance has, found {found}")]
    Size {
        /// Rows of the covariance.
        expected: usize,
        /// Rows found.
        found: usize,
    },
    /// Functionals out of order.
    #[error(
        "functionals must be in the order of their first samples: number {index} begins before the one before it"
    )]
    NotSorted {
        /// Index of the functional.
        index: usize,
    },
}
