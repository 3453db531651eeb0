//! A fit that leaves windows out in turn: theta is fitted to the others, as if those had not been recorded, and they
//! are predicted.
//!
//! Whatever is left out, it begins at the optimum of all: what the windows are there, linearised, is computed once and
//! each takes its part of it.

use super::end::FitError;
use super::minimise::{Linearised, Minimisation};
use super::normal::Arrow;
use super::{Effort, Filter, Fit, Hypothesis, Windowed};
use std::ops::Add;

/// A fit of which windows may be left out.
pub struct LeavingOut<'f, 'p> {
    fit: &'f Fit<'p>,
    /// A filter a window, recording by recording; none where no noise drives the machine.
    filters: Vec<Vec<Filter>>,
    linearised: Linearised,
}

/// What windows say of an effect that was fitted without them, in units of the noise: let it change what is predicted
/// of them by D.
#[derive(Clone, Copy, Debug, Default)]
pub struct Said {
    /// `|D|^2`.
    pub size: f64,
    /// By how much the squares fall with the effect.
    pub drop: f64,
}

impl Add for Said {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        Self { size: self.size + other.size, drop: self.drop + other.drop }
    }
}

impl<'p> Fit<'p> {
    /// This fit, to leave windows out.
    ///
    /// # Errors
    /// [`FitError`].
    pub fn leaving_out(&self) -> Result<LeavingOut<'_, 'p>, FitError> {
        let mut all = self.at_itself();
        let linearised = all.begin()?;
        Ok(LeavingOut { fit: self, filters: all.filters, linearised })
    }

    /// A minimisation that begins at this fit, with what is known of its windows there.
    pub(super) fn at_itself(&self) -> Minimisation<'p> {
        Minimisation { known: self.known(), ..self.minimisation(self.windowed.clone()) }
    }

    /// A minimisation that begins at this fit, in some of its windows.
    fn minimisation(&self, windowed: Windowed) -> Minimisation<'p> {
        let hypothesis = self.hypothesis.clone();
        let minimisation = Minimisation::new(self.problem, hypothesis, windowed, self.substeps);
        Minimisation { noise: self.noise.clone(), ..minimisation }
    }
}

impl LeavingOut<'_, '_> {
    /// The hypothesis with theta fitted as if the windows that are marked had not been recorded.
    ///
    /// # Errors
    /// [`FitError`].
    pub fn learned_without(&self, marked: &[bool], effort: Effort) -> Result<Hypothesis, FitError> {
        let Self { fit, filters, linearised } = self;
        let rest: Vec<bool> = marked.iter().map(|out| !out).collect();
        let (windowed, kept) = fit.windowed.part(&rest);
        let filters = part_of(filters, &kept);
        let known = Some(linearised.part(&kept));
        let left_out = kept.into_iter().map(|k| marked[k]).collect();
        let part = Minimisation { left_out, filters, known, ..fit.minimisation(windowed) };
        Ok(part.run(effort)?.hypothesis)
    }

    /// Residuals of the windows that are marked, which are predicted: theta is fitted as if they had not been
    /// recorded, then their states, and they alone.
    ///
    /// # Errors
    /// [`FitError`].
    pub fn predicted(&self, marked: &[bool], effort: Effort) -> Result<Vec<Vec<f64>>, FitError> {
        self.fit.foretold(self.learned_without(marked, effort)?, marked)
    }

    /// What the windows that are marked say of effect `k`, theta being fitted without them with and without it: by the
    /// windows as they were linearised, and so the more rightly the less it does. None where it vanishes nowhere
    /// that is fitted.
    #[must_use]
    pub fn said_of(&self, k: usize, marked: &[bool]) -> Option<Said> {
        let theta = self.fit.hypothesis.theta();
        let given = self.fit.to_absent(k)?;
        let blocks = &self.linearised.blocks;
        let arrow = Arrow::new(&self.fit.hypothesis, blocks, marked);
        let with = arrow.learned(&theta, &[]).ok()?;
        let without = arrow.learned(&theta, &given).ok()?;
        let change = &with - &without;
        let mut said = Said::default();
        for (block, _) in blocks.iter().zip(marked).filter(|(_, out)| **out) {
            let window = block.eliminated(0.0);
            let drop = window.squares(&without) - window.squares(&with);
            said = said + Said { size: change.dot(&(&window.theta * &change)), drop };
        }
        Some(said)
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
