//! Trajectories of many Parquet files, for [`Stream`]: which there are, and chunks of them that
//! are read by whoever comes.
//!
//! | step | module |
//! | --- | --- |
//! | which files, cut into chunks | [`Trajectories`] |
//! | a chunk as motions, one after the other | `read` |
//! | what is wrong, with file, row group and trajectory | [`TrajectoriesError`] |
//!
//! A trajectory is a run of rows of one file with the same number in the column that names trajectories; without such a
//! column a file is one. Chunks are made of whole row groups and depend on the files alone, not on who reads them. A
//! trajectory belongs to the chunk in which it begins, whatever row groups it goes on through.

mod error;
mod read;

pub use error::TrajectoriesError;

use crate::occupation::{IdentificationError, Motion, Stream, Sums, evenly};
use crate::recordings::RowGroups;
use read::{Place, Reader};
use serde::{Deserialize, Serialize};
use std::collections::BTreeSet;
use std::ops::Range;
use std::path::PathBuf;

/// Rows, at least, of a chunk that is not the last.
const CHUNK_ROWS: usize = 100_000;
/// Row groups that a sample is taken from, and trajectories in it.
const SAMPLED_PIECES: usize = 48;
const SAMPLED: usize = 1500;
/// Motions that are in memory at a time.
const TOGETHER: usize = 32;

/// Which columns hold what.
#[derive(Clone, Debug, Deserialize, Serialize)]
pub struct Columns {
    /// Time, in seconds.
    pub time: String,
    /// Number of the trajectory that a row is of; without, a file is a trajectory.
    pub trajectory: Option<String>,
    /// Coordinates.
    pub coordinates: Vec<String>,
    /// Their rates, where these are measured: as many.
    pub rates: Option<Vec<String>>,
    /// Inputs.
    pub inputs: Vec<String>,
}

impl Columns {
    /// All of them: the trajectory's, time, coordinates, rates, inputs.
    fn all(&self) -> Vec<String> {
        let measured = self.coordinates.iter().chain(self.rates.iter().flatten());
        let rest = std::iter::once(&self.time).chain(measured).chain(&self.inputs);
        self.trajectory.iter().chain(rest).cloned().collect()
    }

    fn check(&self) -> Result<(), TrajectoriesError> {
        let (expected, found) =
            (self.coordinates.len(), self.rates.as_ref().map_or(0, |rates| rates.len()));
        if expected == 0 {
            return Err(TrajectoriesError::NoCoordinate);
        }
        if self.rates.is_some() && expected != found {
            return Err(TrajectoriesError::Rates { expected, found });
        }
        let mut seen = BTreeSet::new();
        match self.all().into_iter().find(|name| !seen.insert(name.clone())) {
            Some(column) => Err(TrajectoriesError::Twice { column }),
            None => Ok(()),
        }
    }
}

/// A row group, or a whole file where that is a trajectory.
#[derive(Clone, Debug, Deserialize, Serialize)]
struct Piece {
    file: usize,
    groups: Range<usize>,
    rows: usize,
}

/// The trajectories of some files: where they are, not what they hold.
#[derive(Clone, Debug, Deserialize, Serialize)]
pub struct Trajectories {
    columns: Columns,
    files: Vec<PathBuf>,
    pieces: Vec<Piece>,
    /// Pieces of each chunk.
    chunks: Vec<Range<usize>>,
}

impl Trajectories {
    /// Finds the files that match a pattern, and looks at what they say of themselves.
    ///
    /// # Errors
    /// No such file, files that are cut, and columns that are missing: before anything is read.
    pub fn find(pattern: &str, columns: Columns) -> Result<Self, TrajectoriesError> {
        columns.check()?;
        let bad = |reason: String| TrajectoriesError::Pattern { pattern: pattern.into(), reason };
        let mut files = glob::glob(pattern)
            .map_err(|e| bad(e.msg.into()))?
            .collect::<Result<Vec<PathBuf>, _>>()
            .map_err(|e| bad(e.to_string()))?;
        files.retain(|file| !file.is_dir());
        for file in &mut files {
            *file = std::path::absolute(&*file).map_err(|e| bad(e.to_string()))?;
        }
        files.sort();
        let mut pieces = Vec::new();
        for (k, path) in files.iter().enumerate() {
            let file = RowGroups::open(path, &columns.all())?;
            let whole = 0..file.count();
            let parts = match columns.trajectory {
                Some(_) => whole.map(|group| group..group + 1).collect(),
                None => vec![whole],
            };
            let piece = |groups: Range<usize>| {
                let rows = groups.clone().map(|group| file.rows(group)).sum();
                Piece { file: k, groups, rows }
            };
            pieces.extend(parts.into_iter().map(piece).filter(|piece| piece.rows > 0));
        }
        if pieces.is_empty() {
            return Err(TrajectoriesError::Nothing { pattern: pattern.into(), files: files.len() });
        }
        let chunks = chunks(&pieces);
        Ok(Self { columns, files, pieces, chunks })
    }

