//! What was chosen, and what the data cannot tell.

use serde::{Deserialize, Serialize};

use super::choice::{BlockChoice, RowChoice};
use super::field::Field;
use crate::identified::IdentifiedModel;

/// A function is unknown at a point where its standard deviation is above this share of the prior's.
pub(super) const UNKNOWN: f64 = 0.5;
/// Warn where f or g is unknown in more than this share of the box of the data.
const MUCH: f64 = 0.25;
/// Points at which the box is probed.
const PROBES: usize = 400;

/// How a model was identified.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Report {
    /// Choice for each coordinate.
    pub rows: Vec<RowReport>,
    /// Length of the longest window with free initial values, seconds.
    pub window_seconds: f64,
    /// Windows at the end; more than at first where the model could not follow long ones.
    pub windows: usize,
    /// Measured values.
    pub samples: usize,
    /// Gauss-Newton steps along the model's own trajectories.
    pub iterations: usize,
    /// Noise standard deviations: coordinates, then their rates where measured.
    pub noise_sd: Vec<f64>,
    /// What the data cannot tell.
    pub warnings: Vec<Warning>,
}

/// Choice for one coordinate.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct RowReport {
    /// Of f_i, g_i1, ..., g_im.
    pub blocks: Vec<BlockReport>,
    /// Log marginal likelihood of the windows on which it was chosen, nats.
    pub log_evidence: f64,
}

/// Choice for one function.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct BlockReport {
    /// Kernel and prior amplitude.
    #[serde(flatten)]
    pub choice: BlockChoice,
    /// Noise variance over prior variance.
    pub lambda: f64,
    /// Landmarks of the sum.
    pub landmarks: usize,
    /// Root mean square of the function over the data.
    pub rms: f64,
    /// Of its standard deviation.
    pub sd: f64,
    /// Standard deviation over the prior's, over the data: 1 where the data say nothing.
    pub unknown: f64,
}

/// What the data cannot tell, with numbers.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(tag = "kind", rename_all = "snake_case")]
pub enum Warning {
    /// An input that does not move enough, or only together with others, to tell its effect on a coordinate.
    NotExcited {
        /// Input j, from 0.
        input: usize,
        /// Coordinate i, from 0.
        coordinate: usize,
        /// Standard deviation of g_ij over the prior's: 1 where the data say nothing.
        unknown: f64,
        /// Standard deviation of g_ij over its root mean square.
        relative_sd: f64,
    },
    /// A part of the box of the data where the prior speaks rather than the data.
    NoData {
        /// Coordinate i, from 0.
        coordinate: usize,
        /// 0 for f_i, j for g_ij.
        block: usize,
        /// Share of the box between the smallest and largest arguments seen.
        share: f64,
    },
}

/// What a report is made of, besides the model.
pub(super) struct Seen<'s> {
    pub field: &'s Field,
    /// Arguments of the data, rows of d, and fewer of them.
    pub candidates: &'s [f64],
    pub few_candidates: &'s [f64],
    pub window_seconds: f64,
    pub windows: usize,
    pub samples: usize,
    pub iterations: usize,
    /// As of [`Report`].
    pub noise_sd: Vec<f64>,
    /// Noise of what the equations of each coordinate are made of.
    pub equations_sd: &'s [f64],
}

impl Report {
    pub(super) fn of(seen: &Seen<'_>, rows: &[RowChoice], model: &IdentifiedModel) -> Self {
        let probe = Probe::along(model, seen.few_candidates);
        let boxed = Probe::along(model, &box_points(seen.candidates, model.arguments()));
        let mut warnings = Vec::new();
        let mut reports = Vec::new();
        for (i, row) in rows.iter().enumerate() {
            let mut blocks = Vec::new();
            for (b, choice) in row.blocks.iter().enumerate() {
                let [rms, sd, unknown] = probe.summary(i, b);
                warnings.extend(warning(i, b, [rms, sd, unknown], boxed.share_unknown(i, b)));
                let term = seen.field.terms.iter().find(|t| (t.row, t.block) == (i, b));
                let mut choice = choice.clone();
                choice.amplitude = term.map_or(choice.amplitude, |t| t.amplitude);
                blocks.push(BlockReport {
                    lambda: (seen.equations_sd[i] / choice.amplitude).powi(2),
                    choice,
                    landmarks: term.map_or(0, |t| t.basis.rank()),
                    rms,
                    sd,
                    unknown,
                });
            }
            reports.push(RowReport { blocks, log_evidence: row.log_evidence });
        }
        Self {
            rows: reports,
            window_seconds: seen.window_seconds,
            windows: seen.windows,
            samples: seen.samples,
            iterations: seen.iterations,
            noise_sd: seen.noise_sd.clone(),
            warnings,
        }
    }
}

