//! Trajectories of row groups of one file.

use super::{Columns, TrajectoriesError};
use crate::occupation::{IdentificationError, Motion};
use crate::recordings::RowGroups;
use std::ops::Range;
use std::path::{Path, PathBuf};

/// From here on whole numbers are no longer all told apart.
const TOLD_APART: f64 = 9_007_199_254_740_992.0;

/// Where a trajectory begins.
#[derive(Clone, Debug)]
pub(super) struct Place {
    file: PathBuf,
    group: usize,
    row: usize,
    samples: usize,
    name: String,
}

impl Place {
    pub fn error(&self, source: IdentificationError) -> TrajectoriesError {
        let (Self { file, group, row, samples, name }, source) = (self.clone(), Box::new(source));
        TrajectoriesError::Trajectory { file, group, row, samples, name, source }
    }
}

/// What is read of a file.
pub(super) struct Reader<'c> {
    path: &'c Path,
    columns: &'c Columns,
    names: Vec<String>,
    groups: RowGroups,
}

/// A trajectory of which more may come.
struct Run {
    number: Option<f64>,
    group: usize,
    row: usize,
    /// Time, coordinates, rates, inputs.
    columns: Vec<Vec<f64>>,
}

type Sink<'s> = &'s mut dyn FnMut(Place, Motion) -> Result<(), TrajectoriesError>;

impl<'c> Reader<'c> {
    pub fn open(path: &'c Path, columns: &'c Columns) -> Result<Self, TrajectoriesError> {
        let names = columns.all();
        let groups = RowGroups::open(path, &names)?;
        Ok(Self { path, columns, names, groups })
    }

    /// Hands on every trajectory that begins in some row groups, which had so many rows.
    pub fn each(
        mut self,
        groups: Range<usize>,
        expected: usize,
        sink: Sink<'_>,
    ) -> Result<(), TrajectoriesError> {
        let rows = |group| if group < self.groups.count() { self.groups.rows(group) } else { 0 };
        let found = groups.clone().map(rows).sum();
        if found != expected {
            let (file, from, to) = (self.path.to_owned(), groups.start, groups.end);
            return Err(TrajectoriesError::Changed { file, from, to, expected, found });
        }
        let mut before = self.last_number(groups.start)?;
        let mut run: Option<Run> = None;
        for group in groups.start..self.groups.count() {
            if group >= groups.end && run.is_none() {
                break;
            }
            let mut columns = self.read(group)?;
            let numbers = self.columns.trajectory.as_ref().map(|_| columns.remove(0));
            for rows in runs(numbers.as_deref(), columns[0].len()) {
                let number = numbers.as_ref().map(|numbers| numbers[rows.start]);
                let goes_on = run.as_ref().is_some_and(|run| run.number == number);
                // It began in the chunk before.
                if run.is_none() && number.is_some() && before == number {
                    continue;
                }
                before = None;
                if !goes_on {
                    run.take().map_or(Ok(()), |run| self.finish(run, sink))?;
                    if group >= groups.end {
                        break;
                    }
                    let columns = vec![Vec::new(); columns.len()];
                    run = Some(Run { number, group, row: rows.start, columns });
                }
                let own = run.iter_mut().flat_map(|run| &mut run.columns);
                own.zip(&columns).for_each(|(to, from)| to.extend(&from[rows.clone()]));
            }
        }
        run.map_or(Ok(()), |run| self.finish(run, sink))
    }

    /// The columns of a row group, all finite.
    fn read(&mut self, group: usize) -> Result<Vec<Vec<f64>>, TrajectoriesError> {
        let columns =
            self.groups.read(group).map_err(|source| TrajectoriesError::Group { group, source })?;
        for (column, values) in self.names.iter().zip(&columns) {
            if let Some(row) = values.iter().position(|value| !value.is_finite()) {
                let (file, column, found) = (self.path.to_owned(), column.clone(), values[row]);
                return Err(TrajectoriesError::NotFinite { file, group, row, column, found });
            }
        }
        if let Some(column) = &self.columns.trajectory {
            let far = |number: &f64| number.abs() >= TOLD_APART;
            if let Some(row) = columns[0].iter().position(far) {
                let (file, column, found) = (self.path.to_owned(), column.clone(), columns[0][row]);
                return Err(TrajectoriesError::Number { file, group, row, column, found });
            }
        }
        Ok(columns)
    }

    /// The number of the last row before a row group.
    fn last_number(&self, group: usize) -> Result<Option<f64>, TrajectoriesError> {
        let Some(name) = &self.columns.trajectory else { return Ok(None) };
        let mut numbers = RowGroups::open(self.path, std::slice::from_ref(name))?;
        for group in (0..group).rev() {
            let read = numbers.read(group);
            let read = read.map_err(|source| TrajectoriesError::Group { group, source })?;
            if let Some(number) = read[0].last() {
                return Ok(Some(*number));
            }
        }
        Ok(None)
    }

    fn finish(&self, run: Run, sink: Sink<'_>) -> Result<(), TrajectoriesError> {
        let place = Place {
            file: self.path.to_owned(),
            group: run.group,
            row: run.row,
            samples: run.columns[0].len(),
            name: match (&self.columns.trajectory, run.number) {
                (Some(column), Some(number)) => format!(" ({column} = {number})"),
                _ => String::new(),
            },
        };
        let n = self.columns.coordinates.len();
        let rates = self.columns.rates.as_ref().map_or(0, |rates| rates.len());
        let (measured, inputs) = run.columns[1..].split_at(n + rates);
        let (coordinates, rates) = measured.split_at(n);
        let motion = Motion::new(run.columns[0].clone(), by_rows(coordinates), by_rows(inputs));
        let motion = motion.and_then(|motion| match self.columns.rates {
            Some(_) => motion.with_rates(by_rows(rates)),
            None => Ok(motion),
        });
        sink(place.clone(), motion.map_err(|source| place.error(source))?)
    }
}

/// Rows that stand together and have the same number; all of them where there is none.
fn runs(numbers: Option<&[f64]>, rows: usize) -> Vec<Range<usize>> {
    let lengths: Vec<usize> = match numbers {
        Some(numbers) => numbers.chunk_by(|a, b| a == b).map(<[f64]>::len).collect(),
        None => vec![rows],
    };
    let mut first = 0;
    let run = |length| {
        first += length;
        first - length..first
    };
    lengths.into_iter().map(run).collect()
}

/// Columns as rows.
fn by_rows(columns: &[Vec<f64>]) -> Vec<f64> {
    let rows = columns.first().map_or(0, Vec::len);
    (0..rows).flat_map(|k| columns.iter().map(move |column| column[k])).collect()
}
