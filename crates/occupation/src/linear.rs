//! Dense Cholesky solves on one thread, so that results do not depend on how many there are.

use faer::dyn_stack::{MemBuffer, MemStack};
use faer::linalg::cholesky::llt::factor::{LltError, cholesky_in_place, cholesky_in_place_scratch};
use faer::linalg::cholesky::llt::solve::solve_in_place;
use faer::linalg::matmul::matmul;
use faer::linalg::matmul::triangular::{BlockStructure, matmul as triangular};
use faer::linalg::triangular_solve::{
    solve_lower_triangular_in_place, solve_upper_triangular_in_place,
};
use faer::{Accum, Mat, MatMut, MatRef, Par};

/// `rows` times an upper triangular matrix.
pub(crate) fn times_upper(to: MatMut<'_, f64>, rows: MatRef<'_, f64>, upper: MatRef<'_, f64>) {
    triangular(
        to,
        BlockStructure::Rectangular,
        Accum::Replace,
        rows,
        BlockStructure::Rectangular,
        upper,
        BlockStructure::TriangularUpper,
        1.0,
        Par::Seq,
    );
}

/// A pivot of the Cholesky factorisation that is not positive.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct NonPositivePivot {
    /// Row of the pivot.
    pub index: usize,
}

/// Solves `matrix` X = `right` in place of `right`; reads the lower triangle and overwrites it by its factor.
pub(crate) fn solve_positive_definite(
    matrix: &mut Mat<f64>,
    right: &mut Mat<f64>,
) -> Result<(), NonPositivePivot> {
    let rows = matrix.nrows();
    let mut memory =
        MemBuffer::new(cholesky_in_place_scratch::<f64>(rows, Par::Seq, Default::default()));
    let stack = MemStack::new(&mut memory);
    cholesky_in_place(matrix.as_mut(), Default::default(), Par::Seq, stack, Default::default())
        .map_err(|LltError::NonPositivePivot { index }| NonPositivePivot { index })?;
    solve_in_place(matrix.as_ref(), right.as_mut(), Par::Seq, stack);
    Ok(())
}

/// Lower Cholesky factor C of a positive definite matrix B = C C^T.
#[derive(Debug, Clone)]
pub struct Factor {
    lower: Mat<f64>,
}

impl Factor {
    /// Factorises; reads the lower triangle alone.
    ///
    /// # Errors
    /// A pivot that is not positive.
    pub fn of(mut matrix: Mat<f64>) -> Result<Self, NonPositivePivot> {
        let size = matrix.nrows();
        let mut memory =
            MemBuffer::new(cholesky_in_place_scratch::<f64>(size, Par::Seq, Default::default()));
        let stack = MemStack::new(&mut memory);
        cholesky_in_place(matrix.as_mut(), Default::default(), Par::Seq, stack, Default::default())
            .map_err(|LltError::NonPositivePivot { index }| NonPositivePivot { index })?;
        Ok(Self { lower: matrix })
    }

    /// Factorises a matrix that is positive definite but for rounding: where it is not, the diagonal is raised by shares of
    /// the trace, from that of rounding up. Made anew for each trial, as factors take its place; reads the lower triangle.
    ///
    /// # Errors
    /// A pivot that is not positive however much the diagonal is raised.
    pub fn of_nearly(matrix: impl Fn() -> Mat<f64>) -> Result<Self, NonPositivePivot> {
        const SHARES: [f64; 4] = [1e-15, 1e-13, 1e-11, 1e-9];
        let mut found = Self::of(matrix());
        for share in SHARES {
            if found.is_ok() {
                break;
            }
            let mut raised = matrix();
            let trace: f64 = (0..raised.nrows()).map(|i| raised[(i, i)]).sum();
            (0..raised.nrows()).for_each(|i| raised[(i, i)] += share * trace);
            found = Self::of(raised);
        }
        found
    }

    /// C^-1 X in place of X.
    pub fn solve_lower(&self, right: &mut Mat<f64>) {
        solve_lower_triangular_in_place(self.lower.as_ref(), right.as_mut(), Par::Seq);
    }

    /// C^-1 x in place of x.
    pub fn solve_lower_slice(&self, right: &mut [f64]) {
        let rows = right.len();
        let column = MatMut::from_column_major_slice_mut(right, rows, 1);
        solve_lower_triangular_in_place(self.lower.as_ref(), column, Par::Seq);
    }

    /// C^-T X in place of X.
    pub fn solve_lower_transposed(&self, right: &mut Mat<f64>) {
        solve_upper_triangular_in_place(self.lower.transpose(), right.as_mut(), Par::Seq);
    }

    /// C; above the diagonal anything.
    pub fn lower(&self) -> MatRef<'_, f64> {
        self.lower.as_ref()
    }

    /// C_ij of the lower triangle.
    pub fn entry(&self, i: usize, j: usize) -> f64 {
        self.lower[(i, j)]
    }

    /// ln det B.
    pub fn log_determinant(&self) -> f64 {
        2.0 * (0..self.lower.nrows()).map(|i| self.lower[(i, i)].ln()).sum::<f64>()
    }

    /// B^-1.
    pub fn inverse(&self) -> Mat<f64> {
        let size = self.lower.nrows();
        let mut root = Mat::identity(size, size);
        self.solve_lower(&mut root);
        let mut inverse = Mat::zeros(size, size);
        matmul(&mut inverse, Accum::Replace, root.transpose(), &root, 1.0, Par::Seq);
        inverse
    }
}
