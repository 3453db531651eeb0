//! A fit that leaves windows out in turn: theta is fitted to the others, as if those had not been recorded, and they
//! are predicted.
//!
//! Whatever is left out, it begins at the optimum of all: what the windows are there, linearised, is computed once and
//! each takes its part of it.

use super::end::FitError;
use super::minimise::{Begun, Linearised, Minimisation};
use super::{Effort, Filter, Fit, Hypothesis};

/// A fit of which windows may be left out.
pub struct LeavingOut<'f, 'p> {
    fit: &'f Fit<'p>,
    begun: Begun,
}

impl<'p> Fit<'p> {
    /// This fit, to leave windows out.
    ///
    /// # Errors
    /// [`FitError`].
    pub fn leaving_out(&self) -> Result<LeavingOut<'_, 'p>, FitError> {
        let hypothesis = self.hypothesis.clone();
        let windowed = self.windows_for(&hypothesis);
        let minimisation = Minimisation::new(self.problem, hypothesis, windowed, self.substeps);
        let known = self.linearised.clone();
        let known = known.map(|blocks| Linearised { blocks, residuals: self.residuals.clone() });
        let begun = Minimisation { noise: self.noise.clone(), known, ..minimisation }.begun()?;
        Ok(LeavingOut { fit: self, begun })
    }
}

impl LeavingOut<'_, '_> {
    /// The hypothesis with theta fitted as if the windows that are marked had not been recorded.
    ///
    /// # Errors
    /// [`FitError`].
    pub fn learned_without(&self, marked: &[bool], effort: Effort) -> Result<Hypothesis, FitError> {
        let Self { fit, begun } = self;
        let rest: Vec<bool> = marked.iter().map(|out| !out).collect();
        let (windowed, kept) = begun.windowed.part(&rest);
        let known = Some(begun.linearised.part(&kept));
        let filters = part_of(&begun.filters, &kept);
        let left_out = kept.into_iter().map(|k| marked[k]).collect();
        let hypothesis = begun.hypothesis.clone();
        let noise = fit.noise.clone();
        let minimisation = Minimisation::new(fit.problem, hypothesis, windowed, fit.substeps);
        let learned =
            Minimisation { left_out, noise, filters, known, ..minimisation }.run(effort)?;
        Ok(learned.hypothesis)
    }

    /// Residuals of the windows that are marked, which are predicted: theta is fitted as if they had not been
    /// recorded, then their states, and they alone.
    ///
    /// # Errors
    /// [`FitError`].
    pub fn predicted(&self, marked: &[bool], effort: Effort) -> Result<Vec<Vec<f64>>, FitError> {
        self.fit.foretold(self.learned_without(marked, effort)?, marked)
    }
}

impl Linearised {
    /// Of some windows.
    fn part(&self, kept: &[usize]) -> Self {
        let of = |k: &usize| (self.blocks[*k].clone(), self.residuals[*k].clone());
        let (blocks, residuals): (Vec<_>, Vec<_>) = kept.iter().map(of).unzip();
        Self { blocks: blocks.into(), residuals: residuals.into() }
    }
}

/// The filters of some windows, counted through all recordings.
fn part_of(filters: &[Vec<Filter>], kept: &[usize]) -> Vec<Vec<Filter>> {
    let mut first = 0;
    let of = |own: &Vec<Filter>| {
        let range = first..first + own.len();
        first = range.end;
        let kept = kept.iter().filter(|k| range.contains(k));
        kept.map(|k| own[k - range.start].clone()).collect()
    };
    filters.iter().map(of).collect()
}
