//! Several further laws at once, of which each alone is but a part of what is left. Beside a formula that says all but
//! a thousandth, two more may be there, and each takes away less than half of the rest; a force without a formula says
//! more than either, for it says both.

use super::forward::{Tried, named, rank, says_alike, settles};
use super::{Path, Search, chain};
use crate::candidates::Candidate;
use crate::likelihood::{Fit, QUICK};
use crate::screen::Screen;
use lacuna_effects::Variable;
use lacuna_plants::model::ModelEffect;

impl<'p> Search<'p> {
    /// A path with the best of what was `tried`, a force of its channel's own motion, and with others of the kind that it
    /// takes beside it to say most of what is left; at most `most` effects in all. Each must say its share of what
    /// those before it leave.
    pub(super) fn several(
        &self,
        path: &Path<'p>,
        mut tried: Vec<Tried<'p>>,
        most: usize,
    ) -> Option<Path<'p>> {
        if path.fit.noise.is_some() || path.fit.reduced() < self.decision.explained {
            return None;
        }
        let mut gained = self.gained_by_own(&path.fit, &mut tried)?;
        let rest = self.rest(&path.fit).filter(Rest::is_within_reach)?;
        let mut found = path.clone();
        while found.named.len() < most && !self.watch.is_late() {
            found.named.push(named(&tried, gained));
            found.fit = chain::polish(tried.swap_remove(0).fit);
            let more = found.named.len() - path.named.len();
            if more > 1 && self.says_rest(&path.fit, &rest, &found.fit) {
                found.fit = self.lengthen(found.fit);
                self.tell("found together", &found.fit);
                return Some(found);
            }
            tried = self.fit_all(&found.fit, &self.look(&found.fit).shortlist);
            rank(&mut tried);
            gained = self.gained_by_own(&found.fit, &mut tried)?;
        }
        None
    }

    /// Nats that the best of what was tried gains, where it is a force of its channel's own motion, or one is as good and
    /// is put first, and says its share.
    fn gained_by_own(&self, base: &Fit<'p>, tried: &mut [Tried<'p>]) -> Option<f64> {
        self.prefer(tried, is_own);
        let best = tried.first().filter(|t| is_own(&t.candidate))?;
        let gained = best.fit.gain_over(base);
        let says = settles(&self.decision, (base, &best.fit), self.decision.share, 0.0);
        (says && gained >= self.decision.prior_odds).then_some(gained)
    }

    /// Whether the effects that a fit has beyond another's say what that leaves.
    pub(super) fn says_most(&self, base: &Fit<'p>, with: &Fit<'p>) -> bool {
        base.noise.is_none() && self.rest(base).is_some_and(|r| self.says_rest(base, &r, with))
    }

    /// Whether the effects that a fit has beyond another's, forces of their channel's own motion, say most of what that
    /// leaves and of what any such force could say; and with the others all of the mismatch to a twentieth, which
    /// formulas that are not reality's do not. What says with another but one curve is worth its price beside that.
    fn says_rest(&self, base: &Fit<'p>, rest: &Rest, with: &Fit<'p>) -> bool {
        let decision = &self.decision;
        let before = base.hypothesis.supposed();
        let is_new = |e: &&ModelEffect| before.iter().all(|b| Candidate::of(b) != Candidate::of(e));
        let further: Vec<_> = with.hypothesis.supposed().iter().filter(is_new).collect();
        let inflation = base.inflation();
        let says = with.log_evidence(inflation) - base.log_evidence(inflation);
        let least = match is_curve(before, &further) {
            true => rest.nats + further.len() as f64 * decision.prior_odds,
            false => (1.0 - decision.share) * rest.nats,
        };
        further.iter().all(|e| is_own(&Candidate::of(e)))
            && settles(decision, (base, with), decision.further_share, 0.0)
            && with.excess() < rest.exact
            && says > least
    }

    /// What a fit leaves.
    fn rest(&self, fit: &Fit<'p>) -> Option<Rest> {
        let named = 0..fit.hypothesis.supposed().len();
        let alone = fit.hypothesis.clone().without_all(named);
        let mismatch = fit.refit(alone, QUICK).ok()?.excess();
        let exact = (self.decision.relevant * mismatch).max(self.decision.noise - 1.0);
        let screen = Screen::new(fit).ok()?;
        let channels = 0..self.problem.model.channels();
        let nats = channels.filter_map(|c| screen.remainder(c)).fold(0.0, f64::max);
        let said = 2.0 * nats * fit.inflation() / fit.count as f64;
        Some(Rest { nats, left: fit.excess() - said, exact })
    }
}

/// Whether a candidate is a force of its channel's own motion.
fn is_own(c: &Candidate) -> bool {
    c.says_only(&[Variable::Coordinate, Variable::Velocity])
}

/// Whether all further effects are with one that was there but a curve over its variable.
fn is_curve(before: &[ModelEffect], further: &[&ModelEffect]) -> bool {
    let over_one = |e: &&ModelEffect| e.effect.variables(&e.parameters).len() == 1;
    let all_alike = |e: &ModelEffect| further.iter().all(|f| says_alike(e, &Candidate::of(f)));
    before.iter().filter(over_one).any(all_alike)
}

/// What is left of a mismatch by laws that need not be quite reality's.
struct Rest {
    /// Nats that the best force of a channel's own motion gains there.
    nats: f64,
    /// Mean square that even such a force leaves.
    left: f64,
    /// Mean square that is noise, or next to nothing of the mismatch.
    exact: f64,
}

impl Rest {
    /// Whether forces of a channel's own motion could say all but next to nothing.
    fn is_within_reach(&self) -> bool {
        self.left < self.exact
    }
}
