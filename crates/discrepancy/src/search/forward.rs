//! Forward selection.

use super::gain::{RELEVANT, THRESHOLD, Worth, gain};
use super::{Named, Path, Rival, Search, candidate_of, chain, effect_of};
use crate::candidates::{Candidate, Term};
use crate::likelihood::{Fit, Problem};
use crate::screen::{Scored, Screen};
use lacuna_effects::{Law, Variable};
use lacuna_plants::model::ModelEffect;
use rayon::prelude::*;

/// Candidates that are fitted with the differential equation.
const SHORTLIST: usize = 7;
/// Nats that the screening must promise for a fit to be worth its time, about a fit that is far
/// from the noise ...
const PROMISING: f64 = 2.0;
/// ... and about one that is near it, where the screening is nearly exact.
const PROMISING_NEAR: f64 = 5.0;
/// Mean square residual, in units of the noise, that is near it, and one that is at it.
pub(super) const NEAR: f64 = 1.3;
pub(super) const AT_THE_NOISE: f64 = 1.05;
/// Share of the first effect's gain that each further one must reach.
const SHARE_OF_FIRST: f64 = 0.002;

/// Share of what is above the noise that a further effect must explain, that the first must, and
/// that the screening must promise of a further one.
const MOST_OF_IT: f64 = 0.5;
pub(super) const SOME_OF_IT: f64 = 0.2;
const HOPEFUL: f64 = 0.2;
/// Share of the best candidate's gain in short windows by which others may lie behind it.
const BEHIND: f64 = 0.4;

/// A fit seen through the screening.
#[derive(Clone, Default)]
pub(super) struct Look {
    pub shortlist: Vec<Scored>,
    pub curves: Vec<Scored>,
}

/// A candidate fitted in the place of the next effect.
pub(super) struct Tried {
    pub candidate: Candidate,
    pub fit: Fit,
}

impl Search<'_> {
    /// Add effects as long as they are worth it, at most `most`. `first` is what the first effect
    /// gained, where the path has one already; `look` a screening of the path's fit, if there is
    /// one.
    pub(super) fn forward(
        &self,
        mut path: Path,
        mut first: Option<f64>,
        mut look: Option<Look>,
        most: usize,
    ) -> Path {
        while path.named.len() < most {
            (self.progress)(&format!("looking for effect {}", path.named.len() + 1));
            let seen = look.take().unwrap_or_else(|| self.look(&path.fit));
            let Some((next, named)) = self.next(&path, first, &seen) else { break };
            self.tell("found", &next);
            first = first.or(Some(named.gain));
            path.fit = next;
            path.named.push(named);
        }
        path
    }

    /// The effect that gains most, if it is worth it.
    fn next(&self, path: &Path, first: Option<f64>, look: &Look) -> Option<(Fit, Named)> {
        let base = &path.fit;
        let mut shortlist = look.shortlist.clone();
        if first.is_some() {
            // What cannot settle what is left need not be fitted.
            let excess = base.count as f64 * (1.0 - 1.0 / base.inflation());
            shortlist.retain(|s| base.reduced() < NEAR || s.gain > HOPEFUL * 0.5 * excess);
        }
        let mut tried = self.fit_all(base, &shortlist);
        self.add_variants(&mut tried);
        rank(self.problem, &mut tried);
        let needed = THRESHOLD.max(SHARE_OF_FIRST * first.unwrap_or(0.0));
        let best = tried.first()?;
        let gained = gain(self.problem, base, &best.fit);
        let share = if first.is_some() { MOST_OF_IT } else { SOME_OF_IT };
        if gained < needed || !settles(base, &best.fit, share) {
            return None;
        }
        if first.is_some() && best.fit.reduced() > NEAR && !beats_remainder(best, look) {
            return None;
        }
        let log = best.fit.log_evidence() - base.log_evidence();
        let rivals = self.lengthened(tried, log);
        let worth = Worth::of(self.problem, &rivals[0].fit);
        let behind = |t: &Tried| Rival {
            candidate: t.candidate,
            behind: worth.gain(&t.fit, &rivals[0].fit),
            hypothesis: t.fit.hypothesis.clone(),
        };
        let named = Named { gain: gained, rivals: rivals.iter().skip(1).map(behind).collect() };
        Some((rivals.into_iter().next()?.fit, named))
    }

    /// What the screening finds worth a fit, and the free curves.
    pub(super) fn look(&self, base: &Fit) -> Look {
        let Some(screen) = Screen::new(self.problem, base) else { return Look::default() };
        let have: Vec<Candidate> = base.hypothesis.supposed().iter().map(candidate_of).collect();
        let left = |c: &&Candidate| {
            !have.iter().any(|h| h.excludes(c))
                && !base.hypothesis.supposed().iter().any(|e| curve_covers(e, c))
        };
        let candidates: Vec<Candidate> = self.candidates.iter().filter(left).copied().collect();
        let mut shortlist = screen.score(&candidates);
        let top = shortlist.first().map_or(0.0, |s| s.gain);
        let promising = if base.reduced() < NEAR { PROMISING_NEAR } else { PROMISING };
        let mut rank = 0;
        shortlist.retain(|s| {
            rank += 1;
            rank <= SHORTLIST
                && s.gain > promising
                && (rank <= 3 || s.gain > (0.4 * top).min(top - 8.0))
        });
        Look { shortlist, curves: screen.curves() }
    }

    /// Fit each of a shortlist on top of a fit: all of them in short windows, and those that can
    /// still win in the fit's own.
    pub(super) fn fit_all(&self, base: &Fit, shortlist: &[Scored]) -> Vec<Tried> {
        let short = self.shorter(base);
        let begun = shortlist.par_iter().map(|s| {
            let Term { candidate, shape } = &s.term;
            let effect = effect_of(candidate, &s.amplitudes, shape);
            let h = self.with(&base.hypothesis, effect);
            let fit = chain::begin(self.problem, &short, h)?;
            Some(Tried { candidate: *candidate, fit })
        });
        let mut tried: Vec<Tried> = begun.collect::<Vec<_>>().into_iter().flatten().collect();
        self.keep_likely(&mut tried, &short);
        let grown = tried
            .into_par_iter()
            .map(|t| Some(Tried { fit: chain::grow(self.problem, base, t.fit)?, ..t }));
        grown.collect::<Vec<_>>().into_iter().flatten().collect()
    }

    /// Drop what lies so far behind the best that longer windows cannot bring it back.
    fn keep_likely(&self, tried: &mut Vec<Tried>, base: &Fit) {
        rank(self.problem, tried);
        let Some(best) = tried.first().map(|t| t.fit.log_evidence()) else { return };
        let room = (BEHIND * (best - base.log_evidence())).max(60.0);
        tried.retain(|t| t.fit.log_evidence() > best - room);
    }

    /// The same model in windows a quarter as long, where a guess does little harm.
    pub(super) fn shorter(&self, base: &Fit) -> Fit {
        let level = (base.windowed.level + 2).min(self.level.max(base.windowed.level));
        if level == base.windowed.level {
            return base.clone();
        }
        base.states_at(self.problem, level).unwrap_or_else(|| base.clone())
    }

    pub(super) fn fit_one(&self, base: &Fit, short: &Fit, effect: ModelEffect) -> Option<Fit> {
        let begun = chain::begin(self.problem, short, self.with(&base.hypothesis, effect))?;
        chain::grow(self.problem, base, begun)
    }

    /// The best in the longest windows that it follows, with those that came close.
    fn lengthened(&self, tried: Vec<Tried>, gained: f64) -> Vec<Tried> {
        let top = tried[0].fit.log_evidence();
        // Where the best leaves nothing but noise, likelihoods are what they say; where it does
        // not, longer windows may turn the order.
        let room =
            if tried[0].fit.reduced() < AT_THE_NOISE { 30.0 } else { (0.1 * gained).max(30.0) };
        let close: Vec<Tried> =
            tried.into_iter().filter(|t| t.fit.log_evidence() > top - room).collect();
        let first = chain::lengthen(self.problem, close[0].fit.clone());
        let level = first.windowed.level;
        let mut long: Vec<Tried> = close
            .into_par_iter()
            .enumerate()
            .filter_map(|(k, t)| {
                let fit = if k == 0 {
                    first.clone()
                } else {
                    chain::lengthen_to(self.problem, t.fit, level, 10.0)
                };
                (fit.windowed.level == level)
                    .then(|| Tried { fit: chain::polish(self.problem, fit), ..t })
            })
            .collect();
        rank(self.problem, &mut long);
        long
    }
}

