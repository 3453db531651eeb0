//! Recordings as Parquet: one row per time, columns of numbers, groups and lists of them.
//!
//! Of every column that is wanted the rows of the selection are read, a batch at a time; the
//! others are not touched. A null is a missing sample. A column of time that holds points in time
//! (timestamps) is counted in seconds from the file's first row.

mod groups;
mod pages;
mod schema;

use std::fs::File;
use std::ops::Range;
use std::path::Path;

use ::parquet::column::reader::{ColumnReader, ColumnReaderImpl};
use ::parquet::data_type::DataType;
use ::parquet::errors::ParquetError;
use ::parquet::file::metadata::ParquetMetaData;
use ::parquet::file::reader::{FileReader, RowGroupReader, SerializedFileReader};
use lacuna_units::names::nearest;

use crate::contained::contained;
use crate::error::RecordingError;
use crate::log::{Log, Wanted};
use crate::memory::Budget;
use crate::reader::{Reader, open};
use crate::recording::{Column, Recording};
use crate::source::{RecordingSource, Selection};
pub use groups::RowGroups;
use schema::Leaf;

/// Rows that are decoded at once.
const BATCH: usize = 4096;
/// Rows in which the length of a list is looked for.
const LENGTH_ROWS: usize = 1000;
/// Longest list whose entries are columns: longer ones are pictures or clouds of points.
pub(crate) const LONGEST_LIST: usize = 256;

/// Reads Parquet. Errors: a file that is cut or compressed in a way that is not read, lists that grow, time
/// missing or not increasing, each with its row.
pub struct Parquet;

impl Reader for Parquet {
    fn format(&self) -> &'static str {
        "Parquet"
    }

    fn extensions(&self) -> &'static [&'static str] {
        &["parquet", "pq"]
    }

    fn recognises(&self, head: &[u8]) -> bool {
        head.starts_with(b"PAR1")
    }

    fn read(&self, source: &RecordingSource, wanted: &Wanted) -> Result<Log, RecordingError> {
        contained(self.format(), source, || Table::open(&source.path)?.read(source, wanted))
    }
}

struct Table {
    file: String,
    /// For the headers of pages, which the reader does not show.
    raw: File,
    reader: SerializedFileReader<File>,
    leaves: Vec<Leaf>,
    rows: usize,
    budget: Budget,
}

impl Table {
    fn open(path: &Path) -> Result<Self, RecordingError> {
        let file = path.display().to_string();
        let unreadable = |source| RecordingError::Unreadable { path: path.into(), source };
        let (opened, bytes) = open(path)?;
        let raw = opened.try_clone().map_err(unreadable)?;
        let reader = SerializedFileReader::new(opened).map_err(|e| broken(&file, &e))?;
        let metadata = reader.metadata();
        check_places(&file, metadata, bytes)?;
        let leaves = schema::leaves(metadata.file_metadata().schema_descr());
        let rows: i64 = metadata.row_groups().iter().map(|g| g.num_rows().max(0)).sum();
        let budget = Budget::of(&file, bytes);
        Ok(Self { file, raw, leaves, rows: rows as usize, reader, budget })
    }

    fn read(mut self, source: &RecordingSource, wanted: &Wanted) -> Result<Log, RecordingError> {
        let columns = self.columns()?;
        let time = self.time_leaf(&wanted.time, &columns)?;
        let (rows, time) = self.selected((time, wanted.seconds), &source.selection)?;
        let keep: Vec<bool> = time.iter().map(|&t| source.selection.has_time(t)).collect();
        let retained = |mut values: Vec<f64>| {
            let mut keep = keep.iter();
            values.retain(|_| keep.next().copied().unwrap_or(false));
            values
        };
        let mut kept = vec![Column { name: wanted.time.clone(), values: retained(time) }];
        let mut others = Vec::new();
        for (leaf, names) in columns {
            if names[..] == *std::slice::from_ref(&kept[0].name) {
                continue;
            }
            let slots: Vec<bool> = names.iter().map(|name| wanted.keeps(name)).collect();
            let mut all = match slots.contains(&true) {
                true => self.values(leaf, &rows, &slots)?.into_iter().peekable(),
                false => Vec::new().into_iter().peekable(),
            };
            for (name, slot) in names.into_iter().zip(slots) {
                match all.next_if(|_| slot) {
                    Some(values) => kept.push(Column { name, values: retained(values) }),
                    None => others.push(name),
                }
            }
        }
        let mut recording = Recording::from_columns(&source.to_string(), kept, &wanted.time)?;
        recording.name = source.name();
        Ok(Log { recording, others, clocks: vec![] })
    }

