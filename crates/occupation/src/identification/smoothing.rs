//! Kernel arguments behind noisy samples (errors in variables): the coordinates smoothed, and their rates.
//!
//! The noise is first estimated from high differences, which on coarse sampling see the motion too; it is then lowered
//! as long as the smoother's likelihood rises.

use std::borrow::Borrow;
use std::collections::HashMap;

use lacuna_recordings::{
    MeanPath, Prior, Samples, SharedSmoother, SignalError, estimate_noise_pooled,
};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

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
#[derive(Debug, Clone, Copy, Serialize, Deserialize)]
pub(super) struct Channel {
    pub noise_sd: f64,
    #[serde(with = "SavedPrior")]
    prior: Prior,
}

/// As it is saved.
#[derive(Serialize, Deserialize)]
#[serde(remote = "Prior")]
enum SavedPrior {
    WhiteJerk,
    WhiteSnap,
}

/// Motions' coordinates smoothed at their samples, and their rates and second derivatives: N x n each.
#[derive(Debug, Clone)]
pub(super) struct Smooth {
    pub values: Vec<f64>,
    pub rates: Vec<f64>,
    /// Second derivatives, for first guesses.
    pub seconds: Vec<f64>,
}

impl Smooth {
    /// All coordinates of all motions.
    pub fn all(
        motions: &[Motion],
        channels: &[Channel],
        rate_noise: &[Option<f64>],
    ) -> Result<Vec<Self>, IdentificationError> {
        let n = channels.len();
        let zeros = |motion: &Motion| {
            let zeros = vec![0.0; motion.samples() * n];
            Self { values: zeros.clone(), rates: zeros.clone(), seconds: zeros }
        };
        let mut all: Vec<Self> = motions.iter().map(zeros).collect();
        for i in 0..n {
            let paths = smooth(motions, i, channels[i], rate_noise[i]);
            for (smooth, path) in all.iter_mut().zip(paths) {
                let path =
                    path.map_err(|source| IdentificationError::Signal { coordinate: i, source })?;
                let rows = [&mut smooth.values, &mut smooth.rates, &mut smooth.seconds];
                for (derivative, rows) in rows.into_iter().enumerate() {
                    let column = rows.iter_mut().skip(i).step_by(n);
                    column.zip(path.at_samples(derivative)).for_each(|(to, value)| *to = value);
                }
            }
        }
        Ok(all)
    }

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
    let judged: Vec<Series> =
        judged.into_iter().map(|(times, values)| Series { times, values, rates: &[] }).collect();
    let mut best = (f64::NEG_INFINITY, Channel { noise_sd: estimated, prior: Prior::WhiteJerk });
    for prior in [Prior::WhiteJerk, Prior::WhiteSnap] {
        let mut noise_sd = estimated;
        let mut before = f64::NEG_INFINITY;
        let groups = groups(prior, &judged, 0.0);
        while noise_sd >= LOWEST * estimated {
            let found = likelihood(&groups, &judged, noise_sd);
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

/// What was measured of one coordinate of a motion.
struct Series<'m> {
    times: &'m [f64],
    values: &'m [f64],
    rates: &'m [f64],
}

impl Series<'_> {
    fn samples(&self) -> Samples<'_> {
        Samples { values: self.values, rates: self.rates }
    }

    /// The same for series with the same times from their first, and the same samples missing.
    fn pattern(&self) -> Vec<[u64; 2]> {
        const PARTS: f64 = 1e6;
        let step = (self.times[self.times.len() - 1] - self.times[0]) / self.times.len() as f64;
        let seen = |values: &[f64], k: usize| u64::from(values.get(k).is_some_and(|v| !v.is_nan()));
        let place = |t: &f64| (PARTS * (t - self.times[0]) / step).round() as u64;
        let times = self.times.iter().enumerate();
        times.map(|(k, t)| [place(t), seen(self.values, k) + 2 * seen(self.rates, k)]).collect()
    }
}

