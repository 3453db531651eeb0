//! What makes a regression impossible.

use crate::kernel::KernelError;
use crate::test_function::TestFunctionError;
use crate::whitening::WhiteningError;

/// A regression that cannot be carried out.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum FitError {
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
    /// A differential equation of order zero.
    #[error("the order of the dynamics must be at least 1, found 0")]
    Order,
    /// Kernel parameters out of range.
    #[error(transparent)]
    Kernel(#[from] KernelError),
    /// A test function that does not suit a trajectory.
    #[error("trajectory {trajectory}: {source}")]
    TestFunction {
        /// Index of the trajectory.
        trajectory: usize,
        /// What is wrong.
        source: TestFunctionError,
    },
    /// Given initial derivatives that are missing or of the wrong number.
    #[error(
        "trajectory {trajectory}: expected {expected} initial derivatives (order - 1 times coordinates), found {found}"
    )]
    InitialDerivatives {
        /// Index of the trajectory.
        trajectory: usize,
        /// (s - 1) n
        expected: usize,
        /// Number given.
        found: usize,
    },
    /// A lambda that is no positive number.
    #[error("lambda must be positive and finite, found {found}")]
    Lambda {
        /// Lambda given.
        found: f64,
    },
    /// The noise covariance of the right-hand sides cannot be formed.
    #[error(transparent)]
    Whitening(#[from] WhiteningError),
    /// No landmark: the kernel is zero on all data, or overflows there.
    #[error(
        "no landmark can be taken: the kernel is zero on the data or overflows there (its scale does not suit them), or \
         none is allowed"
    )]
    NoLandmark,
    /// Rounding made the regularised Gram matrix indefinite.
    #[error(
        "G + lambda I is not positive definite at pivot {index} with lambda = {lambda:e}: a larger lambda is needed"
    )]
    NotPositiveDefinite {
        /// Row of the pivot.
        index: usize,
        /// The ridge.
        lambda: f64,
    },
    /// Overflow: kernel values too large for floating point.
    #[error(
        "weight {index} of coordinate {coordinate} is not finite: kernel values overflow, the kernel's scale is too small for the data"
    )]
    NotFinite {
        /// Index of the occupation kernel.
        index: usize,
        /// Coordinate.
        coordinate: usize,
    },
}
