//! What the targets share: a folder for inputs that are read from files.

use std::path::{Path, PathBuf};
use std::sync::LazyLock;

static FOLDER: LazyLock<tempfile::TempDir> =
    LazyLock::new(|| tempfile::tempdir().expect("a folder for the inputs"));

/// A file of this process with these bytes.
pub fn file(name: &str, bytes: &[u8]) -> PathBuf {
    let path = FOLDER.path().join(name);
    std::fs::write(&path, bytes).expect("the input is written");
    path
}

/// The folder of these files.
pub fn folder() -> &'static Path {
    FOLDER.path()
}

/// The parts of an input, between lines of `===`.
pub fn parts(text: &str) -> impl Iterator<Item = &str> {
    text.split("\n===\n")
}
