//! What is fuzzed: each reader, and the commands on a model and a recording, with a folder for inputs that are read
//! from files. The targets hand on what the fuzzer makes up; `tests/fuzz.rs` of the workspace what it draws itself.

pub mod command;
pub mod expression;
pub mod fleet;
pub mod learned;
pub mod log;
pub mod model;
pub mod recording;
pub mod robot;

use lacuna::recordings::{Recording, RecordingError, Sampling};
use std::path::PathBuf;
use std::sync::LazyLock;

static FOLDER: LazyLock<tempfile::TempDir> =
    LazyLock::new(|| tempfile::tempdir().expect("a folder for the inputs"));

/// A file of this process with these bytes.
pub fn file(name: &str, bytes: &[u8]) -> PathBuf {
    let path = FOLDER.path().join(name);
    std::fs::write(&path, bytes).expect("the input is written");
    path
}

/// The parts of an input, between lines of `===`.
pub fn parts(text: &str) -> impl Iterator<Item = &str> {
    text.split("\n===\n")
}

/// That what is read of a recording has a place for every sample, and that what cannot be read is told.
pub fn told(read: Result<Recording, RecordingError>) {
    match read {
        Ok(recording) => {
            let sampling = Sampling::of(&recording.time);
            assert_eq!(sampling.positions(recording.len()).len(), recording.len());
        }
        Err(error) => assert!(!error.to_string().is_empty()),
    }
}