fn warning(i: usize, b: usize, [rms, sd, unknown]: [f64; 3], share: f64) -> Option<Warning> {
    if b > 0 && unknown > UNKNOWN {
        let relative_sd = sd / rms.max(f64::MIN_POSITIVE);
        return Some(Warning::NotExcited { input: b - 1, coordinate: i, unknown, relative_sd });
    }
    (share > MUCH).then_some(Warning::NoData { coordinate: i, block: b, share })
}

/// f, g and their standard deviations at some points: entries (value, sd, prior sd) by point, row and block.
struct Probe {
    entries: Vec<[f64; 3]>,
    rows: usize,
    blocks: usize,
}

impl Probe {
    fn along(model: &IdentifiedModel, points: &[f64]) -> Self {
        let (n, m, d) = (model.dimension(), model.inputs(), model.arguments());
        let mut entries = Vec::new();
        let (mut f, mut g) = (vec![0.0; n], vec![0.0; n * m]);
        for x in points.chunks_exact(d) {
            let Ok(Some(sd)) = model.standard_deviations(x) else { continue };
            if model.evaluate(x, &mut f, &mut g).is_err() {
                continue;
            }
            let drift = |i: usize| [f[i], sd.f[i], sd.f_prior[i]];
            let effectiveness = |at: usize| [g[at], sd.g[at], sd.g_prior[at]];
            let of_row =
                |i: usize| std::iter::once(drift(i)).chain((i * m..(i + 1) * m).map(effectiveness));
            entries.extend((0..n).flat_map(of_row));
        }
        Self { entries, rows: n, blocks: m + 1 }
    }

    fn of(&self, i: usize, b: usize) -> impl Iterator<Item = &[f64; 3]> {
        self.entries.iter().skip(i * self.blocks + b).step_by(self.rows * self.blocks)
    }

    /// Root mean squares of value and sd, and of sd over the prior's.
    fn summary(&self, i: usize, b: usize) -> [f64; 3] {
        let count = self.of(i, b).count().max(1) as f64;
        let rms = |of: &dyn Fn(&[f64; 3]) -> f64| {
            (self.of(i, b).map(|e| of(e).powi(2)).sum::<f64>() / count).sqrt()
        };
        [rms(&|e| e[0]), rms(&|e| e[1]), rms(&|e| e[1]) / rms(&|e| e[2]).max(f64::MIN_POSITIVE)]
    }

    fn share_unknown(&self, i: usize, b: usize) -> f64 {
        let unknown = self.of(i, b).filter(|e| e[1] > UNKNOWN * e[2]).count();
        unknown as f64 / self.of(i, b).count().max(1) as f64
    }
}

/// Points of the box that the data span, by an additive recurrence (R. Roberts' generalised golden ratio).
fn box_points(rows: &[f64], d: usize) -> Vec<f64> {
    let range = |i: usize| {
        let all = rows.iter().skip(i).step_by(d);
        all.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), &v| (a.min(v), b.max(v)))
    };
    let ranges: Vec<(f64, f64)> = (0..d).map(range).collect();
    let ratio = (0..40).fold(2.0f64, |r, _| (1.0 + r).powf(1.0 / (d as f64 + 1.0)));
    let share = |k: usize, i: usize| (0.5 + k as f64 * ratio.powi(-(i as i32) - 1)).fract();
    (0..PROBES)
        .flat_map(|k| (0..d).map(move |i| (k, i)))
        .map(|(k, i)| ranges[i].0 + share(k, i) * (ranges[i].1 - ranges[i].0))
        .collect()
}