    /// Leaves and the names of their columns.
    fn columns(&self) -> Result<Vec<(usize, Vec<String>)>, RecordingError> {
        let names = |(k, leaf): (usize, &Leaf)| {
            let width = if leaf.is_list() { self.list_length(k)? } else { 1 };
            Ok((k, (0..width).map(|entry| leaf.column(entry)).collect()))
        };
        self.leaves.iter().enumerate().map(names).collect()
    }

    /// Length of a list in the first row that has any; 0 for lists that are too long for columns.
    fn list_length(&self, leaf: usize) -> Result<usize, RecordingError> {
        let (mut first, mut length) = (None, 0);
        let found = self.each(leaf, &(0..self.rows.min(LENGTH_ROWS)), |row, entry, _| {
            if *first.get_or_insert(row) == row {
                length = entry + 1;
            }
            Ok(())
        });
        match found {
            Err(RecordingError::TooLarge { .. }) => Ok(0),
            Err(other) => Err(other),
            Ok(()) => Ok(if length > LONGEST_LIST { 0 } else { length }),
        }
    }

    fn time_leaf(
        &self,
        wanted: &str,
        columns: &[(usize, Vec<String>)],
    ) -> Result<usize, RecordingError> {
        if let Some((leaf, _)) = columns.iter().find(|(_, names)| names[..] == [wanted]) {
            return Ok(*leaf);
        }
        let available: Vec<String> = columns.iter().flat_map(|(_, names)| names.clone()).collect();
        Err(RecordingError::NoTimeColumn {
            file: self.file.clone(),
            wanted: wanted.into(),
            separated: "",
            suggestion: nearest(wanted, available.iter().map(String::as_str)).map(Into::into),
            available,
        })
    }

    /// The rows from the first to the last of a selection, and their times in seconds: plain numbers are in a unit of so
    /// many.
    fn selected(
        &mut self,
        (time, seconds): (usize, f64),
        selection: &Selection,
    ) -> Result<(Range<usize>, Vec<f64>), RecordingError> {
        let (file, rows) = (self.file.clone(), self.rows);
        let range = match *selection {
            Selection::Rows { to: Some(to), .. } if to > rows => {
                let selection = *selection;
                return Err(RecordingError::SelectionBeyondEnd { file, selection, rows });
            }
            Selection::Rows { from, to } => from.unwrap_or(0).min(rows)..to.unwrap_or(rows),
            _ => 0..rows,
        };
        if self.leaves[time].is_timestamp {
            self.leaves[time].zero = self.first_whole(&self.leaves[time])?;
        }
        let mut times = self.values(time, &range, &[true])?.remove(0);
        if !self.leaves[time].is_timestamp {
            times.iter_mut().for_each(|t| *t *= seconds);
        }
        let is_in = |t: &f64| selection.has_time(*t);
        let ends = (times.iter().position(is_in), times.iter().rposition(is_in));
        let (Some(first), Some(last)) = ends else {
            return Err(RecordingError::EmptySelection { file, selection: *selection, rows });
        };
        Ok((range.start + first..range.start + last + 1, times[first..=last].to_vec()))
    }

