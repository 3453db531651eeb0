//! Kernel arguments behind noisy samples (errors in variables): the coordinates smoothed, and their rates.
//!
//! The noise is first estimated from high differences, which on coarse sampling see the motion too; it is then lowered
//! as long as the smoother's likelihood rises.

use std::borrow::Borrow;

use lacuna_recordings::{Prior, SignalError, Smoothed, Smoother, estimate_noise_pooled};
use rayon::prelude::*;

use super::IdentificationError;
use super::motion::Motion;

/// Motions on which the noise is judged.
const JUDGED: usize = 16;
/// Values that a likelihood needs.
const FEWEST: usize = 6;
/// Noise is lowered by this factor at a time.
const FACTOR: f64 = 0.2;
/// Lowest noise tried, relative to the estimate from differences.
const LOWEST: f64 = 1e-4;
/// Noise is never taken for less than this share of the largest value: simulations have rounding errors too.
const ROUNDING: f64 = 1e-8;

/// What is known of one channel before anything is identified.
#[derive(Debug, Clone, Copy)]
pub(super) struct Channel {
    pub noise_sd: f64,
    prior: Prior,
}

/// A motion's coordinates smoothed at its samples, and their rates: N x n each.
#[derive(Debug, Clone)]
pub(super) struct Smooth {
    pub values: Vec<f64>,
    pub rates: Vec<f64>,
    /// Second derivatives, for first guesses.
    pub seconds: Vec<f64>,
}

impl Smooth {
    /// y^(s-1) and y^(s) for order s.
    pub fn derivatives(&self, order: usize) -> [&[f64]; 2] {
        if order == 1 { [&self.values, &self.rates] } else { [&self.rates, &self.seconds] }
    }
}

/// Column i of `values` (N x n).
pub(super) fn column(values: &[f64], n: usize, i: usize) -> Vec<f64> {
    values.iter().skip(i).step_by(n).copied().collect()
}

/// Noise of coordinate i of all motions.
pub(super) fn judge<M: Borrow<Motion>>(
    motions: &[M],
    i: usize,
) -> Result<Channel, IdentificationError> {
    let series: Vec<(&[f64], Vec<f64>)> = motions
        .iter()
        .map(Borrow::borrow)
        .map(|motion: &Motion| {
            (motion.times(), column(motion.coordinates(), motion.dimension(), i))
        })
        .collect();
    let estimated = noise_of(&series, i)?;
    let seen = |values: &[f64]| values.iter().filter(|y| y.is_finite()).count();
    let long: Vec<_> = series.iter().filter(|(_, y)| seen(y) >= FEWEST).collect();
    let every = long.len().div_ceil(JUDGED).max(1);
    let judged: Vec<&(&[f64], Vec<f64>)> = long.into_iter().step_by(every).collect();
    let likelihood = |prior: Prior, sd: f64| -> f64 {
        let one = |(times, values): &&(&[f64], Vec<f64>)| {
            Smoother::new(prior)
                .smooth(times, values, sd)
                .map_or(f64::NEG_INFINITY, |s| s.log_likelihood())
        };
        judged.par_iter().map(one).collect::<Vec<_>>().iter().sum()
    };
    let mut best = (f64::NEG_INFINITY, Channel { noise_sd: estimated, prior: Prior::WhiteJerk });
    for prior in [Prior::WhiteJerk, Prior::WhiteSnap] {
        let mut noise_sd = estimated;
        let mut before = f64::NEG_INFINITY;
        while noise_sd >= LOWEST * estimated {
            let found = likelihood(prior, noise_sd);
            if found > best.0 {
                best = (found, Channel { noise_sd, prior });
            }
            if found <= before {
                break;
            }
            before = found;
            noise_sd *= FACTOR;
        }
    }
    Ok(best.1)
}

/// Noise of the rates of coordinate i, where measured.
pub(super) fn judge_rates(
    motions: &[Motion],
    i: usize,
) -> Result<Option<f64>, IdentificationError> {
    let series: Vec<(&[f64], Vec<f64>)> = motions
        .iter()
        .filter_map(|m| Some((m.times(), column(m.rates()?, m.dimension(), i))))
        .collect();
    let measured = series.iter().any(|(_, rates)| rates.iter().any(|v| v.is_finite()));
    if !measured { Ok(None) } else { noise_of(&series, i).map(Some) }
}

fn noise_of(series: &[(&[f64], Vec<f64>)], i: usize) -> Result<f64, IdentificationError> {
    let pairs: Vec<(&[f64], &[f64])> = series.iter().map(|(t, y)| (*t, y.as_slice())).collect();
    let found = estimate_noise_pooled(&pairs)
        .map_err(|source| IdentificationError::Signal { coordinate: i, source })?;
    let values = pairs.iter().flat_map(|(_, y)| *y).filter(|y| y.is_finite());
    let largest = values.fold(0.0f64, |m, y| m.max(y.abs()));
    if largest == 0.0 {
        return Err(IdentificationError::Still { coordinate: i });
    }
    Ok(found.sd.max(ROUNDING * largest))
}

/// Smooths a motion.
pub(super) fn smooth(
    motion: &Motion,
    channels: &[Channel],
    rate_noise: &[Option<f64>],
) -> Result<Smooth, IdentificationError> {
    let (n, samples) = (motion.dimension(), motion.samples());
    let mut smooth = Smooth {
        values: vec![0.0; samples * n],
        rates: vec![0.0; samples * n],
        seconds: vec![0.0; samples * n],
    };
    for (i, channel) in channels.iter().enumerate() {
        let values = column(motion.coordinates(), n, i);
        let rates = motion.rates().map(|r| column(r, n, i));
        let path = smooth_one(motion.times(), &values, rates.as_deref(), rate_noise[i], *channel)
            .map_err(|source| IdentificationError::Signal { coordinate: i, source })?
            .at(motion.times());
        for k in 0..samples {
            smooth.values[k * n + i] = path.value[k];
            smooth.rates[k * n + i] = path.first[k];
            smooth.seconds[k * n + i] = path.second[k];
        }
    }
    Ok(smooth)
}

/// Coordinate i smoothed; none where it cannot be.
pub(super) fn one(motion: &Motion, i: usize, channel: Channel) -> Option<Smoothed> {
    let values = column(motion.coordinates(), motion.dimension(), i);
    smooth_one(motion.times(), &values, None, None, channel).ok()
}

fn smooth_one(
    times: &[f64],
    values: &[f64],
    rates: Option<&[f64]>,
    rate_noise: Option<f64>,
    channel: Channel,
) -> Result<Smoothed, SignalError> {
    let mut smoother = Smoother::new(channel.prior);
    if let (Some(rates), Some(sd)) = (rates, rate_noise) {
        smoother = smoother.with_derivative(rates, sd);
    }
    smoother.smooth(times, values, channel.noise_sd)
}
