//! The remainder: what is left after the named effects, learned as free curves.

use super::{Search, chain, effect_of, untried};
use crate::likelihood::Fit;
use crate::screen::Screen;

impl<'p> Search<'p> {
    /// The fit with a free curve over the coordinate or velocity of every channel on which one
    /// still gains, the most important first. A curve is never a name: it is what a name leaves.
    #[must_use]
    pub fn with_remainder(&self, fit: &Fit<'p>) -> Fit<'p> {
        let mut fit = fit.clone();
        for _ in 0..self.problem.model.channels() {
            if self.watch.skips(untried::REMAINDER) {
                break;
            }
            self.watch.tell("learning the remainder");
            let Ok(screen) = Screen::new(&fit) else { break };
            let taken = |channel: usize| {
                let mut all = fit.hypothesis.supposed().iter();
                all.any(|e| e.over().is_some() && e.channel == channel)
            };
            let mut curves = screen.curves().into_iter();
            let next = curves
                .find(|s| !taken(s.term.candidate.channel) && s.gain > self.decision.prior_odds);
            let Some(next) = next else { break };
            let effect = effect_of(&next.term.candidate, &next.amplitudes, &next.term.shape);
            let h = self.with(&fit.hypothesis, effect);
            drop(screen);
            let Ok(learned) = fit.refit(h, crate::likelihood::QUICK) else { break };
            let learned = chain::polish(learned);
            // The screening is linear: what it promises must come true.
            if learned.gain_over(&fit) < self.decision.prior_odds {
                break;
            }
            fit = learned;
        }
        fit
    }
}
