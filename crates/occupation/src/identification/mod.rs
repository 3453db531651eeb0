//! Identification in one call: drift and control effectiveness from noisy samples, with everything chosen by the data.
//!
//! ```text
//! y^(s) = f(x) + g(x) u,   x = y or (y, y', ..., y^(s-1)),   samples y_k + noise
//! ```
//!
//! | step | module | what |
//! | --- | --- | --- |
//! | kernel arguments from noisy samples | `smoothing` | Kalman smoother, noise by likelihood |
//! | weak form without initial derivatives | `weak` | whole windows, free initial values, the errors' exact covariance |
//! | kernel family, widths, lambda, noise | [`choice`] | marginal likelihood in closed form |
//! | arguments between samples | `path` | trajectories of trial models |
//! | coefficients, first from the weak form | `fit`, [`evidence`] | linear regression in closed form |
//! | few features instead of every sample | `basis` | pivoted Cholesky (Nystrom) |
//! | errors in variables, motion between samples | `flow`, `refine` | the weak form along the model's own trajectories |
//! | polynomials of few terms | `few_terms`, `monomials`, `select` | evidence of what is left without a term |
//! | any number of motions | [`Stream`] | inner products of their equations, summed over parts |
//! | standard deviations of f and g | [`crate::Uncertainty`] | posterior of the last linearisation |
//! | what the data cannot tell | [`report`] | inputs that do not excite, regions without data |

mod basis;
pub mod choice;
mod data;
mod error;
pub mod evidence;
mod family;
mod few_terms;
mod field;
mod fit;
mod flow;
mod initial;
mod inputs;
mod matrix;
mod monomials;
mod motion;
mod optimise;
mod path;
mod refine;
pub mod report;
mod select;
mod smoothing;
mod stream;
mod table;
mod weak;

use std::sync::Arc;

use faer::MatRef;
use serde::{Deserialize, Serialize};

pub(crate) use basis::Basis;
pub use choice::{BlockChoice, RowChoice};
pub use error::IdentificationError;
pub use family::{Family, ScaledKernel};
pub use motion::{InputPath, Motion};
pub use report::{Report, Warning};
pub use stream::{Stream, Sums};

use crate::identified::{Expansion, IdentifiedModel, RowPosterior, TermOf, Uncertainty};
use choice::{Alternative, Effort, Start, choose, reconsider};
use data::Data;
use field::{Field, Term};
use flow::{Shot, steps_for};
use refine::{OutputNoise, Refined, Refinement};
use report::Seen;
use weak::WeakWindow;

