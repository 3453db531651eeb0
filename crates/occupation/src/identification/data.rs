//! What all steps of an identification look at.

use rayon::prelude::*;

use super::basis::Basis;
use super::family::{Family, ScaledKernel};
use super::field::Field;
use super::flow::{Flow, Setting};
use super::motion::Motion;
use super::smoothing::{self, Channel, Smooth, column};
use super::weak::{WeakRow, WeakWindow};
use super::{Identification, IdentificationError};
use crate::sample::sample;

/// Landmark candidates while choosing, and for the model.
const FEW_CANDIDATES: usize = 160;
const CANDIDATES: usize = 3000;
/// ... but not more than this times the square of the number of arguments: few points cover a line.
const CANDIDATES_ON_A_LINE: usize = 600;
/// Windows last as many typical times (spread of a coordinate's rate over that of its acceleration) ...
const TYPICAL_TIMES: f64 = 2.0 * std::f64::consts::PI;
/// ... and hold at least so many samples.
const SHORTEST_WINDOW: usize = 24;

/// The motions, smoothed and cut into windows.
pub(crate) struct Data {
    pub dimension: usize,
    pub inputs: usize,
    pub order: usize,
    pub channels: Vec<Channel>,
    pub rate_noise: Vec<Option<f64>>,
    pub windows: Vec<WeakWindow>,
    pub initial_states: Vec<Vec<f64>>,
    pub window_seconds: f64,
    /// Mean and standard deviation of each argument.
    pub centre: Vec<f64>,
    pub spread: Vec<f64>,
    pub candidates: Vec<f64>,
    pub few_candidates: Vec<f64>,
    /// Root mean square of each coordinate's highest derivative, and of each input.
    pub highest: Vec<f64>,
    pub input_rms: Vec<f64>,
    pub middle: Vec<f64>,
    pub half_range: Vec<f64>,
}

impl Data {
    pub fn of(settings: &Identification, motions: &[Motion]) -> Result<Self, IdentificationError> {
        let (n, m) = (motions[0].dimension(), motions[0].input_count());
        let channels =
            (0..n).map(|i| smoothing::judge(motions, i)).collect::<Result<Vec<_>, _>>()?;
        let rate_noise =
            (0..n).map(|i| smoothing::judge_rates(motions, i)).collect::<Result<Vec<_>, _>>()?;
        let smooth = Smooth::all(motions, &channels, &rate_noise)?;
        let states: Vec<Vec<f64>> =
            smooth.iter().map(|s| states_of(s, settings.order, n)).collect();
        let count = n * settings.order;
        let (centre_all, spread_all) = moments(&states, count);
        let (middle, half_range) = ranges(&states, count);
        let d = settings.argument_count(n);
        if let Some(i) = is_still(&centre_all[..d], &spread_all[..d]) {
            return Err(IdentificationError::Still { coordinate: i % n });
        }
        let highest_rms = rms(smooth.iter().map(|s| s.derivatives(settings.order)[1].to_vec()), n);
        let input_rms = rms(motions.iter().map(|motion| motion.inputs().to_vec()), m);
        let wanted = settings.window.unwrap_or_else(|| typical_window(&smooth, settings.order, n));
        let (mut windows, mut initial_states) = (Vec::new(), Vec::new());
        for ((motion, states), smooth) in motions.iter().zip(&states).zip(&smooth) {
            let [below, highest] = smooth.derivatives(settings.order);
            for (first, samples) in cut(motion.times(), wanted) {
                let rows = states[first * count..(first + samples) * count].chunks_exact(count);
                initial_states.push(states[first * count..(first + 1) * count].to_vec());
                let arguments = rows.flat_map(|z| &z[..d]).copied().collect();
                let part = motion.part(first, samples);
                let rows = first * n..(first + samples) * n;
                let derivatives = [&below[rows.clone()], &highest[rows]];
                let (order, path) = (settings.order, settings.input_path);
                windows.push(WeakWindow::sampled(
                    part.into(),
                    arguments,
                    order,
                    path,
                    derivatives,
                    &highest_rms,
                ));
            }
        }
        let all: Vec<f64> = windows.iter().flat_map(|w| &w.arguments).copied().collect();
        let candidates = thin(&all, d);
        let spread = spread_all[..d].to_vec();
        let narrow = ScaledKernel {
            family: Family::Gaussian,
            centre: vec![0.0; d],
            widths: spread.iter().map(|s| 0.35 * s).collect(),
        };
        let few_candidates = Basis::choose(narrow, &candidates, 1e-10, FEW_CANDIDATES).landmarks;
        Ok(Self {
            dimension: n,
            inputs: m,
            order: settings.order,
            channels,
            rate_noise,
            window_seconds: windows.iter().map(duration).fold(0.0, f64::max),
            windows,
            initial_states,
            centre: centre_all[..d].to_vec(),
            spread,
            candidates,
            few_candidates,
            highest: highest_rms,
            input_rms,
            middle,
            half_range,
        })
    }

    /// Noise of coordinate i over that of its rate.
    fn rate_weight(&self, i: usize) -> Option<f64> {
        let sd = self.rate_noise[i].filter(|_| self.order > 1)?;
        Some(self.channels[i].noise_sd / sd)
    }

    /// Windows with about so many equations of each coordinate.
    pub fn some_windows(&self, equations: usize) -> Vec<usize> {
        let all: usize = self.windows.iter().map(|w| w.motion.samples()).sum();
        sample(self.windows.len(), (equations * self.windows.len() / all).max(1)).collect()
    }

