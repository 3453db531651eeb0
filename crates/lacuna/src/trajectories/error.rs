//! What is wrong with trajectories in files.

use crate::occupation::IdentificationError;
use crate::recordings::RecordingError;
use std::path::PathBuf;
use thiserror::Error;

/// Files of which no trajectories can be read.
#[derive(Debug, Error)]
pub enum TrajectoriesError {
    /// No coordinate is named.
    #[error("at least one coordinate is needed; found none")]
    NoCoordinate,
    /// Not a rate for every coordinate.
    #[error("expected a rate for each of the {expected} coordinates, found {found}")]
    Rates {
        /// Number of coordinates.
        expected: usize,
        /// Number of rates.
        found: usize,
    },
    /// A column that is to be two things.
    #[error("column '{column}' is named twice")]
    Twice {
        /// The column.
        column: String,
    },
    /// A pattern that is none, or a folder that cannot be read.
    #[error("'{pattern}': {reason}")]
    Pattern {
        /// The pattern.
        pattern: String,
        /// What is wrong.
        reason: String,
    },
    /// Not a row.
    #[error("'{pattern}' matches {files} files, and they have no rows; expected trajectories")]
    Nothing {
        /// The pattern.
        pattern: String,
        /// Number of files.
        files: usize,
    },
    /// A file that cannot be read.
    #[error(transparent)]
    File(#[from] RecordingError),
    /// A row group that cannot be read.
    #[error("row group {group}: {source}")]
    Group {
        /// The row group, from 0.
        group: usize,
        /// Why.
        source: RecordingError,
    },
    /// A file that was changed since it was looked at.
    #[error("{file}: row groups {from}..{to} have {found} rows, where they had {expected}; was the file changed meanwhile?", file = file.display())]
    Changed {
        /// The file.
        file: PathBuf,
        /// First row group.
        from: usize,
        /// One past the last.
        to: usize,
        /// Rows at first.
        expected: usize,
        /// Rows now.
        found: usize,
    },
    /// A number that is missing or not finite.
    #[error("{file}, row group {group}, row {row} (from 0): {column} is {found}, expected a finite number", file = file.display())]
    NotFinite {
        /// The file.
        file: PathBuf,
        /// The row group, from 0.
        group: usize,
        /// Row within it, from 0.
        row: usize,
        /// The column.
        column: String,
        /// The number.
        found: f64,
    },
    /// A number of a trajectory that is not told apart from its neighbours.
    #[error("{file}, row group {group}, row {row} (from 0): {column} is {found}; trajectories are numbered by whole numbers below 2^53", file = file.display())]
    Number {
        /// The file.
        file: PathBuf,
        /// The row group, from 0.
        group: usize,
        /// Row within it, from 0.
        row: usize,
        /// The column.
        column: String,
        /// The number.
        found: f64,
    },
    /// A trajectory that cannot be used.
    #[error("{file}, row group {group}, {samples} rows from row {row} (from 0) on{name}: {source}", file = file.display())]
    Trajectory {
        /// The file.
        file: PathBuf,
        /// The row group in which it begins, from 0.
        group: usize,
        /// Its first row within that, from 0.
        row: usize,
        /// Number of its rows.
        samples: usize,
        /// Its number, as ` (id = 3)`.
        name: String,
        /// What is wrong.
        source: Box<IdentificationError>,
    },
    /// Data or sums from which nothing can be identified.
    #[error(transparent)]
    Identification(#[from] IdentificationError),
}
