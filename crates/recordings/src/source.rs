//! Which rows of which file: `run.csv`, `run.csv#rows=100..40575`, `run.csv#t=1.0..2.5`.
//!
//! Official splits of published benchmarks are often several ranges of one file; a
//! selection says so without copying data.

use std::fmt;
use std::path::{Path, PathBuf};
use std::str::FromStr;

use thiserror::Error;

use crate::error::RecordingError;

/// A part of a file. Ranges are half-open; an end left out reaches to the file's end.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Selection {
    /// Every row.
    #[default]
    All,
    /// Data rows `from <= row < to`, counted from 0 without header, comments and blank lines.
    Rows {
        /// First row.
        from: Option<usize>,
        /// Row after the last one.
        to: Option<usize>,
    },
    /// Rows with `from <= time < to`, in seconds as the file counts them.
    Time {
        /// First time, s.
        from: Option<f64>,
        /// Time after the last one, s.
        to: Option<f64>,
    },
}

impl Selection {
    /// Whether a selection by rows has this one; any other has every row.
    pub fn has_row(&self, row: usize) -> bool {
        match *self {
            Self::Rows { from, to } => {
                from.is_none_or(|from| from <= row) && to.is_none_or(|to| row < to)
            }
            _ => true,
        }
    }

    /// Whether a selection by time has this one, in seconds; any other has every time.
    pub fn has_time(&self, time: f64) -> bool {
        match *self {
            Self::Time { from, to } => {
                from.is_none_or(|from| from <= time) && to.is_none_or(|to| time < to)
            }
            _ => true,
        }
    }
}

impl Selection {
    /// The rows that it has, of so many times of a file.
    ///
    /// # Errors
    /// [`RecordingError::SelectionBeyondEnd`], and [`RecordingError::EmptySelection`] where there are none.
    pub(crate) fn picked(self, times: &[f64], file: &str) -> Result<Vec<usize>, RecordingError> {
        let rows = times.len();
        if let Self::Rows { to: Some(to), .. } = self
            && to > rows
        {
            let file = file.into();
            return Err(RecordingError::SelectionBeyondEnd { file, selection: self, rows });
        }
        let is_in = |k: &usize| self.has_row(*k) && self.has_time(times[*k]);
        let picked: Vec<usize> = (0..rows).filter(is_in).collect();
        if picked.is_empty() {
            return Err(RecordingError::EmptySelection {
                file: file.into(),
                selection: self,
                rows,
            });
        }
        Ok(picked)
    }
}

/// A file and the part of it that is meant.
#[derive(Clone, Debug, PartialEq)]
pub struct RecordingSource {
    /// The file.
    pub path: PathBuf,
    /// The part of it.
    pub selection: Selection,
}

impl RecordingSource {
    /// The whole of a file.
    pub fn file(path: impl Into<PathBuf>) -> Self {
        Self { path: path.into(), selection: Selection::All }
    }

    /// File name without its folder, followed by the selection.
    pub fn name(&self) -> String {
        let file = self.path.file_name().map_or_else(
            || self.path.display().to_string(),
            |name| name.to_string_lossy().into_owned(),
        );
        format!("{file}{}", self.selection)
    }
}

impl From<&Path> for RecordingSource {
    fn from(path: &Path) -> Self {
        Self::file(path)
    }
}

/// A text that names no recording.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum SourceError {
    /// No file name.
    #[error("'{text}' names no file; expected FILE.csv, FILE.csv#rows=0..100 or FILE.csv#t=0..2.5")]
    NoFile {
        /// The text.
        text: String,
    },
    /// A selection by something else than rows or time.
    #[error("'{text}': cannot select by '{key}'; expected #rows=FROM..TO or #t=FROM..TO")]
    UnknownKey {
        /// The text.
        text: String,
        /// What stands before the equals sign.
        key: String,
    },
    /// The range is not two ends with two dots between them.
    #[error(
        "'{text}': expected a range FROM..TO, where either end may be left out, found '{found}'"
    )]
    NotARange {
        /// The text.
        text: String,
        /// What stands after the equals sign.
        found: String,
    },
    /// An end of the range is not a number of the right kind.
    #[error("'{text}': expected {expected}, found '{found}'")]
    BadEnd {
        /// The text.
        text: String,
        /// What such an end must be.
        expected: &'static str,
        /// What stands there.
        found: String,
    },
    /// The range ends where it begins, or before.
    #[error("'{text}': the range is empty; its end must lie after its beginning")]
    EmptyRange {
        /// The text.
        text: String,
    },
}

