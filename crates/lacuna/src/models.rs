//! A model of equations (TOML, a robot's file, an FMU) or one that `lacuna identify` wrote (JSON), known by its text, and what can
//! be done with either.

use crate::discrepancy::{Dataset, DiagnoseError, IdentifiedPredictor, Prediction, Predictor};
use crate::occupation::compile::Compiled;
use crate::occupation::{IdentifiedModel, ModelFileError, Names};
use crate::plants::Model;
use crate::recordings::{Recording, RecordingError, RecordingSource, Wanted, read_log};
use std::error::Error;
use std::path::Path;

/// A model that can be run on a recording.
#[derive(Clone, Debug)]
pub enum AnyModel {
    /// Equations with parameters.
    Equations(Box<Model>),
    /// Identified from recordings, and what its columns are called.
    Identified(Box<(IdentifiedModel, Names)>),
}

impl AnyModel {
    /// Read a model file of either kind, for a recording, if it is known ([`Model::driven_by`]).
    ///
    /// # Errors
    /// What is wrong with the file, with its path.
    pub fn read(path: &Path, like: Option<&RecordingSource>) -> Result<Self, Box<dyn Error>> {
        if !is_json_object(path) {
            return Ok(Self::Equations(Box::new(read_for(path, like)?)));
        }
        let model = IdentifiedModel::load(path).map_err(|e| match e {
            ModelFileError::Json { path, reason } => format!(
                "{}: a JSON file, but no model that `lacuna identify` wrote: {reason}",
                path.display()
            ),
            error @ ModelFileError::Io { .. } => error.to_string(),
        })?;
        match model.names().cloned() {
            Some(names) => Ok(Self::Identified(Box::new((model, names)))),
            None => Err(format!("{}: {}", path.display(), DiagnoseError::Unnamed).into()),
        }
    }

    /// The name of its equations; what is identified is called by its file.
    pub fn name(&self, file: &str) -> String {
        match self {
            Self::Equations(model) => model.name.clone(),
            Self::Identified(_) => file.to_owned(),
        }
    }

    /// Column of time in recordings.
    pub fn time_column(&self) -> &str {
        match self {
            Self::Equations(model) => &model.time_column,
            Self::Identified(identified) => &identified.1.time,
        }
    }

    /// Seconds in one unit of that column.
    pub fn time_seconds(&self) -> f64 {
        match self {
            Self::Equations(model) => model.time_seconds,
            Self::Identified(_) => 1.0,
        }
    }

    /// What it uses of a file.
    pub fn wanted(&self) -> Wanted {
        match self {
            Self::Equations(model) => Dataset::wanted(model),
            Self::Identified(identified) => {
                let (model, names) = &**identified;
                Dataset::wanted_by_identified(names, model.order())
            }
        }
    }

    /// What it uses of a recording.
    ///
    /// # Errors
    /// What is wrong with the file, with its path.
    pub fn recording(&self, source: &RecordingSource) -> Result<Recording, RecordingError> {
        Ok(read_log(source, &self.wanted())?.recording)
    }

    /// A recording in the model's channels.
    ///
    /// # Errors
    /// What does not fit the model, with the names of the recording and column.
    pub fn dataset(&self, recording: &Recording) -> Result<Dataset, DiagnoseError> {
        let recording = std::slice::from_ref(recording);
        match self {
            Self::Equations(model) => Dataset::new(model, recording),
            Self::Identified(identified) => {
                let (model, names) = &**identified;
                Dataset::of_identified(names, model.order(), recording)
            }
        }
    }

    /// Windows of `horizon` seconds, or a free run without it, whose state the first `warmup` samples
    /// tell.
    ///
    /// # Errors
    /// Channels that cannot be smoothed.
    pub fn predict(
        &self,
        dataset: &Dataset,
        horizon: Option<f64>,
        warmup: usize,
    ) -> Result<Prediction, DiagnoseError> {
        let observed = &dataset.recordings[0];
        match self {
            Self::Equations(model) => {
                let predictor = Predictor::new(model, dataset);
                Ok(match horizon {
                    Some(horizon) => predictor.windowed(observed, horizon),
                    None => predictor.free_run(observed, warmup),
                })
            }
            Self::Identified(identified) => {
                let predictor = IdentifiedPredictor::new(&identified.0, dataset)?;
                match horizon {
                    Some(horizon) => predictor.windowed(observed, horizon),
                    None => predictor.free_run(observed, warmup),
                }
            }
        }
    }
}

/// A model without equations: as it was identified, or compiled.
pub enum LearnedModel {
    /// Of `lacuna identify`.
    Identified(Box<(IdentifiedModel, Names)>),
    /// Of `lacuna compile`.
    Compiled(Box<Compiled>),
}

impl LearnedModel {
    /// Read a JSON file of either kind.
    ///
    /// # Errors
    /// What is wrong with the file, with its path.
    pub fn read(path: &Path) -> Result<Self, Box<dyn Error>> {
        let text = std::fs::read_to_string(path).map_err(|e| format!("{}: {e}", path.display()))?;
        if !is_json_object(path) {
            return Err(format!(
                "{}: no JSON file; expected model.json of `lacuna identify`. A model of equations \
                 (TOML) is evaluated as it is, and need not be compiled",
                path.display()
            )
            .into());
        }
        let value: serde_json::Value =
            serde_json::from_str(&text).map_err(|e| format!("{}: {e}", path.display()))?;
        if value.get("compiled").is_some() {
            return Ok(Self::Compiled(Box::new(Compiled::load(path)?)));
        }
        match AnyModel::read(path, None)? {
            AnyModel::Identified(identified) => Ok(Self::Identified(identified)),
            AnyModel::Equations(_) => {
                Err(format!("{}: no identified model", path.display()).into())
            }
        }
    }
}

/// Read a model of equations, for what needs its parameters and laws, and for a recording, if it is known
/// ([`Model::driven_by`]).
///
/// # Errors
/// What is wrong with the file, with its path.
pub fn read_equations(
    path: &Path,
    like: Option<&RecordingSource>,
) -> Result<Model, Box<dyn Error>> {
    // A file of numbers in one line is no help where the reader of models points at its mistake.
    if is_json_object(path) {
        return Err(no_equations(&path.display().to_string()).into());
    }
    read_for(path, like)
}

/// A model as a recording drives it. A recording that cannot be read is left to who reads it next.
fn read_for(path: &Path, like: Option<&RecordingSource>) -> Result<Model, Box<dyn Error>> {
    let model = Model::read(path)?;
    let like = like.filter(|_| model.has_servos_of_file());
    let all = Wanted::all(&model.time_column).counting(model.time_seconds);
    let log = like.and_then(|like| read_log(like, &all).ok());
    let columns = log.into_iter().flat_map(|log| log.recording.columns).map(|column| column.name);
    Ok(model.driven_by(&columns.collect::<Vec<_>>())?)
}

/// What is said of an identified model in the place of one of equations; `called` is its file.
pub fn no_equations(called: &str) -> String {
    format!(
        "{called}: a JSON file, such as `lacuna identify` writes for `lacuna simulate`; expected a model of \
         equations (TOML)"
    )
}

/// Whether the first sign of the text is that of a JSON object: no TOML begins with it. A file
/// that cannot be read is left to the reader of models, which says why.
fn is_json_object(path: &Path) -> bool {
    let bytes = std::fs::read(path).unwrap_or_default();
    let text = bytes.strip_prefix("\u{feff}".as_bytes()).unwrap_or(&bytes);
    text.trim_ascii_start().starts_with(b"{")
}
