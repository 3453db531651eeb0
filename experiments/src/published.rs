//! Curves that others published, read from a file beside the project for comparison in a figure.

use serde::Deserialize;
use std::io::ErrorKind;
use std::path::Path;

use crate::StudyError;

/// The paper's mean errors against lambda.
#[derive(Clone, Debug, PartialEq)]
pub struct LambdaCurves {
    /// `(lambda, mean |f error|)`.
    pub f: Vec<(f64, f64)>,
    /// `(lambda, mean |g error|)`.
    pub g: Vec<(f64, f64)>,
}

/// The file: its other curves are not read.
#[derive(Deserialize)]
struct File {
    /// Rows of log10 lambda, mean |f error|, mean |g error|.
    fig1: Vec<[f64; 3]>,
}

/// The published errors against lambda in the JSON file `path`; none where there is no such file.
///
/// # Errors
/// [`StudyError::Read`] for a file that cannot be read, [`StudyError::Published`] for one without
/// the rows `fig1` of log10 lambda, mean |f error| and mean |g error|.
pub fn lambda_curves(path: &Path) -> Result<Option<LambdaCurves>, StudyError> {
    let text = match std::fs::read_to_string(path) {
        Ok(text) => text,
        Err(error) if error.kind() == ErrorKind::NotFound => return Ok(None),
        Err(source) => return Err(StudyError::Read { path: path.to_path_buf(), source }),
    };
    let file: File = serde_json::from_str(&text)
        .map_err(|source| StudyError::Published { path: path.to_path_buf(), source })?;
    let curve = |k: usize| file.fig1.iter().map(|row| (10_f64.powf(row[0]), row[k])).collect();
    Ok(Some(LambdaCurves { f: curve(1), g: curve(2) }))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn curves_are_read_where_there_is_a_file() {
        let directory = tempfile::tempdir().unwrap();
        let path = directory.path().join("curves.json");
        assert_eq!(lambda_curves(&path).unwrap(), None);
        std::fs::write(&path, r#"{"fig1": [[-2.0, 0.5, 0.25]], "fig3_f": [1.0]}"#).unwrap();
        let expected = LambdaCurves { f: vec![(0.01, 0.5)], g: vec![(0.01, 0.25)] };
        assert_eq!(lambda_curves(&path).unwrap(), Some(expected));
        std::fs::write(&path, "{}").unwrap();
        assert!(matches!(lambda_curves(&path), Err(StudyError::Published { .. })));
    }
}
