//! The file of an identified model: JSON with a version.

use std::fs;
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use super::Uncertainty;
use super::expansion::MOST_ARGUMENTS;
use super::uncertainty::SavedRow;
use super::{Expansion, IdentifiedModel, OccupationExpansion, SavedExpansion, SavedOccupation};
use crate::identification::InputPath;
use crate::kernel::KernelError;

/// Version of the saved form ...
const VERSION: u32 = 3;
/// ... and the oldest that can be read: it has no sums of occupation kernels.
const OLDEST: u32 = 2;

/// What the model's coordinates, inputs and arguments are called, and in which units.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Names {
    /// Name of the n coordinates.
    pub coordinates: Vec<String>,
    /// Columns that measure their rates, for models of order 2.
    pub rates: Vec<Option<String>>,
    /// Name of the m inputs.
    pub inputs: Vec<String>,
    /// Name of the d arguments.
    pub arguments: Vec<String>,
    /// Column of time.
    pub time: String,
    /// What the inputs do between samples.
    pub input_path: InputPath,
}

/// What the file holds.
#[derive(Debug, Serialize, Deserialize)]
struct SavedModel {
    version: u32,
    order: usize,
    dimension: usize,
    inputs: usize,
    arguments: usize,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    names: Option<Names>,
    expansions: Vec<SavedExpansion>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    occupation: Option<SavedOccupation>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    uncertainty: Option<Vec<SavedRow>>,
}

impl IdentifiedModel {
    /// Writes the model as JSON, with its `version`; [`IdentifiedModel::load`] brings back the
    /// same f and g to the last bit, and their standard deviations to rounding (they are solved for anew).
    ///
    /// # Errors
    /// A file that cannot be written.
    pub fn save(&self, path: &Path) -> Result<(), ModelFileError> {
        fs::write(path, self.to_json()).map_err(|error| ModelFileError::io(path, &error))
    }

    /// The text that [`IdentifiedModel::save`] writes.
    pub fn to_json(&self) -> String {
        let saved = SavedModel {
            version: VERSION,
            order: self.order,
            dimension: self.dimension,
            inputs: self.inputs,
            arguments: self.arguments,
            names: self.names.clone(),
            expansions: self.expansions.iter().map(|e| e.saved.clone()).collect(),
            occupation: self.occupation.as_ref().map(|e| e.saved.clone()),
            uncertainty: self.uncertainty.as_ref().map(Uncertainty::saved),
        };
        serde_json::to_string(&saved).expect("numbers and strings become JSON")
    }

    /// Reads a model that [`IdentifiedModel::save`] wrote.
    ///
    /// # Errors
    /// A file that cannot be read, is no JSON of a model, or holds a model that is not consistent.
    pub fn load(path: &Path) -> Result<Self, ModelFileError> {
        let text = fs::read_to_string(path).map_err(|error| ModelFileError::io(path, &error))?;
        Self::from_json(&text)
            .map_err(|reason| ModelFileError::Json { path: path.to_owned(), reason })
    }

    /// Reads the text that [`IdentifiedModel::to_json`] made.
    ///
    /// # Errors
    /// What is wrong where the text is no JSON of a model, or holds a model that is not consistent.
    pub fn from_json(text: &str) -> Result<Self, String> {
        let json = |error: serde_json::Error| error.to_string();
        let VersionOnly { version: found } = serde_json::from_str(text).map_err(json)?;
        if !(OLDEST..=VERSION).contains(&found) {
            return Err(SavedModelError::Version { expected: VERSION, found }.to_string());
        }
        let saved: SavedModel = serde_json::from_str(text).map_err(json)?;
        saved.restore().map_err(|error| error.to_string())
    }
}

fn restore_occupation(
    saved: SavedOccupation,
    [n, m, d]: [usize; 3],
) -> Result<OccupationExpansion, SavedModelError> {
    saved.kernel.validate(d)?;
    let samples = saved.functionals.len();
    let lengths = [
        ("lengths", samples, saved.lengths.iter().fold(0, |sum: usize, l| sum.saturating_add(*l))),
        ("points", samples.saturating_mul(d), saved.points.len()),
        ("inputs", samples.saturating_mul(m), saved.inputs.len()),
        ("weights", saved.lengths.len().saturating_mul(n), saved.weights.len()),
    ];
    if let Some((what, expected, found)) = lengths.into_iter().find(|(_, e, f)| e != f) {
        return Err(SavedModelError::Length { what, expected, found });
    }
    let too_many = SavedModelError::Entry { row: n, block: m };
    OccupationExpansion::new(saved, [d, m, n]).ok_or(too_many)
}

