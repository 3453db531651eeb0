//! Gauss-Newton on the trajectories: the most probable f and g given every sample.
//!
//! ```text
//! min over c, z_w:  sum_w sum_k |(y_wk - z_wk(c, z_w)) / sigma|^2 + |c / a|^2
//! ```
//!
//! with z_w the model's own trajectory in window w from a free initial state z_w. The linearisation
//! ([`super::flow`]) is the weak form along these trajectories with the model's adjoint for test function. Initial
//! states are fitted for each c (variable projection: G. Golub, V. Pereyra, 2003); a step that does not lead
//! downhill is halved. Noise is estimated from what is left.

use std::sync::Arc;

use faer::{Mat, MatRef};
use rayon::prelude::*;

use super::IdentificationError;
use super::evidence::Normal;
use super::field::{Field, Term};
use super::flow::{Integrator, Run, Setting, Shot};
use super::initial::{Misfit, fit_initial, guess_initial, measurements};
use super::select::Subspace;
use super::weak::{Reduction, Reflection};

/// Most Gauss-Newton steps.
const MOST_STEPS: usize = 12;
/// Steps that gain less than this are the last, in units of minus two log posterior.
const GAIN: f64 = 0.5;
/// Noise is never taken for less than this share of an output's half range.
const ROUNDING: f64 = 1e-9;
/// Halvings of a step before the search ends.
const HALVINGS: usize = 6;
/// Windows whose inner products are summed by one thread, in order.
const GROUP: usize = 16;
/// Shortest window, in samples.
const SHORTEST: usize = 8;
/// A window is halved while its misfit is above this share of the half range, and above three times the noise.
const MISFIT: f64 = 0.1;

/// Noise standard deviations of the coordinates, then of their rates where measured.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct OutputNoise(pub Vec<f64>);

impl OutputNoise {
    /// The factor by which all differ from another; none where they have no factor in common.
    fn over(&self, other: &Self) -> Option<f64> {
        let mut factors = self.0.iter().zip(&other.0).map(|(a, b)| a / b);
        let factor = factors.next()?;
        factors.all(|f| (f - factor).abs() <= 1e-12 * factor).then_some(factor)
    }
}

/// What the refinement found.
pub(crate) struct Refined {
    pub field: Field,
    pub noise: OutputNoise,
    /// The equations of the last linearisation, with errors of variance 1.
    pub normal: Normal,
    pub posterior: Known,
    /// Where the coefficients are; anywhere where there is none.
    pub within: Option<Subspace>,
    pub iterations: usize,
    pub windows: Vec<Shot>,
    /// Measured values.
    pub samples: usize,
}

impl Refined {
    /// Whether this is more probable than another; not where trajectories of one had to be cut that the other follows.
    pub fn beats(&self, other: &Self) -> bool {
        self.normal.equations == other.normal.equations
            && self.log_evidence() > other.log_evidence()
    }

    /// log p of the samples and of what monomials there are, but for what all fields share.
    fn log_evidence(&self) -> f64 {
        let sizes: f64 = self.noise.0.iter().map(|sd| sd.ln()).sum();
        let mean = sizes / self.noise.0.len() as f64;
        let log_odds = self.within.as_ref().map_or(0.0, |subspace| subspace.log_odds);
        self.posterior.log_evidence - self.normal.equations as f64 * mean + log_odds
    }
}

/// What equations say of all coefficients.
pub(crate) struct Known {
    /// Most probable.
    pub coefficients: Vec<f64>,
    /// Over the prior's standard deviations.
    pub covariance: Mat<f64>,
    /// log p(y) of the linear equations.
    pub log_evidence: f64,
}

/// The search: its field, windows and noise.
pub(crate) struct Refinement {
    pub field: Field,
    pub setting: Setting,
    pub shots: Vec<Shot>,
    pub noise: OutputNoise,
    /// lambda = sigma^2 / a^2, where given.
    pub lambda: Option<f64>,
    /// Where the coefficients are; anywhere where there is none.
    pub within: Option<Subspace>,
}

impl Refinement {
    /// Splits windows that the field does not follow, and drops those that it loses even when short.
    fn settle(&mut self) -> Result<Misfit, IdentificationError> {
        let shots = std::mem::take(&mut self.shots);
        let settled: Vec<Vec<(Shot, Misfit)>> =
            shots.into_par_iter().map(|shot| self.settle_one(shot)).collect();
        let mut total = Misfit::new(self.noise.0.len());
        for (shot, left) in settled.into_iter().flatten() {
            total.add(&left);
            self.shots.push(shot);
        }
        if self.shots.is_empty() { Err(IdentificationError::Lost) } else { Ok(total) }
    }

    fn settle_one(&self, mut shot: Shot) -> Vec<(Shot, Misfit)> {
        let mut integrator = Integrator::new(&self.field, &self.setting, &shot);
        let found = fit_initial(&mut integrator, &mut shot, &self.setting, &self.noise);
        let samples = shot.motion.samples();
        match found {
            Some(left) if self.follows(&left) || samples < 2 * SHORTEST => vec![(shot, left)],
            None if samples < 2 * SHORTEST => Vec::new(),
            _ => self.halves(&shot).into_iter().flat_map(|half| self.settle_one(half)).collect(),
        }
    }