impl FromStr for RecordingSource {
    type Err = SourceError;

    /// Reads `FILE`, `FILE#rows=A..B` or `FILE#t=A..B`. A `#` that no `=` follows belongs
    /// to the file's name.
    fn from_str(text: &str) -> Result<Self, SourceError> {
        let (file, selection) = match text.rsplit_once('#') {
            Some((file, rest)) if rest.contains('=') => (file, parse_selection(text, rest)?),
            _ => (text, Selection::All),
        };
        if file.is_empty() {
            return Err(SourceError::NoFile { text: text.into() });
        }
        Ok(Self { path: file.into(), selection })
    }
}

fn parse_selection(text: &str, rest: &str) -> Result<Selection, SourceError> {
    let (key, range) = rest.split_once('=').unwrap_or((rest, ""));
    match key.trim() {
        "rows" => {
            let (from, to) = ends(text, range, "a row number (0, 1, 2, ...)", |_: &usize| true)?;
            Ok(Selection::Rows { from, to })
        }
        "t" => {
            let (from, to) = ends(text, range, "a time in seconds", |t: &f64| t.is_finite())?;
            Ok(Selection::Time { from, to })
        }
        key => Err(SourceError::UnknownKey { text: text.into(), key: key.into() }),
    }
}

type Ends<T> = (Option<T>, Option<T>);

fn ends<T: FromStr + PartialOrd>(
    text: &str,
    range: &str,
    expected: &'static str,
    valid: impl Fn(&T) -> bool,
) -> Result<Ends<T>, SourceError> {
    let Some((from, to)) = range.split_once("..") else {
        return Err(SourceError::NotARange { text: text.into(), found: range.into() });
    };
    let end =
        |found: &str| match found.trim() {
            "" => Ok(None),
            found => found.parse().ok().filter(&valid).map(Some).ok_or_else(|| {
                SourceError::BadEnd { text: text.into(), expected, found: found.into() }
            }),
        };
    match (end(from)?, end(to)?) {
        (Some(from), Some(to)) if from >= to => Err(SourceError::EmptyRange { text: text.into() }),
        ends => Ok(ends),
    }
}

impl fmt::Display for Selection {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::All => Ok(()),
            Self::Rows { from, to } => write!(f, "#rows={}..{}", shown(from), shown(to)),
            Self::Time { from, to } => write!(f, "#t={}..{}", shown(from), shown(to)),
        }
    }
}

fn shown<T: fmt::Display>(end: &Option<T>) -> String {
    end.as_ref().map_or_else(String::new, T::to_string)
}

impl fmt::Display for RecordingSource {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}{}", self.path.display(), self.selection)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parse(text: &str) -> Result<RecordingSource, SourceError> {
        text.parse()
    }

    #[test]
    fn texts_become_sources_and_back() {
        for (text, selection) in [
            ("a/run.csv", Selection::All),
            ("run#3.csv", Selection::All),
            ("a.csv#rows=100..40575", Selection::Rows { from: Some(100), to: Some(40575) }),
            ("a.csv#rows=..7", Selection::Rows { from: None, to: Some(7) }),
            ("a.csv#t=-1.5..", Selection::Time { from: Some(-1.5), to: None }),
            ("run#3.csv#t=1..2.5", Selection::Time { from: Some(1.0), to: Some(2.5) }),
        ] {
            let source = parse(text).unwrap();
            assert_eq!(source.selection, selection);
            assert_eq!(source.to_string(), text);
        }
        assert_eq!(parse("a/b/run.csv#rows=1..2").unwrap().name(), "run.csv#rows=1..2");
    }

    #[test]
    fn wrong_texts_are_told_apart() {
        assert!(matches!(parse(""), Err(SourceError::NoFile { .. })));
        assert!(matches!(parse("#rows=1..2"), Err(SourceError::NoFile { .. })));
        assert!(matches!(parse("a#row=1..2"), Err(SourceError::UnknownKey { .. })));
        assert!(matches!(parse("a#rows=12"), Err(SourceError::NotARange { .. })));
        assert!(matches!(parse("a#rows=1.5..2"), Err(SourceError::BadEnd { .. })));
        assert!(matches!(parse("a#rows=-1..2"), Err(SourceError::BadEnd { .. })));
        assert!(matches!(parse("a#t=nan..2"), Err(SourceError::BadEnd { .. })));
        assert!(matches!(parse("a#t=2..2"), Err(SourceError::EmptyRange { .. })));
    }
}
