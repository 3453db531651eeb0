//! Cases as files: what the diagnosis sees, and what stays under seal in another directory.
//!
//! ```text
//! OPEN/ID/model.toml               the model, and robot.urdf where it is a robot's
//! OPEN/ID/recordings/run01.csv     what it is diagnosed with
//! SEALED/ID/truth.json             what is concealed
//! SEALED/ID/states/run01.csv       true states at the rows of run01.csv
//! SEALED/ID/test/test01.csv        recordings for the proof
//! ```

use lacuna_recordings::{Recording, write_csv_with_time};
use std::fs;
use std::path::{Path, PathBuf};

use super::ConcealedError;
use super::case::Case;
use super::sealed::Sealed;
use crate::StudyError;

/// Where a case is.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Folders {
    /// What the diagnosis sees.
    pub open: PathBuf,
    /// What it does not.
    pub sealed: PathBuf,
}

impl Folders {
    /// The folders of a case within those of all cases.
    pub fn of(open: &Path, sealed: &Path, id: &str) -> Self {
        Self { open: open.join(id), sealed: sealed.join(id) }
    }

    /// Recordings that the diagnosis is given, relative to [`Folders::open`].
    pub fn recordings(count: usize) -> Vec<String> {
        (1..=count).map(|k| format!("recordings/run{k:02}.csv")).collect()
    }

    /// Recordings for the proof.
    pub fn tests(&self, count: usize) -> Vec<PathBuf> {
        (1..=count).map(|k| self.sealed.join(format!("test/test{k:02}.csv"))).collect()
    }

    /// True states of the recordings.
    pub fn states(&self, count: usize) -> Vec<PathBuf> {
        (1..=count).map(|k| self.sealed.join(format!("states/run{k:02}.csv"))).collect()
    }

    /// Write a case.
    ///
    /// # Errors
    /// [`StudyError::Write`] or [`ConcealedError::Recording`] when a file cannot be written.
    pub fn write(&self, case: &Case) -> Result<(), StudyError> {
        let recordings = Self::recordings(case.recordings.len());
        let recordings: Vec<PathBuf> = recordings.iter().map(|r| self.open.join(r)).collect();
        write_all(&case.recordings, &recordings, &case.time_column)?;
        write_all(&case.states, &self.states(case.states.len()), &case.time_column)?;
        write_all(&case.tests, &self.tests(case.tests.len()), &case.time_column)?;
        case.files.write(&self.open)?;
        crate::output::write_json(&self.sealed, "truth", &case.sealed)?;
        Ok(())
    }

    /// Break the seal.
    ///
    /// # Errors
    /// [`StudyError::Read`] and [`StudyError::Content`] for a file that is gone or broken.
    pub fn unseal(&self) -> Result<Sealed, StudyError> {
        crate::output::read_json(&self.sealed.join("truth.json"))
    }
}

fn write_all(
    recordings: &[Recording],
    paths: &[PathBuf],
    time_column: &str,
) -> Result<(), StudyError> {
    for (recording, path) in recordings.iter().zip(paths) {
        if let Some(folder) = path.parent() {
            fs::create_dir_all(folder)
                .map_err(|source| StudyError::Write { path: folder.to_path_buf(), source })?;
        }
        write_csv_with_time(path, recording, time_column).map_err(ConcealedError::from)?;
    }
    Ok(())
}
