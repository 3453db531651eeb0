//! Screening: which effects of the catalogue does the weak residual ask for?
//!
//! Forward selection by evidence. At each step every candidate is tried over its grid of
//! shapes with the noise as it is; the best few are refined (shape by a simplex search, the
//! white force that stands for the unexplained re-estimated) and compared by log evidence.
//! Afterwards each effect is dropped in turn.

mod guards;
mod learn;
mod shapes;
mod shortlist;
mod system;

pub use learn::{Learned, Over};
use system::System;

use crate::DiagnoseError;
use crate::candidates::{Candidate, Term, candidates};
use crate::evidence::{Evidence, Normal, colour};
use crate::trajectories::SmoothedRecording;
use crate::weak::{Column, WeakForm, Whitener};
use lacuna_effects::{Law, Range};
use rayon::prelude::*;

/// Nats by which an effect must beat the model without it.
const THRESHOLD: f64 = 10.0;
/// Share of the first effect's gain that later ones must reach: formulas are never exact,
/// and what a slightly wrong one leaves behind is no second effect.
const SHARE_OF_FIRST: f64 = 0.01;
/// Most effects that are added.
const MOST_EFFECTS: usize = 3;
/// Parameters may move this many tolerances.
const MOST_TOLERANCES: f64 = 4.0;

/// A set of effects, fitted.
#[derive(Clone, Debug)]
pub struct Hypothesis {
    /// The effects.
    pub terms: Vec<Term>,
    /// Standard deviation of the white force on each used channel, in units of its noise.
    pub tau: Vec<f64>,
    /// The fit: parameters with a tolerance first, then the amplitudes of each term.
    pub evidence: Evidence,
    /// How much more slowly than white noise the whitened residual varies (1 is white):
    /// evidence counts this many times less.
    pub colour: f64,
}

/// What the screening found.
#[derive(Clone, Debug)]
pub struct Screening {
    /// The model with calibrated parameters and no effect.
    pub calibrated: Hypothesis,
    /// The model at its nominal parameters.
    pub nominal: Hypothesis,
    /// The chosen effects.
    pub chosen: Hypothesis,
    /// For each chosen effect, rivals and the nats they lie behind it.
    pub rivals: Vec<Vec<(Term, f64)>>,
    /// For each chosen effect, the nats it gains over leaving it out.
    pub gains: Vec<f64>,
}

/// The regression at one point of the parameters.
pub struct Screen<'w> {
    weak: &'w WeakForm<'w>,
    /// Point about which parameters are linear.
    pub point: Vec<f64>,
    target: Column,
    parameters: Vec<(usize, Column)>,
    /// Root mean square of the residual over all rows: what amplitudes are expected to explain.
    scale: f64,
}

impl<'w> Screen<'w> {
    /// The smoothed recordings.
    pub fn smoothed(&self) -> impl Iterator<Item = &SmoothedRecording> {
        self.weak.smoothed()
    }

    /// Set up the regression at `point`.
    #[must_use]
    pub fn new(weak: &'w WeakForm<'w>, point: Vec<f64>) -> Self {
        let target = weak.residual(&point);
        let parameters = weak.parameter_columns(&point);
        let scale = rms(&target);
        Self { weak, point, target, parameters, scale }
    }

    /// What the model believes of its free parameters, about the point of the regression.
    #[must_use]
    pub fn parameter_priors(&self) -> Vec<Normal> {
        let prior = |&(k, _): &(usize, Column)| {
            let p = &self.weak.model().parameters[k];
            Normal { mean: p.value - self.point[k], sd: p.std() }
        };
        self.parameters.iter().map(prior).collect()
    }

    /// Target and columns of a set of terms before whitening.
    fn system(&self, terms: &[Term]) -> System {
        let mut target = self.target.clone();
        if terms.iter().any(|t| matches!(t.candidate.effect.law, Law::Input(_))) {
            let change = self.input_change(terms);
            target.iter_mut().zip(&change).for_each(|(t, c)| *t -= c);
        }
        let mut columns: Vec<Column> = self.parameters.iter().map(|(_, c)| c.clone()).collect();
        let mut priors = self.parameter_priors();
        for term in terms {
            for column in term.columns(self.weak, &self.point) {
                priors.push(Normal { mean: 0.0, sd: amplitude_sd(self.scale, &column) });
                columns.push(column);
            }
        }
        System { target, columns, priors }
    }

    /// What the input effects among `terms` change in the explained force.
    fn input_change(&self, terms: &[Term]) -> Column {
        let m = self.weak.model().inputs.len();
        self.weak.input_column(&self.point, |s| {
            let mut inputs = self.weak.model().effective_inputs(&s.times, &s.commands);
            terms.iter().for_each(|t| t.transform(&s.times, &mut inputs, m));
            inputs
        })
    }

