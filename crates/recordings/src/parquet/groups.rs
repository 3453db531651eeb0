//! Some columns of a file, a row group at a time: for files that are too large to be a recording.

use std::path::Path;

use ::parquet::file::reader::FileReader;
use lacuna_units::names::nearest;

use super::{Parquet, Table};
use crate::contained::contained;
use crate::error::RecordingError;
use crate::memory::Budget;
use crate::reader::Reader;
use crate::source::RecordingSource;

/// Columns of numbers of a Parquet file, read a row group at a time: no more than one is in memory, and columns that
/// are not asked for are not touched.
pub struct RowGroups {
    source: RecordingSource,
    table: Table,
    bytes: u64,
    leaves: Vec<usize>,
}

impl RowGroups {
    /// The columns of these names.
    ///
    /// # Errors
    /// A file that cannot be read or is cut, and a name that is no column of numbers.
    pub fn open(path: &Path, columns: &[String]) -> Result<Self, RecordingError> {
        let source = RecordingSource::file(path);
        contained(Parquet.format(), &source, || {
            let mut table = Table::open(path)?;
            let leaves = columns
                .iter()
                .map(|name| table.flat_leaf(name))
                .collect::<Result<Vec<usize>, _>>()?;
            for &leaf in &leaves {
                if table.leaves[leaf].is_timestamp {
                    table.leaves[leaf].zero = table.first_whole(&table.leaves[leaf])?;
                }
            }
            let bytes = table.bytes();
            Ok(Self { source: source.clone(), table, bytes, leaves })
        })
    }

    /// Number of row groups.
    pub fn count(&self) -> usize {
        self.table.reader.metadata().num_row_groups()
    }

    /// Number of rows of a group.
    pub fn rows(&self, group: usize) -> usize {
        self.table.reader.metadata().row_group(group).num_rows().max(0) as usize
    }

    /// The columns of a group, in the order in which they were asked for; NaN where nothing stands.
    ///
    /// # Errors
    /// Pages that are damaged or too large.
    pub fn read(&mut self, group: usize) -> Result<Vec<Vec<f64>>, RecordingError> {
        let first: usize = (0..group).map(|k| self.rows(k)).sum();
        let range = first..first + self.rows(group);
        // What was read before is not kept.
        self.table.budget = Budget::of(&self.table.file, self.bytes);
        let (table, leaves) = (&mut self.table, &self.leaves);
        contained(Parquet.format(), &self.source, || {
            leaves.iter().map(|&leaf| Ok(table.values(leaf, &range, &[true])?.remove(0))).collect()
        })
    }
}

impl Table {
    /// The leaf outside of lists that is called so.
    fn flat_leaf(&self, name: &str) -> Result<usize, RecordingError> {
        let is_it = |leaf: &super::Leaf| !leaf.is_list() && leaf.name() == name;
        self.leaves.iter().position(is_it).ok_or_else(|| {
            let flat = self.leaves.iter().filter(|leaf| !leaf.is_list());
            let available: Vec<String> = flat.map(|leaf| leaf.name().to_owned()).collect();
            let suggestion = nearest(name, available.iter().map(String::as_str)).map(Into::into);
            let (recording, wanted) = (self.file.clone(), name.to_owned());
            RecordingError::NoSuchColumn { recording, wanted, available, suggestion }
        })
    }

    fn bytes(&self) -> u64 {
        self.raw.metadata().map_or(0, |metadata| metadata.len())
    }
}
