//! Backward: each effect must be missed, and nothing may do better in its place. And the
//! question whether the catalogue holds what is there at all.

use super::driven::Quieted;
use super::forward::{Look, Tried, rank, says_alike, settles};
use super::{MOST_EFFECTS, Named, Once, Path, Rival, Search, chain, untried};
use crate::candidates::Candidate;
use crate::decision::Decision;
use crate::likelihood::{FULL, Fit, QUICK};
use crate::screen::Screen;
use rayon::prelude::*;

impl<'p> Search<'p> {
    /// Take away what is not missed; replace what something else does better.
    pub(super) fn prune(&self, calibrated: &Fit<'p>, mut path: Path<'p>) -> Path<'p> {
        const ROUNDS: usize = 4;
        for _ in 0..ROUNDS {
            if path.named.len() < 2
                || self.watch.skips(untried::MISSED)
                || !(self.prune_once(&mut path) || self.drop_remainder(calibrated, &mut path))
            {
                break;
            }
        }
        path
    }

    fn prune_once(&self, path: &mut Path<'p>) -> bool {
        self.watch.tell("taking each effect away");
        for k in (0..path.named.len()).rev() {
            let Some(fit) = self.without(&path.fit, k, self.decision.prior_odds) else { continue };
            let missed = path.fit.gain_over(&fit);
            if missed < self.decision.prior_odds {
                path.fit = fit;
                path.named.remove(k);
                return true;
            }
            // An effect of a model that leaves nothing but noise may be beyond doubt.
            let decisive = missed > self.decision.beyond_doubt();
            let settled = path.fit.reduced() < self.decision.noise && decisive;
            // Later effects have shared the work of earlier ones.
            path.named[k].gain = missed;
            // Another law of its kind says what it said: the others are missed as before.
            if settled {
                self.rewrite(path, k, 0.0, |_| true);
            } else if self.swap(path, k, &fit) {
                return true;
            }
        }
        false
    }

    /// A fit without one of its effects, which is missed if that loses more than `least` nats. Where the posterior says that
    /// it is not and this fit that it is, one of the two is wrong, and it is fitted from where the posterior has all else.
    pub(super) fn without(&self, fit: &Fit<'p>, k: usize, least: f64) -> Option<Fit<'p>> {
        let own = fit.without(k, QUICK).ok();
        let is_missed = own.as_ref().is_none_or(|own| fit.gain_over(own) > least);
        let is_said = || fit.missed(k, fit.temperature()).is_none_or(|nats| nats > least);
        if !is_missed || is_said() {
            return own;
        }
        let leapt = fit.leapt_without(k, QUICK);
        own.into_iter().chain(leapt).min_by(|a, b| a.misfit().total_cmp(&b.misfit()))
    }

    /// Take away an effect that says next to nothing of the mismatch, unless the others leave more
    /// than noise and it says most of that, by other variables than theirs: no formula is reality's to a
    /// twentieth, and what is smaller than that beside what the formulas say is their remainder, at
    /// which many can nibble. Nor are several taken away that together say most of what the others leave (`several`).
    fn drop_remainder(&self, calibrated: &Fit<'p>, path: &mut Path<'p>) -> bool {
        let Some(says) = shares(calibrated, &path.fit, self.level) else { return false };
        let small = |k: &usize| says[*k] <= self.decision.relevant;
        let small: Vec<usize> = (0..path.named.len()).filter(small).collect();
        let Some(&k) = small.iter().min_by(|a, b| says[**a].total_cmp(&says[**b])) else {
            return false;
        };
        let others = path.fit.hypothesis.clone().without_all(small.iter().copied());
        if small.len() > 1
            && let Ok(others) = path.fit.refit_alike(others, FULL)
            && self.says_most(&others, &path.fit)
        {
            return false;
        }
        let Ok(fit) = path.fit.without(k, FULL) else { return false };
        let drop = fit.excess() - path.fit.excess();
        let own = Candidate::of(&path.fit.hypothesis.supposed()[k]);
        let others = fit.hypothesis.supposed();
        let missed =
            fit.reduced() > self.decision.noise && !others.iter().any(|e| says_alike(e, &own));
        if missed && drop > self.decision.further_share * fit.excess() {
            return false;
        }
        path.fit = fit;
        path.named.remove(k);
        true
    }

    /// Try the other laws of its kind that are `wanted` in the place of one, which must lead it by more than `least`
    /// nats: beside further effects a simpler one may do.
    pub(super) fn rewrite(
        &self,
        path: &mut Path<'p>,
        k: usize,
        least: f64,
        wanted: impl Fn(&Candidate) -> bool,
    ) -> bool {
        let Some(best) = self.best_variant(&path.fit, k, wanted) else { return false };
        let lead = best.fit.gain_over(&path.fit);
        if lead <= least {
            return false;
        }
        let own = Candidate::of(&path.fit.hypothesis.supposed()[k]);
        let before = std::mem::replace(&mut path.fit, best.fit).hypothesis;
        let mut named = path.named.remove(k);
        named.rivals.retain(|r| r.candidate != best.candidate);
        for rival in &mut named.rivals {
            rival.behind += lead;
        }
        named.rivals.push(Rival { candidate: own, behind: lead, hypothesis: before });
        path.named.push(named);
        true
    }

    /// Try what else could stand in the place of effect `k`; whether what does is of another kind.
    fn swap(&self, path: &mut Path<'p>, k: usize, without: &Fit<'p>) -> bool {
        let short = self.shorter(without);
        let own = Candidate::of(&path.fit.hypothesis.supposed()[k]);
        let mut shortlist = self.look(&short).shortlist;
        shortlist.retain(|s| s.term.candidate != own);
        shortlist.truncate(3);
        let holder = (own, &path.fit.hypothesis);
        let tried = self.fit_instead((without, &short), &shortlist, Some(holder));
        // What stalled on its way is judged where it arrives, if it may still win.
        let temperature = path.fit.temperature();
        let own_evidence = path.fit.log_evidence(temperature);
        let arrived = |t: Tried<'p>| match t.fit.hope(temperature) > own_evidence {
            true => Tried::new(t.candidate, chain::polish(t.fit)),
            false => t,
        };
        let mut tried: Vec<Tried> = tried.into_par_iter().map(arrived).collect();
        rank(&mut tried);
        let Some(best) = tried.into_iter().next() else { return false };
        let lead = best.fit.gain_over(&path.fit);
        if lead < self.decision.tie {
            return false;
        }
        let kin = own.excludes(&best.candidate);
        let gained = best.fit.gain_over(without);
        let before = path.fit.hypothesis.clone();
        path.fit = chain::polish(best.fit);
        path.named.remove(k);
        let rival = Rival { candidate: own, behind: lead, hypothesis: before };
        path.named.push(Named { gain: gained, rivals: vec![rival] });
        !kin
    }

    /// A free curve over one variable, where it beats the catalogue's best.
    pub(super) fn unknown(
        &self,
        base: &Fit<'p>,
        (look, curve): (&Look, &Once<'p>),
        parametric: Path<'p>,
    ) -> Path<'p> {
        if self.watch.skips(untried::CURVES) {
            return parametric;
        }
        // Where a curve finds nothing beside the named effects, they say all that it could.
        let mut left = Screen::new(&parametric.fit).map_or(vec![], |s| s.curves());
        left.retain(|s| self.scope.admits(self.problem.model, &s.term.candidate));
        if left.first().is_none_or(|s| s.gain < self.decision.prior_odds) {
            return parametric;
        }
        let curve = curve.get_or_init(|| self.best_curve(base, look)).clone();
        let Some(curve) = curve else { return parametric };
        self.curve_instead(base, &parametric, curve, look.blur).unwrap_or(parametric)
    }

    /// The catalogue's first effect where it leaves nothing but noise or a free curve does not do
    /// so either; the curve otherwise.
    pub(super) fn curve_at_once(
        &self,
        base: &Fit<'p>,
        (look, curve): (&Look, &Once<'p>),
        first: Path<'p>,
    ) -> (Path<'p>, bool) {
        let noise = self.decision.noise;
        if first.fit.excess() < noise - 1.0 {
            return (first, false);
        }
        let curve = curve.get_or_init(|| self.best_curve(base, look)).clone();
        let Some(curve) = curve else { return (first, false) };
        if curve.excess() > noise - 1.0 || curve.windowed.level > first.fit.windowed.level {
            return (first, false);
        }
        match self.curve_instead(base, &first, curve, look.blur) {
            Some(path) => (path, true),
            None => (first, false),
        }
    }

    /// A path that begins with a curve, or with what it is spelled as, where the curve beats a
    /// path without. Lost inputs move predictions by a mean square of `blur`.
    fn curve_instead(
        &self,
        base: &Fit<'p>,
        parametric: &Path<'p>,
        curve: Fit<'p>,
        blur: f64,
    ) -> Option<Path<'p>> {
        let level = parametric.fit.windowed.level.max(curve.windowed.level);
        let at = |fit: &Fit<'p>| {
            if fit.windowed.level == level {
                return Some(fit.clone());
            }
            fit.at_level(level, QUICK).ok()
        };
        let (learned, named) = (at(&curve)?, at(&parametric.fit)?);
        let lead = learned.gain_over(&named);
        self.watch.tell(&format!("a free curve leads by {lead:.1} nats"));
        if lead < self.decision.prior_odds {
            return None;
        }
        // What they leave is measured by the same noise.
        let alike = learned.driven_by(named.noise.clone(), QUICK).ok()?;
        if !settles(&self.decision, (&named, &alike), self.decision.share, blur)
            || !worth_a_curve(&self.decision, &named, &alike)
        {
            return None;
        }
        let gained = learned.gain_over(base);
        let longest = chain::polish(self.lengthen(learned));
        let h = &parametric.fit.hypothesis;
        let rival = |e| Rival { candidate: Candidate::of(e), behind: lead, hypothesis: h.clone() };
        let named = Named { gain: gained, rivals: h.supposed().iter().map(rival).collect() };
        let path = self.spelled(Path { fit: longest, named: vec![named] });
        // Whether names would do was not asked to the end.
        if self.watch.skips(untried::CURVES) {
            return None;
        }
        Some(self.forward(path, None, MOST_EFFECTS))
    }

    /// The curve that the screening prefers, fitted, where it can rival the catalogue.
    fn best_curve(&self, base: &Fit<'p>, look: &Look) -> Option<Fit<'p>> {
        let best = look.curves.first()?;
        let rival = look.shortlist.first().map_or(0.0, |s| s.gain);
        let Decision { prior_odds, screening_error, .. } = self.decision;
        let room = ((1.0 - screening_error) * rival.abs()).max(prior_odds);
        if best.gain < rival - room || best.gain < prior_odds {
            return None;
        }
        let c = &best.term.candidate;
        let effect = super::effect_of(c, &best.amplitudes, &best.term.shape);
        let fit = self.fit_one(base, &self.shorter(base), effect).ok()?;
        if base.noise.is_none() {
            return Some(self.lengthen(fit));
        }
        let Quieted { fit, gone } = self.quieted(&fit).ok()?;
        if gone { self.exactly(&fit).ok() } else { Some(fit) }
    }
}

