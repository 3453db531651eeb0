//! What can be wrong with an FMU.

use thiserror::Error;

/// What is wrong with an FMU and what to do; its path is known to who opens it.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum FmuError {
    /// The file, or a folder to unpack it into, cannot be read or written.
    #[error("cannot be read: {reason}")]
    Io {
        /// What the operating system says.
        reason: String,
    },
    /// It is no archive, or a damaged one.
    #[error("is no FMU: an FMU is a ZIP archive ({reason})")]
    NoArchive {
        /// What is wrong.
        reason: String,
    },
    /// An entry that would be written elsewhere than into the folder it is unpacked into.
    #[error("holds '{entry}', {what}: such an archive is not unpacked")]
    Escapes {
        /// The entry.
        entry: String,
        /// What it is.
        what: &'static str,
    },
    /// More than anyone would unpack.
    #[error("holds {what} of {found}; at most {limit} are unpacked")]
    TooLarge {
        /// Of what.
        what: String,
        /// How much there is.
        found: String,
        /// How much there may be.
        limit: String,
    },
    /// An entry is not as large as the archive says.
    #[error(
        "is damaged, or made to be unpacked into more than it says: '{entry}' is not of {declared} bytes"
    )]
    Disguised {
        /// The entry.
        entry: String,
        /// Its size by the archive.
        declared: u64,
    },
    /// Something that an FMU must hold.
    #[error("has no {missing}{instead}")]
    Missing {
        /// What is missing.
        missing: String,
        /// What there is in its place; may be empty.
        instead: String,
    },
    /// `modelDescription.xml` says something that it cannot.
    #[error("{}{message}", line.map_or_else(|| "modelDescription.xml: ".to_owned(), |n| format!("modelDescription.xml, line {n}: ")))]
    Description {
        /// The line, from 1.
        line: Option<u32>,
        /// What is wrong.
        message: String,
    },
    /// It needs what is not supported.
    #[error("{what}")]
    Unsupported {
        /// What it needs, and what to do.
        what: String,
    },
    /// It cannot be evaluated.
    #[error("cannot be evaluated: {reason}")]
    Evaluation {
        /// Why.
        reason: String,
    },
    /// The program that reads it does not know how to evaluate it.
    #[error("cannot be evaluated: this program has not called lacuna_fmu::evaluate_with")]
    NoEvaluator,
}

impl FmuError {
    pub(crate) fn io(error: impl std::fmt::Display) -> Self {
        Self::Io { reason: error.to_string() }
    }

    pub(crate) fn unsupported(what: impl Into<String>) -> Self {
        Self::Unsupported { what: what.into() }
    }
}
