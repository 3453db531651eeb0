//! What keeps the remainders of inexact formulas from being named as further physics.

use super::{Hypothesis, Over, Screen, THRESHOLD};
use crate::DiagnoseError;
use crate::candidates::{Term, deviation};
use crate::evidence::{Normal, regress};
use lacuna_effects::{Law, Variable};

impl Screen<'_> {
    /// Whether a further effect says more than a force without a name would: a smooth curve
    /// over the coordinate or the velocity of the same channel. If the curve gains more, what
    /// is left is the remainder of formulas that are not exact, and no further law.
    pub(super) fn beats_a_remainder(
        &self,
        chosen: &Hypothesis,
        with: &Hypothesis,
        gain: f64,
    ) -> Result<bool, DiagnoseError> {
        let Some(added) = with.terms.last().filter(|_| !chosen.terms.is_empty()) else {
            return Ok(true);
        };
        let Law::Force(_) = added.candidate.effect.law else { return Ok(true) };
        for over in [Over::Coordinate, Over::Velocity] {
            let curve = {
                let (priors, channel) = (self.parameter_priors(), added.candidate.channel);
                self.learn(&chosen.terms, &chosen.tau, priors, channel, over)?
            };
            if curve.gain > gain {
                return Ok(false);
            }
        }
        Ok(true)
    }

    /// Whether the last effect, if it depends on time, does something that the motion does not
    /// do as well: where the motion is periodic, a force that returns with it may as well be
    /// one of the state, and these recordings cannot tell.
    pub(super) fn is_told_apart_from_motion(&self, h: &Hypothesis) -> bool {
        const MOST_EXPLAINED: f64 = 0.5;
        let Some(Term { candidate, shape }) = h.terms.last() else { return true };
        let Law::Force(law) = candidate.effect.law else { return true };
        if !candidate.effect.depends_on.contains(&Variable::Time) {
            return true;
        }
        let (mut features, mut basis) = (Vec::new(), vec![Vec::new(); law.amplitudes()]);
        for s in self.weak.smoothed() {
            let series = s.basis(law, shape, candidate.channel, candidate.other);
            for k in (0..s.len()).step_by(s.len().div_ceil(2000)) {
                let at = s.local(candidate.channel, None, k);
                features.push((at.q, at.v));
                basis.iter_mut().zip(&series).for_each(|(b, x)| b.push(x[k]));
            }
        }
        let explained = basis.iter().map(|b| share_explained_by_motion(&features, b));
        explained.fold(0.0, f64::max) < MOST_EXPLAINED
    }

    /// Whether what `with` adds to `without` is learned from one half of the recordings and
    /// found again in the other, both ways: a formula that is only slightly wrong leaves
    /// remainders that a further law can fit, but seldom the same ones everywhere.
    pub(super) fn generalises(
        &self,
        without: &Hypothesis,
        with: &Hypothesis,
    ) -> Result<bool, DiagnoseError> {
        let whitener = self.weak.whitener(&with.tau)?;
        let systems =
            [&without.terms, &with.terms].map(|terms| self.system(terms).whitened(&whitener));
        let halves = self.halves();
        let mut gains = [0.0; 2];
        for (gain, learn) in gains.iter_mut().zip(0..2) {
            let errors = systems.each_ref().map(|system| {
                let part = system.rows(&halves[learn]);
                let fit = part.regress()?;
                let residual = system.rows(&halves[1 - learn]).residual(&fit);
                Some(residual.iter().map(|r| r * r).sum::<f64>())
            });
            let [Some(without), Some(with)] = errors else { return Ok(false) };
            *gain = 0.5 * (without - with);
        }
        let total = (gains[0] + gains[1]) / with.colour;
        Ok(gains.iter().all(|&g| g > 0.0) && total > THRESHOLD)
    }

    /// Rows of two halves: every other recording, or the first and second half of a single
    /// one.
    fn halves(&self) -> [Vec<std::ops::Range<usize>>; 2] {
        let mut halves = [vec![], vec![]];
        let used = self.weak.channels().len();
        let segments = self.weak.segments();
        let single = segments.len() == used;
        for (k, (_, rows)) in segments.into_iter().enumerate() {
            if single {
                let middle = rows.start + rows.len() / 2;
                halves[0].push(rows.start..middle);
                halves[1].push(middle..rows.end);
            } else {
                halves[(k / used) % 2].push(rows);
            }
        }
        halves
    }
}

/// Share of a series' variance that a cubic polynomial of coordinate and velocity explains.
fn share_explained_by_motion(motion: &[(f64, f64)], series: &[f64]) -> f64 {
    let standard = |values: Vec<f64>| -> Vec<f64> {
        let mean = values.iter().sum::<f64>() / values.len() as f64;
        let sd = deviation(&values).max(f64::MIN_POSITIVE);
        values.iter().map(|v| (v - mean) / sd).collect()
    };
    let q = standard(motion.iter().map(|m| m.0).collect());
    let v = standard(motion.iter().map(|m| m.1).collect());
    let powers: Vec<(i32, i32)> = (0..4).flat_map(|i| (0..4 - i).map(move |j| (i, j))).collect();
    let columns: Vec<Vec<f64>> = powers
        .iter()
        .map(|&(i, j)| q.iter().zip(&v).map(|(q, v)| q.powi(i) * v.powi(j)).collect())
        .collect();
    let target = standard(series.to_vec());
    let refs: Vec<&[f64]> = columns.iter().map(Vec::as_slice).collect();
    let wide = vec![Normal { mean: 0.0, sd: 1e3 }; columns.len()];
    let Some(fit) = regress(&target, &refs, &wide, 0.0) else { return 0.0 };
    1.0 - fit.chi2 / target.iter().map(|t| t * t).sum::<f64>().max(f64::MIN_POSITIVE)
}