#[derive(Deserialize)]
struct VersionOnly {
    version: u32,
}

impl SavedModel {
    fn restore(self) -> Result<IdentifiedModel, SavedModelError> {
        for (what, count) in
            [("order", self.order), ("dimension", self.dimension), ("arguments", self.arguments)]
        {
            if count == 0 {
                return Err(SavedModelError::Zero { what });
            }
        }
        self.expansions.iter().try_for_each(|e| self.check(e))?;
        self.check_names()?;
        let (d, n) = (self.arguments, self.dimension);
        let uncertainty = match self.uncertainty {
            Some(rows) if rows.len() == n => {
                Some(Uncertainty::restore(rows, d).ok_or(SavedModelError::Uncertainty)?)
            }
            Some(_) => return Err(SavedModelError::Uncertainty),
            None => None,
        };
        let expansions = self.expansions.into_iter().map(|e| Expansion::new(e, d)).collect();
        let shape = [n, self.inputs, d];
        let mut model = IdentifiedModel::of_expansions(self.order, shape, expansions, uncertainty);
        model.occupation =
            self.occupation.map(|saved| restore_occupation(saved, shape)).transpose()?;
        Ok(match self.names {
            Some(names) => model.with_names(names),
            None => model,
        })
    }

    fn check(&self, e: &SavedExpansion) -> Result<(), SavedModelError> {
        let d = self.arguments;
        e.kernel.validate(d)?;
        if !e.widths.is_empty() && d > MOST_ARGUMENTS {
            let (expected, found) = (MOST_ARGUMENTS, d);
            return Err(SavedModelError::Length { what: "widths", expected, found });
        }
        let points = e.points.len() / d;
        let mut lengths = vec![
            ("points", points * d, e.points.len()),
            ("weights", points * e.entries.len(), e.weights.len()),
        ];
        if !(e.widths.is_empty() && e.centre.is_empty()) {
            lengths.extend([("centre", d, e.centre.len()), ("widths", d, e.widths.len())]);
        }
        if let Some((what, expected, found)) = lengths.into_iter().find(|(_, e, f)| e != f) {
            return Err(SavedModelError::Length { what, expected, found });
        }
        let outside = |&(i, block): &(usize, usize)| i >= self.dimension || block > self.inputs;
        match e.entries.iter().find(|entry| outside(entry)) {
            Some(&(row, block)) => Err(SavedModelError::Entry { row, block }),
            None => Ok(()),
        }
    }

    fn check_names(&self) -> Result<(), SavedModelError> {
        let Some(names) = &self.names else { return Ok(()) };
        let lengths = [
            ("names of coordinates", self.dimension, names.coordinates.len()),
            ("names of rates", self.dimension, names.rates.len()),
            ("names of inputs", self.inputs, names.inputs.len()),
            ("names of arguments", self.arguments, names.arguments.len()),
        ];
        match lengths.into_iter().find(|(_, expected, found)| expected != found) {
            Some((what, expected, found)) => Err(SavedModelError::Length { what, expected, found }),
            None => Ok(()),
        }
    }
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
    #[error("{what}: expected {expected} values, found {found}")]
    Length {
        /// Which array.
        what: &'static str,
        /// Values that the others ask for.
        expected: usize,
        /// Length of the array.
        found: usize,
    },
    /// A function that the model does not have.
    #[error("there is no function of row {row} and block {block}")]
    Entry {
        /// Row i.
        row: usize,
        /// Block, 0 for f_i and j for g_ij.
        block: usize,
    },
    /// Landmarks or covariances that do not fit together.
    #[error("the standard deviations do not fit the model")]
    Uncertainty,
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
    pub(crate) fn io(path: &Path, error: &std::io::Error) -> Self {
        Self::Io { path: path.to_owned(), kind: error.kind(), reason: error.to_string() }
    }
}
