//! What cannot be identified, and why.

use lacuna_recordings::SignalError;

use crate::regression::FitError;
use crate::test_function::TestFunctionError;
use crate::trajectory::TrajectoryError;

/// Data or settings from which nothing can be identified.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum IdentificationError {
    /// No data at all.
    #[error("expected at least one motion, found none")]
    NoMotion,
    /// A motion of another shape.
    #[error("motion {motion} has other coordinates, rates or inputs than the first")]
    Shape {
        /// Index of the motion.
        motion: usize,
    },
    /// Too short.
    #[error("a motion needs at least {expected} samples, found {found}")]
    TooFewSamples {
        /// Samples needed.
        expected: usize,
        /// Samples given.
        found: usize,
    },
    /// Times that do not increase.
    #[error(transparent)]
    Times(#[from] crate::quadrature::QuadratureError),
    /// An array of the wrong length.
    #[error("{what}: expected {expected} values or a multiple, found {found}")]
    Length {
        /// Which array.
        what: &'static str,
        /// What its length must be.
        expected: usize,
        /// Its length.
        found: usize,
    },
    /// A value that is not finite.
    #[error("{what}: row {row} is {found}, expected a finite number")]
    NotFinite {
        /// Which array.
        what: &'static str,
        /// Row of the value.
        row: usize,
        /// The value.
        found: f64,
    },
    /// Smoothed samples that make no trajectory.
    #[error(transparent)]
    Trajectory(#[from] TrajectoryError),
    /// A test function that does not suit a motion: it is too short.
    #[error(transparent)]
    TestFunction(TestFunctionError),
    /// Equations that cannot be made or whitened.
    #[error(transparent)]
    Equations(FitError),
    /// Sums, or what was chosen for them, of other data.
    #[error("these are sums of other data: expected {expected} {what}, found {found}")]
    OtherStream {
        /// What there is another number of.
        what: &'static str,
        /// Their number here.
        expected: usize,
        /// Their number there.
        found: usize,
    },
    /// Bytes that are no sums, or not all of them.
    #[error(
        "{found} bytes are no sums, or were cut: what was written for a part of the data is expected whole"
    )]
    NoSums {
        /// Number of bytes.
        found: usize,
    },
    /// Order out of range.
    #[error("the order of the dynamics must be 1 or 2, found {found}")]
    Order {
        /// The order.
        found: usize,
    },
    /// No family or no landmark.
    #[error("at least one kernel family and one landmark are needed")]
    NothingToChoose,
    /// A setting that is not positive.
    #[error("{what} must be positive and finite, found {found}")]
    NotPositive {
        /// Which.
        what: &'static str,
        /// Its value.
        found: f64,
    },
    /// A channel without motion.
    #[error("coordinate {coordinate} never changes: nothing can be learned of it")]
    Still {
        /// Index of the coordinate.
        coordinate: usize,
    },
    /// A channel that cannot be smoothed.
    #[error("coordinate {coordinate}: {source}")]
    Signal {
        /// Index of the coordinate.
        coordinate: usize,
        /// Why.
        source: SignalError,
    },
    /// No kernel makes the data likely in floating point numbers.
    #[error(
        "the regression is singular in floating point numbers; give a larger lambda or other widths"
    )]
    NoEvidence,
    /// No trajectory of the model stays near the data.
    #[error(
        "the identified model's trajectories leave the data from every start; record more, or shorter windows"
    )]
    Lost,
}

impl From<FitError> for IdentificationError {
    /// Without the index of the trajectory, which is that within a group.
    fn from(error: FitError) -> Self {
        match error {
            FitError::TestFunction { source, .. } => Self::TestFunction(source),
            other => Self::Equations(other),
        }
    }
}
