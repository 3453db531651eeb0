//! Recordings from columns in memory: a data frame, arrays by name.

use lacuna_units::names::nearest;
use thiserror::Error;

use crate::error::RecordingError;
use crate::recording::{Column, Recording};

/// What is wrong with columns in memory. Rows are counted from 0.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum TableError {
    /// No row.
    #[error("the columns have no rows")]
    Empty,
    /// Two columns share a name.
    #[error("two columns are named '{column}'; give each its own name")]
    DuplicateColumn {
        /// The name that occurs twice.
        column: String,
    },
    /// A column of another length than time.
    #[error("column '{column}' has {found} values, time has {expected}")]
    ColumnLength {
        /// The column.
        column: String,
        /// Number of times.
        expected: usize,
        /// Number of values.
        found: usize,
    },
    /// A row does not say when it was taken.
    #[error("row {row}: the time column '{column}' is missing here; every row needs a time")]
    MissingTime {
        /// The row.
        row: usize,
        /// Name of the time column.
        column: String,
    },
    /// An infinite value.
    #[error(
        "row {row} of column '{column}' is {found}; expected a number, or nan where none was measured"
    )]
    Infinite {
        /// The column.
        column: String,
        /// The row.
        row: usize,
        /// The value.
        found: f64,
    },
    /// Time stands still or runs backwards.
    #[error(
        "time does not increase: {earlier} s in row {}, then {later} s in row {row}; remove repeated rows, and \
         split runs that were joined",
        row - 1
    )]
    TimeNotIncreasing {
        /// Time of the earlier row, s.
        earlier: f64,
        /// The later row.
        row: usize,
        /// Its time, s.
        later: f64,
    },
}

impl Recording {
    /// A recording from columns, one of them time in seconds, as a file's reader would make it.
    ///
    /// # Errors
    /// [`RecordingError::NoTimeColumn`], and [`RecordingError::Table`] for what no file could hold.
    pub fn from_columns(
        name: &str,
        mut columns: Vec<Column>,
        time_column: &str,
    ) -> Result<Self, RecordingError> {
        let names: Vec<&str> = columns.iter().map(|c| c.name.as_str()).collect();
        let Some(index) = names.iter().position(|name| *name == time_column) else {
            return Err(RecordingError::NoTimeColumn {
                file: name.into(),
                wanted: time_column.into(),
                separated: "",
                suggestion: nearest(time_column, names.iter().copied()).map(Into::into),
                available: names.into_iter().map(Into::into).collect(),
            });
        };
        check(&columns, index)
            .map_err(|source| RecordingError::Table { table: name.into(), source })?;
        let time = columns.remove(index).values;
        Ok(Self { name: name.into(), time, columns })
    }
}

fn check(columns: &[Column], time_index: usize) -> Result<(), TableError> {
    let Column { name: time_name, values: time } = &columns[time_index];
    if time.is_empty() {
        return Err(TableError::Empty);
    }
    for (k, Column { name, values }) in columns.iter().enumerate() {
        let column = || name.clone();
        if columns[..k].iter().any(|c| c.name == *name) {
            return Err(TableError::DuplicateColumn { column: column() });
        }
        if values.len() != time.len() {
            let (expected, found) = (time.len(), values.len());
            return Err(TableError::ColumnLength { column: column(), expected, found });
        }
        if let Some(row) = values.iter().position(|v| v.is_infinite()) {
            return Err(TableError::Infinite { column: column(), row, found: values[row] });
        }
    }
    if let Some(row) = time.iter().position(|t| t.is_nan()) {
        return Err(TableError::MissingTime { row, column: time_name.clone() });
    }
    match time.windows(2).position(|pair| pair[1] <= pair[0]) {
        Some(k) => {
            let (earlier, later) = (time[k], time[k + 1]);
            Err(TableError::TimeNotIncreasing { earlier, row: k + 1, later })
        }
        None => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn made(time: &[f64], q: &[f64], time_column: &str) -> Result<Recording, String> {
        let column =
            |name: &str, values: &[f64]| Column { name: name.into(), values: values.into() };
        Recording::from_columns("run", vec![column("q", q), column("t", time)], time_column)
            .map_err(|e| e.to_string())
    }

    #[test]
    fn columns_become_a_recording() {
        let run = made(&[0.0, 0.1], &[1.0, f64::NAN], "t").unwrap();
        assert_eq!((&*run.name, &run.time[..], run.columns.len()), ("run", &[0.0, 0.1][..], 1));
        assert_eq!(run.column("q").unwrap()[0], 1.0);
    }

    #[test]
    fn columns_that_no_file_could_hold_are_told() {
        let inf = f64::INFINITY;
        for (time, q, said) in [
            (&[][..], &[][..], "run: the columns have no rows"),
            (&[0.0, 1.0], &[1.0], "run: column 'q' has 1 values, time has 2"),
            (&[0.0, 1.0], &[1.0, inf], "run: row 1 of column 'q' is inf; expected a number"),
            (&[0.0, f64::NAN], &[1.0, 2.0], "run: row 1: the time column 't' is missing here"),
            (&[0.5, 0.5], &[1.0, 2.0], "run: time does not increase: 0.5 s in row 0, then 0.5 s"),
        ] {
            let found = made(time, q, "t").unwrap_err();
            assert!(found.starts_with(said), "{found}");
        }
        let said = made(&[0.0], &[1.0], "time").unwrap_err();
        assert!(said.starts_with("run has no time column 'time'"), "{said}");
    }
}
