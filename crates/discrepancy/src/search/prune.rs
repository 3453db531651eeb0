//! Backward: each effect must be missed, and nothing may do better in its place. And the
//! question whether the catalogue holds what is there at all.

use super::forward::{AT_THE_NOISE, Look, NEAR, SOME_OF_IT, rank, settles};
use super::gain::{THRESHOLD, Worth, gain};
use super::{MOST_EFFECTS, Named, Path, Rival, Search, candidate_of, chain};
use crate::likelihood::{Fit, QUICK};
use crate::screen::Screen;

/// Nats beyond which an effect of a model that leaves nothing but noise is beyond doubt.
const DECISIVE: f64 = 200.0;
/// Share of what a name leaves above the noise that is little.
const LITTLE: f64 = 0.1;
/// Nats by which another effect must be better to take a place.
const BETTER: f64 = 2.0;

impl Search<'_> {
    /// Take away what is not missed; replace what something else does better.
    pub(super) fn prune(&self, mut path: Path) -> Path {
        const ROUNDS: usize = 4;
        for _ in 0..ROUNDS {
            if path.named.len() < 2 || !self.prune_once(&mut path) {
                break;
            }
        }
        path
    }

    fn prune_once(&self, path: &mut Path) -> bool {
        (self.progress)("taking each effect away");
        for k in (0..path.named.len()).rev() {
            let without = path.fit.hypothesis.clone().without(k);
            let Some(fit) = path.fit.refit(self.problem, without, QUICK) else { continue };
            let missed = gain(self.problem, &fit, &path.fit);
            if missed < THRESHOLD {
                path.fit = fit;
                path.named.remove(k);
                return true;
            }
            let settled = path.fit.reduced() < AT_THE_NOISE && missed > DECISIVE;
            let replaced = if settled { self.rewrite(path, k) } else { self.swap(path, k, &fit) };
            if replaced {
                return true;
            }
            // Later effects have shared the work of earlier ones.
            path.named[k].gain = missed;
        }
        false
    }

    /// Try the other laws of dry friction in the place of one: beside further effects a simpler
    /// one may do.
    fn rewrite(&self, path: &mut Path, k: usize) -> bool {
        let Some(best) = self.best_variant(&path.fit, k) else { return false };
        let lead = Worth::of(self.problem, &best.fit).gain(&path.fit, &best.fit);
        if lead <= 0.0 {
            return false;
        }
        let own = candidate_of(&path.fit.hypothesis.supposed()[k]);
        let before = std::mem::replace(&mut path.fit, best.fit).hypothesis;
        let mut named = path.named.remove(k);
        named.rivals.retain(|r| r.candidate != best.candidate);
        named.rivals.push(Rival { candidate: own, behind: lead, hypothesis: before });
        path.named.push(named);
        true
    }

    /// Try what else could stand in the place of effect `k`.
    fn swap(&self, path: &mut Path, k: usize, without: &Fit) -> bool {
        let short = self.shorter(without);
        let own = candidate_of(&path.fit.hypothesis.supposed()[k]);
        let mut shortlist = self.look(&short).shortlist;
        shortlist.retain(|s| s.term.candidate != own);
        shortlist.truncate(3);
        let mut tried = self.fit_all(without, &shortlist);
        rank(self.problem, &mut tried);
        let Some(best) = tried.into_iter().next() else { return false };
        let worth = Worth::of(self.problem, &best.fit);
        let lead = worth.gain(&path.fit, &best.fit);
        if lead < BETTER {
            return false;
        }
        let gained = worth.gain(without, &best.fit);
        let before = path.fit.hypothesis.clone();
        path.fit = chain::polish(self.problem, best.fit);
        path.named.remove(k);
        let rival = Rival { candidate: own, behind: lead, hypothesis: before };
        path.named.push(Named { gain: gained, rivals: vec![rival] });
        true
    }

    /// A free curve over one variable, where it beats the catalogue's best.
    pub(super) fn unknown(&self, base: &Fit, look: &Look, parametric: Path) -> Path {
        // Where a curve finds nothing beside the named effects, they say all that it could.
        let left = Screen::new(self.problem, &parametric.fit).map_or(vec![], |s| s.curves());
        if left.first().is_none_or(|s| s.gain < THRESHOLD) {
            return parametric;
        }
        let Some(curve) = self.best_curve(base, look) else { return parametric };
        self.curve_instead(base, &parametric, curve).unwrap_or(parametric)
    }

    /// The catalogue's first effect where it leaves nothing but noise or a free curve does not do
    /// so either; the curve otherwise.
    pub(super) fn curve_at_once(&self, base: &Fit, look: &Look, first: Path) -> (Path, bool) {
        if first.fit.reduced() < AT_THE_NOISE {
            return (first, false);
        }
        let Some(curve) = self.best_curve(base, look) else { return (first, false) };
        if curve.reduced() > AT_THE_NOISE || curve.windowed.level > first.fit.windowed.level {
            return (first, false);
        }
        match self.curve_instead(base, &first, curve) {
            Some(path) => (path, true),
            None => (first, false),
        }
    }

    /// A path that begins with a curve, or with what it is spelled as, where the curve beats a
    /// path without.
    fn curve_instead(&self, base: &Fit, parametric: &Path, curve: Fit) -> Option<Path> {
        let level = parametric.fit.windowed.level.max(curve.windowed.level);
        let at = |fit: &Fit| {
            if fit.windowed.level == level {
                return Some(fit.clone());
            }
            fit.at_level(self.problem, level, QUICK)
        };
        let (learned, named) = (at(&curve)?, at(&parametric.fit)?);
        let lead = gain(self.problem, &named, &learned);
        (self.progress)(&format!("a free curve leads by {lead:.1} nats"));
        if lead < THRESHOLD
            || !settles(&named, &learned, SOME_OF_IT)
            || !worth_a_curve(&named, &learned)
        {
            return None;
        }
        let gained = gain(self.problem, base, &learned);
        let longest = chain::polish(self.problem, chain::lengthen(self.problem, learned));
        let h = &parametric.fit.hypothesis;
        let rival = |e| Rival { candidate: candidate_of(e), behind: lead, hypothesis: h.clone() };
        let named = Named { gain: gained, rivals: h.supposed().iter().map(rival).collect() };
        let path = self.spelled(Path { fit: longest, named: vec![named] });
        Some(self.forward(path, Some(gained), None, MOST_EFFECTS))
    }

    /// The curve that the screening prefers, fitted, where it can rival the catalogue.
    fn best_curve(&self, base: &Fit, look: &Look) -> Option<Fit> {
        let best = look.curves.first()?;
        let rival = look.shortlist.first().map_or(0.0, |s| s.gain);
        if best.gain < rival - (0.4 * rival.abs()).max(8.0) || best.gain < THRESHOLD {
            return None;
        }
        let c = &best.term.candidate;
        let effect = super::effect_of(c, &best.amplitudes, &best.term.shape);
        let fit = self.fit_one(base, &self.shorter(base), effect)?;
        Some(chain::lengthen(self.problem, fit))
    }
}

/// Whether a curve is worth giving up a name: it leaves nothing but noise, or little of what the
/// name leaves. A law whose formula is not quite reality's is still the better answer.
pub(super) fn worth_a_curve(named: &Fit, learned: &Fit) -> bool {
    let excess = |f: &Fit| (f.reduced() - 1.0).max(0.0);
    named.hypothesis.supposed().is_empty()
        || learned.reduced() < NEAR
        || excess(learned) < LITTLE * excess(named)
}
