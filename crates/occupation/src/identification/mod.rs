//! Identification in one call: drift and control effectiveness from noisy samples, with everything chosen by the data.
//!
//! ```text
//! y^(s) = f(x) + g(x) u,   x = y or (y, y', ..., y^(s-1)),   samples y_k + noise
//! ```
//!
//! | step | module | what |
//! | --- | --- | --- |
//! | kernel arguments from noisy samples | `smoothing` | Kalman smoother, noise by likelihood |
//! | weak form without initial derivatives | `weak` | whole windows, free initial values, independent errors |
//! | kernel family, widths, lambda, noise | [`choice`] | marginal likelihood in closed form |
//! | few features instead of every sample | `basis` | pivoted Cholesky (Nystrom) |
//! | errors in variables, motion between samples | `flow`, `refine` | the weak form along the model's own trajectories |
//! | standard deviations of f and g | [`crate::Uncertainty`] | posterior of the last linearisation |
//! | what the data cannot tell | [`report`] | inputs that do not excite, regions without data |

mod basis;
pub mod choice;
mod evidence;
mod family;
mod field;
mod flow;
mod inputs;
mod motion;
mod optimise;
mod refine;
pub mod report;
mod smoothing;
mod weak;

use lacuna_recordings::SignalError;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

pub(crate) use basis::Basis;
pub use choice::{BlockChoice, RowChoice};
pub use family::{Family, ScaledKernel};
pub use motion::{InputPath, Motion};
pub use report::{Report, Warning};

use crate::identified::{Expansion, IdentifiedModel, RowPosterior, TermOf, Uncertainty};
use choice::{Start, choose};
use evidence::Normal;
use field::{Field, Term};
use flow::{Integrator, Setting, Shot};
use refine::{OutputNoise, Refined, Refinement};
use smoothing::{Channel, Smooth, column};
use weak::{WeakRow, WeakWindow};

/// Equations on which kernels are chosen: more tell little more.
const CHOOSING_EQUATIONS: usize = 2100;
/// Landmark candidates while choosing, and for the model.
const FEW_CANDIDATES: usize = 160;
const CANDIDATES: usize = 3000;
/// Landmarks may leave this share of the posterior standard deviation.
const LANDMARK_SHARE: f64 = 0.01;
/// Most landmarks of a control effectiveness: it is simpler than the drift (in mechanics it does not depend on velocities).
const EFFECTIVENESS_LANDMARKS: usize = 80;
/// Windows last as many typical times (spread of a coordinate's rate over that of its acceleration) ...
const TYPICAL_TIMES: f64 = 2.0 * std::f64::consts::PI;
/// ... and hold at least so many samples.
const SHORTEST_WINDOW: usize = 24;

/// What f and g depend on.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Arguments {
    /// The coordinates y alone.
    Coordinates,
    /// The state y, y', ..., y^(s-1).
    State,
}

/// What to identify; what is `None` or has several entries is chosen by the data.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Identification {
    /// Order s of the dynamics, 1 or 2.
    pub order: usize,
    /// What f and g depend on.
    pub arguments: Arguments,
    /// What inputs do between samples.
    pub input_path: InputPath,
    /// Kernel families to choose from.
    pub families: Vec<Family>,
    /// Kernel widths, one per argument.
    pub widths: Option<Vec<f64>>,
    /// lambda: noise variance over prior variance.
    pub lambda: Option<f64>,
    /// Length of the windows with free initial values, seconds.
    pub window: Option<f64>,
    /// Most landmarks of a function.
    pub most_landmarks: usize,
}

impl Identification {
    /// Everything chosen by the data.
    pub fn new(order: usize, arguments: Arguments, input_path: InputPath) -> Self {
        Self {
            order,
            arguments,
            input_path,
            families: Family::ALL.to_vec(),
            widths: None,
            lambda: None,
            window: None,
            most_landmarks: 400,
        }
    }

