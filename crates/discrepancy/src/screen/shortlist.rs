//! Which candidates are worth a closer look, and at which shapes.

use super::shapes::{Bounds, simplex};
use super::system::Ground;
use super::{Hypothesis, Screen, amplitude_sd, sensible};
use crate::DiagnoseError;
use crate::candidates::{Candidate, Term};
use crate::evidence::{Normal, regress};
use crate::weak::Column;
use lacuna_effects::Law;
use rayon::prelude::*;

/// Candidates that are refined at each step, from each of two scans.
const REFINED: usize = 6;
/// Share of the white force at which candidates are screened a second time.
const SMALLER_TAU: f64 = 0.2;

impl Screen<'_> {
    /// The candidates that are worth a closer look, each with its best shape: the first few at
    /// the noise of `base`, and the first few at a smaller white force. What is missing
    /// inflates the white force, behind which an effect that acts slowly or seldom hides.
    pub(super) fn shortlist(
        &self,
        base: &Hypothesis,
        list: &[Candidate],
    ) -> Result<Vec<Term>, DiagnoseError> {
        let tries: Vec<Term> = list
            .iter()
            .flat_map(|&candidate| {
                let shapes = candidate.shapes(&candidate.scales(self.weak));
                shapes.into_iter().map(move |shape| Term { candidate, shape })
            })
            .collect();
        let mut short: Vec<Term> = Vec::new();
        for share in [1.0, SMALLER_TAU] {
            let tau: Vec<f64> = base.tau.iter().map(|t| share * t).collect();
            for term in self.scan(base, &tau, &tries)?.into_iter().take(REFINED) {
                if !short.iter().any(|t| t.candidate == term.candidate) {
                    short.push(term);
                }
            }
        }
        Ok(short)
    }

    /// The best shape of every candidate, by its gain over `base` with white forces `tau`.
    fn scan(
        &self,
        base: &Hypothesis,
        tau: &[f64],
        tries: &[Term],
    ) -> Result<Vec<Term>, DiagnoseError> {
        let whitener = self.weak.whitener(tau)?;
        let system = self.system(&base.terms).whitened(&whitener);
        let failed = || DiagnoseError::Weak { reason: "the regression is not finite".into() };
        let fit = system.regress().ok_or_else(failed)?;
        let ground = Ground { residual: system.residual(&fit), system, fit, whitener };
        let gains: Vec<Option<f64>> =
            tries.par_iter().map(|term| self.quick_gain(&ground, &base.terms, term)).collect();
        let mut best: Vec<(f64, &Term)> = Vec::new();
        for (gain, term) in gains.into_iter().zip(tries) {
            let Some(gain) = gain else { continue };
            match best.iter_mut().find(|(_, t)| t.candidate == term.candidate) {
                Some(entry) if entry.0 >= gain => {}
                Some(entry) => *entry = (gain, term),
                None => best.push((gain, term)),
            }
        }
        best.sort_by(|a, b| b.0.total_cmp(&a.0));
        Ok(best.into_iter().map(|(_, term)| term.clone()).collect())
    }

    /// Gain of one term with the noise fixed: the target's projection on what the columns of
    /// the base leave of the new ones.
    fn quick_gain(&self, ground: &Ground, base: &[Term], term: &Term) -> Option<f64> {
        let Ground { system, fit, residual, whitener } = ground;
        let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(x, y)| x * y).sum::<f64>();
        if let Law::Input(_) = term.candidate.effect.law {
            // The change is what it is: no amplitude to choose, only the base to refit.
            let mut terms = base.to_vec();
            terms.push(term.clone());
            let (with, without) = (self.input_change(&terms), self.input_change(base));
            let change: Column = with.iter().zip(&without).map(|(a, b)| a - b).collect();
            let mut change = whitener.whiten(&change);
            system.project_out(fit, &mut change);
            return Some(dot(residual, &change) - 0.5 * dot(&change, &change));
        }
        let columns: Vec<Column> = term.columns(self.weak, &self.point);
        let priors: Vec<Normal> =
            columns.iter().map(|c| Normal { mean: 0.0, sd: amplitude_sd(self.scale, c) }).collect();
        let projected: Vec<Column> = columns
            .iter()
            .map(|c| {
                let mut c = whitener.whiten(c);
                system.project_out(fit, &mut c);
                c
            })
            .collect();
        let refs: Vec<&[f64]> = projected.iter().map(Vec::as_slice).collect();
        let with = regress(residual, &refs, &priors, 0.0)?;
        let without = regress(residual, &[], &[], 0.0)?;
        sensible(term, &with.coefficients, |k| with.std(k)).then_some(with.log - without.log)
    }

    /// Refine a term's shape by a simplex search on the evidence with the noise of `base`.
    pub(super) fn refine(&self, base: &Hypothesis, term: &Term) -> Result<Term, DiagnoseError> {
        let d = term.shape.len();
        if d == 0 {
            return Ok(term.clone());
        }
        let whitener = self.weak.whitener(&base.tau)?;
        let system = self.system(&base.terms).whitened(&whitener);
        let residual = system.residual(&base.evidence);
        let ground = Ground { system, fit: base.evidence.clone(), residual, whitener };
        let scales = term.candidate.scales(self.weak);
        let bounds = Bounds::of(&term.candidate.shapes(&scales));
        let cost = |x: &[f64]| {
            let trial = Term { candidate: term.candidate, shape: bounds.shape(x) };
            self.quick_gain(&ground, &base.terms, &trial).map_or(1e30, |g| -g)
        };
        let x = simplex(&cost, &bounds.coordinates(&term.shape), &bounds.steps(), 25 * d);
        Ok(Term { candidate: term.candidate, shape: bounds.shape(&x) })
    }
}
