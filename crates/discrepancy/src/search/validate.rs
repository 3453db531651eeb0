//! What recordings that nothing was fitted to say of an effect.
//!
//! Let an effect change the predictions on held-out recordings by D (in units of the noise, the
//! states at the windows' beginnings fitted with and without it). If it is there, the squares
//! fall by about `|D|^2`; if it only fits what is peculiar to the training recordings, they rise
//! by about as much. Where D is small, the held-out recordings do not touch what it describes and
//! say nothing.

use super::chain;
use super::{Path, Rival, Search, candidate_of};
use crate::likelihood::{FULL, Fit, Hypothesis, Problem};

/// Windows of the held-out recordings: `2^LEVEL` each.
const LEVEL: u32 = 3;
/// `|D|^2` below which nothing is said.
const SILENT: f64 = 20.0;
/// Nats of predictive likelihood that speak against an effect however small D is.
const AGAINST: f64 = 3.0;
/// Share of `|D|^2` by which the squares must fall.
const CONFIRMED: f64 = 0.2;

/// Whether held-out recordings speak against `with`, compared with `without`.
#[must_use]
pub fn refuted(held_out: &Problem, without: &Hypothesis, with: &Hypothesis) -> bool {
    let fit = |h: &Hypothesis| Fit::begin(held_out, h.clone().held(), LEVEL);
    let (Some(a), Some(b)) = (fit(without), fit(with)) else { return false };
    let change = |(x, y): (&Vec<f64>, &Vec<f64>)| -> f64 {
        x.iter().zip(y).map(|(p, q)| (p - q).powi(2)).sum()
    };
    let (x, y) = (a.residuals(held_out), b.residuals(held_out));
    let size: f64 = x.iter().zip(&y).map(change).sum();
    // What residuals above the noise say is worth as much less.
    let inflation = b.inflation();
    let (size, drop) = (size / inflation, (a.chi2 - b.chi2) / inflation);
    drop < -2.0 * AGAINST || (size > SILENT && drop < CONFIRMED * size)
}

impl Search<'_> {
    /// Take away the effects that the held-out recordings speak against, and what an effect says
    /// beyond a simpler law if they speak against that; all of them, if they speak against them
    /// together.
    pub(super) fn validate(&self, calibrated: &Fit, path: Path) -> Path {
        let mut path = self.simplified(path);
        for k in (0..path.named.len()).rev() {
            let h = path.fit.hypothesis.clone().without(k);
            let Some(without) = path.fit.refit(self.problem, h, FULL) else { continue };
            if refuted(self.held_out, &without.hypothesis, &path.fit.hypothesis) {
                path.named.remove(k);
                path.fit = chain::polish(self.problem, without);
            }
        }
        let together = &path.fit.hypothesis;
        if !path.named.is_empty() && refuted(self.held_out, &calibrated.hypothesis, together) {
            return Path { fit: calibrated.clone(), named: vec![] };
        }
        path
    }

    /// Simpler laws where the held-out recordings speak against a richer one beside them.
    fn simplified(&self, mut path: Path) -> Path {
        for k in (0..path.named.len()).rev() {
            let Some(simple) = self.special_case(&path.fit, k) else { continue };
            let rich = &path.fit.hypothesis;
            if refuted(self.held_out, &simple.hypothesis, rich) {
                let candidate = candidate_of(&rich.supposed()[k]);
                let rival = Rival { candidate, behind: AGAINST, hypothesis: rich.clone() };
                let mut named = path.named.remove(k);
                named.rivals.retain(|r| !r.candidate.excludes(&candidate));
                named.rivals.push(rival);
                path.named.push(named);
                path.fit = simple;
            }
        }
        path
    }
}