/// Series that one smoother smooths, by their indices.
struct Group {
    smoother: Result<SharedSmoother, SignalError>,
    members: Vec<usize>,
}

/// Series with a smoother for those with the same times; `rate_scale` is the noise of values over that of rates.
fn groups(prior: Prior, series: &[Series<'_>], rate_scale: f64) -> Vec<Group> {
    let mut place: HashMap<Vec<[u64; 2]>, usize> = HashMap::new();
    let mut groups: Vec<Group> = Vec::new();
    for (s, one) in series.iter().enumerate() {
        let at = *place.entry(one.pattern()).or_insert(groups.len());
        if at == groups.len() {
            let smoother = SharedSmoother::new(prior, one.times, one.samples(), rate_scale);
            groups.push(Group { smoother, members: Vec::new() });
        }
        groups[at].members.push(s);
    }
    groups
}

/// Series that one thread smooths at a time.
const TOGETHER: usize = 64;

/// Groups cut for threads.
fn parts(groups: &[Group]) -> Vec<(&Result<SharedSmoother, SignalError>, &[usize])> {
    let mut parts = Vec::new();
    for group in groups {
        parts.extend(group.members.chunks(TOGETHER).map(|members| (&group.smoother, members)));
    }
    parts
}

/// Log likelihood of all series.
fn likelihood(groups: &[Group], series: &[Series<'_>], noise_sd: f64) -> f64 {
    let of = |(smoother, members): &(&Result<SharedSmoother, _>, &[usize])| -> f64 {
        let samples: Vec<Samples> = members.iter().map(|&s| series[s].samples()).collect();
        let found = smoother.as_ref().ok().and_then(|s| s.log_likelihoods(&samples, noise_sd).ok());
        found.map_or(f64::NEG_INFINITY, |found| found.iter().sum())
    };
    parts(groups).par_iter().map(of).collect::<Vec<f64>>().iter().sum()
}

/// Coordinate i of motions smoothed, with the measured rates where their noise is given; each for itself.
pub(super) fn smooth<M: Borrow<Motion> + Sync>(
    motions: &[M],
    i: usize,
    channel: Channel,
    rate_noise: Option<f64>,
) -> Vec<Result<MeanPath, SignalError>> {
    let columns: Vec<[Vec<f64>; 2]> = motions
        .iter()
        .map(Borrow::borrow)
        .map(|motion: &Motion| {
            let n = motion.dimension();
            let rates = motion.rates().filter(|_| rate_noise.is_some());
            [column(motion.coordinates(), n, i), rates.map_or(Vec::new(), |r| column(r, n, i))]
        })
        .collect();
    let series: Vec<Series> = motions
        .iter()
        .zip(&columns)
        .map(|(motion, [values, rates])| Series { times: motion.borrow().times(), values, rates })
        .collect();
    let scale = rate_noise.map_or(0.0, |sd| channel.noise_sd / sd);
    let groups = groups(channel.prior, &series, scale);
    let of = |(smoother, members): &(&Result<SharedSmoother, SignalError>, &[usize])| {
        let samples: Vec<_> =
            members.iter().map(|&s| (series[s].times, series[s].samples())).collect();
        let smoother = smoother.as_ref().map_err(Clone::clone);
        let found = smoother.and_then(|smoother| smoother.smooth(&samples, channel.noise_sd));
        found.unwrap_or_else(|error| vec![Err(error); members.len()])
    };
    let mut paths: Vec<Result<MeanPath, SignalError>> = Vec::new();
    paths.resize_with(series.len(), || Err(SignalError::OutOfRange));
    let parts = parts(&groups);
    let found: Vec<_> = parts.par_iter().map(of).collect();
    for ((_, members), found) in parts.iter().zip(found) {
        members.iter().zip(found).for_each(|(&s, path)| paths[s] = path);
    }
    paths
}
