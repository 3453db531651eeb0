//! The identified model: drift and control effectiveness as sums over samples.

use std::fs;
use std::ops::Range;
use std::path::{Path, PathBuf};

use faer::Mat;
use serde::{Deserialize, Serialize};

use crate::kernel::{Kernel, KernelError, KernelSpec};
use crate::occupation_kernels::OccupationKernels;
use crate::vector::{add_weighted_sums, coordinate_by_coordinate};

/// Version of the saved form.
const VERSION: u32 = 1;

/// Samples in a tile: their kernel values stand on the stack.
const TILE: usize = 128;

/// H(x) = \[f(x) g(x)\] = sum_a W_a Gamma_a(x)^T, an n x (m + 1) matrix.
///
/// The weights are folded per sample, beta_k = sum_a c_a(k) W_a in R^n, so that
///
/// ```text
/// f(x) = sum_k beta_k K(x, x_k),   g(x) = sum_k beta_k K(x, x_k) u_k^T
/// ```
///
/// costs one kernel value a sample, however many test functions overlap there.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(into = "SavedModel", try_from = "SavedModel")]
pub struct IdentifiedModel {
    saved: SavedModel,
    tiles: Vec<Tile>,
}

/// What a model's file holds.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
struct SavedModel {
    version: u32,
    kernel: KernelSpec,
    order: usize,
    dimension: usize,
    inputs: usize,
    arguments: usize,
    /// x_k, samples x d.
    points: Vec<f64>,
    /// beta_k, samples x n.
    coefficients: Vec<f64>,
    /// u_k, samples x m.
    sample_inputs: Vec<f64>,
}

/// Some samples, laid out for vectorised sums.
#[derive(Debug, Clone, PartialEq)]
struct Tile {
    samples: usize,
    /// x_k, coordinate by coordinate.
    points: Vec<f64>,
    /// beta_ki, coordinate by coordinate.
    drift: Vec<f64>,
    /// beta_ki u_kj, entry (i, j) by entry.
    effectiveness: Vec<f64>,
}

impl IdentifiedModel {
    /// beta_k = sum_a c_a(k) W_a; samples without any weight are left out.
    pub(crate) fn fold(
        kernel: KernelSpec,
        order: usize,
        occupation: &OccupationKernels,
        weights: &Mat<f64>,
    ) -> Self {
        let n = weights.ncols();
        let mut folded = vec![0.0; occupation.samples() * n];
        for (a, functional) in occupation.functionals().iter().enumerate() {
            let samples = folded[functional.first * n..functional.end() * n].chunks_exact_mut(n);
            for (coefficient, c) in samples.zip(&functional.weights) {
                coefficient
                    .iter_mut()
                    .enumerate()
                    .for_each(|(i, entry)| *entry += c * weights[(a, i)]);
            }
        }
        let mut saved = SavedModel {
            version: VERSION,
            kernel,
            order,
            dimension: n,
            inputs: occupation.input_count(),
            arguments: occupation.argument_count(),
            points: Vec::new(),
            coefficients: Vec::new(),
            sample_inputs: Vec::new(),
        };
        for (k, coefficient) in folded.chunks_exact(n).enumerate() {
            if coefficient.iter().any(|&entry| entry != 0.0) {
                saved.points.extend_from_slice(occupation.argument(k));
                saved.coefficients.extend_from_slice(coefficient);
                saved.sample_inputs.extend_from_slice(occupation.input(k));
            }
        }
        Self::of_saved(saved)
    }

    fn of_saved(saved: SavedModel) -> Self {
        let samples = saved.points.len() / saved.arguments;
        let tiles = (0..samples)
            .step_by(TILE)
            .map(|start| saved.tile(start..samples.min(start + TILE)))
            .collect();
        Self { saved, tiles }
    }

    /// Writes the drift f(x) (n) and the control effectiveness g(x) (n x m, row-major) at x (d). Allocates nothing.
    ///
    /// # Errors
    /// A slice of another length than d, n or n m.
    pub fn evaluate(&self, x: &[f64], f: &mut [f64], g: &mut [f64]) -> Result<(), EvaluationError> {
        check_length("x", self.arguments(), x.len())?;
        check_length("f", self.dimension(), f.len())?;
        check_length("g", self.dimension() * self.inputs(), g.len())?;
        f.fill(0.0);
        g.fill(0.0);
        let mut values = [0.0; TILE];
        for tile in &self.tiles {
            let values = &mut values[..tile.samples];
            self.saved.kernel.evaluate_row(x, &tile.points, values);
            add_weighted_sums(values, &tile.drift, f);
            add_weighted_sums(values, &tile.effectiveness, g);
        }
        Ok(())
    }

    /// Number n of coordinates.
    pub fn dimension(&self) -> usize {
        self.saved.dimension
    }

    /// Number m of inputs.
    pub fn inputs(&self) -> usize {
        self.saved.inputs
    }

    /// Number d of arguments x.
    pub fn arguments(&self) -> usize {
        self.saved.arguments
    }

    /// Order s of the dynamics.
    pub fn order(&self) -> usize {
        self.saved.order
    }

    /// Number of samples in the sums.
    pub fn samples(&self) -> usize {
        self.saved.points.len() / self.saved.arguments
    }

