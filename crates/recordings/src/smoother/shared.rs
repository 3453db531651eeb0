//! The smoother's means for many series with the same times.
//!
//! Gains do not depend on what was measured, only on when: for series that share their times (and what is missing) they
//! are worked out once for each density, as matrices
//!
//! ```text
//! (z_k, e_k) = A_k (z_(k-1), y_k)                        information and residuals, forwards
//! m_k = F^-1 m_(k+1) - G_k (E_k z_k - R_k m_(k+1))       means, backwards
//! log p = -|e|^2 / (2 sigma^2) - log det                 likelihood of a density
//! ```
//!
//! from the same rotations as for one series, and series pass through them side by side. Densities are those of a grid,
//! steps of [`FINEST`] in the logarithm: the smoother's band width goes with the sixth root and less.

mod gain;

use std::collections::BTreeMap;
use std::sync::OnceLock;

use super::means::MeanPath;
use super::{HIGHEST, LOWEST, Prior, SignalError, check_noise, check_pairs, search_density};
use crate::sampling::Sampling;
use gain::{Gain, LANES};

/// Step of the grid of log densities.
const FINEST: f64 = 0.5;
/// Gains of series with more samples are not kept.
const LONGEST: usize = 4096;

/// One of many series: values, and measured derivatives of them where there are; NaN where missing.
#[derive(Clone, Copy, Debug)]
pub struct Samples<'a> {
    /// Values, one per time.
    pub values: &'a [f64],
    /// Derivatives, one per time, or none.
    pub rates: &'a [f64],
}

/// What smooths all series that were measured at the same times.
#[derive(Debug)]
pub struct SharedSmoother {
    prior: Prior,
    step: f64,
    /// In usual steps, from the first.
    times: Vec<f64>,
    /// Whether value and rate are there.
    present: Vec<[bool; 2]>,
    /// sigma over sigma_v in usual steps.
    rate_weight: f64,
    /// sigma over sigma_v.
    rate_scale: f64,
    gains: Gains,
}

#[derive(Debug)]
enum Gains {
    Jerk(Bank<3, 5>),
    Snap(Bank<4, 6>),
}

impl SharedSmoother {
    /// For series measured at `time` where `like` was; `rate_scale` is the noise of values over that of derivatives.
    ///
    /// # Errors
    /// [`SignalError`] if times do not increase, lengths differ, or fewer than n + 1 values are present, n the order of the prior.
    pub fn new(
        prior: Prior,
        time: &[f64],
        like: Samples<'_>,
        rate_scale: f64,
    ) -> Result<Self, SignalError> {
        check_pairs(time, like.values)?;
        if !like.rates.is_empty() {
            check_pairs(time, like.rates)?;
        }
        let found = like.values.iter().filter(|value| !value.is_nan()).count();
        let needed = prior.order() + 1;
        if found < needed {
            return Err(SignalError::TooFewSamples { needed, found });
        }
        let step = Sampling::of(time).step;
        let rate = |k: usize| like.rates.get(k).is_some_and(|rate| !rate.is_nan());
        let gains = match prior {
            Prior::WhiteJerk => Gains::Jerk(Bank::new()),
            Prior::WhiteSnap => Gains::Snap(Bank::new()),
        };
        Ok(Self {
            prior,
            step,
            times: time.iter().map(|t| (t - time[0]) / step).collect(),
            present: (0..time.len()).map(|k| [!like.values[k].is_nan(), rate(k)]).collect(),
            rate_weight: rate_scale / step,
            rate_scale,
            gains,
        })
    }