    /// Identifies f and g from motions, all with the same coordinates and inputs.
    ///
    /// The result does not depend on the number of threads.
    ///
    /// # Errors
    /// No motion, motions of different shape, settings out of range, channels that never change, and data from which
    /// no model can be made that stays near them.
    pub fn identify(&self, motions: &[Motion]) -> Result<Identified, IdentificationError> {
        self.validate(motions)?;
        let data = Data::of(self, motions)?;
        let rows = data.each_row(|i| self.choose(&data, i))?;
        let mut field = self.field(&data, &rows);
        for (i, row) in rows.iter().enumerate() {
            fit_row(&data, i, row, &mut field)?;
        }
        let refined = self.refine(&data, field)?;
        Ok(self.finish(&data, &rows, &refined))
    }

    fn validate(&self, motions: &[Motion]) -> Result<(), IdentificationError> {
        let first = motions.first().ok_or(IdentificationError::NoMotion)?;
        if !(1..=2).contains(&self.order) {
            return Err(IdentificationError::Order { found: self.order });
        }
        if self.families.is_empty() || self.most_landmarks == 0 {
            return Err(IdentificationError::NothingToChoose);
        }
        let shape = |m: &Motion| (m.dimension(), m.input_count(), m.rates().is_some());
        if let Some(index) = motions.iter().position(|m| shape(m) != shape(first)) {
            return Err(IdentificationError::Shape { motion: index });
        }
        let positive =
            |what, values: &[f64]| match values.iter().find(|v| !(**v > 0.0 && v.is_finite())) {
                Some(&found) => Err(IdentificationError::NotPositive { what, found }),
                None => Ok(()),
            };
        positive("lambda", self.lambda.as_slice())?;
        positive("window", self.window.as_slice())?;
        if let Some(widths) = &self.widths {
            positive("width", widths)?;
            let expected = self.argument_count(first.dimension());
            if widths.len() != expected {
                return Err(IdentificationError::Length {
                    what: "widths",
                    expected,
                    found: widths.len(),
                });
            }
        }
        Ok(())
    }

    fn argument_count(&self, n: usize) -> usize {
        match self.arguments {
            Arguments::Coordinates => n,
            Arguments::State => n * self.order,
        }
    }

    fn choose(&self, data: &Data, i: usize) -> Result<RowChoice, IdentificationError> {
        let start = Start {
            centre: &data.centre,
            spread: &data.spread,
            candidates: &data.few_candidates,
            amplitudes: data.amplitudes(i),
            noise_sd: data.channels[i].noise_sd,
            families: &self.families,
            widths: self.widths.as_deref(),
            lambda: self.lambda,
        };
        choose(&data.weak_row(i), &start)
    }

    fn field(&self, data: &Data, rows: &[RowChoice]) -> Field {
        let most = self.most_landmarks;
        let term = |i: usize, b: usize, block: &BlockChoice| {
            let share = LANDMARK_SHARE * block.posterior_sd / block.amplitude;
            let basis = Basis::choose(
                block.kernel.clone(),
                &data.candidates,
                share * share,
                if b == 0 { most } else { most.min(EFFECTIVENESS_LANDMARKS) },
            );
            Term::new(i, b, basis, block.amplitude)
        };
        let of_row = |(i, row): (usize, &RowChoice)| {
            row.blocks.iter().enumerate().map(|(b, block)| term(i, b, block)).collect::<Vec<_>>()
        };
        let terms = rows.iter().enumerate().flat_map(of_row).collect();
        Field { dimension: data.dimension, arguments: data.centre.len(), terms }
    }

    fn refine(&self, data: &Data, field: Field) -> Result<Refined, IdentificationError> {
        let setting = data.setting(self);
        let mut noise: Vec<f64> = data.channels.iter().map(|c| c.noise_sd).collect();
        if self.order > 1 && data.rate_noise.iter().all(Option::is_some) {
            noise.extend(data.rate_noise.iter().flatten());
        }
        let steps = data.steps(&field, &setting);
        let shot = |(window, state): (&WeakWindow, &Vec<f64>)| Shot {
            motion: window.motion.clone(),
            initial: state.clone(),
            steps,
        };
        let shots = data.windows.iter().zip(&data.initial_states).map(shot).collect();
        Refinement { field, setting, shots, noise: OutputNoise(noise) }.run()
    }