    /// Number of chunks.
    pub fn chunks(&self) -> usize {
        self.chunks.len()
    }

    /// Number of rows of all files.
    pub fn rows(&self) -> usize {
        self.pieces.iter().map(|piece| piece.rows).sum()
    }

    /// Which columns hold what.
    pub fn columns(&self) -> &Columns {
        &self.columns
    }

    /// Some trajectories, spread evenly over the files.
    ///
    /// # Errors
    /// As [`Trajectories::sums`].
    pub fn sample(&self) -> Result<Vec<Motion>, TrajectoriesError> {
        let each = SAMPLED.div_ceil(SAMPLED_PIECES.min(self.pieces.len()));
        let mut all = Vec::new();
        for piece in evenly(self.pieces.len(), SAMPLED_PIECES) {
            let mut own = Vec::new();
            self.each(piece..piece + 1, |_, motion| {
                own.push(motion);
                Ok(())
            })?;
            all.extend(evenly(own.len(), each).map(|k| own[k].clone()));
        }
        Ok(all)
    }

    /// What a stream sums of a chunk.
    ///
    /// # Errors
    /// Files that cannot be read or have changed, numbers that are not finite, trajectories that are too short; each with
    /// file and row group.
    pub fn sums(&self, stream: &Stream, chunk: usize) -> Result<Sums, TrajectoriesError> {
        let mut sums = stream.none();
        let (mut places, mut motions): (Vec<Place>, Vec<Motion>) = (Vec::new(), Vec::new());
        let mut add = |places: &mut Vec<Place>, motions: &mut Vec<Motion>| {
            let added = stream.add(&mut sums, motions);
            added.map_err(|error| blamed(stream, error, (&*places, &*motions)))?;
            places.clear();
            motions.clear();
            Ok(())
        };
        self.each(self.chunks[chunk].clone(), |place, motion| {
            places.push(place);
            motions.push(motion);
            if motions.len() == TOGETHER { add(&mut places, &mut motions) } else { Ok(()) }
        })?;
        add(&mut places, &mut motions)?;
        Ok(sums)
    }

    /// Hands on every trajectory that begins in some pieces.
    fn each(
        &self,
        pieces: Range<usize>,
        mut sink: impl FnMut(Place, Motion) -> Result<(), TrajectoriesError>,
    ) -> Result<(), TrajectoriesError> {
        for run in self.pieces[pieces].chunk_by(|a, b| a.file == b.file) {
            let groups = run[0].groups.start..run[run.len() - 1].groups.end;
            let expected = run.iter().map(|piece| piece.rows).sum();
            let file = &self.files[run[0].file];
            Reader::open(file, &self.columns)?.each(groups, expected, &mut sink)?;
        }
        Ok(())
    }
}

/// Pieces that stand together until they have enough rows.
fn chunks(pieces: &[Piece]) -> Vec<Range<usize>> {
    let (mut chunks, mut first, mut rows) = (Vec::new(), 0, 0);
    for (k, piece) in pieces.iter().enumerate() {
        rows += piece.rows;
        if rows >= CHUNK_ROWS || k + 1 == pieces.len() {
            chunks.push(first..k + 1);
            (first, rows) = (k + 1, 0);
        }
    }
    chunks
}

/// The error with the first motion that has one by itself.
fn blamed(
    stream: &Stream,
    error: IdentificationError,
    (places, motions): (&[Place], &[Motion]),
) -> TrajectoriesError {
    for (place, motion) in places.iter().zip(motions) {
        if let Err(source) = stream.add(&mut stream.none(), std::slice::from_ref(motion)) {
            return place.error(source);
        }
    }
    error.into()
}
