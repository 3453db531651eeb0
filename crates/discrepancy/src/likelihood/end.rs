//! How minimisations end: at an optimum, before one, or without a fit at all.

use std::fmt;

/// Why a minimisation went no further.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum End {
    /// The last step gained less than was asked for: an optimum.
    Converged,
    /// No step lowers the objective, however short: an optimum as far as rounding lets one see,
    /// or the edge of a region in which the model diverges.
    Stalled,
    /// The steps that were allowed are used up.
    OutOfSteps,
}

impl fmt::Display for End {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Converged => "converged",
            Self::Stalled => "stalled: no step lowers the misfit",
            Self::OutOfSteps => "out of steps before it converged",
        })
    }
}

/// Where a run left what a double can hold.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("the model diverges on {recording} at {time} s")]
pub struct Diverged {
    /// The recording.
    pub recording: String,
    /// The sample from which on it diverges (s).
    pub time: f64,
}

/// Why there is no fit.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum FitError {
    /// The model diverges from the very beginning.
    #[error(transparent)]
    Diverged(#[from] Diverged),
    /// The normal equations cannot be solved.
    #[error("the normal equations are singular: a parameter changes nothing that is finite")]
    Singular,
    /// In windows that grow the misfit ran away: expected at most, found.
    #[error(
        "the misfit runs away in longer windows: {found:.3} times the noise, at most {most:.3}"
    )]
    RanAway {
        /// Largest mean square residual with which a fit goes on, in units of the noise.
        most: f64,
        /// What was found.
        found: f64,
    },
    /// Whoever asked for the fit wants it no more.
    #[error("cancelled")]
    Cancelled,
}
