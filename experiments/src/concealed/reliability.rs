//! Claimed probabilities against how often they are right.
//!
//! Findings are put into bins by the probability p that they claim. With n_b findings in bin b, mean claim
//! p_b and share of right ones r_b, the expected calibration error is
//!
//! ```text
//! ECE = sum_b (n_b / n) |p_b - r_b|
//! ```
//!
//! and the Brier score the mean of (p - y)^2, y being 1 where it is right, which a sharper claim makes smaller, too.

use serde::{Deserialize, Serialize};

use super::proportion::Proportion;
use super::row::Row;

/// Edges of the bins of claimed probability: finer where most claims are.
const EDGES: [f64; 8] = [0.0, 0.5, 0.7, 0.8, 0.9, 0.95, 0.99, 1.0];

/// What one finding claims, and whether it is right.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Claim {
    /// Claimed probability.
    pub probability: f64,
    /// Whether class and channel are right.
    pub right: bool,
}

/// A bin: findings by the probability that they claim.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
pub struct Bin {
    /// Claimed probabilities from this one, to the next edge.
    pub from: f64,
    /// The upper edge; the last bin holds it.
    pub to: f64,
    /// Mean of the claimed probabilities; none in an empty bin.
    pub claimed: Option<f64>,
    /// Findings that are right.
    pub right: Proportion,
}

/// How far claims are to be relied on.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
pub struct Reliability {
    /// Findings that claim a probability.
    pub findings: usize,
    /// Expected calibration error; none without findings.
    pub calibration_error: Option<f64>,
    /// Brier score; none without findings.
    pub brier: Option<f64>,
    /// The bins.
    pub bins: Vec<Bin>,
}

/// What the findings of some cases claim, as the files of results have it.
pub fn claims(rows: &[Row]) -> Vec<Claim> {
    let matches = rows.iter().flat_map(|r| &r.score.matches);
    let claim = matches.filter_map(|m| Some(Claim { probability: m.probability?, right: m.right }));
    claim.collect()
}

impl Reliability {
    /// Of some claims.
    pub fn of(claims: &[Claim]) -> Self {
        let bins: Vec<Bin> =
            EDGES.windows(2).map(|edge| Bin::of(claims, edge[0], edge[1])).collect();
        let n = claims.len() as f64;
        let off = |b: &Bin| Some(b.right.of as f64 / n * (b.claimed? - b.right.share?).abs());
        let square = |c: &Claim| (c.probability - f64::from(u8::from(c.right))).powi(2);
        let some = |value: f64| (!claims.is_empty()).then_some(value);
        Self {
            findings: claims.len(),
            calibration_error: some(bins.iter().filter_map(off).sum()),
            brier: some(claims.iter().map(square).sum::<f64>() / n),
            bins,
        }
    }
}

impl Bin {
    fn of(claims: &[Claim], from: f64, to: f64) -> Self {
        let inside = |p: f64| p >= from && (p < to || (to == 1.0 && p == 1.0));
        let of: Vec<_> = claims.iter().filter(|c| inside(c.probability)).collect();
        let sum: f64 = of.iter().map(|c| c.probability).sum();
        Self {
            from,
            to,
            claimed: (!of.is_empty()).then(|| sum / of.len() as f64),
            right: Proportion::new(of.iter().filter(|c| c.right).count(), of.len()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{Claim, Reliability};

    #[test]
    fn claims_are_compared_with_the_truth() {
        let claim = |probability, right| Claim { probability, right };
        let claims = [claim(0.97, true), claim(0.96, false), claim(1.0, false), claim(0.6, true)];
        let r = Reliability::of(&claims);
        let at = |p: f64| r.bins.iter().find(|b| b.from == p).unwrap();
        assert_eq!((at(0.95).right.count, at(0.95).right.of), (1, 2));
        assert!((at(0.95).claimed.unwrap() - 0.965).abs() < 1e-12);
        assert_eq!((at(0.99).right.count, at(0.99).right.of), (0, 1));
        assert_eq!(at(0.7).claimed, None);
        let error = 0.5 * (0.965 - 0.5) + 0.25 * 1.0 + 0.25 * 0.4;
        assert!((r.calibration_error.unwrap() - error).abs() < 1e-12);
        let brier = (0.03f64.powi(2) + 0.96f64.powi(2) + 1.0 + 0.4f64.powi(2)) / 4.0;
        assert!((r.brier.unwrap() - brier).abs() < 1e-12);
        assert_eq!(r.findings, 4);
    }

    #[test]
    fn no_claims_have_no_error() {
        let r = Reliability::of(&[]);
        assert_eq!((r.findings, r.calibration_error, r.brier), (0, None, None));
    }
}