    fn follows(&self, left: &Misfit) -> bool {
        (0..left.counts.len()).all(|i| {
            let rms = (left.squares[i] / left.counts[i].max(1) as f64).sqrt();
            rms <= (MISFIT * self.setting.half_range[i]).max(3.0 * self.noise.0[i])
        })
    }

    /// Two halves that share a sample; the second starts from the measured or middle state.
    fn halves(&self, shot: &Shot) -> [Shot; 2] {
        let samples = shot.motion.samples();
        let cut = samples / 2;
        let first = Shot { motion: shot.motion.part(0, cut + 1).into(), ..shot.clone() };
        let motion = shot.motion.part(cut, samples - cut);
        let initial = guess_initial(&motion, &self.setting);
        [first, Shot { motion: motion.into(), initial, steps: shot.steps }]
    }

    /// What is left with the present field, each window's initial state fitted; none where any trajectory is lost.
    fn profile(&self, field: &Field) -> Option<(Vec<Shot>, Misfit)> {
        let one = |shot: &Shot| {
            let mut shot = shot.clone();
            let mut integrator = Integrator::new(field, &self.setting, &shot);
            let left = fit_initial(&mut integrator, &mut shot, &self.setting, &self.noise)?;
            Some((shot, left))
        };
        let found: Option<Vec<(Shot, Misfit)>> = self.shots.par_iter().map(one).collect();
        let mut total = Misfit::new(self.noise.0.len());
        let mut shots = Vec::new();
        for (shot, left) in found? {
            total.add(&left);
            shots.push(shot);
        }
        Some((shots, total))
    }

    fn prior(&self) -> Vec<f64> {
        Term::priors(&self.field.terms)
    }

    fn cost(&self, field: &Field, left: &Misfit) -> f64 {
        let prior = self.prior();
        let coefficients = field.coefficients();
        let penalty: f64 = coefficients.iter().zip(&prior).map(|(c, a)| (c / a).powi(2)).sum();
        left.chi_square(&self.noise) + penalty
    }

    /// The noise's scale from what is left, less what the parameters took. Its ratios stay those of the channels: in a
    /// model that is not exact, what one output explains badly others would follow for free.
    fn update_noise(&mut self, left: &Misfit, taken: f64) {
        let samples: usize = left.counts.iter().sum();
        let free = (samples as f64 - taken).max(0.1 * samples as f64);
        let scale = (left.chi_square(&self.noise) / free).sqrt().max(f64::MIN_POSITIVE);
        let least = self.setting.half_range.iter().map(|half_range| ROUNDING * half_range);
        self.noise.0.iter_mut().zip(least).for_each(|(sd, least)| *sd = (*sd * scale).max(least));
        if let Some(lambda) = self.lambda {
            for term in &mut self.field.terms {
                term.amplitude = self.noise.0[term.row] / lambda.sqrt();
            }
        }
    }

    /// Inner products of all windows, linearised about their trajectories.
    fn assemble(&self) -> Option<Normal> {
        let features = self.field.features();
        let group = |shots: &[Shot]| {
            let mut normal = Normal::new(features);
            for shot in shots {
                self.add_window(shot, &mut normal)?;
            }
            Some(normal)
        };
        let groups: Option<Vec<Normal>> =
            self.shots.par_chunks(GROUP.max(self.shots.len() / 32)).map(group).collect();
        let mut total = Normal::new(features);
        groups?.iter().for_each(|normal| total.merge(normal));
        Some(total)
    }

    fn add_window(&self, shot: &Shot, normal: &mut Normal) -> Option<()> {
        let count = self.setting.states();
        let (run, kernel_rows) =
            Integrator::new(&self.field, &self.setting, shot).run_with_design(&shot.initial)?;
        let seen = measurements(shot, count);
        let reduction = Reduction::of(initial_columns(&run, &self.setting, &self.noise, &seen));
        let features = self.field.features();
        let weights: Vec<f64> = self.field.terms.iter().flat_map(|t| &t.weights).copied().collect();
        let mut rows = Vec::with_capacity(seen.len() * features);
        let mut right = Vec::with_capacity(seen.len());
        for &(k, i, value) in &seen {
            let (at, weight) = (k * count + i, 1.0 / self.noise.0[i]);
            let row = &kernel_rows[at * features..(at + 1) * features];
            let model: f64 = row.iter().zip(&weights).map(|(k, w)| k * w).sum();
            right.push(weight * (value - run.states[at] + model));
            rows.extend(row.iter().map(|k| weight * k));
        }
        Reflection { reduction: &reduction, columns: features, rows: &mut rows }.work_out();
        reduction.reflect(&mut right);
        let lost = reduction.lost();
        let left =
            MatRef::from_row_major_slice(&rows[lost * features..], right.len() - lost, features);
        let mut design = Mat::zeros(left.nrows(), features);
        let mut first = 0;
        for term in &self.field.terms {
            let rank = term.basis.rank();
            let own = term.basis.to_features(left.subcols(first, rank));
            design.as_mut().subcols_mut(first, rank).copy_from(&own);
            first += rank;
        }
        normal.add(design.as_ref(), &right[lost..]);
        Some(())
    }

