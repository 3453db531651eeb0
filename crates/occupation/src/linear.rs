//! Dense Cholesky solves on one thread, so that results do not depend on how many there are.

use faer::dyn_stack::{MemBuffer, MemStack};
use faer::linalg::cholesky::llt::factor::{LltError, cholesky_in_place, cholesky_in_place_scratch};
use faer::linalg::cholesky::llt::solve::solve_in_place;
use faer::{Mat, Par};

/// A pivot of the Cholesky factorisation that is not positive.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct NonPositivePivot {
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
