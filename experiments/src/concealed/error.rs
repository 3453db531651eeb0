//! Why the proof could not be carried out.

use std::path::PathBuf;
use thiserror::Error;

/// Failures of the concealed-physics proof.
#[derive(Debug, Error)]
pub enum ConcealedError {
    /// A plant's model file is wrong.
    #[error("a plant of the proof is wrong: {reason}")]
    Plant {
        /// What the model reader says.
        reason: String,
    },
    /// No fair case could be drawn.
    #[error("none of {attempts} draws made a fair case of '{topic}'")]
    NoCase {
        /// The topic.
        topic: String,
        /// Draws.
        attempts: usize,
    },
    /// The tool under test is not there.
    #[error(
        "there is no `lacuna` command at {path}; build it with `cargo build --release -p lacuna`, \
         or say where it is with --lacuna PATH"
    )]
    NoBinary {
        /// Where it was looked for.
        path: PathBuf,
    },
    /// The tool under test could not be started.
    #[error("{program} could not be run")]
    Run {
        /// The program.
        program: PathBuf,
        /// Why.
        source: std::io::Error,
    },
    /// A file of results holds no finding with what it rests on.
    #[error(
        "{path} holds no finding with its evidence, which a probability could be calibrated with"
    )]
    NoEvidence {
        /// The file.
        path: PathBuf,
    },
    /// A recording could not be written or read.
    #[error(transparent)]
    Recording(#[from] lacuna_recordings::RecordingError),
    /// A model file could not be read.
    #[error(transparent)]
    Model(#[from] lacuna_plants::ModelError),
}
