//! Laws between two coordinates, taken apart. One law that acts on both stands for two that have nothing to do
//! with each other where these are alike in size, and is found first, since it does the work of both.

use super::{Path, Search, chain};
use crate::candidates::Candidate;
use crate::likelihood::{FULL, Fit, Hypothesis};
use lacuna_plants::model::ModelEffect;

impl<'p> Search<'p> {
    /// The path with its last effect, a law between two coordinates, as one of its own on each, where these
    /// are worth their prior odds.
    pub(super) fn apart(&self, path: Path<'p>) -> Path<'p> {
        match self.taken_apart(&path.fit) {
            Some((fit, lead)) => self.named_instead(path, fit, lead),
            None => path,
        }
    }

    /// A fit with its last effect taken apart, in the longest windows that it follows then, and the nats by
    /// which it leads.
    fn taken_apart(&self, fit: &Fit<'p>) -> Option<(Fit<'p>, f64)> {
        let h = self.two_for_one(&fit.hypothesis)?;
        let apart = fit.refit(h, FULL).ok()?;
        let lead = apart.gain_over(fit);
        self.watch
            .tell(&format!("a law on each coordinate leads the one between by {lead:.1} nats"));
        if lead <= self.decision.prior_odds {
            return None;
        }
        let longer = if apart.noise.is_some() { apart } else { self.lengthen(apart) };
        Some((chain::polish(longer), lead))
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
            let free = !h.supposed().iter().any(|e| Candidate::of(e).excludes(&of));
            let (parameters, std) = (parameters.clone(), vec![None; parameters.len()]);
            let law = ModelEffect { effect, channel, other: None, parameters, std };
            (free && self.candidates.contains(&of)).then(|| self.with(&h, law))
        };
        on(on(plain, between.channel)?, between.other?)
    }
}
