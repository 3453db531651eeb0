//! Recordings as MATLAB files of version 5 (`save -v6`, `-v7`, `scipy.io.savemat`): arrays of numbers and structs of them.
//!
//! A column is a vector as long as time, called by its variable, a field of a struct `VARIABLE.FIELD`, of one of
//! several `VARIABLE[0].FIELD`. A matrix with a row for each time, or a column for each, is a column `NAME[0]`, `NAME[1]`
//! ... for each entry. Arrays of other sizes are parameters, and no columns. Of what nobody wants sizes alone are kept.

mod arrays;
mod stream;

use std::io::BufReader;

use lacuna_units::names::nearest;

use crate::error::RecordingError;
use crate::log::{Log, Wanted};
use crate::memory::Budget;
use crate::parquet::LONGEST_LIST;
use crate::reader::{Reader, open};
use crate::recording::{Column, Recording};
use crate::source::RecordingSource;
use arrays::{Array, Arrays};

/// What versions that are not read are told.
const SAVE_AS: &str = "save it with save(..., '-v7')";

/// Reads MATLAB files of version 5. Errors: a file that is cut or of another version, variables that are wanted and
/// hold no numbers, or not as many as there are times.
pub struct Mat;

impl Reader for Mat {
    fn format(&self) -> &'static str {
        "MATLAB"
    }

    fn extensions(&self) -> &'static [&'static str] {
        &["mat"]
    }

    fn recognises(&self, head: &[u8]) -> bool {
        head.starts_with(b"MATLAB 5.0")
    }

    fn read(&self, source: &RecordingSource, wanted: &Wanted) -> Result<Log, RecordingError> {
        let (file, bytes) = open(&source.path)?;
        let name = source.path.display().to_string();
        let mut arrays = Arrays::new(wanted, Budget::of(&name, bytes));
        arrays.read(&mut BufReader::new(file), &name)?;
        Table { file: name, wanted, arrays }.log(source)
    }
}

/// What was found, still to be made columns.
struct Table<'w> {
    file: String,
    wanted: &'w Wanted,
    arrays: Arrays<'w>,
}

/// How an array is laid out beside time.
struct Layout {
    /// Number of columns.
    width: usize,
    /// Entries from one time to the next.
    step: usize,
    /// Entries from one column to the next.
    stride: usize,
}

impl Layout {
    /// Of an array with these dimensions, the first of which runs fastest; none where it has not an entry for each of
    /// so many times.
    fn of(dims: &[usize], times: usize) -> Option<Self> {
        let others = |dims: &[usize]| dims.iter().product::<usize>();
        match dims {
            [first, rest @ ..] if *first == times => {
                Some(Self { width: others(rest), step: 1, stride: times })
            }
            [rest @ .., last] if *last == times => {
                Some(Self { width: others(rest), step: others(rest), stride: 1 })
            }
            _ => None,
        }
    }
}

impl Table<'_> {
    fn log(mut self, source: &RecordingSource) -> Result<Log, RecordingError> {
        let time = self.time()?;
        let rows = source.selection.picked(&time, &self.file)?;
        let picked = |values: &[f64], from: usize, step: usize| -> Vec<f64> {
            rows.iter().map(|&row| values[from + row * step]).collect()
        };
        let mut kept = vec![Column { name: self.wanted.time.clone(), values: picked(&time, 0, 1) }];
        let mut others = Vec::new();
        for array in std::mem::take(&mut self.arrays.all) {
            let Some(layout) = self.layout(&array, time.len()) else { continue };
            for entry in 0..layout.width {
                let name = match layout.width {
                    1 => array.name.clone(),
                    _ => format!("{}[{entry}]", array.name),
                };
                match array.values.as_ref().filter(|_| self.wanted.keeps(&name)) {
                    Some(values) => {
                        let values = picked(values, entry * layout.stride, layout.step);
                        kept.push(Column { name, values });
                    }
                    None => others.push(name),
                }
            }
        }
        let names: Vec<&str> =
            kept[1..].iter().map(|c| &c.name).chain(&others).map(|n| &**n).collect();
        self.wanted.check(&self.file, &names).map_err(|e| self.why(e))?;
        let mut recording = Recording::from_columns(&source.to_string(), kept, &self.wanted.time)?;
        recording.name = source.name();
        Ok(Log { recording, others, clocks: vec![] })
    }

    /// Takes the times out of the arrays, in seconds.
    fn time(&mut self) -> Result<Vec<f64>, RecordingError> {
        let wanted = &self.wanted.time;
        let Some(index) = self.arrays.all.iter().position(|a| a.name == *wanted) else {
            let available: Vec<String> = self.arrays.all.iter().map(|a| a.name.clone()).collect();
            let error = RecordingError::NoTimeColumn {
                file: self.file.clone(),
                wanted: wanted.clone(),
                separated: "",
                suggestion: nearest(wanted, available.iter().map(String::as_str)).map(Into::into),
                available,
            };
            return Err(self.reason(wanted).unwrap_or(error));
        };
        let Array { dims, values, .. } = self.arrays.all.remove(index);
        let values = values.unwrap_or_default();
        if values.is_empty() || dims.iter().filter(|d| **d != 1).count() > 1 {
            return Err(self.not_read(wanted, &format!("an array of {}", in_words(&dims))));
        }
        Ok(values.into_iter().map(|t| t * self.wanted.seconds).collect())
    }

    /// How an array is columns; none, and why, where it is none.
    fn layout(&mut self, array: &Array, times: usize) -> Option<Layout> {
        let layout = Layout::of(&array.dims, times);
        let why = match &layout {
            Some(layout) if layout.width > LONGEST_LIST => {
                format!("{} entries a row, where {LONGEST_LIST} are columns at most", layout.width)
            }
            Some(_) => return layout,
            None => format!("an array of {}, where there are {times} times", in_words(&array.dims)),
        };
        self.arrays.not_read.insert(array.name.clone(), why);
        None
    }

    /// A column that is missing because its variable is not read is answered with the reason.
    fn why(&self, error: RecordingError) -> RecordingError {
        let why = error.missing_columns().iter().find_map(|name| self.reason(name));
        why.unwrap_or(error)
    }

    /// Why a variable, or what it is a part of, is not read.
    fn reason(&self, column: &str) -> Option<RecordingError> {
        let is_of = |name: &str| {
            column
                .strip_prefix(name)
                .is_some_and(|rest| rest.is_empty() || rest.starts_with(['.', '[']))
        };
        let (name, why) = self.arrays.not_read.iter().find(|(name, _)| is_of(name))?;
        Some(self.not_read(name, why))
    }

    fn not_read(&self, name: &str, found: &str) -> RecordingError {
        RecordingError::NotRead {
            file: self.file.clone(),
            what: format!("'{name}':"),
            found: found.into(),
            advice: "save vectors of real numbers, one entry for each time",
        }
    }
}

/// 3 x 700.
fn in_words(dims: &[usize]) -> String {
    dims.iter().map(usize::to_string).collect::<Vec<_>>().join(" x ")
}
