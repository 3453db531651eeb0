//! Why a study could not be finished.

use lacuna_charts::ChartError;
use lacuna_control::ControlError;
use lacuna_excitation::{InitialStateError, NoiseError, SinusoidError};
use lacuna_occupation::compile::CompileError;
use lacuna_occupation::{EvaluationError, FitError, TrajectoryError};
use lacuna_plants::SimulationError;
use std::path::PathBuf;
use thiserror::Error;

use crate::recipes::IdentificationError;

impl From<FitError> for StudyError {
    fn from(error: FitError) -> Self {
        Self::Identification(error.into())
    }
}

/// Failures of the studies.
#[derive(Debug, Error)]
pub enum StudyError {
    /// Initial states could not be laid out.
    #[error(transparent)]
    InitialStates(#[from] InitialStateError),
    /// No input could be drawn.
    #[error(transparent)]
    Input(#[from] SinusoidError),
    /// No noise could be drawn.
    #[error(transparent)]
    Noise(#[from] NoiseError),
    /// The plant could not be simulated.
    #[error(transparent)]
    Simulation(#[from] SimulationError),
    /// The samples make no trajectory.
    #[error(transparent)]
    Trajectory(#[from] TrajectoryError),
    /// A recipe made no model of the data.
    #[error(transparent)]
    Identification(#[from] IdentificationError),
    /// The identified model does not have the arguments and coordinates of the plant.
    #[error(transparent)]
    Evaluation(#[from] EvaluationError),
    /// The identified model could not be compiled.
    #[error(transparent)]
    Compile(#[from] CompileError),
    /// No pool of threads could be had.
    #[error(transparent)]
    Threads(#[from] rayon::ThreadPoolBuildError),
    /// The controlled plant could not be simulated.
    #[error(transparent)]
    Control(#[from] ControlError),
    /// The proof on concealed physics could not be carried out.
    #[error(transparent)]
    Concealed(#[from] crate::concealed::ConcealedError),
    /// A figure could not be drawn.
    #[error(transparent)]
    Figure(#[from] ChartError),
    /// A file could not be read.
    #[error("cannot read {path}")]
    Read {
        /// The file.
        path: PathBuf,
        /// Why.
        source: std::io::Error,
    },
    /// A file of published curves does not hold what is looked for.
    #[error("{path} holds no published curve of the choice of lambda")]
    Published {
        /// The file.
        path: PathBuf,
        /// Why.
        source: serde_json::Error,
    },
    /// A file of results does not hold what is looked for.
    #[error("{path} holds other results than these")]
    Content {
        /// The file.
        path: PathBuf,
        /// Why.
        source: serde_json::Error,
    },
    /// There is no number that decides of this name.
    #[error("no number that decides is called '{name}'; there are {known}")]
    NoField {
        /// The name.
        name: String,
        /// Those that there are.
        known: String,
    },
    /// A result has no JSON form.
    #[error("cannot write {path} as JSON")]
    Json {
        /// The file.
        path: PathBuf,
        /// Why.
        source: serde_json::Error,
    },
    /// A file could not be written.
    #[error("cannot write {path}")]
    Write {
        /// The file.
        path: PathBuf,
        /// Why.
        source: std::io::Error,
    },
}
