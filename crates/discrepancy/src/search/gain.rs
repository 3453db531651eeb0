//! What an effect is worth.

use crate::likelihood::{Fit, Problem};

/// Nats that an effect, or a moved parameter, must gain.
pub const THRESHOLD: f64 = 10.0;

/// Mean square, in units of the noise, by which predictions must change to be worth a word.
pub const RELEVANT: f64 = 0.0025;

/// How much of the evidence counts: residuals that are larger or slower than white noise say
/// less, in proportion.
#[derive(Clone, Copy, Debug)]
pub struct Worth {
    inflation: f64,
    colour: f64,
}

impl Worth {
    /// Judged by what a fit leaves.
    #[must_use]
    pub fn of(problem: &Problem, fit: &Fit) -> Self {
        Self { inflation: fit.inflation(), colour: fit.colour(problem) }
    }

    /// Log evidence of a fit (nats), up to what all fits in the same windows share.
    #[must_use]
    pub fn evidence(&self, fit: &Fit) -> f64 {
        -0.5 * fit.chi2 / (self.inflation * self.colour) - fit.price(self.inflation * self.colour)
    }

    /// Nats that `with` gains over `without`, in the same windows.
    #[must_use]
    pub fn gain(&self, without: &Fit, with: &Fit) -> f64 {
        self.evidence(with) - self.evidence(without)
    }
}

/// Nats that `with` gains over `without` in the same windows, judged by what `with` leaves.
#[must_use]
pub fn gain(problem: &Problem, without: &Fit, with: &Fit) -> f64 {
    Worth::of(problem, with).gain(without, with)
}