/// Equations on which kernels are chosen ...
const CHOOSING_EQUATIONS: usize = 2100;
/// ... and on which the choice is compared with others that were tried.
const RECONSIDERING_EQUATIONS: usize = 20_000;
/// Most landmarks of the first of two trial models.
const TRIAL_LANDMARKS: usize = 120;
/// A trial model follows the samples where it leaves less than this times their noise.
const FOLLOWS: f64 = 1.2;
/// Landmarks may leave this share of the posterior standard deviation.
const LANDMARK_SHARE: f64 = 0.01;
/// Regularisation lambda of data without noise: none that is chosen by noise is enough there.
pub const NOISE_FREE: f64 = 1e-8;
/// Most landmarks of a drift and of a control effectiveness, whatever is asked for: the latter is simpler (in mechanics it
/// does not depend on velocities).
const TERM_LIMITS: [usize; 2] = [usize::MAX, 80];

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
    /// The result does not depend on the number of threads. Where no lambda is given and the data, without noise as
    /// simulators write them, leave none that a computer's numbers bear, it is [`NOISE_FREE`].
    ///
    /// # Errors
    /// No motion, motions of different shape, settings out of range, channels that never change, and data from which
    /// no model can be made that stays near them.
    pub fn identify(&self, motions: &[Motion]) -> Result<Identified, IdentificationError> {
        match self.as_asked(motions) {
            Err(IdentificationError::NoEvidence) if self.lambda.is_none() => {
                Self { lambda: Some(NOISE_FREE), ..self.clone() }.as_asked(motions)
            }
            found => found,
        }
    }

    fn as_asked(&self, motions: &[Motion]) -> Result<Identified, IdentificationError> {
        self.validate(motions)?;
        let data = Data::of(self, motions)?;
        let Chosen { rows, polynomials, more, shots } = self.chosen(&data)?;
        let start =
            if more == (0..data.windows.len()).collect::<Vec<_>>() { &shots[..] } else { &[] };
        let full = self.refined(&data, &rows, start)?;
        let few = self.of_few_terms(&data, [&rows, &polynomials], &full, start);
        let (rows, refined) = few.unwrap_or((rows, full));
        Ok(self.finish(&data, &rows, &refined))
    }

    /// The field of given priors, along the trajectories of all windows; `start` are initial states nearer to them than what
    /// the smoother makes of the first samples.
    fn refined(
        &self,
        data: &Data,
        rows: &[RowChoice],
        start: &[Shot],
    ) -> Result<Refined, IdentificationError> {
        let field = self.field(data, rows, self.most_landmarks);
        let every: Vec<usize> = (0..data.windows.len()).collect();
        let field = fit::fit(data, &data.windows, rows, field)?;
        let mut refinement = self.refinement(data, field, &every);
        refinement.start_from(start);
        refinement.run()
    }

    /// The priors of all functions.
    fn chosen(&self, data: &Data) -> Result<Chosen, IdentificationError> {
        let (trial, windows) = self.along_trials(data)?;
        let chosen = self.choose(data, &windows, Effort::THOROUGH)?;
        let more = data.some_windows(RECONSIDERING_EQUATIONS);
        let shots = self.refinement(data, trial.clone(), &more).settled()?;
        let (rows, polynomials) = self.reconsider(data, &trial, &shots, chosen)?;
        Ok(Chosen { rows, polynomials, more, shots })
    }

    /// A trial model that is good enough to tell what passes between samples, and a few windows as weak equations along
    /// its trajectories. The first of two knows but cubics between samples, and where motion is stiff only the second is
    /// good enough: what the first leaves there drowns among many samples that it explains. Where cubics do and the first
    /// follows the samples to their noise, there is nothing for a second to add.
    fn along_trials(&self, data: &Data) -> Result<(Field, Vec<WeakWindow>), IdentificationError> {
        let few = data.some_windows(CHOOSING_EQUATIONS);
        let mut windows: Vec<WeakWindow> = few.iter().map(|&k| data.windows[k].clone()).collect();
        let mut trial = None;
        for most in [TRIAL_LANDMARKS.min(self.most_landmarks), self.most_landmarks] {
            let chosen = self.choose(data, &windows, Effort::QUICK)?;
            let rows: Vec<RowChoice> = chosen.into_iter().map(|(row, _)| row).collect();
            let field = fit::fit(data, &windows, &rows, self.field(data, &rows, most))?;
            let refined = self.refinement(data, field, &few).run()?;
            windows = path::along(&refined.field, &data.setting(self), &refined.windows);
            let noise = refined.noise.0.iter().zip(&data.channels);
            let follows = noise.into_iter().all(|(left, c)| *left < FOLLOWS * c.noise_sd);
            trial = Some(refined.field);
            if follows && few.iter().all(|&k| data.windows[k].is_resolved()) {
                break;
            }
        }
        trial.map(|field| (field, windows)).ok_or(IdentificationError::NothingToChoose)
    }

    /// Compares what was chosen with its alternatives on more windows, along the trial's trajectories.
    fn reconsider(
        &self,
        data: &Data,
        trial: &Field,
        shots: &[Shot],
        chosen: Vec<(RowChoice, Vec<Alternative>)>,
    ) -> Result<(Vec<RowChoice>, Vec<RowChoice>), IdentificationError> {
        let windows = path::along(trial, &data.setting(self), shots);
        let found = data.each_row(|i| {
            let start = self.start(data, i, Effort::THOROUGH);
            reconsider(&data.row(&windows, i), &start, chosen[i].clone())
        })?;
        let both = |(row, polynomial): (RowChoice, Option<RowChoice>)| {
            let polynomial = polynomial.unwrap_or_else(|| row.clone());
            (row, polynomial)
        };
        Ok(found.into_iter().map(both).unzip())
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

    fn choose(
        &self,
        data: &Data,
        windows: &[WeakWindow],
        effort: Effort,
    ) -> Result<Vec<(RowChoice, Vec<Alternative>)>, IdentificationError> {
        data.each_row(|i| choose(&data.row(windows, i), &self.start(data, i, effort)))
    }

    fn start<'s>(&'s self, data: &'s Data, i: usize, effort: Effort) -> Start<'s> {
        Start {
            centre: &data.centre,
            spread: &data.spread,
            candidates: &data.few_candidates,
            amplitudes: data.amplitudes(i),
            noise_sd: data.channels[i].noise_sd,
            families: &self.families,
            widths: self.widths.as_deref(),
            lambda: self.lambda,
            effort,
        }
    }

    fn field(&self, data: &Data, rows: &[RowChoice], most: usize) -> Field {
        let term = |i: usize, b: usize, block: &BlockChoice| {
            let share = LANDMARK_SHARE * block.posterior_sd / block.amplitude;
            let basis = Basis::choose(
                block.kernel.clone(),
                &data.candidates,
                share * share,
                most.min(TERM_LIMITS[b.min(1)]),
            );
            Term::new(i, b, basis, block.amplitude, &data.candidates)
        };
        let of_row = |(i, row): (usize, &RowChoice)| {
            row.blocks.iter().enumerate().map(|(b, block)| term(i, b, block)).collect::<Vec<_>>()
        };
        let terms = rows.iter().enumerate().flat_map(of_row).collect();
        Field { dimension: data.dimension, arguments: data.centre.len(), terms }
    }

    fn refinement(&self, data: &Data, field: Field, windows: &[usize]) -> Refinement {
        let setting = data.setting(self);
        let mut noise: Vec<f64> = data.channels.iter().map(|c| c.noise_sd).collect();
        if self.order > 1 && data.rate_noise.iter().any(Option::is_some) {
            // Nothing is measured where there is none.
            noise.extend(data.rate_noise.iter().map(|sd| sd.unwrap_or(1.0)));
        }
        let stiffness = data.stiffness(&field);
        let shot = |&k: &usize| {
            let motion = Arc::clone(&data.windows[k].motion);
            let steps = steps_for(stiffness, motion.times());
            Shot { motion, initial: data.initial_states[k].clone(), steps }
        };
        let shots = windows.iter().map(shot).collect();
        let (noise, lambda) = (OutputNoise(noise), self.lambda);
        Refinement { field, setting, shots, noise, lambda, within: None }
    }

    fn finish(&self, data: &Data, rows: &[RowChoice], refined: &Refined) -> Identified {
        let (field, covariance) = (&refined.field, &refined.posterior.covariance);
        let mut first = 0;
        let of_row = |i: usize| {
            let terms = field.terms.iter().filter(|t| t.row == i);
            let size: usize = terms.map(|t| t.basis.rank()).sum();
            let own = covariance.as_ref().submatrix(first, first, size, size);
            first += size;
            own
        };
        let covariances: Vec<MatRef<'_, f64>> = (0..data.dimension).map(of_row).collect();
        let shape = [data.dimension, data.inputs, data.centre.len()];
        let model = model_of(self.order, shape, field, &covariances);
        let noise = &refined.noise.0;
        let seen = Seen {
            field,
            candidates: &data.candidates,
            few_candidates: &data.few_candidates,
            window_seconds: data.window_seconds,
            windows: refined.windows.len(),
            samples: refined.samples,
            iterations: refined.iterations,
            noise_sd: noise.clone(),
            equations_sd: noise,
        };
        let report = Report::of(&seen, rows, &model);
        Identified { model, report }
    }
}

