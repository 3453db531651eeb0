//! What was seen of one motion.

use super::IdentificationError;
use crate::quadrature::check_increasing;
use crate::trajectory::TrajectoryData;
use serde::{Deserialize, Serialize};

/// What inputs do between their samples.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum InputPath {
    /// They keep the last sample until the next (zero-order hold).
    Held,
    /// They run along straight lines.
    Linear,
    /// They are samples of a smooth signal: cubics through four neighbouring samples.
    Smooth,
}

/// Samples of the coordinates y, perhaps of their rates y', and of the inputs u; row-major, a row a sample.
///
/// NaN marks a missing measurement. Unlike [`TrajectoryData`] nothing here is smoothed: the kernel's arguments are
/// estimated by the identification.
#[derive(Debug, Clone, PartialEq)]
pub struct Motion {
    times: Vec<f64>,
    coordinates: Vec<f64>,
    rates: Option<Vec<f64>>,
    inputs: Vec<f64>,
}

impl Motion {
    /// A motion from `times` (N, seconds, increasing), `coordinates` (N x n) and `inputs` (N x m).
    ///
    /// # Errors
    /// Fewer than [`Motion::FEWEST_SAMPLES`] samples, times that do not increase, lengths that are no multiple of N,
    /// infinite values, and inputs that are missing.
    pub fn new(
        times: Vec<f64>,
        coordinates: Vec<f64>,
        inputs: Vec<f64>,
    ) -> Result<Self, IdentificationError> {
        let samples = times.len();
        if samples < Self::FEWEST_SAMPLES {
            return Err(IdentificationError::TooFewSamples {
                expected: Self::FEWEST_SAMPLES,
                found: samples,
            });
        }
        check_increasing(&times)?;
        check("coordinates", &coordinates, samples, 1)?;
        check("inputs", &inputs, samples, 0)?;
        if let Some(k) = inputs.iter().position(|u| u.is_nan()) {
            let row = k / (inputs.len() / samples);
            return Err(IdentificationError::NotFinite { what: "inputs", row, found: inputs[k] });
        }
        Ok(Self { times, coordinates, rates: None, inputs })
    }

    /// Fewest samples of a motion: a cubic runs through four.
    pub const FEWEST_SAMPLES: usize = 5;

    /// The same with measured rates y' of all coordinates, N x n; NaN where missing.
    ///
    /// # Errors
    /// A length other than N n, infinite values.
    pub fn with_rates(mut self, rates: Vec<f64>) -> Result<Self, IdentificationError> {
        if rates.len() != self.coordinates.len() {
            return Err(IdentificationError::Length {
                what: "rates",
                expected: self.coordinates.len(),
                found: rates.len(),
            });
        }
        check("rates", &rates, self.times.len(), 1)?;
        self.rates = Some(rates);
        Ok(self)
    }

    /// Number N of samples.
    pub fn samples(&self) -> usize {
        self.times.len()
    }

    /// Number n of coordinates.
    pub fn dimension(&self) -> usize {
        self.coordinates.len() / self.times.len()
    }

    /// Number m of inputs.
    pub fn input_count(&self) -> usize {
        self.inputs.len() / self.times.len()
    }

    /// Sample times, seconds.
    pub fn times(&self) -> &[f64] {
        &self.times
    }

    /// Measured coordinates, N x n.
    pub fn coordinates(&self) -> &[f64] {
        &self.coordinates
    }

    /// Measured rates, N x n.
    pub fn rates(&self) -> Option<&[f64]> {
        self.rates.as_deref()
    }

    /// Inputs, N x m.
    pub fn inputs(&self) -> &[f64] {
        &self.inputs
    }

    /// What is left of the coordinates without those of the states z (N x (s n)).
    pub(crate) fn less(&self, states: &[f64]) -> Self {
        let n = self.dimension();
        let count = states.len() / self.samples();
        let left = |(index, y): (usize, &f64)| y - states[index / n * count + index % n];
        let coordinates = self.coordinates.iter().enumerate().map(left).collect();
        Self { coordinates, rates: None, ..self.clone() }
    }

    /// Samples `first..first + count`.
    pub(crate) fn part(&self, first: usize, count: usize) -> Self {
        let (n, m) = (self.dimension(), self.input_count());
        let rows = |values: &[f64], c: usize| values[first * c..(first + count) * c].to_vec();
        Self {
            times: rows(&self.times, 1),
            coordinates: rows(&self.coordinates, n),
            rates: self.rates.as_ref().map(|rates| rows(rates, n)),
            inputs: rows(&self.inputs, m),
        }
    }
}

/// The measured coordinates and inputs of a trajectory; its arguments are left out.
impl TryFrom<&TrajectoryData> for Motion {
    type Error = IdentificationError;

    fn try_from(data: &TrajectoryData) -> Result<Self, IdentificationError> {
        Self::new(data.times().to_vec(), data.coordinates().to_vec(), data.inputs().to_vec())
    }
}

fn check(
    what: &'static str,
    values: &[f64],
    samples: usize,
    at_least: usize,
) -> Result<(), IdentificationError> {
    let columns = values.len() / samples;
    if !values.len().is_multiple_of(samples) || columns < at_least {
        return Err(IdentificationError::Length { what, expected: samples, found: values.len() });
    }
    match values.iter().position(|v| v.is_infinite()) {
        Some(k) => Err(IdentificationError::NotFinite { what, row: k / columns, found: values[k] }),
        None => Ok(()),
    }
}