    /// Log marginal likelihood of each series with values of noise `noise_sd`, for its most likely density; up to a constant as
    /// [`super::Smoothed::log_likelihood`].
    ///
    /// # Errors
    /// A noise that is not positive.
    pub fn log_likelihoods(
        &self,
        series: &[Samples<'_>],
        noise_sd: f64,
    ) -> Result<Vec<f64>, SignalError> {
        check_noise(noise_sd)?;
        let found = match &self.gains {
            Gains::Jerk(bank) => bank.most_likely(self, series, noise_sd),
            Gains::Snap(bank) => bank.most_likely(self, series, noise_sd),
        };
        Ok(found.into_iter().map(|(_, log_likelihood)| log_likelihood).collect())
    }

    /// The means of each series, measured at its own `times` (the shared ones but for their origin), values with
    /// noise `noise_sd`; an error for each that is out of range.
    ///
    /// # Errors
    /// A noise that is not positive.
    pub fn smooth(
        &self,
        series: &[(&[f64], Samples<'_>)],
        noise_sd: f64,
    ) -> Result<Vec<Result<MeanPath, SignalError>>, SignalError> {
        check_noise(noise_sd)?;
        let samples: Vec<Samples<'_>> = series.iter().map(|(_, samples)| *samples).collect();
        let states = match &self.gains {
            Gains::Jerk(bank) => bank.smooth(self, &samples, noise_sd),
            Gains::Snap(bank) => bank.smooth(self, &samples, noise_sd),
        };
        let path = |((times, _), states): (&(&[f64], _), Option<Vec<f64>>)| {
            let states = states.ok_or(SignalError::OutOfRange)?;
            Ok(MeanPath::new(self.prior, times.to_vec(), states))
        };
        Ok(series.iter().zip(states).map(path).collect())
    }
}

/// Gains for the densities of the grid, each made when first asked for.
#[derive(Debug)]
struct Bank<const D: usize, const R: usize> {
    of_density: Vec<OnceLock<Gain<D, R>>>,
}

impl<const D: usize, const R: usize> Bank<D, R> {
    fn new() -> Self {
        let count = ((HIGHEST - LOWEST) / FINEST) as usize + 1;
        Self { of_density: (0..count).map(|_| OnceLock::new()).collect() }
    }

    fn with<T>(&self, shared: &SharedSmoother, k: usize, of: impl FnOnce(&Gain<D, R>) -> T) -> T {
        let make = || Gain::new(shared, (LOWEST + FINEST * k as f64).exp());
        if shared.times.len() > LONGEST {
            of(&make())
        } else {
            of(self.of_density[k].get_or_init(make))
        }
    }

    /// Density and its log likelihood, of each series.
    fn most_likely(
        &self,
        shared: &SharedSmoother,
        series: &[Samples<'_>],
        noise_sd: f64,
    ) -> Vec<(usize, f64)> {
        let likelihoods = |k: usize, wanted: &[usize]| -> Vec<f64> {
            self.with(shared, k, |gain| {
                let of_lanes = |wanted: &[usize]| {
                    let squares = gain.filter(shared, series, wanted, |_| {});
                    squares.into_iter().take(wanted.len()).collect::<Vec<f64>>()
                };
                let squares = wanted.chunks(LANES).flat_map(of_lanes);
                let scale = -0.5 / (noise_sd * noise_sd);
                squares.map(|s| scale * s - gain.log_determinant).collect()
            })
        };
        search_density(self.of_density.len(), FINEST, series.len(), likelihoods)
    }

    fn smooth(
        &self,
        shared: &SharedSmoother,
        series: &[Samples<'_>],
        noise_sd: f64,
    ) -> Vec<Option<Vec<f64>>> {
        let mut by_density: BTreeMap<usize, Vec<usize>> = BTreeMap::new();
        for (s, (k, log_likelihood)) in
            self.most_likely(shared, series, noise_sd).into_iter().enumerate()
        {
            if log_likelihood.is_finite() {
                by_density.entry(k).or_default().push(s);
            }
        }
        let mut states = vec![None; series.len()];
        for (k, wanted) in by_density {
            self.with(shared, k, |gain| {
                for lanes in wanted.chunks(LANES) {
                    gain.smooth(shared, series, lanes, &mut states);
                }
            });
        }
        states
    }
}

#[cfg(test)]
mod tests;