    /// The first value of a leaf of whole numbers; 0 where there is none.
    fn first_whole(&self, leaf: &Leaf) -> Result<i64, RecordingError> {
        let failed = |e: ParquetError| broken(&self.file, &e);
        let groups = self.reader.metadata().row_groups();
        let Some(first) = groups.iter().position(|g| g.num_rows() > 0) else { return Ok(0) };
        self.check_pages(first, leaf)?;
        let group = self.reader.get_row_group(first).map_err(failed)?;
        let column = group.get_column_reader(leaf.index).map_err(failed)?;
        let ColumnReader::Int64ColumnReader(mut column) = column else { return Ok(0) };
        let (mut defs, mut reps, mut values) = (vec![], vec![], vec![]);
        column.read_records(1, Some(&mut defs), Some(&mut reps), &mut values).map_err(failed)?;
        Ok(values.first().copied().unwrap_or(0))
    }

    /// Values of those entries of a leaf that have a slot, for every row; NaN where there is none.
    fn values(
        &mut self,
        leaf: usize,
        rows: &Range<usize>,
        slots: &[bool],
    ) -> Result<Vec<Vec<f64>>, RecordingError> {
        let count = slots.iter().filter(|slot| **slot).count();
        self.budget.take_numbers(count as u64 * rows.len() as u64)?;
        let mut series = vec![vec![f64::NAN; rows.len()]; count];
        let order: Vec<Option<usize>> = slots
            .iter()
            .scan(0, |next, slot| {
                *next += usize::from(*slot);
                Some(slot.then(|| *next - 1))
            })
            .collect();
        self.each(leaf, rows, |row, entry, value| {
            let Some(slot) = order.get(entry) else {
                return Err(RecordingError::LongerList {
                    file: self.file.clone(),
                    column: self.leaves[leaf].name().into(),
                    row: rows.start + row,
                    expected: slots.len(),
                });
            };
            if let Some(slot) = slot {
                series[*slot][row] = value;
            }
            Ok(())
        })?;
        Ok(series)
    }

    /// Hands every value of a leaf on, with its row (from 0 at the first of `rows`) and entry.
    fn each(
        &self,
        leaf: usize,
        rows: &Range<usize>,
        mut sink: impl FnMut(usize, usize, f64) -> Result<(), RecordingError>,
    ) -> Result<(), RecordingError> {
        let leaf = &self.leaves[leaf];
        let mut before = 0;
        for (k, group) in self.reader.metadata().row_groups().iter().enumerate() {
            let count = group.num_rows().max(0) as usize;
            let own = rows.start.max(before)..rows.end.min(before + count);
            if !own.is_empty() {
                self.check_pages(k, leaf)?;
                let group = self.reader.get_row_group(k).map_err(|e| broken(&self.file, &e))?;
                let within = own.start - before..own.end - before;
                let offset = own.start - rows.start;
                self.each_of_group(&*group, leaf, within, &mut |row, entry, value| {
                    sink(offset + row, entry, value)
                })?;
            }
            before += count;
        }
        Ok(())
    }

    /// That no page is too large, nor the number of entries of all lists.
    fn check_pages(&self, group: usize, leaf: &Leaf) -> Result<(), RecordingError> {
        let (start, length) =
            self.reader.metadata().row_group(group).column(leaf.index).byte_range();
        let pages = pages::pages(&self.raw, start, length).map_err(|e| {
            let (file, reason) = (self.file.clone(), e.to_string());
            RecordingError::Broken { file, format: "Parquet", reason }
        })?;
        let entries = if leaf.is_list() { pages.values * size_of::<f64>() as u64 } else { 0 };
        self.budget.check_piece(pages.largest.max(entries))
    }