    fn finish(&self, data: &Data, rows: &[RowChoice], refined: &Refined) -> Identified {
        let field = &refined.field;
        let expansion = |t: &Term| {
            let (kernel, weights) = (&t.basis.kernel, t.weights.clone());
            Expansion::of_landmarks(kernel, &t.basis.landmarks, weights, (t.row, t.block))
        };
        let expansions = field.terms.iter().map(expansion).collect();
        let covariance = refined.posterior.factor.inverse();
        let mut first = 0;
        let posteriors = (0..data.dimension).map(|i| {
            let terms = field.terms.iter().filter(|t| t.row == i);
            let terms: Vec<TermOf> = terms
                .map(|t| TermOf { block: t.block, amplitude: t.amplitude, basis: &t.basis })
                .collect();
            let size: usize = terms.iter().map(|t| t.basis.rank()).sum();
            let row =
                RowPosterior::of(&terms, covariance.as_ref().submatrix(first, first, size, size));
            first += size;
            row
        });
        let uncertainty = Uncertainty::new(posteriors.collect());
        let model = IdentifiedModel::of_expansions(
            self.order,
            [data.dimension, data.inputs, data.centre.len()],
            expansions,
            Some(uncertainty),
        );
        let report = Report::of(data, rows, refined, &model);
        Identified { model, report }
    }
}

/// An identified model and how it came about.
#[derive(Debug, Clone)]
pub struct Identified {
    /// f and g with their standard deviations.
    pub model: IdentifiedModel,
    /// What was chosen, and what the data cannot tell.
    pub report: Report,
}

/// What all steps look at.
pub(crate) struct Data {
    dimension: usize,
    inputs: usize,
    order: usize,
    channels: Vec<Channel>,
    rate_noise: Vec<Option<f64>>,
    windows: Vec<WeakWindow>,
    initial_states: Vec<Vec<f64>>,
    window_seconds: f64,
    /// Mean and standard deviation of each argument.
    centre: Vec<f64>,
    spread: Vec<f64>,
    candidates: Vec<f64>,
    few_candidates: Vec<f64>,
    /// Root mean square of each coordinate's highest derivative, and of each input.
    highest: Vec<f64>,
    input_rms: Vec<f64>,
    middle: Vec<f64>,
    half_range: Vec<f64>,
}

impl Data {
    fn of(settings: &Identification, motions: &[Motion]) -> Result<Self, IdentificationError> {
        let (n, m) = (motions[0].dimension(), motions[0].input_count());
        let channels =
            (0..n).map(|i| smoothing::judge(motions, i)).collect::<Result<Vec<_>, _>>()?;
        let rate_noise =
            (0..n).map(|i| smoothing::judge_rates(motions, i)).collect::<Result<Vec<_>, _>>()?;
        let smooth: Vec<Smooth> = motions
            .par_iter()
            .map(|motion| smoothing::smooth(motion, &channels, &rate_noise))
            .collect::<Result<_, _>>()?;
        let states: Vec<Vec<f64>> = smooth.iter().map(|s| settings.states(s, n)).collect();
        let count = n * settings.order;
        let (centre_all, spread_all) = moments(&states, count);
        let (middle, half_range) = ranges(&states, count);
        let d = settings.argument_count(n);
        if let Some(i) = spread_all[..d].iter().position(|s| s.is_nan() || *s <= 0.0) {
            return Err(IdentificationError::Still { coordinate: i % n });
        }
        let highest_rms = rms(smooth.iter().map(|s| s.derivatives(settings.order)[1].to_vec()), n);
        let input_rms = rms(motions.iter().map(|motion| motion.inputs().to_vec()), m);
        let window_seconds =
            settings.window.unwrap_or_else(|| typical_window(&smooth, settings.order, n));
        let (mut windows, mut initial_states) = (Vec::new(), Vec::new());
        for ((motion, states), smooth) in motions.iter().zip(&states).zip(&smooth) {
            let [below, highest] = smooth.derivatives(settings.order);
            for (first, samples) in cut(motion.times(), window_seconds) {
                let rows = states[first * count..(first + samples) * count].chunks_exact(count);
                initial_states.push(states[first * count..(first + 1) * count].to_vec());
                let arguments = rows.flat_map(|z| &z[..d]).copied().collect();
                let part = motion.part(first, samples);
                let rows = first * n..(first + samples) * n;
                let derivatives = [&below[rows.clone()], &highest[rows]];
                let (order, path) = (settings.order, settings.input_path);
                windows.push(WeakWindow::new(
                    part,
                    arguments,
                    order,
                    path,
                    derivatives,
                    &highest_rms,
                ));
            }
        }
        let all: Vec<f64> = windows.iter().flat_map(|w| &w.arguments).copied().collect();
        let candidates = thin(&all, d, CANDIDATES);
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
            windows,
            initial_states,
            window_seconds,
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

    /// The weak equations of coordinate i on which kernels are chosen.
    fn weak_row(&self, i: usize) -> WeakRow<'_> {
        let all: usize = self.windows.iter().map(|w| w.motion.samples()).sum();
        let most = (CHOOSING_EQUATIONS * self.windows.len() / all).max(1);
        let chosen = sample(self.windows.len(), most);
        self.row(chosen.into_iter().map(|k| &self.windows[k]), i)
    }

