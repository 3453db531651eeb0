//! What can be wrong with a recording, with the place, what was found and what to do.

use std::io;
use std::path::PathBuf;

use lacuna_units::names::did_you_mean;
use thiserror::Error;

use crate::source::Selection;
use crate::table::TableError;

/// A recording that cannot be read, written or used as asked. Every variant names the
/// file (or the recording) it speaks of; lines are counted from 1, as editors do.
#[derive(Debug, Error)]
pub enum RecordingError {
    /// The file cannot be opened or read.
    #[error("cannot read {path}: {source}; check the path and its permissions", path = path.display())]
    Unreadable {
        /// The file asked for.
        path: PathBuf,
        /// What the operating system said.
        source: io::Error,
    },
    /// No reader knows the file, neither by its name nor by its first bytes.
    #[error(
        "{file}: no reader for {} files{}; formats that are read: {}",
        named(extension),
        looks_like(found),
        list(known)
    )]
    UnknownFormat {
        /// The file.
        file: String,
        /// Extension of its name.
        extension: String,
        /// What its first bytes say it is, and what to do with it.
        found: Option<(&'static str, &'static str)>,
        /// Formats and their extensions.
        known: Vec<String>,
    },
    /// The file is of another kind than CSV.
    #[error("{file} is not a CSV file: it looks like {found}; {advice}")]
    NotCsv {
        /// The file.
        file: String,
        /// What its first bytes say it is.
        found: &'static str,
        /// How to turn it into CSV.
        advice: &'static str,
    },
    /// The bytes are not UTF-8 text.
    #[error("{file}, line {line}: the text is not UTF-8; save the file as UTF-8 text")]
    NotUtf8 {
        /// The file.
        file: String,
        /// Line of the first bad byte.
        line: usize,
    },
    /// Nothing is in the file but blank lines and comments.
    #[error(
        "{file} is empty: a header line with the column names and at least one row of numbers \
         are needed"
    )]
    Empty {
        /// The file.
        file: String,
    },
    /// The file ends after its header line.
    #[error("{file} has a header line (line {line}) but no rows; was the recording interrupted?")]
    HeaderOnly {
        /// The file.
        file: String,
        /// Line of the header.
        line: usize,
    },
    /// The first line holds numbers where column names were expected.
    #[error(
        "{file}, line {line}: expected a header line with column names, found numbers ({found}); \
         write the names above the first row (without a leading #)"
    )]
    NoHeader {
        /// The file.
        file: String,
        /// Line that should have been the header.
        line: usize,
        /// What stands there.
        found: String,
    },
    /// Two columns share a name.
    #[error("{file}, line {line}: two columns are named '{column}'; give each its own name")]
    DuplicateColumn {
        /// The file.
        file: String,
        /// Line of the header.
        line: usize,
        /// The name that occurs twice.
        column: String,
    },
    /// A row has more or fewer cells than the header.
    #[error(
        "{file}, line {line}: expected {expected} cells as in the header, found {found}; \
         a missing value is written as an empty cell"
    )]
    RaggedRow {
        /// The file.
        file: String,
        /// Line of the row.
        line: usize,
        /// Number of columns of the header.
        expected: usize,
        /// Number of cells in the row.
        found: usize,
    },
    /// The file ends within its last row.
    #[error(
        "{file}, line {line}: the file ends within this row, after {found} of {expected} cells; was \
         the recording interrupted? Remove the row, or select those before it with #rows=0..{rows}"
    )]
    CutRow {
        /// The file.
        file: String,
        /// Line of the row.
        line: usize,
        /// Number of columns of the header.
        expected: usize,
        /// Number of cells in the row.
        found: usize,
        /// Number of rows before it.
        rows: usize,
    },
    /// A row of units, or other words, stands between the header and the numbers.
    #[error(
        "{file}, line {line}: expected the first row of numbers, found words ({found}); if they are \
         units, put a # in front of the line and state them in the model"
    )]
    WordsForNumbers {
        /// The file.
        file: String,
        /// Line of the row.
        line: usize,
        /// What stands there, shortened where it is long.
        found: String,
    },
    /// A cell holds something else than a finite number.
    #[error(
        "{file}, line {line}, column '{column}': expected a number, found '{found}'; numbers are \
         written with a decimal point, a missing value as an empty cell, nan, NA or N/A"
    )]
    NotANumber {
        /// The file.
        file: String,
        /// Line of the cell.
        line: usize,
        /// Name of its column.
        column: String,
        /// The text found, shortened where it is long.
        found: String,
    },
    /// Times are dates or times of day.
    #[error(
        "{file}, line {line}, column '{column}': expected a time as a number of seconds, found '{found}'; write the \
         seconds since the first row instead"
    )]
    TimeOfDay {
        /// The file.
        file: String,
        /// Line of the cell.
        line: usize,
        /// Name of the time column.
        column: String,
        /// The text found, shortened where it is long.
        found: String,
    },
    /// The file has no column of the name that time should have.
    #[error(
        "{file} has no time column '{wanted}'{}; its columns{separated} are: {}; the model's [recordings] section names the time column",
        did_you_mean(suggestion),
        list(available)
    )]
    NoTimeColumn {
        /// The file.
        file: String,
        /// The name asked for.
        wanted: String,
        /// How they are told apart, where that may be wrong.
        separated: &'static str,
        /// The columns that exist.
        available: Vec<String>,
        /// The nearest of them, where one is near.
        suggestion: Option<String>,
    },
    /// A row does not say when it was taken.
    #[error(
        "{file}, line {line}: the time column '{column}' is empty here; every row needs a time, \
         remove rows without one"
    )]
    MissingTime {
        /// The file.
        file: String,
        /// Line of the row.
        line: usize,
        /// Name of the time column.
        column: String,
    },
    /// Time stands still or runs backwards.
    #[error(
        "{file}: time does not increase: {earlier} s on line {earlier_line}, then {later} s on \
         line {line}; remove repeated rows, and split runs that were joined into one file each \
         (or select one with #rows=FROM..TO)"
    )]
    TimeNotIncreasing {
        /// The file.
        file: String,
        /// Line of the earlier row.
        earlier_line: usize,
        /// Its time, s.
        earlier: f64,
        /// Line of the next row.
        line: usize,
        /// Its time, s.
        later: f64,
    },
    /// A selection reaches beyond the rows of the file.
    #[error("{file} has {rows} rows, fewer than the selection {selection} asks for")]
    SelectionBeyondEnd {
        /// The file.
        file: String,
        /// The selection.
        selection: Selection,
        /// Rows in the file.
        rows: usize,
    },
    /// A selection holds no row.
    #[error("{file}: the selection {selection} holds none of the {rows} rows; widen it")]
    EmptySelection {
        /// The file.
        file: String,
        /// The selection.
        selection: Selection,
        /// Rows in the file.
        rows: usize,
    },
    /// A file that ends too soon, or is not what its name or first bytes say.
    #[error(
        "{file} cannot be read as {format}: {reason}; was the recording interrupted, or the file cut?"
    )]
    Broken {
        /// The file.
        file: String,
        /// The format.
        format: &'static str,
        /// What its reader found.
        reason: String,
    },
    /// A part of a file in a way of writing that is not read.
    #[error("{file}: {what} {found} is not read; {advice}")]
    NotRead {
        /// The file.
        file: String,
        /// What is written so.
        what: String,
        /// How.
        found: String,
        /// What to do.
        advice: &'static str,
    },
    /// No message of which a column is wanted.
    #[error(
        "{file} has no message of which a column is used; the columns of its topics are: {}",
        list(available)
    )]
    NoMessages {
        /// The file.
        file: String,
        /// The columns that exist.
        available: Vec<String>,
    },
    /// More memory than a file may make a reader take.
    #[error(
        "{file}: what it holds takes {} MiB of memory, where {} MiB are allowed; ask for fewer columns \
         ([[measurement]]), or split the file",
        needed >> 20,
        allowed >> 20
    )]
    TooLarge {
        /// The file.
        file: String,
        /// Bytes that it says it takes.
        needed: u64,
        /// Bytes that are allowed.
        allowed: u64,
    },
    /// A list that is longer in one row than in the first.
    #[error(
        "{file}, row {row} (from 0): the list '{column}' has more than the {expected} entries of the first \
         row; every entry is a column of its own"
    )]
    LongerList {
        /// The file.
        file: String,
        /// The list.
        column: String,
        /// The row.
        row: usize,
        /// Number of entries in the first row that has any.
        expected: usize,
    },
    /// Columns in memory that make no recording.
    #[error("{table}: {source}")]
    Table {
        /// Name of the recording.
        table: String,
        /// What is wrong with them.
        source: TableError,
    },
    /// The recording has no column of that name.
    #[error(
        "recording {recording} has no column '{wanted}'{}; its columns are: {}",
        did_you_mean(suggestion),
        list(available)
    )]
    NoSuchColumn {
        /// The recording.
        recording: String,
        /// The name asked for.
        wanted: String,
        /// The columns that exist.
        available: Vec<String>,
        /// The nearest of them, where one is near.
        suggestion: Option<String>,
    },
    /// No column measures anything that is looked for.
    #[error(
        "recording {recording} has none of the columns that are measured ({}); its columns are: {}; the model's \
         [[measurement]] sections say what columns measure",
        list(measured),
        list(available)
    )]
    NothingMeasured {
        /// The recording.
        recording: String,
        /// The columns of which one is needed.
        measured: Vec<String>,
        /// The columns that exist.
        available: Vec<String>,
    },
    /// A column to be written is longer or shorter than the time.
    #[error(
        "cannot write {path}: column '{column}' has {found} values, time has {expected}",
        path = path.display()
    )]
    ColumnLength {
        /// The file to be written.
        path: PathBuf,
        /// The column.
        column: String,
        /// Number of times.
        expected: usize,
        /// Number of values.
        found: usize,
    },
    /// A value to be written is infinite, or a time is missing.
    #[error(
        "cannot write {path}: row {row} of column '{column}' is {found}, which no reader would \
         accept; did the simulation diverge?",
        path = path.display()
    )]
    NotWritable {
        /// The file to be written.
        path: PathBuf,
        /// The column.
        column: String,
        /// Row, from 0.
        row: usize,
        /// The value.
        found: f64,
    },
    /// The file cannot be written.
    #[error("cannot write {path}: {source}; check the folder and its permissions", path = path.display())]
    Unwritable {
        /// The file to be written.
        path: PathBuf,
        /// What the operating system said.
        source: io::Error,
    },
}

impl RecordingError {
    /// The columns for want of which a file is of no use, if that is what is wrong.
    pub(crate) fn missing_columns(&self) -> &[String] {
        match self {
            Self::NoSuchColumn { wanted, .. } => std::slice::from_ref(wanted),
            Self::NothingMeasured { measured, .. } => measured,
            _ => &[],
        }
    }
}

fn named(extension: &str) -> String {
    if extension.is_empty() { "unnamed".into() } else { format!(".{extension}") }
}

fn looks_like(found: &Option<(&str, &str)>) -> String {
    found.map_or_else(String::new, |(what, advice)| format!("; it looks like {what}; {advice}"))
}

fn list(names: &[String]) -> String {
    if names.is_empty() { "(none)".into() } else { names.join(", ") }
}