    /// Fit a set of terms with the white forces `tau`.
    fn fit(&self, system: &System, tau: &[f64]) -> Result<Option<Evidence>, DiagnoseError> {
        let whitener = self.weak.whitener(tau)?;
        Ok(system.whitened(&whitener).regress())
    }

    /// Fit a set of terms, the white forces chosen by evidence, beginning from `tau`.
    ///
    /// # Errors
    /// [`DiagnoseError`] when the noise covariance cannot be factored or nothing is finite.
    pub fn hypothesis(&self, terms: &[Term], tau: &[f64]) -> Result<Hypothesis, DiagnoseError> {
        let mut system = self.system(terms);
        let (tau, evidence) = self.choose_tau(&system, tau)?;
        let whitener = self.weak.whitener(&tau)?;
        let colour = self.colour(&system.whitened(&whitener).residual(&evidence));
        // Data of which only one in `colour` counts move a prior that much less.
        system.priors.iter_mut().for_each(|p| p.sd /= colour.sqrt());
        let evidence = self.within_bounds(&mut system, &whitener)?;
        Ok(Hypothesis { terms: terms.to_vec(), tau, evidence, colour })
    }

    /// Fit, and hold parameters that leave their bounds there.
    fn within_bounds(
        &self,
        system: &mut System,
        whitener: &Whitener,
    ) -> Result<Evidence, DiagnoseError> {
        let failed = || DiagnoseError::Weak { reason: "the regression is not finite".into() };
        let mut held = vec![false; self.parameters.len()];
        loop {
            let fit = system.whitened(whitener).regress().ok_or_else(failed)?;
            let outside = (0..held.len()).find_map(|k| {
                let p = &self.weak.model().parameters[self.parameters[k].0];
                let value = self.point[self.parameters[k].0] + fit.coefficients[k];
                let shift = (value - p.value) / p.std();
                (!held[k] && shift.abs() > MOST_TOLERANCES).then_some((k, shift, p))
            });
            let Some((k, shift, p)) = outside else { return Ok(fit) };
            let bound = p.value + MOST_TOLERANCES * shift.signum() * p.std();
            system.priors[k] =
                Normal { mean: bound - self.point[self.parameters[k].0], sd: 1e-6 * p.std() };
            held[k] = true;
        }
    }

    /// Evidence maximised over the white forces: one channel after the other, in steps of a
    /// factor that shrinks.
    fn choose_tau(
        &self,
        system: &System,
        start: &[f64],
    ) -> Result<(Vec<f64>, Evidence), DiagnoseError> {
        let failed = || DiagnoseError::Weak { reason: "the regression is not finite".into() };
        let mut tau = start.to_vec();
        let mut best = self.fit(system, &tau)?.ok_or_else(failed)?;
        for factor in [4.0, 2.0, 1.3] {
            for c in 0..tau.len() {
                for direction in [1.0 / factor, factor] {
                    loop {
                        let mut trial = tau.clone();
                        trial[c] *= direction;
                        let Some(fit) = self.fit(system, &trial)? else { break };
                        if fit.log <= best.log + 1e-3 || trial[c] < 1e-9 * self.scale {
                            break;
                        }
                        (tau, best) = (trial, fit);
                    }
                }
            }
        }
        Ok((tau, best))
    }

    /// White forces that explain the whole residual: where the search for them begins.
    #[must_use]
    pub fn largest_tau(&self) -> Vec<f64> {
        vec![self.scale.max(f64::MIN_POSITIVE); self.weak.channels().len()]
    }

    fn colour(&self, residual: &[f64]) -> f64 {
        let segments = self.weak.segments();
        colour(segments.iter().map(|(_, rows)| &residual[rows.clone()]))
    }

    /// The whole search.
    ///
    /// # Errors
    /// [`DiagnoseError`] when the weak form breaks down numerically.
    pub fn search(&self, progress: &dyn Fn(&str)) -> Result<Screening, DiagnoseError> {
        let calibrated = self.hypothesis(&[], &self.largest_tau())?;
        let nominal = self.nominal(&calibrated)?;
        let list = candidates(self.weak.model(), self.weak.channels());
        let mut chosen = calibrated.clone();
        let mut rivals: Vec<Vec<(Term, f64)>> = Vec::new();
        let mut first_gain = None;
        while chosen.terms.len() < MOST_EFFECTS {
            progress(&format!("screening {} candidates", list.len()));
            let taken = |c: &Candidate| chosen.terms.iter().any(|t| t.candidate.excludes(c));
            let free: Vec<_> = list.iter().filter(|c| !taken(c)).copied().collect();
            let shortlist = self.shortlist(&chosen, &free)?;
            let fits = shortlist
                .par_iter()
                .map(|term| {
                    let mut terms = chosen.terms.clone();
                    terms.push(self.refine(&chosen, term)?);
                    self.hypothesis(&terms, &chosen.tau)
                })
                .collect::<Result<Vec<_>, _>>()?;
            let mut fits: Vec<_> = fits.into_iter().filter(|h| self.is_sensible(h)).collect();
            fits.sort_by(|a, b| b.evidence.log.total_cmp(&a.evidence.log));
            let mut kept = Vec::new();
            for h in fits {
                if self.is_told_apart_from_motion(&h)
                    && (chosen.terms.is_empty() || self.generalises(&chosen, &h)?)
                {
                    kept.push(h);
                }
            }
            fits = kept;
            let Some(best) = fits.first() else { break };
            let gain = (best.evidence.log - chosen.evidence.log) / best.colour;
            let needed = THRESHOLD.max(SHARE_OF_FIRST * first_gain.unwrap_or(0.0));
            if gain < needed || !self.beats_a_remainder(&chosen, best, gain)? {
                break;
            }
            first_gain.get_or_insert(gain);
            let behind = |h: &Hypothesis| (best.evidence.log - h.evidence.log) / best.colour;
            let last = |h: &Hypothesis| h.terms[h.terms.len() - 1].clone();
            rivals.push(fits.iter().skip(1).map(|h| (last(h), behind(h))).collect());
            chosen = best.clone();
        }
        let gains = self.prune(&mut chosen, &mut rivals)?;
        Ok(Screening { calibrated, nominal, chosen, rivals, gains })
    }