    fn each_row(
        &self,
        of: impl Fn(usize) -> Result<RowChoice, IdentificationError> + Sync + Send,
    ) -> Result<Vec<RowChoice>, IdentificationError> {
        (0..self.dimension).into_par_iter().map(of).collect()
    }

    /// The equations of coordinate i in some windows.
    fn row<'w>(&self, windows: impl Iterator<Item = &'w WeakWindow>, i: usize) -> WeakRow<'w> {
        WeakRow::new(windows, i, self.channels[i].noise_sd, self.rate_weight(i))
    }

    /// First guesses of the prior amplitudes.
    fn amplitudes(&self, i: usize) -> Vec<f64> {
        let highest = self.highest[i].max(f64::MIN_POSITIVE);
        let of_input = |rms: &f64| if *rms > 0.0 { 0.3 * highest / rms } else { highest };
        std::iter::once(highest).chain(self.input_rms.iter().map(of_input)).collect()
    }

    fn setting(&self, settings: &Identification) -> Setting {
        Setting {
            order: self.order,
            arguments: settings.arguments,
            path: settings.input_path,
            middle: self.middle.clone(),
            half_range: self.half_range.clone(),
        }
    }

    /// Runge-Kutta steps from sample to sample, for the stiffest of many samples.
    fn steps(&self, field: &Field, setting: &Setting) -> usize {
        let d = self.centre.len();
        let mut integrator = Integrator::new(field, setting, self.inputs);
        let mut stiffest = 0.0f64;
        let u = vec![0.0; self.inputs];
        for x in self.few_candidates.chunks_exact(d) {
            let mut z = self.middle.clone();
            z[..d].copy_from_slice(x);
            stiffest = stiffest.max(integrator.stiffness(&z, &u));
        }
        let longest = self.windows.iter().flat_map(|w| w.motion.times().windows(2));
        let mut steps: Vec<f64> = longest.map(|t| t[1] - t[0]).collect();
        steps.sort_by(f64::total_cmp);
        Integrator::steps_for(stiffest, steps[steps.len() * 9 / 10])
    }
}

impl Identification {
    /// States z, N x (s n).
    fn states(&self, smooth: &Smooth, n: usize) -> Vec<f64> {
        if self.order == 1 {
            return smooth.values.clone();
        }
        let pairs = smooth.values.chunks_exact(n).zip(smooth.rates.chunks_exact(n));
        pairs.flat_map(|(y, v)| y.iter().chain(v).copied()).collect()
    }
}

