//! Why a control input could not be computed.

use lacuna_plants::SimulationError;
use thiserror::Error;

/// Failures of control laws and closed loops.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum ControlError {
    /// The model's g2 has lost rank: some acceleration cannot be commanded.
    #[error(
        "the model's control effectiveness is singular at t = {time} s: its singular values \
         range from {smallest:e} to {largest:e}"
    )]
    Singular {
        /// Time in seconds.
        time: f64,
        /// Smallest singular value.
        smallest: f64,
        /// Largest singular value.
        largest: f64,
    },
    /// The model returned a number that is not finite.
    #[error("the model's accelerations are not finite at t = {time} s")]
    NotFinite {
        /// Time in seconds.
        time: f64,
    },
    /// Fewer inputs than coordinates: accelerations cannot be commanded independently.
    #[error("computed torque needs an input for each of {coordinates} coordinates, found {inputs}")]
    Underactuated {
        /// Coordinates of the model.
        coordinates: usize,
        /// Its inputs.
        inputs: usize,
    },
    /// The plant has no positions and velocities to control.
    #[error(
        "expected a plant of order 2, or of order 1 with positions and velocities as states; \
         found order {order} and dimension {dimension}"
    )]
    NotMechanical {
        /// Order of the plant.
        order: usize,
        /// Its dimension.
        dimension: usize,
    },
    /// Gains, model and plant do not belong together.
    #[error("{what}: expected {expected}, found {found}")]
    Mismatch {
        /// What was counted.
        what: &'static str,
        /// The number that fits.
        expected: usize,
        /// The number found.
        found: usize,
    },
    /// A sampling period must be positive.
    #[error("the sampling period must be positive and finite, found {found} s")]
    BadPeriod {
        /// The period given.
        found: f64,
    },
    /// The plant could not be simulated.
    #[error(transparent)]
    Simulation(#[from] SimulationError),
}
