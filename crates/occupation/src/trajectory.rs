//! The samples of one trajectory.

use crate::quadrature::{QuadratureError, check_increasing};

/// One trajectory: N samples of the kernel's arguments, the inputs and the regressed coordinates.
///
/// Arrays are row-major, a row a sample. The shapes N x d, N x m and N x n follow from the lengths.
#[derive(Debug, Clone, PartialEq)]
pub struct TrajectoryData {
    times: Vec<f64>,
    arguments: Vec<f64>,
    inputs: Vec<f64>,
    coordinates: Vec<f64>,
    initial_derivatives: Option<Vec<f64>>,
}

impl TrajectoryData {
    /// A trajectory from `times` (N, seconds, increasing), kernel `arguments` x (N x d), `inputs` u (N x m, may be
    /// empty for m = 0) and regressed `coordinates` y (N x n). For a first-order system y = x; for a second-order one
    /// y are the positions, and x the positions, or positions and velocities.
    ///
    /// # Errors
    /// Fewer than 2 samples, times that do not increase, a length that is no multiple of N, no argument or no
    /// coordinate at all, and values that are not finite.
    pub fn new(
        times: Vec<f64>,
        arguments: Vec<f64>,
        inputs: Vec<f64>,
        coordinates: Vec<f64>,
    ) -> Result<Self, TrajectoryError> {
        if times.len() < 2 {
            return Err(TrajectoryError::TooFewSamples { expected: 2, found: times.len() });
        }
        check_increasing(&times)?;
        check_rows("arguments", &arguments, times.len(), 1)?;
        check_rows("inputs", &inputs, times.len(), 0)?;
        check_rows("coordinates", &coordinates, times.len(), 1)?;
        Ok(Self { times, arguments, inputs, coordinates, initial_derivatives: None })
    }

    /// The same with known derivatives y', ..., y^(s-1) of the coordinates at the first sample, (s-1) x n row-major:
    /// for order 2 the n initial velocities. [`crate::InitialDerivative::Given`] uses them.
    ///
    /// # Errors
    /// A length that is no multiple of n, or values that are not finite.
    pub fn with_initial_derivatives(
        mut self,
        derivatives: Vec<f64>,
    ) -> Result<Self, TrajectoryError> {
        let columns = self.dimension();
        if !derivatives.len().is_multiple_of(columns) {
            let found = derivatives.len();
            return Err(TrajectoryError::Shape {
                what: "initial derivatives",
                expected: columns,
                found,
            });
        }
        check_finite("initial derivatives", &derivatives, columns)?;
        self.initial_derivatives = Some(derivatives);
        Ok(self)
    }

    /// Number of samples N.
    pub fn samples(&self) -> usize {
        self.times.len()
    }

    /// Number n of regressed coordinates.
    pub fn dimension(&self) -> usize {
        self.coordinates.len() / self.times.len()
    }

    /// Number m of inputs.
    pub fn input_count(&self) -> usize {
        self.inputs.len() / self.times.len()
    }

    /// Number d of the kernel's arguments.
    pub fn argument_count(&self) -> usize {
        self.arguments.len() / self.times.len()
    }

    /// Sample times, in seconds.
    pub fn times(&self) -> &[f64] {
        &self.times
    }

    /// Kernel arguments x, N x d.
    pub fn arguments(&self) -> &[f64] {
        &self.arguments
    }

    /// Inputs u, N x m.
    pub fn inputs(&self) -> &[f64] {
        &self.inputs
    }

    /// Regressed coordinates y, N x n.
    pub fn coordinates(&self) -> &[f64] {
        &self.coordinates
    }

    /// What has another number of columns in `other`, with the number here and there; none where all agree.
    pub fn other_shape(&self, other: &Self) -> Option<(&'static str, usize, usize)> {
        let counts = [
            ("coordinates", self.dimension(), other.dimension()),
            ("inputs", self.input_count(), other.input_count()),
            ("arguments", self.argument_count(), other.argument_count()),
        ];
        counts.into_iter().find(|(_, here, there)| here != there)
    }

    /// Known derivatives of the coordinates at the first sample, (s-1) x n.
    pub fn initial_derivatives(&self) -> Option<&[f64]> {
        self.initial_derivatives.as_deref()
    }
}

fn check_rows(
    what: &'static str,
    values: &[f64],
    samples: usize,
    at_least: usize,
) -> Result<(), TrajectoryError> {
    if !values.len().is_multiple_of(samples) || values.len() / samples < at_least {
        return Err(TrajectoryError::Shape { what, expected: samples, found: values.len() });
    }
    check_finite(what, values, values.len() / samples)
}

fn check_finite(what: &'static str, values: &[f64], columns: usize) -> Result<(), TrajectoryError> {
    match values.iter().position(|value| !value.is_finite()) {
        Some(k) => Err(TrajectoryError::NotFinite {
            what,
            row: k / columns,
            column: k % columns,
            found: values[k],
        }),
        None => Ok(()),
    }
}

/// Samples that make no trajectory.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum TrajectoryError {
    /// Not enough samples.
    #[error("a trajectory needs at least {expected} samples, found {found}")]
    TooFewSamples {
        /// Samples needed.
        expected: usize,
        /// Samples given.
        found: usize,
    },
    /// Times that are not finite or do not increase.
    #[error(transparent)]
    Times(#[from] QuadratureError),
    /// An array that does not divide into rows.
    #[error("{what}: expected a positive multiple of {expected} values, found {found}")]
    Shape {
        /// Which array.
        what: &'static str,
        /// The length must be a multiple of this.
        expected: usize,
        /// Its length.
        found: usize,
    },
    /// A value that is not finite.
    #[error("{what}: row {row}, column {column} is {found}, expected a finite number")]
    NotFinite {
        /// Which array.
        what: &'static str,
        /// Row of the value.
        row: usize,
        /// Column of the value.
        column: usize,
        /// The value.
        found: f64,
    },
}