    /// Takes the initial states of the same windows, unless some were cut or dropped.
    pub fn start_from(&mut self, shots: &[Shot]) {
        let same = |(own, other): (&Shot, &Shot)| Arc::ptr_eq(&own.motion, &other.motion);
        if shots.len() == self.shots.len() && self.shots.iter().zip(shots).all(same) {
            let pairs = self.shots.iter_mut().zip(shots);
            pairs.for_each(|(own, other)| own.initial.clone_from(&other.initial));
        }
    }

    /// The windows, each with the initial state that suits the field.
    ///
    /// # Errors
    /// Where the model's trajectories leave the data from every window.
    pub fn settled(mut self) -> Result<Vec<Shot>, IdentificationError> {
        self.settle()?;
        Ok(self.shots)
    }

    /// Runs the search.
    ///
    /// # Errors
    /// Where the model's trajectories leave the data from every window, or the system cannot be factorised.
    pub fn run(mut self) -> Result<Refined, IdentificationError> {
        let mut left = self.settle()?;
        let spent = self.shots.len() * self.setting.states();
        self.update_noise(&left, (spent + self.dimension()) as f64);
        let mut iterations = 0;
        let normal = loop {
            let noise = self.noise.clone();
            let normal = self.assemble().ok_or(IdentificationError::Lost)?;
            let posterior = self.known(&normal)?;
            let before = self.cost(&self.field, &left);
            let moved = self.line_search(&posterior.coefficients, before);
            let gain = match moved {
                Some((field, shots, found)) => {
                    let gain = before - self.cost(&field, &found);
                    (self.field, self.shots, left) = (field, shots, found);
                    gain
                }
                None => 0.0,
            };
            iterations += 1;
            let taken = spent as f64 + self.effective(&posterior);
            self.update_noise(&left, taken);
            match self.noise.over(&noise) {
                // Hardly anything has moved since: the linearisation stands.
                Some(factor) if gain < GAIN => break normal.scaled(factor),
                _ if gain < GAIN || iterations == MOST_STEPS => {
                    break self.assemble().ok_or(IdentificationError::Lost)?;
                }
                _ => {}
            }
        };
        let posterior = self.known(&normal)?;
        let samples = left.counts.iter().sum();
        Ok(Refined {
            field: self.field,
            noise: self.noise,
            normal,
            posterior,
            within: self.within,
            iterations,
            windows: self.shots,
            samples,
        })
    }

    /// Number of coefficients that are free.
    fn dimension(&self) -> usize {
        self.within.as_ref().map_or(self.field.features(), Subspace::dimension)
    }

    /// Effective number of parameters, P - tr B^-1.
    fn effective(&self, posterior: &Known) -> f64 {
        let covariance = &posterior.covariance;
        let unknown: f64 = (0..covariance.nrows()).map(|i| covariance[(i, i)]).sum();
        self.dimension() as f64 - unknown
    }

    fn known(&self, normal: &Normal) -> Result<Known, IdentificationError> {
        let prior = self.prior();
        let found = match &self.within {
            Some(subspace) => subspace.posterior(normal, &prior),
            None => normal.posterior(&prior, 1.0).map(|found| {
                let covariance = found.factor.inverse();
                (found, covariance)
            }),
        };
        let (found, covariance) = found.map_err(|_| IdentificationError::NoEvidence)?;
        let (coefficients, log_evidence) = (found.coefficients, found.log_evidence);
        Ok(Known { coefficients, covariance, log_evidence })
    }

    fn line_search(&self, target: &[f64], before: f64) -> Option<(Field, Vec<Shot>, Misfit)> {
        let from = self.field.coefficients();
        let mut length = 1.0;
        for _ in 0..HALVINGS {
            let blend: Vec<f64> =
                from.iter().zip(target).map(|(a, b)| a + length * (b - a)).collect();
            let mut field = self.field.clone();
            field.set(&blend);
            if let Some((shots, left)) = self.profile(&field)
                && self.cost(&field, &left) < before
            {
                return Some((field, shots, left));
            }
            length *= 0.5;
        }
        None
    }
}

/// Weighted columns of the initial state.
fn initial_columns<'r>(
    run: &'r Run,
    setting: &'r Setting,
    noise: &'r OutputNoise,
    seen: &'r [(usize, usize, f64)],
) -> impl Iterator<Item = Vec<f64>> + 'r {
    let count = setting.states();
    (0..count).map(move |a| {
        let entry = |&(k, i, _): &(usize, usize, f64)| {
            run.transitions[(k * count + i) * count + a] * setting.half_range[a] / noise.0[i]
        };
        seen.iter().map(entry).collect()
    })
}
