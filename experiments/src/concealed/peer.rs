//! placeholder until written
use super::diagnosis::Diagnosis;
use super::files::Folders;

/// none
pub fn diagnose(_folders: &Folders, _recordings: usize) -> Option<Diagnosis> {
    None
}