    /// Something for every coordinate, in parallel; the first error.
    pub fn each_row<C: Send>(
        &self,
        of: impl Fn(usize) -> Result<C, IdentificationError> + Sync + Send,
    ) -> Result<Vec<C>, IdentificationError> {
        let all: Vec<_> = (0..self.dimension).into_par_iter().map(of).collect();
        all.into_iter().collect()
    }

    /// The equations of coordinate i in some windows.
    pub fn row<'w>(&self, windows: &'w [WeakWindow], i: usize) -> WeakRow<'w> {
        WeakRow::new(windows, i, self.channels[i].noise_sd, self.rate_weight(i))
    }

    /// First guesses of the prior amplitudes.
    pub fn amplitudes(&self, i: usize) -> Vec<f64> {
        let highest = self.highest[i].max(f64::MIN_POSITIVE);
        let of_input = |rms: &f64| if *rms > 0.0 { 0.3 * highest / rms } else { highest };
        std::iter::once(highest).chain(self.input_rms.iter().map(of_input)).collect()
    }

    pub fn setting(&self, settings: &Identification) -> Setting {
        Setting {
            order: self.order,
            path: settings.input_path,
            middle: self.middle.clone(),
            half_range: self.half_range.clone(),
        }
    }

    /// The fastest rate of the field in the data, for inputs of either sign.
    pub fn stiffness(&self, field: &Field) -> f64 {
        let d = self.centre.len();
        let mut flow = Flow::new(field);
        let mut stiffest = 0.0f64;
        for sign in [-1.0, 0.0, 1.0] {
            let u: Vec<f64> = self.input_rms.iter().map(|rms| sign * rms).collect();
            for x in self.few_candidates.chunks_exact(d) {
                let mut z = self.middle.clone();
                z[..d].copy_from_slice(x);
                stiffest = stiffest.max(flow.stiffness(&z, &u));
            }
        }
        stiffest
    }
}

fn duration(window: &WeakWindow) -> f64 {
    let times = window.motion.times();
    times[times.len() - 1] - times[0]
}

/// The first argument that is constant but for rounding.
fn is_still(centre: &[f64], spread: &[f64]) -> Option<usize> {
    let moves = |(c, s): (&f64, &f64)| *s > 1e-12 * c.abs();
    let mut arguments = centre.iter().zip(spread);
    arguments.position(|pair| !moves(pair))
}

/// States z, N x (s n).
pub(super) fn states_of(smooth: &Smooth, order: usize, n: usize) -> Vec<f64> {
    if order == 1 {
        return smooth.values.clone();
    }
    let pairs = smooth.values.chunks_exact(n).zip(smooth.rates.chunks_exact(n));
    pairs.flat_map(|(y, v)| y.iter().chain(v).copied()).collect()
}

fn moments(rows: &[Vec<f64>], columns: usize) -> (Vec<f64>, Vec<f64>) {
    let count = rows.iter().map(Vec::len).sum::<usize>() as f64 / columns as f64;
    let all = |i: usize| rows.iter().flat_map(move |r| r.iter().skip(i).step_by(columns));
    let mean = |i: usize| all(i).sum::<f64>() / count;
    let means: Vec<f64> = (0..columns).map(mean).collect();
    let sd = |i: usize| (all(i).map(|v| (v - means[i]).powi(2)).sum::<f64>() / count).sqrt();
    let sds = (0..columns).map(sd).collect();
    (means, sds)
}

fn ranges(rows: &[Vec<f64>], columns: usize) -> (Vec<f64>, Vec<f64>) {
    let range = |i: usize| {
        let all = rows.iter().flat_map(|r| column(r, columns, i));
        all.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), v| (a.min(v), b.max(v)))
    };
    (0..columns)
        .map(range)
        .map(|(a, b)| (0.5 * (a + b), (0.5 * (b - a)).max(f64::MIN_POSITIVE)))
        .unzip()
}

fn rms(rows: impl Iterator<Item = Vec<f64>>, columns: usize) -> Vec<f64> {
    let mut squares = vec![0.0; columns];
    let mut count = 0;
    for row in rows {
        count += row.len() / columns.max(1);
        for (k, v) in row.iter().enumerate() {
            squares[k % columns] += v * v;
        }
    }
    squares.iter().map(|s| (s / count.max(1) as f64).sqrt()).collect()
}

/// Several times the fastest coordinate's typical time.
fn typical_window(smooth: &[Smooth], order: usize, n: usize) -> f64 {
    let of = |p: usize| smooth.iter().map(|s| s.derivatives(order)[p].to_vec()).collect::<Vec<_>>();
    let (below, highest) = (of(0), of(1));
    let (_, spread) = moments(&below, n);
    let speed = rms(highest.into_iter(), n);
    let times = spread.iter().zip(&speed).map(|(s, v)| s / v).filter(|t| t.is_finite());
    TYPICAL_TIMES * times.fold(f64::INFINITY, f64::min)
}

/// First sample and number of samples of each window; neighbours share one sample.
fn cut(times: &[f64], seconds: f64) -> Vec<(usize, usize)> {
    let samples = times.len();
    let step = (times[samples - 1] - times[0]) / (samples - 1) as f64;
    let wanted = ((seconds / step).round().clamp(1.0, 1e9) as usize).max(SHORTEST_WINDOW - 1);
    let count = ((samples - 1) / wanted).max(1);
    let edge = |w: usize| w * (samples - 1) / count;
    (0..count).map(|w| (edge(w), edge(w + 1) - edge(w) + 1)).collect()
}

/// Landmark candidates among rows of d arguments.
pub(super) fn thin(rows: &[f64], d: usize) -> Vec<f64> {
    let kept = sample(rows.len() / d, CANDIDATES.min(CANDIDATES_ON_A_LINE * d * d));
    kept.flat_map(|k| &rows[k * d..(k + 1) * d]).copied().collect()
}
