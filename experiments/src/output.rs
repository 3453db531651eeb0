//! Reading results, and writing them: whole or not at all.

use crate::StudyError;
use serde::Serialize;
use serde::de::DeserializeOwned;
use std::fs;
use std::path::{Path, PathBuf};

/// Write `value` as indented JSON to `directory/name.json` and return the path.
///
/// # Errors
/// [`StudyError::Write`] when the file cannot be written.
pub fn write_json(
    directory: &Path,
    name: &str,
    value: &impl Serialize,
) -> Result<PathBuf, StudyError> {
    let path = directory.join(format!("{name}.json"));
    write_json_to(&path, value)?;
    Ok(path)
}

/// Write `value` as indented JSON to a file.
///
/// # Errors
/// [`StudyError::Write`] when the file cannot be written.
pub fn write_json_to(path: &Path, value: &impl Serialize) -> Result<(), StudyError> {
    let mut text = serde_json::to_string_pretty(value)
        .map_err(|source| StudyError::Json { path: path.to_path_buf(), source })?;
    text.push('\n');
    replace(path, &text)
}

/// Read what a JSON file holds.
///
/// # Errors
/// [`StudyError::Read`] and [`StudyError::Content`] for a file that is not there or holds something else.
pub fn read_json<T: DeserializeOwned>(path: &Path) -> Result<T, StudyError> {
    let text = fs::read_to_string(path)
        .map_err(|source| StudyError::Read { path: path.to_path_buf(), source })?;
    serde_json::from_str(&text)
        .map_err(|source| StudyError::Content { path: path.to_path_buf(), source })
}

/// Write a picture to `directory/figures/name.svg` and return the path.
///
/// # Errors
/// [`StudyError::Write`] when the file cannot be written.
pub fn write_figure(directory: &Path, name: &str, svg: &str) -> Result<PathBuf, StudyError> {
    let path = directory.join("figures").join(format!("{name}.svg"));
    replace(&path, svg)?;
    Ok(path)
}

/// Write pictures, each with its name, as [`write_figure`] does.
///
/// # Errors
/// [`StudyError::Write`] when a file cannot be written.
pub fn write_figures(directory: &Path, figures: &[(&str, String)]) -> Result<(), StudyError> {
    figures.iter().try_for_each(|(name, svg)| write_figure(directory, name, svg).map(|_| ()))
}

/// Write to a temporary file beside `path` and rename it, so that a reader never sees a half
/// and an interrupted study leaves the old results.
///
/// # Errors
/// [`StudyError::Write`] when the file cannot be written.
pub fn replace(path: &Path, text: &str) -> Result<(), StudyError> {
    let failed = |source| StudyError::Write { path: path.to_path_buf(), source };
    if let Some(directory) = path.parent() {
        fs::create_dir_all(directory).map_err(failed)?;
    }
    let partial = path.with_extension(format!("partial-{}", std::process::id()));
    let written = fs::write(&partial, text).and_then(|()| fs::rename(&partial, path));
    if written.is_err() {
        // The cause is reported below; a leftover that cannot be removed either adds nothing.
        let _ = fs::remove_file(&partial);
    }
    written.map_err(failed)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn results_replace_older_ones_and_leave_nothing_else() {
        let directory = tempfile::tempdir().unwrap();
        write_json(directory.path(), "study", &1).unwrap();
        let path = write_json(directory.path(), "study", &[1, 2]).unwrap();
        assert_eq!(read_json::<Vec<u32>>(&path).unwrap(), [1, 2]);
        let said = read_json::<String>(&path).unwrap_err().to_string();
        assert!(said.contains("study.json"), "{said}");
        let figure = write_figure(directory.path(), "plot", "<svg/>").unwrap();
        assert_eq!(fs::read_to_string(figure).unwrap(), "<svg/>");
        assert_eq!(fs::read_dir(directory.path()).unwrap().count(), 2);
    }

    #[test]
    fn a_place_that_cannot_be_written_is_an_error() {
        let directory = tempfile::tempdir().unwrap();
        let file = directory.path().join("file");
        fs::write(&file, "").unwrap();
        assert!(matches!(write_json(&file, "study", &1), Err(StudyError::Write { .. })));
    }
}
