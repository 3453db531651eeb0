//! A fit with one of its effects taken away.

use super::{Effort, Fit, FitError, What};

impl Fit<'_> {
    /// This hypothesis without its effect `k`, fitted from here as a special case.
    ///
    /// # Errors
    /// [`FitError`].
    pub fn without(&self, k: usize, effort: Effort) -> Result<Self, FitError> {
        self.refit_alike(self.hypothesis.clone().without(k), effort)
    }

    /// The same, fitted from where the linearised windows have all else if the effect vanishes. What does the same as
    /// others together is far from where it belongs without them, and a model there may run away. None where it
    /// vanishes nowhere that is fitted, or has no such fit.
    #[must_use]
    pub fn leapt_without(&self, k: usize, effort: Effort) -> Option<Self> {
        let given = self.to_absent(k)?;
        let (hypothesis, windowed) = self.at_itself().leapt(&given).ok()?;
        let there = Self { hypothesis, windowed, linearised: None, ..self.clone() };
        there.without(k, effort).ok()
    }

    /// The steps of its entries of theta with which effect `k` vanishes: of what does nothing the shape stays as it is.
    /// None where it vanishes nowhere that is fitted.
    pub(super) fn to_absent(&self, k: usize) -> Option<Vec<(usize, f64)>> {
        let h = &self.hypothesis;
        let (amplitudes, absent) = self.vanishes_with(k)?;
        let theta = h.theta();
        let own = |i: &usize| matches!(h.free[*i].what, What::Effect(e, _) if e == h.own + k);
        let gone = |i| if amplitudes.contains(&i) { (i, absent - theta[i]) } else { (i, 0.0) };
        Some((0..theta.len()).filter(own).map(gone).collect())
    }
}
