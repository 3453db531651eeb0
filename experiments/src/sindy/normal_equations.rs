//! A linear regression, gathered trajectory by trajectory.

use nalgebra::DMatrix;

use super::SparseRegressionError;

/// The normal equations T^T T c = T^T y of a regression with several right-hand sides.
///
/// They are all that the thresholded least squares need, and small however long the data are. That
/// they square the condition of T does no harm here: `tests/sindy.rs` compares with a reference
/// that factorises T itself.
#[derive(Clone, Debug)]
pub struct NormalEquations {
    /// T^T T, columns x columns.
    gram: DMatrix<f64>,
    /// T^T y, columns x targets.
    moments: DMatrix<f64>,
}

impl NormalEquations {
    /// A regression of `targets` right-hand sides on `columns` columns, as yet without rows.
    pub fn new(columns: usize, targets: usize) -> Self {
        Self { gram: DMatrix::zeros(columns, columns), moments: DMatrix::zeros(columns, targets) }
    }

    /// Add rows: `regressors` (rows x columns) and `targets` (rows x targets).
    ///
    /// # Panics
    /// For other numbers of columns.
    pub fn add(&mut self, regressors: &DMatrix<f64>, targets: &DMatrix<f64>) {
        self.gram.gemm_tr(1.0, regressors, regressors, 1.0);
        self.moments.gemm_tr(1.0, regressors, targets, 1.0);
    }

    /// Number of columns.
    pub fn columns(&self) -> usize {
        self.gram.nrows()
    }

    /// Number of right-hand sides.
    pub fn targets(&self) -> usize {
        self.moments.ncols()
    }

    /// Coefficients of the columns `support` for right-hand side `target`, minimising
    /// |T c - y|^2 + ridge |c|^2.
    ///
    /// # Errors
    /// [`SparseRegressionError::Dependent`] when these columns are dependent.
    pub fn solve(
        &self,
        support: &[usize],
        target: usize,
        ridge: f64,
    ) -> Result<Vec<f64>, SparseRegressionError> {
        let columns = support.len();
        let mut gram =
            DMatrix::from_fn(columns, columns, |a, b| self.gram[(support[a], support[b])]);
        (0..columns).for_each(|a| gram[(a, a)] += ridge);
        let moments = DMatrix::from_fn(columns, 1, |a, _| self.moments[(support[a], target)]);
        let factor = gram.cholesky().ok_or(SparseRegressionError::Dependent { columns })?;
        Ok(factor.solve(&moments).as_slice().to_vec())
    }
}
