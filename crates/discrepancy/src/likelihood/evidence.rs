//! The evidence: how probable a hypothesis makes what was recorded.
//!
//! By Laplace's method about the optimum, up to what all hypotheses in the same windows share,
//!
//! ```text
//! log Z = - (chi^2 + log det S_z) / (2 T) - |(theta - theta_0) / S|^2 / 2 - sum_i log m_i
//!         - log det(1 + (H - 1) / T) / 2
//! ```
//!
//! with S_z the covariance of the innovations in units of the outputs' noise (1 where no noise
//! drives the machine), H the precision of theta in units of its prior S, and m the mass that the normal prior
//! of an entry has within its bounds (1/2 for a magnitude, which cannot be negative). T is the
//! temperature: residuals whose mean square is s times that of the noise, and of which c samples
//! in a row say the same, are worth one sample of the noise in T = s c. It belongs to what is
//! compared, not to one of the hypotheses: all are judged by what the one that fits best leaves.

use super::{Fit, Free, QUICK, What};
use crate::colour::{RELIABLE, ROUGH, colour};
use lacuna_effects::Law;
use nalgebra::{DMatrix, DVector};

impl Fit<'_> {
    /// Mean square of the residual in units of the noise.
    #[must_use]
    pub fn reduced(&self) -> f64 {
        self.chi2 / self.count.max(1) as f64
    }

    /// Mean square of the residual beyond what the outputs' noise alone would leave.
    #[must_use]
    pub fn excess(&self) -> f64 {
        if self.noise.is_none() {
            return self.reduced() - 1.0;
        }
        let quiet: f64 = self.filters.iter().flatten().map(|f| f.quiet).sum();
        (self.chi2 - quiet) / self.count.max(1) as f64
    }

    /// Mean square of the residual beyond all noise, 0 at least: what a recorded input was not of what the machine got
    /// is noise, as that of outputs is; a random force is not.
    #[must_use]
    pub fn beyond_noise(&self) -> f64 {
        let left = match &self.noise {
            Some(noise) if noise.pushes_nothing() => self.reduced() - 1.0,
            _ => self.excess(),
        };
        left.max(0.0)
    }

    /// [`Fit::excess`] in each recording.
    #[must_use]
    pub fn excess_by_recording(&self) -> Vec<f64> {
        let mut residuals = self.residuals.iter();
        let of = |(r, windows): (usize, &Vec<_>)| {
            let own = residuals.by_ref().take(windows.len()).flatten();
            let (chi2, count) = own.fold((0.0, 0.0), |(sum, n), e| (sum + e * e, n + 1.0));
            let quiet = match self.noise {
                Some(_) => self.filters[r].iter().map(|f| f.quiet).sum(),
                None => count,
            };
            (chi2 - quiet) / f64::max(count, 1.0)
        };
        self.windowed.windows.iter().enumerate().map(of).collect()
    }

    /// How much wider innovations are than the outputs' noise: log det of their covariance.
    #[must_use]
    pub fn width(&self) -> f64 {
        self.filters.iter().flatten().map(|f| f.log_determinant).sum()
    }

    /// Minus twice the log likelihood with the pull of the priors, at its optimum.
    #[must_use]
    pub fn misfit(&self) -> f64 {
        self.chi2 + self.width() + self.penalty
    }

    /// By how much the variance of the noise must be larger for the residual to be noise.
    #[must_use]
    pub fn inflation(&self) -> f64 {
        self.reduced().max(1.0)
    }

    /// How many samples of the residual are worth one of the noise.
    #[must_use]
    pub fn temperature(&self) -> f64 {
        self.inflation() * self.colour(RELIABLE)
    }

    /// The same to an order of magnitude, from few windows.
    #[must_use]
    pub fn rough_temperature(&self) -> f64 {
        self.inflation() * self.colour(ROUGH)
    }

    /// How much more slowly than white noise the residual varies (1 is white).
    fn colour(&self, fewest: usize) -> f64 {
        colour(self.residuals.iter().map(Vec::as_slice), fewest)
    }

    /// Log evidence (nats) at a temperature, up to what all fits in the same windows share; none at all of effects
    /// that cannot be.
    #[must_use]
    pub fn log_evidence(&self, temperature: f64) -> f64 {
        if !self.is_possible() {
            return f64::NEG_INFINITY;
        }
        let occam = self.precision.log_determinant(temperature);
        -0.5 * ((self.chi2 + self.width()) / temperature + self.penalty + occam)
            - self.hypothesis.log_prior_mass()
    }

    /// The same with what the fit's end still promises: where it was given up early.
    #[must_use]
    pub fn hope(&self, temperature: f64) -> f64 {
        self.log_evidence(temperature) + 0.5 * self.promised / temperature
    }

    /// Whether each effect can be with its parameters.
    fn is_possible(&self) -> bool {
        self.hypothesis.supposed().iter().all(|e| match e.effect.nature.possible {
            Some(possible) => possible(&e.parameters, &self.problem.scales_of(e)),
            None => true,
        })
    }

    /// Nats by which this fit is ahead of the same without effect `k`, by the densities that prior and posterior
    /// have where the effect vanishes (Savage and Dickey): as exact as the posterior is normal. None where it
    /// vanishes nowhere that is fitted: an actuator without a limit has an infinite one.
    #[must_use]
    pub fn missed(&self, k: usize, temperature: f64) -> Option<f64> {
        let h = &self.hypothesis;
        let (entries, absent) = self.vanishes_with(k)?;
        let all = self.precision.covariance(temperature)?;
        let n = entries.len();
        let covariance = DMatrix::from_fn(n, n, |i, j| all[(entries[i], entries[j])]);
        let theta = h.theta();
        // In units of the prior, from where it vanishes.
        let from = |value: f64, f: &Free| (value - absent) / f.sd;
        let z = DVector::from_fn(n, |i, _| from(theta[entries[i]], &h.free[entries[i]]));
        let believed: f64 = entries.iter().map(|&i| from(h.free[i].mean, &h.free[i]).powi(2)).sum();
        let factor = covariance.cholesky()?;
        let log: f64 = factor.l().diagonal().map(f64::ln).sum();
        let sides = entries.iter().filter(|i| h.free[**i].bounds.0 == absent).count() as f64;
        Some(0.5 * (z.dot(&factor.solve(&z)) - believed) + log + sides * std::f64::consts::LN_2)
    }

    /// The entries of theta that effect `k` vanishes with, and the value at which it does; none where it vanishes
    /// nowhere that is fitted.
    pub(super) fn vanishes_with(&self, k: usize) -> Option<(Vec<usize>, f64)> {
        let h = &self.hypothesis;
        let effect = h.supposed().get(k)?.effect;
        let absent = effect.nature.absent;
        let vanishing = match effect.law {
            Law::Force(law) => law.amplitudes(),
            Law::Structure(law) => law.amplitudes(),
            Law::Input(_) | Law::Sensor(_) => 1,
        };
        let own =
            |f: &Free| matches!(f.what, What::Effect(e, j) if e == h.own + k && j < vanishing);
        let entries: Vec<usize> =
            (0..h.free.len()).filter(|&i| own(&h.free[i]) && !h.free[i].logarithmic).collect();
        (!entries.is_empty() && absent.is_finite()).then_some((entries, absent))
    }

    /// Nats by which this fit is ahead of the same without effect `k`, both fitted; none where that has no fit.
    #[must_use]
    pub fn gained_by(&self, k: usize) -> Option<f64> {
        Some(self.gain_over(&self.without(k, QUICK).ok()?))
    }

    /// Whether effect `k` does nothing with the values that it was given.
    #[must_use]
    pub fn vanishes(&self, k: usize) -> bool {
        let Some(e) = self.hypothesis.supposed().get(k) else { return false };
        let absent = |x: &f64| *x == e.effect.nature.absent;
        match e.effect.law {
            Law::Force(law) => e.internal()[..law.amplitudes()].iter().all(absent),
            Law::Structure(law) => e.parameters[..law.amplitudes()].iter().all(absent),
            Law::Input(_) | Law::Sensor(_) => e.parameters.first().is_some_and(absent),
        }
    }

    /// Nats by which this fit is ahead of another in the same windows, both judged by what this
    /// one leaves, and by the same steps: what steps of other lengths err by adds up over all samples, to more than
    /// what tells two laws apart.
    #[must_use]
    pub fn gain_over(&self, other: &Self) -> f64 {
        let steps = self.substeps.and(other.substeps);
        let (own, other) = (self.by_steps(steps), other.by_steps(steps));
        let temperature = own.temperature();
        own.log_evidence(temperature) - other.log_evidence(temperature)
    }
}

/// The temperature at which fits in the same windows are compared: that of the one that fits
/// best; 1 where there is none.
#[must_use]
pub fn common_temperature<'a, 'p: 'a>(fits: impl Iterator<Item = &'a Fit<'p>>) -> f64 {
    let best = fits.min_by(|a, b| a.misfit().total_cmp(&b.misfit()));
    best.map_or(1.0, Fit::temperature)
}
