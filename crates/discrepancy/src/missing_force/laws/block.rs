//! The rows of a channel under the noise that is left.

use super::super::rows::Rows;
use lacuna_occupation::{BandedCholesky, SymmetricBanded};

/// Of a white force beside the laws, in units of the rows' noise: none, then 2^-2 to 2^17.
pub(super) const WHITE: i32 = 21;

/// The rows of a channel under the noise that is left.
#[derive(Clone)]
pub(super) struct Block {
    pub(super) white: usize,
    /// How many of its rows are worth one.
    pub(super) temperature: f64,
    /// How many of its rows are correlated.
    pub(super) colour: f64,
    /// Nats by which it is less likely than if nothing but the noise of the sensors were left, what is correlated
    /// counted once.
    pub(super) deficit: f64,
    pub(super) factors: Vec<BandedCholesky>,
}

impl Block {
    pub(super) fn new(rows: &[(usize, Rows)], white: usize) -> Option<Self> {
        let mut factors = vec![];
        for (_, own) in rows {
            let mut covariance = if white == 0 {
                own.measured.plus(&own.white, 0.0).ok()?
            } else {
                let share = 2f64.powi(white as i32 - 3);
                let size =
                    |m: &SymmetricBanded| (0..own.right.len()).map(|a| m.get(a, a)).sum::<f64>();
                let ratio = size(&own.measured) / size(&own.white);
                own.measured.plus(&own.white, share * share * ratio).ok()?
            };
            covariance.add_diagonal(1e-12 * covariance.largest_diagonal());
            factors.push(covariance.cholesky().ok()?);
        }
        Some(Self { white, temperature: 1.0, colour: 1.0, deficit: 0.0, factors })
    }

    /// A column of all recordings, whitened.
    pub(super) fn whiten(&self, rows: &[(usize, Rows)], column: &mut [f64]) {
        let mut first = 0;
        for ((_, own), factor) in rows.iter().zip(&self.factors) {
            let count = own.right.len();
            // Lengths agree.
            let _ = factor.solve_lower_in_place(&mut column[first..first + count]);
            first += count;
        }
    }

    pub(super) fn half_log_determinant(&self, rows: &[(usize, Rows)]) -> f64 {
        let of = |((_, own), factor): (&(usize, Rows), &BandedCholesky)| {
            (0..own.right.len()).map(|a| factor.get(a, a).ln()).sum::<f64>()
        };
        rows.iter().zip(&self.factors).map(of).sum()
    }
}

/// A column of all recordings, recording by recording.
pub(super) fn series<'s>(rows: &[(usize, Rows)], column: &'s [f64]) -> Vec<&'s [f64]> {
    let mut first = 0;
    rows.iter()
        .map(|(_, own)| {
            let part = &column[first..first + own.right.len()];
            first += own.right.len();
            part
        })
        .collect()
}