/// Coefficients of one coordinate's functions from the weak form on all windows.
fn fit_row(
    data: &Data,
    i: usize,
    choice: &RowChoice,
    field: &mut Field,
) -> Result<(), IdentificationError> {
    let terms: Vec<&Term> = field.terms.iter().filter(|t| t.row == i).collect();
    let size: usize = terms.iter().map(|t| t.basis.rank()).sum();
    let group = |windows: &[WeakWindow]| {
        let row = data.row(windows.iter(), i);
        let mut normal = Normal::new(size);
        let parts: Vec<_> = terms.iter().map(|t| row.designs(&t.basis, t.block)).collect();
        for (w, (right, lost)) in row.right_hand_sides().enumerate() {
            let design = choice::side_by_side(&parts.iter().map(|p| &p[w]).collect::<Vec<_>>());
            normal.add(design.as_ref(), right, lost);
        }
        normal
    };
    let size_of_group = 8.max(data.windows.len() / 32);
    let groups: Vec<Normal> = data.windows.par_chunks(size_of_group).map(group).collect();
    let mut normal = Normal::new(size);
    groups.iter().for_each(|g| normal.merge(g));
    let prior: Vec<f64> =
        terms.iter().flat_map(|t| std::iter::repeat_n(t.amplitude, t.basis.rank())).collect();
    let posterior =
        normal.posterior(&prior, choice.noise_sd).map_err(|_| IdentificationError::NoEvidence)?;
    let mut first = 0;
    for term in field.terms.iter_mut().filter(|t| t.row == i) {
        let rank = term.basis.rank();
        term.set(&posterior.coefficients[first..first + rank]);
        first += rank;
    }
    Ok(())
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

/// At most `most` of the rows.
fn thin(rows: &[f64], d: usize, most: usize) -> Vec<f64> {
    let kept = sample(rows.len() / d, most);
    kept.into_iter().flat_map(|k| &rows[k * d..(k + 1) * d]).copied().collect()
}

/// At most `most` of `count` indices, evenly but without a period: a stride would see only a part of data that are laid
/// out on a grid or a Halton sequence. The indices with the smallest fractional parts of multiples of the golden ratio.
fn sample(count: usize, most: usize) -> Vec<usize> {
    const GOLDEN: f64 = 0.618_033_988_749_894_9;
    let share = most as f64 / count as f64;
    (0..count).filter(|&k| (k as f64 * GOLDEN).fract() < share).take(most).collect()
}

/// Data or settings from which nothing can be identified.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum IdentificationError {
    /// No data at all.
    #[error("expected at least one motion, found none")]
    NoMotion,
    /// A motion of another shape.
    #[error("motion {motion} has other coordinates, rates or inputs than the first")]
    Shape {
        /// Index of the motion.
        motion: usize,
    },
    /// Too short.
    #[error("a motion needs at least {expected} samples, found {found}")]
    TooFewSamples {
        /// Samples needed.
        expected: usize,
        /// Samples given.
        found: usize,
    },
    /// Times that do not increase.
    #[error(transparent)]
    Times(#[from] crate::quadrature::QuadratureError),
    /// An array of the wrong length.
    #[error("{what}: expected {expected} values or a multiple, found {found}")]
    Length {
        /// Which array.
        what: &'static str,
        /// What its length must be.
        expected: usize,
        /// Its length.
        found: usize,
    },
    /// A value that is not finite.
    #[error("{what}: row {row} is {found}, expected a finite number")]
    NotFinite {
        /// Which array.
        what: &'static str,
        /// Row of the value.
        row: usize,
        /// The value.
        found: f64,
    },
    /// Order out of range.
    #[error("the order of the dynamics must be 1 or 2, found {found}")]
    Order {
        /// The order.
        found: usize,
    },
    /// No family or no landmark.
    #[error("at least one kernel family and one landmark are needed")]
    NothingToChoose,
    /// A setting that is not positive.
    #[error("{what} must be positive and finite, found {found}")]
    NotPositive {
        /// Which.
        what: &'static str,
        /// Its value.
        found: f64,
    },
    /// A channel without motion.
    #[error("coordinate {coordinate} never changes: nothing can be learned of it")]
    Still {
        /// Index of the coordinate.
        coordinate: usize,
    },
    /// A channel that cannot be smoothed.
    #[error("coordinate {coordinate}: {source}")]
    Signal {
        /// Index of the coordinate.
        coordinate: usize,
        /// Why.
        source: SignalError,
    },
    /// No kernel makes the data likely in floating point numbers.
    #[error(
        "the regression is singular in floating point numbers; give a larger lambda or other widths"
    )]
    NoEvidence,
    /// No trajectory of the model stays near the data.
    #[error(
        "the identified model's trajectories leave the data from every start; record more, or shorter windows"
    )]
    Lost,
}
