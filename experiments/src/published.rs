//! What the paper published: numbers that figures show beside ours, and curves, read from a file
//! beside the project.

use serde::Deserialize;
use std::io::ErrorKind;
use std::path::Path;

use crate::StudyError;
use crate::manipulator_ctc::Angles;
use crate::statistics::OverPoints;

/// Errors of one Duffing trial over 61 points of [-3, 3], as the paper's figures show them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OneTrial {
    /// Greatest.
    pub max: f64,
    /// Mean.
    pub mean: f64,
}

impl OneTrial {
    /// Of the drift and of the control effectiveness.
    pub const ALL: [Self; 2] = [Self { max: 0.613, mean: 0.226 }, Self { max: 0.396, mean: 0.130 }];
}

/// Relative errors of the manipulator over 100 points, as the paper's figures show them: of the
/// drift and of both columns of the control effectiveness.
pub const MANIPULATOR: [OverPoints; 3] = [
    OverPoints { max: 0.177, median: 0.0694, mean: 0.0750 },
    OverPoints { max: 1.90, median: 0.276, mean: 0.402 },
    OverPoints { max: 0.674, median: 0.0895, mean: 0.109 },
];

/// Both joint angles (rad) of the regulated manipulator after 5 s and after 10 s, as the paper's
/// figures show them: with the true model, and with the identified one.
pub const REGULATOR: [Angles; 2] = [
    Angles { q_5s: [0.0105; 2], q_10s: [0.0003; 2] },
    Angles { q_5s: [0.0154, 0.0494], q_10s: [-0.0026, 0.0201] },
];

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
