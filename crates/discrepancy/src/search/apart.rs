//! Laws that do the work of two, taken apart. One between two coordinates stands for two that have nothing to do with each
//! other where these are alike in size; friction that differs between the two directions, for any that does not beside a
//! constant force. Such a law is found first, since it does the work of both.

use super::{Path, Search, chain};
use crate::candidates::Candidate;
use crate::likelihood::{FULL, Fit, Hypothesis, STILL};

impl<'p> Search<'p> {
    /// The path with its last effect as the two that it may stand for, where these are worth their prior odds.
    pub(super) fn apart(&self, path: Path<'p>) -> Path<'p> {
        match self.taken_apart(&path.fit) {
            Some((fit, lead)) => self.named_instead(path, fit, lead),
            None => path,
        }
    }

    /// A fit with its last effect taken apart, in the longest windows that it follows then, and the nats by
    /// which it leads.
    fn taken_apart(&self, fit: &Fit<'p>) -> Option<(Fit<'p>, f64)> {
        let apart = match self.two_for_one(&fit.hypothesis) {
            Some(h) => fit.refit(h, FULL).ok()?,
            None => self.beside_a_constant(fit)?,
        };
        let lead = apart.gain_over(fit);
        self.watch.tell(&format!("two laws lead the one that does their work by {lead:.1} nats"));
        if lead <= self.decision.prior_odds {
            return None;
        }
        let longer = if apart.noise.is_some() { apart } else { self.lengthen(apart) };
        Some((chain::polish(longer), lead))
    }

    /// A fit with its last effect as the best of the laws that are kin to what it is beside a constant force; that law and the
    /// force together leave what the effect itself leaves.
    fn beside_a_constant(&self, fit: &Fit<'p>) -> Option<Fit<'p>> {
        let last = fit.hypothesis.supposed().last()?;
        // Of what has no kin nothing else can stand there.
        last.effect.nature.biased?.effect.nature.kin?;
        let h = self.biased(&fit.hypothesis, fit.hypothesis.supposed().len() - 1)?;
        let plain = fit.refit_alike(h, STILL).ok()?;
        let k = plain.hypothesis.supposed().len() - 1;
        let kin = self.best_variant(&plain, k, |c| !std::ptr::eq(c.effect, last.effect))?;
        Some(kin.fit)
    }

    /// A hypothesis with a law on each of the coordinates between which its last effect acts, in the place of
    /// that; none where there are no such laws to be named.
    fn two_for_one(&self, h: &Hypothesis) -> Option<Hypothesis> {
        let between = h.supposed().last()?;
        let effect = between.effect.nature.apart?;
        let parameters = between.parameters[..effect.parameters.len()].to_vec();
        let plain = h.clone().without(h.supposed().len() - 1);
        let on = |h: Hypothesis, channel: usize| {
            let of = Candidate { effect, channel, other: None };
            self.may_join(&h, &of).then(|| self.with(&h, of.with(parameters.clone())))
        };
        on(on(plain, between.channel)?, between.other?)
    }
}