/// The most evidence first. All are judged by what the likeliest of them leaves: where that is no
/// noise, a law with more freedom must earn it by as much more.
pub(super) fn rank(problem: &Problem, tried: &mut [Tried]) {
    let likeliest =
        tried.iter().max_by(|a, b| a.fit.log_evidence().total_cmp(&b.fit.log_evidence()));
    let Some(worth) = likeliest.map(|t| Worth::of(problem, &t.fit)) else { return };
    tried.sort_by(|a, b| worth.evidence(&b.fit).total_cmp(&worth.evidence(&a.fit)));
}

/// Whether an effect settles what is left: either the residual comes down to the noise, or a share
/// of what was above it goes. A law whose formula is not quite reality's leaves a remainder that
/// many others can nibble at, and so does noise that comes in bursts; that is no sign of more
/// physics.
///
/// What changes predictions by less than a twentieth of the noise settles nothing, however many
/// samples make it significant: integrators, clocks and rounding do as much.
pub(super) fn settles(before: &Fit, after: &Fit, share: f64) -> bool {
    let (excess, drop) = ((before.reduced() - 1.0).max(0.0), before.reduced() - after.reduced());
    drop > RELEVANT && (after.reduced() < AT_THE_NOISE || drop > share * excess)
}

/// Whether a further effect says more than a learned remainder does. Where even with it the
/// residual is no noise, the formulas so far are not quite reality's, and what is left belongs to
/// them: a curve over the coordinate or velocity of any channel shows how much. A law of one
/// variable is compared with curves over others than its own, which hold it as a special case.
fn beats_remainder(best: &Tried, look: &Look) -> bool {
    let screened = look.shortlist.iter().find(|s| s.term.candidate == best.candidate);
    let Some(gain) = screened.map(|s| s.gain) else { return true };
    let rival = |s: &&Scored| {
        let curve = effect_of(&s.term.candidate, &s.amplitudes, &s.term.shape);
        !curve_covers(&curve, &best.candidate)
    };
    look.curves.iter().find(rival).is_none_or(|curve| gain > curve.gain)
}

/// Whether an unknown function covers all that a candidate could say: a law of the same single
/// variable on the same channel.
pub(super) fn curve_covers(e: &ModelEffect, c: &Candidate) -> bool {
    if e.over().is_none() || e.channel != c.channel {
        return false;
    }
    let Law::Force(law) = c.effect.law else { return false };
    let over = e.effect.variables(&e.parameters);
    let only = |v: Variable| c.effect.depends_on.iter().all(|d| *d == v);
    law.memory() == 0 && c.other.is_none() && over.iter().any(|v| only(*v))
}