/// Of what the effects of a fit say beside a model, the share that is not said without each, in windows that the model
/// follows: in longer ones it runs away, and what is small there is large beside it. What filters correct is measured
/// without them, in the shortest windows.
fn shares(model: &Fit, fit: &Fit, shortest: u32) -> Option<Vec<f64>> {
    let driven = model.noise.is_some() || fit.noise.is_some();
    let level = if driven { shortest } else { model.windowed.level.max(fit.windowed.level) };
    let model = model.undriven(level, QUICK).ok()?;
    let fit = fit.undriven(level, QUICK).ok()?;
    let all = model.excess() - fit.excess();
    let share = |k: usize| {
        let without = fit.without(k, QUICK);
        without.map_or(1.0, |without| (without.excess() - fit.excess()) / all)
    };
    let supposed = 0..fit.hypothesis.supposed().len();
    (all > 0.0).then(|| supposed.map(share).collect())
}

/// Whether a curve is worth giving up a name: it leaves nothing but noise, or little of what the
/// name leaves. A law whose formula is not quite reality's is still the better answer.
pub(super) fn worth_a_curve(decision: &Decision, named: &Fit, learned: &Fit) -> bool {
    let excess = |f: &Fit| f.excess().max(0.0);
    named.hypothesis.supposed().is_empty()
        || learned.excess() < decision.explained - 1.0
        || excess(learned) < 0.5 * decision.share * excess(named)
}
