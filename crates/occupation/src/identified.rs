//! The identified model: drift and control effectiveness as sums over samples.

use std::fs;
use std::path::{Path, PathBuf};

use faer::Mat;
use serde::{Deserialize, Serialize};

use crate::kernel::{Kernel, KernelError, KernelSpec};
use crate::occupation_kernels::OccupationKernels;

/// Version of the saved form.
const VERSION: u32 = 1;

/// Kernel values computed at a time, on the stack.
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
#[serde(try_from = "SavedModel")]
pub struct IdentifiedModel {
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
        let mut model = Self {
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
                model.points.extend_from_slice(occupation.argument(k));
                model.coefficients.extend_from_slice(coefficient);
                model.sample_inputs.extend_from_slice(occupation.input(k));
            }
        }
        model
    }

    /// Writes the drift f(x) (n) and the control effectiveness g(x) (n x m, row-major) at x (d). Allocates nothing.
    ///
    /// # Errors
    /// A slice of another length than d, n or n m.
    pub fn evaluate(&self, x: &[f64], f: &mut [f64], g: &mut [f64]) -> Result<(), EvaluationError> {
        check_length("x", self.arguments, x.len())?;
        check_length("f", self.dimension, f.len())?;
        check_length("g", self.dimension * self.inputs, g.len())?;
        f.fill(0.0);
        g.fill(0.0);
        let mut values = [0.0; TILE];
        for start in (0..self.samples()).step_by(TILE) {
            let values = &mut values[..TILE.min(self.samples() - start)];
            let end = start + values.len();
            self.kernel.evaluate_row(
                x,
                &self.points[start * self.arguments..end * self.arguments],
                values,
            );
            for (k, &value) in (start..end).zip(values.iter()) {
                self.add_sample(k, value, f, g);
            }
        }
        Ok(())
    }

    fn add_sample(&self, k: usize, value: f64, f: &mut [f64], g: &mut [f64]) {
        let coefficients = &self.coefficients[k * self.dimension..(k + 1) * self.dimension];
        let input = &self.sample_inputs[k * self.inputs..(k + 1) * self.inputs];
        for (i, coefficient) in coefficients.iter().enumerate() {
            let part = coefficient * value;
            f[i] += part;
            for (entry, u) in g[i * self.inputs..(i + 1) * self.inputs].iter_mut().zip(input) {
                *entry += part * u;
            }
        }
    }

    /// Number n of coordinates.
    pub fn dimension(&self) -> usize {
        self.dimension
    }

    /// Number m of inputs.
    pub fn inputs(&self) -> usize {
        self.inputs
    }

    /// Number d of arguments x.
    pub fn arguments(&self) -> usize {
        self.arguments
    }

    /// Order s of the dynamics.
    pub fn order(&self) -> usize {
        self.order
    }

    /// Number of samples in the sums.
    pub fn samples(&self) -> usize {
        self.points.len() / self.arguments
    }

    /// The kernel K.
    pub fn kernel(&self) -> &KernelSpec {
        &self.kernel
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

/// The fields of a model as they stand in a file, before they are checked.
#[derive(Deserialize)]
struct SavedModel {
    version: u32,
    kernel: KernelSpec,
    order: usize,
    dimension: usize,
    inputs: usize,
    arguments: usize,
    points: Vec<f64>,
    coefficients: Vec<f64>,
    sample_inputs: Vec<f64>,
}

impl TryFrom<SavedModel> for IdentifiedModel {
    type Error = SavedModelError;

    fn try_from(saved: SavedModel) -> Result<Self, SavedModelError> {
        if saved.version != VERSION {
            return Err(SavedModelError::Version { expected: VERSION, found: saved.version });
        }
        for (what, count) in
            [("order", saved.order), ("dimension", saved.dimension), ("arguments", saved.arguments)]
        {
            if count == 0 {
                return Err(SavedModelError::Zero { what });
            }
        }
        saved.kernel.validate(saved.arguments)?;
        let samples = saved.points.len() / saved.arguments;
        let lengths = [
            ("points", saved.arguments, saved.points.len()),
            ("coefficients", saved.dimension, saved.coefficients.len()),
            ("sample_inputs", saved.inputs, saved.sample_inputs.len()),
        ];
        for (what, columns, found) in lengths {
            if columns.checked_mul(samples) != Some(found) {
                return Err(SavedModelError::Length { what, samples, columns, found });
            }
        }
        Ok(Self {
            version: saved.version,
            kernel: saved.kernel,
            order: saved.order,
            dimension: saved.dimension,
            inputs: saved.inputs,
            arguments: saved.arguments,
            points: saved.points,
            coefficients: saved.coefficients,
            sample_inputs: saved.sample_inputs,
        })
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