    /// The kernel K.
    pub fn kernel(&self) -> &KernelSpec {
        &self.saved.kernel
    }

    /// Writes the model as JSON, with its `version`; [`IdentifiedModel::load`] brings back the same bits.
    ///
    /// # Errors
    /// A file that cannot be written.
    pub fn save(&self, path: &Path) -> Result<(), ModelFileError> {
        let text =
            serde_json::to_string(self).map_err(|error| ModelFileError::json(path, &error))?;
        fs::write(path, text).map_err(|error| ModelFileError::io(path, &error))
    }

    /// Reads a model that [`IdentifiedModel::save`] wrote.
    ///
    /// # Errors
    /// A file that cannot be read, is no JSON of a model, or holds a model that is not consistent.
    pub fn load(path: &Path) -> Result<Self, ModelFileError> {
        let text = fs::read_to_string(path).map_err(|error| ModelFileError::io(path, &error))?;
        serde_json::from_str(&text).map_err(|error| ModelFileError::json(path, &error))
    }
}

fn check_length(what: &'static str, expected: usize, found: usize) -> Result<(), EvaluationError> {
    if expected == found { Ok(()) } else { Err(EvaluationError { what, expected, found }) }
}

impl SavedModel {
    fn tile(&self, samples: Range<usize>) -> Tile {
        let (d, n, m) = (self.arguments, self.dimension, self.inputs);
        let mut tile = Tile {
            samples: samples.len(),
            points: Vec::new(),
            drift: Vec::new(),
            effectiveness: Vec::new(),
        };
        coordinate_by_coordinate(
            &self.points[samples.start * d..samples.end * d],
            d,
            &mut tile.points,
        );
        coordinate_by_coordinate(
            &self.coefficients[samples.start * n..samples.end * n],
            n,
            &mut tile.drift,
        );
        for i in 0..n {
            for j in 0..m {
                let entry = |k: usize| self.coefficients[k * n + i] * self.sample_inputs[k * m + j];
                tile.effectiveness.extend(samples.clone().map(entry));
            }
        }
        tile
    }

    fn validate(&self) -> Result<(), SavedModelError> {
        if self.version != VERSION {
            return Err(SavedModelError::Version { expected: VERSION, found: self.version });
        }
        for (what, count) in
            [("order", self.order), ("dimension", self.dimension), ("arguments", self.arguments)]
        {
            if count == 0 {
                return Err(SavedModelError::Zero { what });
            }
        }
        self.kernel.validate(self.arguments)?;
        let samples = self.points.len() / self.arguments;
        let lengths = [
            ("points", self.arguments, self.points.len()),
            ("coefficients", self.dimension, self.coefficients.len()),
            ("sample_inputs", self.inputs, self.sample_inputs.len()),
        ];
        for (what, columns, found) in lengths {
            if columns.checked_mul(samples) != Some(found) {
                return Err(SavedModelError::Length { what, samples, columns, found });
            }
        }
        Ok(())
    }
}

impl TryFrom<SavedModel> for IdentifiedModel {
    type Error = SavedModelError;

    fn try_from(saved: SavedModel) -> Result<Self, SavedModelError> {
        saved.validate()?;
        Ok(Self::of_saved(saved))
    }
}

impl From<IdentifiedModel> for SavedModel {
    fn from(model: IdentifiedModel) -> Self {
        model.saved
    }
}

/// A slice of the wrong length.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error("{what} must have {expected} entries, found {found}")]
pub struct EvaluationError {
    /// Which slice.
    pub what: &'static str,
    /// Its length for this model.
    pub expected: usize,
    /// Its length.
    pub found: usize,
}

/// A saved model that is not consistent.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum SavedModelError {
    /// Written by another version.
    #[error("expected version {expected} of the model's format, found {found}")]
    Version {
        /// Version that this program reads.
        expected: u32,
        /// Version of the file.
        found: u32,
    },
    /// A count of zero.
    #[error("{what} must be at least 1, found 0")]
    Zero {
        /// Which count.
        what: &'static str,
    },
    /// Kernel parameters out of range.
    #[error(transparent)]
    Kernel(#[from] KernelError),
    /// Arrays that do not fit together.
    #[error("{what}: expected {samples} samples of {columns} values, found {found} values")]
    Length {
        /// Which array.
        what: &'static str,
        /// Number of samples, from the length of `points`.
        samples: usize,
        /// Values per sample.
        columns: usize,
        /// Length of the array.
        found: usize,
    },
}

/// A model file that cannot be read or written.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum ModelFileError {
    /// The file system said no.
    #[error("{path}: {reason}", path = path.display())]
    Io {
        /// The file.
        path: PathBuf,
        /// Kind of the error.
        kind: std::io::ErrorKind,
        /// What the system said.
        reason: String,
    },
    /// The file is no model: not JSON, or not consistent.
    #[error("{path}: {reason}", path = path.display())]
    Json {
        /// The file.
        path: PathBuf,
        /// What is wrong, and where.
        reason: String,
    },
}

impl ModelFileError {
    fn io(path: &Path, error: &std::io::Error) -> Self {
        Self::Io { path: path.to_owned(), kind: error.kind(), reason: error.to_string() }
    }

    fn json(path: &Path, error: &serde_json::Error) -> Self {
        Self::Json { path: path.to_owned(), reason: error.to_string() }
    }
}
