//! Why a sparse regression failed.

use lacuna_occupation::{TestFunctionError, WhiteningError};
use thiserror::Error;

/// A sparse regression that cannot be carried out.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum SparseRegressionError {
    /// No data at all.
    #[error("expected at least one trajectory, found none")]
    NoTrajectory,
    /// A trajectory of another shape than the first.
    #[error(
        "trajectory {trajectory}: expected {expected} {what}, as in the first trajectory, found {found}"
    )]
    Shape {
        /// Index of the trajectory.
        trajectory: usize,
        /// What differs.
        what: &'static str,
        /// Number in the first trajectory.
        expected: usize,
        /// Number in this one.
        found: usize,
    },
    /// Too few samples for the finite differences.
    #[error("a finite difference of order {order} needs {expected} samples, found {found}")]
    TooFewSamples {
        /// Order of the derivative.
        order: usize,
        /// Samples needed.
        expected: usize,
        /// Samples found.
        found: usize,
    },
    /// A test function that does not suit the samples.
    #[error(transparent)]
    TestFunction(#[from] TestFunctionError),
    /// The noise covariance of the weak right-hand sides cannot be factorised.
    #[error(transparent)]
    Whitening(#[from] WhiteningError),
    /// Columns of the library that the data do not tell apart.
    #[error("the {columns} columns of the library in use are linearly dependent on these data")]
    Dependent {
        /// Columns in use when the factorisation failed.
        columns: usize,
    },
}