    fn each_of_group(
        &self,
        group: &dyn RowGroupReader,
        leaf: &Leaf,
        rows: Range<usize>,
        sink: Sink,
    ) -> Result<(), RecordingError> {
        let column = group.get_column_reader(leaf.index).map_err(|e| broken(&self.file, &e))?;
        let whole = |value: f64| value / leaf.divisor;
        match column {
            ColumnReader::BoolColumnReader(c) => {
                self.decode(c, leaf, rows, |v| f64::from(u8::from(*v)), sink)
            }
            ColumnReader::Int32ColumnReader(c) if leaf.unsigned => {
                self.decode(c, leaf, rows, |v| whole(f64::from(*v as u32)), sink)
            }
            ColumnReader::Int32ColumnReader(c) => {
                self.decode(c, leaf, rows, |v| whole(f64::from(*v)), sink)
            }
            ColumnReader::Int64ColumnReader(c) if leaf.unsigned => {
                self.decode(c, leaf, rows, |v| whole(*v as u64 as f64), sink)
            }
            ColumnReader::Int64ColumnReader(c) => {
                self.decode(c, leaf, rows, |v| whole(v.wrapping_sub(leaf.zero) as f64), sink)
            }
            ColumnReader::FloatColumnReader(c) => {
                self.decode(c, leaf, rows, |v| f64::from(*v), sink)
            }
            ColumnReader::DoubleColumnReader(c) => self.decode(c, leaf, rows, |v| *v, sink),
            _ => Ok(()),
        }
    }

    fn decode<T: DataType>(
        &self,
        mut column: ColumnReaderImpl<T>,
        leaf: &Leaf,
        rows: Range<usize>,
        number: impl Fn(&T::T) -> f64,
        sink: Sink,
    ) -> Result<(), RecordingError> {
        let failed = |e: ParquetError| broken(&self.file, &e);
        column.skip_records(rows.start).map_err(failed)?;
        let (mut defs, mut reps, mut values) = (vec![], vec![], vec![]);
        let mut done = 0;
        while done < rows.len() {
            defs.clear();
            reps.clear();
            values.clear();
            let most = (rows.len() - done).min(BATCH);
            let (records, _, levels) = column
                .read_records(most, Some(&mut defs), Some(&mut reps), &mut values)
                .map_err(failed)?;
            if records == 0 {
                let reason = "it holds fewer rows than it says".into();
                return Err(broken(&self.file, &ParquetError::General(reason)));
            }
            let (mut row, mut entry, mut next) = (done, 0, values.iter());
            for level in 0..levels {
                let defined = defs.get(level).copied().unwrap_or(leaf.value_level);
                match reps.get(level) {
                    Some(0) | None => (row, entry) = (row + usize::from(level > 0), 0),
                    Some(_) => entry += 1,
                }
                let value =
                    if defined == leaf.value_level { next.next().map(&number) } else { None };
                if defined >= leaf.entry_level {
                    sink(row, entry, value.unwrap_or(f64::NAN))?;
                }
            }
            done += records;
        }
        Ok(())
    }
}

/// Takes row, entry and value.
type Sink<'s> = &'s mut dyn FnMut(usize, usize, f64) -> Result<(), RecordingError>;

/// That every column of every group of rows lies in the file, of so many bytes: the reader takes it for granted.
fn check_places(file: &str, metadata: &ParquetMetaData, bytes: u64) -> Result<(), RecordingError> {
    for (k, group) in metadata.row_groups().iter().enumerate() {
        for column in group.columns() {
            let dictionary = column.dictionary_page_offset();
            let start = u64::try_from(dictionary.unwrap_or(column.data_page_offset()));
            let end = start.ok().zip(u64::try_from(column.compressed_size()).ok());
            let end = end.and_then(|(start, length)| start.checked_add(length));
            if end.is_none_or(|end| end > bytes) {
                let name = column.column_path();
                let reason =
                    format!("column {name} of its row group {k} is said to lie outside the file");
                return Err(broken(file, &ParquetError::General(reason)));
            }
        }
    }
    Ok(())
}

fn broken(file: &str, error: &ParquetError) -> RecordingError {
    match error {
        ParquetError::NYI(found) => RecordingError::NotRead {
            file: file.into(),
            what: "Parquet with".into(),
            found: found.clone(),
            advice: "write it with snappy, gzip, zstd or no compression",
        },
        _ => RecordingError::Broken {
            file: file.into(),
            format: "Parquet",
            reason: error.to_string(),
        },
    }
}