/// What [`Identification::chosen`] found, and the windows on which it was compared with others.
struct Chosen {
    rows: Vec<RowChoice>,
    /// The same with polynomials for drifts, where few monomials may be more probable.
    polynomials: Vec<RowChoice>,
    more: Vec<usize>,
    shots: Vec<Shot>,
}

/// The model of a field and the covariances of its rows' coefficients, over the prior's standard deviations.
fn model_of(
    order: usize,
    shape: [usize; 3],
    field: &Field,
    covariances: &[MatRef<'_, f64>],
) -> IdentifiedModel {
    let expansion = |t: &Term| {
        let (kernel, weights) = (&t.basis.kernel, t.weights.clone());
        Expansion::of_landmarks(kernel, &t.basis.landmarks, weights, (t.row, t.block))
    };
    let expansions = field.terms.iter().map(expansion).collect();
    let posteriors = covariances.iter().enumerate().map(|(i, covariance)| {
        let terms = field.terms.iter().filter(|t| t.row == i);
        let terms: Vec<TermOf> = terms
            .map(|t| TermOf { block: t.block, amplitude: t.amplitude, basis: &t.basis })
            .collect();
        RowPosterior::of(&terms, *covariance)
    });
    let uncertainty = Uncertainty::new(posteriors.collect());
    IdentifiedModel::of_expansions(order, shape, expansions, Some(uncertainty))
}

/// An identified model and how it came about.
#[derive(Debug, Clone)]
pub struct Identified {
    /// f and g with their standard deviations.
    pub model: IdentifiedModel,
    /// What was chosen, and what the data cannot tell.
    pub report: Report,
}
