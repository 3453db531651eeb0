//! Forces learned without a formula, as curves over one variable.

use super::{Screen, amplitude_sd};
use crate::DiagnoseError;
use crate::candidates::Term;
use crate::evidence::Normal;
use crate::trajectories::SmoothedRecording;

/// The variable that a learned force depends on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Over {
    /// The channel's coordinate or first-order state.
    Coordinate,
    /// The channel's velocity.
    Velocity,
    /// Time.
    Time,
}

impl Over {
    fn of(self, s: &SmoothedRecording, channel: usize, k: usize) -> f64 {
        let at = s.local(channel, None, k);
        match self {
            Self::Coordinate => at.q,
            Self::Velocity => at.v,
            Self::Time => at.t,
        }
    }
}

/// A force learned without a formula.
#[derive(Clone, Debug)]
pub struct Learned {
    /// Values of the variable.
    pub at: Vec<f64>,
    /// The force there.
    pub force: Vec<f64>,
    /// Its standard deviation.
    pub std: Vec<f64>,
    /// Log evidence (nats) that it gains.
    pub gain: f64,
}

/// The range that holds all but a thousandth of the values at each end.
fn central_range(values: &[f64]) -> (f64, f64) {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    let cut = sorted.len() / 1000;
    (sorted[cut], sorted[sorted.len() - 1 - cut])
}

impl Screen<'_> {
    /// What the residual shows of a force on `channel` that depends on one variable alone, in
    /// addition to `terms`: bumps over the variable's range with a Gaussian prior, so that the
    /// result is a smooth curve with its uncertainty. `known` says what is known beforehand of
    /// the free parameters and, after them, of the terms' amplitudes.
    ///
    /// # Errors
    /// [`DiagnoseError`] when the weak form breaks down numerically.
    pub fn learn(
        &self,
        terms: &[Term],
        tau: &[f64],
        known: Vec<Normal>,
        channel: usize,
        over: Over,
    ) -> Result<Learned, DiagnoseError> {
        const BUMPS: usize = 24;
        let values: Vec<f64> = self
            .weak
            .smoothed()
            .flat_map(|s| (0..s.len()).map(move |k| over.of(s, channel, k)))
            .collect();
        let (low, high) = central_range(&values);
        let spacing = (high - low) / (BUMPS - 1) as f64;
        let bump = |j: usize, x: f64| {
            let z = (x - low - j as f64 * spacing) / (1.3 * spacing);
            (-0.5 * z * z).exp()
        };
        let mut system = self.system(terms);
        system.priors.splice(..known.len(), known);
        let base = system.clone();
        let own = system.columns.len();
        for j in 0..BUMPS {
            let column = self.weak.force_column(&self.point, channel, None, |s| {
                (0..s.len()).map(|k| bump(j, over.of(s, channel, k).clamp(low, high))).collect()
            });
            system.priors.push(Normal { mean: 0.0, sd: amplitude_sd(self.scale, &column) });
            system.columns.push(column);
        }
        let whitener = self.weak.whitener(tau)?;
        let failed = || DiagnoseError::Weak { reason: "the regression is not finite".into() };
        let with = system.whitened(&whitener);
        let fit = with.regress().ok_or_else(failed)?;
        let without = self.fit(&base, tau)?.ok_or_else(failed)?;
        let colour = self.colour(&with.residual(&fit));
        let at: Vec<f64> = (0..4 * BUMPS)
            .map(|k| low + (high - low) * k as f64 / (4 * BUMPS - 1) as f64)
            .collect();
        let (mut force, mut std) = (vec![], vec![]);
        for &x in &at {
            let b: Vec<f64> = (0..BUMPS).map(|j| bump(j, x)).collect();
            force.push((0..BUMPS).map(|j| b[j] * fit.coefficients[own + j]).sum());
            let variance: f64 = (0..BUMPS)
                .flat_map(|i| (0..BUMPS).map(move |j| (i, j)))
                .map(|(i, j)| b[i] * b[j] * fit.covariance[(own + i, own + j)])
                .sum();
            std.push((variance * colour).max(0.0).sqrt());
        }
        Ok(Learned { at, force, std, gain: (fit.log - without.log) / colour })
    }
}
