//! The peers' way on the same files: discrepancy SINDy.
//!
//! ```text
//! r = M(q) q'' - F(q, q', u)       smoothed and differentiated recordings, nominal model
//! r = J dp + Theta c               J: what the uncertain parameters do, c sparse
//! ```
//!
//! 1. Smooth each channel (the Kalman smoother of `lacuna-recordings`, noise from sixth
//!    differences) and differentiate; what the model does not explain is a residual force.
//! 2. Take out what other parameters could explain, by least squares: without it every wrong
//!    parameter would be a finding.
//! 3. Regress the rest on a library, sequentially thresholded least squares on columns of unit
//!    size, with the threshold that predicts recordings left out, the sparsest within a standard error
//!    of the best (Hastie, Tibshirani, Friedman, The Elements of Statistical Learning, 7.10).
//! 4. A term of the library that is left is a finding, by the class whose formula it is.
//!
//! Source: Kaheman, Kaiser, Strom, Kutz, Brunton, Learning discrepancy models from experimental
//! data, 2019 (arXiv 1909.08574); steps 2 and the choice in 3 are in the peers' favour.

mod library;
mod regression;
mod residual;

use lacuna_plants::Model;
use lacuna_recordings::{Recording, RecordingSource};

use super::ConcealedError;
use super::diagnosis::{Diagnosis, Finding};
use super::files::Folders;
use crate::sindy::SparseRegressionError;
use library::terms;
use regression::{Problem, sparse};
use residual::Residuals;

/// Share of the residual's mean square that parameters must explain to be called wrong.
const EXPLAINED: f64 = 0.1;

/// The diagnosis of a case by its files; none where the method gives no answer.
pub fn diagnose(folders: &Folders, recordings: usize) -> Option<Diagnosis> {
    let model = Model::read(&folders.open.join("model.toml")).ok()?;
    let read = |name: String| {
        lacuna_recordings::read(&RecordingSource::file(folders.open.join(name)), &model.time_column)
    };
    let recordings: Result<Vec<Recording>, _> =
        Folders::recordings(recordings).into_iter().map(read).collect();
    find(&model, &recordings.ok()?).ok()
}

/// The diagnosis of recordings.
///
/// # Errors
/// [`PeerError`] where a channel cannot be smoothed or the regression fails.
fn find(model: &Model, recordings: &[Recording]) -> Result<Diagnosis, PeerError> {
    let residuals = Residuals::of(model, recordings)?;
    let mut findings = Vec::new();
    let mut miscalibrated = false;
    for channel in 0..model.channels() {
        if !residuals.is_measured(channel) {
            continue;
        }
        let terms = terms(model, channel);
        let problem = Problem::of(&residuals, channel, &terms);
        miscalibrated |= problem.explained > EXPLAINED;
        for k in sparse(&problem)? {
            let name = &terms[k].name;
            findings.push(Finding {
                class: name.class.clone(),
                channel: name.channel.clone(),
                ..Finding::default()
            });
        }
    }
    // The same gain may show in the equations of several channels.
    findings.dedup_by(|a, b| a.name() == b.name());
    let verdict = match (findings.is_empty(), miscalibrated) {
        (false, _) => "missing_physics",
        (true, true) => "miscalibrated",
        (true, false) => "no_mismatch",
    };
    Ok(Diagnosis { verdict: verdict.to_owned(), findings, ..Diagnosis::default() })
}

/// Why the method gives no answer.
#[derive(Debug, thiserror::Error)]
enum PeerError {
    #[error(transparent)]
    Recording(#[from] ConcealedError),
    #[error(transparent)]
    Signal(#[from] lacuna_recordings::SignalError),
    #[error(transparent)]
    Regression(#[from] SparseRegressionError),
}

#[cfg(test)]
mod tests;