    /// Drop effects that later ones made superfluous; the gains of those that stay.
    fn prune(
        &self,
        chosen: &mut Hypothesis,
        rivals: &mut Vec<Vec<(Term, f64)>>,
    ) -> Result<Vec<f64>, DiagnoseError> {
        loop {
            let mut gains = Vec::new();
            for k in 0..chosen.terms.len() {
                let mut terms = chosen.terms.clone();
                terms.remove(k);
                let without = self.hypothesis(&terms, &chosen.tau)?;
                gains.push((chosen.evidence.log - without.evidence.log) / chosen.colour);
            }
            let weakest = gains.iter().enumerate().min_by(|a, b| a.1.total_cmp(b.1));
            match weakest {
                Some((k, &gain)) if gain < THRESHOLD => {
                    chosen.terms.remove(k);
                    rivals.remove(k);
                    *chosen = self.hypothesis(&chosen.terms, &chosen.tau)?;
                }
                _ => return Ok(gains),
            }
        }
    }

    /// The model as it stands: parameters at their nominal values.
    fn nominal(&self, calibrated: &Hypothesis) -> Result<Hypothesis, DiagnoseError> {
        let mut system = self.system(&[]);
        for prior in &mut system.priors {
            // A prior too narrow to move.
            prior.sd *= 1e-6;
        }
        let (tau, evidence) = self.choose_tau(&system, &calibrated.tau)?;
        let residual = system.whitened(&self.weak.whitener(&tau)?).residual(&evidence);
        Ok(Hypothesis { terms: vec![], tau, evidence, colour: self.colour(&residual) })
    }

    /// Amplitudes that make physical sense.
    fn is_sensible(&self, h: &Hypothesis) -> bool {
        let mut at = self.parameters.len();
        h.terms.iter().all(|term| {
            let count = term.amplitudes();
            let range = at..at + count;
            at += count;
            sensible(term, &h.evidence.coefficients[range.clone()], |k| {
                h.evidence.std(range.start + k)
            })
        })
    }

    /// Indices of the model's parameters that are regressed.
    #[must_use]
    pub fn free_parameters(&self) -> Vec<usize> {
        self.parameters.iter().map(|(k, _)| *k).collect()
    }
}

impl Term {
    /// Number of amplitudes in the regression.
    #[must_use]
    pub fn amplitudes(&self) -> usize {
        match self.candidate.effect.law {
            Law::Force(law) => law.amplitudes(),
            _ => 0,
        }
    }
}

/// Prior of an amplitude: its column may explain as much as the residual holds.
fn amplitude_sd(scale: f64, column: &[f64]) -> f64 {
    let size = rms(column);
    if size > 0.0 && scale > 0.0 { 2.0 * scale / size } else { 1.0 }
}

fn rms(values: &[f64]) -> f64 {
    (values.iter().map(|v| v * v).sum::<f64>() / values.len().max(1) as f64).sqrt()
}

/// Whether amplitudes whose range is one-sided are on their side (two standard deviations
/// of doubt allowed), and at least one is.
fn sensible(term: &Term, amplitudes: &[f64], std: impl Fn(usize) -> f64) -> bool {
    let Law::Force(law) = term.candidate.effect.law else { return true };
    let internal: Vec<f64> = amplitudes.iter().chain(&term.shape).copied().collect();
    let physical = law.physical(&internal);
    let one_sided = |k: usize| term.candidate.effect.parameters[k].range == Range::NonNegative;
    (0..amplitudes.len()).all(|k| !one_sided(k) || physical[k] > -2.0 * std(k))
        && (0..amplitudes.len()).any(|k| !one_sided(k) || physical[k] > 0.0)
}
