//! Robots: the laws of all joints at once.
//!
//! A robot may lack something on each of its joints, and each of its rollouts is dear. A search that adds one effect
//! a round begins far from a machine that lacks twenty: what it follows by then has run away. The forces that the
//! *measured* motion needs tell the laws of all channels together ([`crate::missing_force::laws`]); the likelihood
//! begins from them, finds their values, gives up what is not missed, and looks for what they cannot tell: what
//! has a memory or a time of its own.

use super::driven::Quieted;
use super::folds::Folded;
use super::{Named, Path, Rival, Search, Searched, effect_of, untried};
use crate::against::against_one;
use crate::candidates::Candidate;
use crate::likelihood::{FULL, Fit, FitError, Hypothesis, QUICK};
use crate::missing_force::{Belief, Obeyed, laws};
use crate::screen::Screen;
use lacuna_effects::Acts;
use lacuna_plants::model::ModelEffect;

impl<'p> Search<'p> {
    /// A search that begins with the laws of all joints of a robot; none where there are no such laws, or where none
    /// of them is missed.
    pub(super) fn search_together(&self) -> Option<Searched<'p>> {
        let model = self.problem.model;
        if !self.problem.is_robot() {
            return None;
        }
        self.watch.tell("the laws of the missing forces of all joints");
        let belief = Belief::of(model, self.decision.prior_odds);
        let all = laws(self.problem, &belief, &self.candidates, &self.decision);
        if all.is_empty() {
            return None;
        }
        for law in &all {
            let Candidate { effect, channel, .. } = law.term.candidate;
            let on = model.effect_channel_name(effect, channel);
            let at = effect.acts.at(on);
            self.watch.tell(&format!("forces show {} {at}: {:.0} nats", effect.words, law.gain));
        }
        if let Some(found) = self.at_edges_alone(&all) {
            return Some(found);
        }
        let (still, all) = self.still(all)?;
        self.beginning_with(&still, &all)
    }

    /// The search from a fit with these laws, beside what drives the machine if anything does. A filter that follows a
    /// sensor that is late can be as unstable as a controller that does: nothing is known of noise then, and there may
    /// be none.
    fn beginning_with(&self, fit: &Fit<'p>, all: &[Obeyed]) -> Option<Searched<'p>> {
        let named = self.named(all);
        let Some(Quieted { fit, gone }) = self.or_tell(self.quieted(fit)) else {
            return self.exact(Path { fit: fit.clone(), named });
        };
        let path = Path { fit, named };
        if gone { self.exact(path) } else { self.beside_noise(path) }
    }

    /// The search from the laws that have an edge, and those of other channels, where these say nearly all. Where a
    /// machine runs into a stop its smoothed motion is the least right, and other laws of the channel are taken for
    /// what that leaves; a filter, too, follows a stop that stands elsewhere, and so the laws begin as the
    /// differential equation has them in short windows.
    fn at_edges_alone(&self, all: &[Obeyed]) -> Option<Searched<'p>> {
        let (still, alone) = self.still(self.without_company_of_edges(all)?)?;
        let fit = self.or_tell(still.refit(still.hypothesis.clone(), FULL))?;
        self.tell("at the edges alone", &fit);
        if fit.reduced() > self.decision.explained {
            return None;
        }
        self.beginning_with(&fit, &alone)
    }

    /// The laws that have an edge, and those of channels without one; none where no law has an edge.
    fn without_company_of_edges(&self, all: &[Obeyed]) -> Option<Vec<Obeyed>> {
        let has_edge = |law: &&Obeyed| law.term.candidate.effect.nature.edge;
        let edges = all.iter().filter(has_edge).map(|law| law.term.candidate.channel);
        let edges: Vec<usize> = edges.collect();
        let drives = |input: &usize| {
            edges.iter().any(|c| self.problem.model.inputs_about(*c).contains(input))
        };
        let is_company = |law: &Obeyed| {
            let Candidate { effect, channel, .. } = law.term.candidate;
            if effect.acts == Acts::Inputs { drives(&channel) } else { edges.contains(&channel) }
        };
        let alone = all.iter().filter(|law| has_edge(law) || !is_company(law));
        (!edges.is_empty()).then(|| alone.cloned().collect())
    }

    /// The model with laws as they were found, and which those are: where it runs away even along the windows of the
    /// recordings, the least missed are left out, for what the measured motion hardly tells may have any size.
    fn still(&self, mut all: Vec<Obeyed>) -> Option<(Fit<'p>, Vec<Obeyed>)> {
        while !all.is_empty() && !self.watch.is_late() {
            let h = self.supposing(&all);
            if let Some(fit) = self.or_tell(Fit::still(self.problem, h, self.level)) {
                return Some((fit, all));
            }
            let gains = all.iter().map(|law| law.gain).enumerate();
            let (least, _) = gains.min_by(|a, b| a.1.total_cmp(&b.1))?;
            all.remove(least);
        }
        None
    }

    /// The model with these laws.
    fn supposing(&self, all: &[Obeyed]) -> Hypothesis {
        let add = |h: Hypothesis, law: &Obeyed| {
            self.with(&h, effect_of(&law.term.candidate, &law.amplitudes, &law.term.shape))
        };
        all.iter().fold(Hypothesis::of(self.problem.model), add)
    }

    /// What speaks for each law.
    fn named(&self, all: &[Obeyed]) -> Vec<Named> {
        let h = self.supposing(all);
        let of = |(k, law): (usize, &Obeyed)| {
            let rivals = law.rivals.iter().map(|r| Rival {
                candidate: r.term.candidate,
                behind: r.behind,
                hypothesis: self.with(
                    &h.clone().without(k),
                    effect_of(&r.term.candidate, &r.amplitudes, &r.term.shape),
                ),
            });
            Named { gain: law.gain, rivals: rivals.collect() }
        };
        all.iter().enumerate().map(of).collect()
    }

    /// The search from some laws where nothing but the recorded inputs drives the machine; none where more than
    /// noise is left even beside further effects.
    fn exact(&self, path: Path<'p>) -> Option<Searched<'p>> {
        let fit = path.fit.undriven(path.fit.windowed.level, FULL).ok()?;
        let path = Path { fit: super::chain::polish(self.lengthen(fit)), ..path };
        self.tell("together", &path.fit);
        let is_noise = |path: &Path| path.fit.reduced() < self.decision.noise;
        let path = self.forward(self.missed(path), None, super::MOST_EFFECTS);
        if !is_noise(&path) || path.named.is_empty() || self.watch.is_late() {
            return None;
        }
        let calibrated = self.as_calibrated(&path.fit)?;
        let path = self.prune(&calibrated, path);
        let path = match self.is_doubted(&path) {
            true => self.select(&calibrated, path),
            false => self.simplified(path),
        };
        (!path.named.is_empty()).then(|| searched(calibrated, path))
    }

    /// The search from many laws beside what drives the machine.
    fn beside_noise(&self, path: Path<'p>) -> Option<Searched<'p>> {
        let fit = self.or_tell(path.fit.at_level(self.fewest_windows(), FULL))?;
        let path = self.quiet(Path { fit, ..path })?;
        self.tell("together", &path.fit);
        let laws = path.named.len();
        let path = self.missed(path);
        // A filter that follows a wrong sensor takes more and more of its errors for forces.
        let wrong = |e: &ModelEffect| e.effect.acts == Acts::Sensors;
        let again = path.named.len() < laws && !path.fit.hypothesis.supposed().iter().any(wrong);
        let path = if again { self.quiet(path)? } else { path };
        let known = path.named.len();
        let path = self.forward(path, None, super::MOST_EFFECTS);
        let path = if again || path.named.len() > known { self.missed(path) } else { path };
        let path = match self.rewritten(&path) {
            Some(Rewritten { path, gone }) => {
                if gone && let Some(exact) = self.exact(path.clone()) {
                    return Some(exact);
                }
                // Others may have done what a law that was nearly right left undone, and noise what they did.
                self.quiet(self.missed(path))?
            }
            None => path,
        };
        let calibrated = self.as_calibrated(&path.fit)?;
        // The measured motion may have promised a richer law more than it is worth beside noise.
        let path = self.kept_by_folds(&calibrated, self.simplified(path));
        (!path.named.is_empty()).then(|| searched(calibrated, path))
    }

    /// Laws written as others of their kind where those say more of a channel that a random force is left on, under
    /// the noise that they leave: the forces that the measured motion needs do not always tell one from another, and
    /// the noise that a nearly right one leaves hides what it misses. None where all are the best of their kind.
    fn rewritten(&self, path: &Path<'p>) -> Option<Rewritten<'p>> {
        let noise = path.fit.noise.clone()?;
        let screen = Screen::new(&path.fit).ok()?;
        let (mut better, mut changed) = (path.clone(), false);
        for (k, law) in path.fit.hypothesis.supposed().iter().enumerate().rev() {
            let is_left = noise.forces.get(law.channel).is_some_and(|force| *force > 0.0);
            let kin = is_left.then(|| self.better_kin(&screen, law)).flatten();
            if let Some(kin) = kin
                && !self.watch.skips(untried::FURTHER)
            {
                changed |= self.rewrite(&mut better, k, self.decision.tie, |c| *c == kin);
            }
        }
        drop(screen);
        if !changed {
            return None;
        }
        let Quieted { fit, gone } = self.or_tell(self.quieted(&better.fit))?;
        self.tell("rewritten", &fit);
        Some(Rewritten { path: Path { fit, ..better }, gone })
    }

    /// The other law of its kind that would gain most beside one, if that is beyond doubt: what leads it in its place
    /// gains beside it, and so does every richer law a little.
    fn better_kin(&self, screen: &Screen, law: &ModelEffect) -> Option<Candidate> {
        let own = Candidate::of(law);
        let kin = self.candidates.iter().filter(|c| own.excludes(c) && **c != own);
        let gains = screen.score(&kin.copied().collect::<Vec<_>>());
        let best = gains.first().filter(|best| best.gain > self.decision.beyond_doubt())?;
        Some(best.term.candidate)
    }

    /// A path under the noise that is most likely along it, or under none.
    fn quiet(&self, path: Path<'p>) -> Option<Path<'p>> {
        let Quieted { fit, gone } = self.or_tell(self.quieted(&path.fit))?;
        let fit = if gone { self.or_tell(self.exactly(&fit))? } else { fit };
        Some(Path { fit, ..path })
    }

    /// What was fitted; of a failure it is told why.
    fn or_tell<T>(&self, fit: Result<T, FitError>) -> Option<T> {
        fit.inspect_err(|error| self.watch.tell(&format!("together: {error}"))).ok()
    }

    /// The level of a few windows in all: what is corrected by what is measured goes astray in no window, and those
    /// that are run through side by side are done the sooner.
    fn fewest_windows(&self) -> u32 {
        const SIDE_BY_SIDE: usize = 4;
        SIDE_BY_SIDE.div_ceil(self.problem.dataset.recordings.len()).next_power_of_two().ilog2()
    }

    /// The model's own parameters fitted in the windows of a fit and under its noise.
    fn as_calibrated(&self, fit: &Fit<'p>) -> Option<Fit<'p>> {
        let h = Hypothesis::of(self.problem.model);
        fit.refit(h.clone(), QUICK).ok().or_else(|| Fit::begin(self.problem, h, self.level).ok())
    }

    /// The effects that are missed when they are taken away: most are beyond doubt by what is known of their
    /// amplitudes, those that no amplitude vanishes with by a fit without them; the others are taken away, the least
    /// missed first.
    fn missed(&self, mut path: Path<'p>) -> Path<'p> {
        loop {
            let temperature = path.fit.temperature();
            for (k, named) in path.named.iter_mut().enumerate() {
                let gain = path.fit.missed(k, temperature).or_else(|| path.fit.gained_by(k));
                named.gain = gain.unwrap_or(named.gain);
            }
            let gains = path.named.iter().map(|n| n.gain).enumerate();
            let over = gains.map(|(k, gain)| (k, gain, self.against(&path.fit, k)));
            let Some((k, gain, least)) = over.min_by(|a, b| (a.1 / a.2).total_cmp(&(b.1 / b.2)))
            else {
                return path;
            };
            // Posteriors are not quite normal.
            if gain > 2.0 * least || self.watch.skips(untried::MISSED) {
                return path;
            }
            let Some(fit) = self.without(&path.fit, k, least) else { return path };
            let missed = path.fit.gain_over(&fit);
            if missed > least && !path.fit.vanishes(k) {
                path.named[k].gain = missed;
                return path;
            }
            let named = path.named.remove(k);
            path.fit = match self.taken_up_again(&path.fit, &fit, k) {
                Some(better) => {
                    path.named.push(named);
                    better
                }
                None => fit,
            };
        }
    }

    /// A fit with effect `k`, which it has as its last, begun where the model went without it: beside noise an optimum
    /// hangs on the filters that were made along the way to it. None where the effect is not missed there either,
    /// the way makes no difference, or nothing is filtered.
    fn taken_up_again(&self, with: &Fit<'p>, without: &Fit<'p>, k: usize) -> Option<Fit<'p>> {
        with.noise.as_ref()?;
        let effect = with.hypothesis.supposed()[k].clone();
        let again = without.refit(self.with(&without.hypothesis, effect), FULL).ok()?;
        let better = again.gain_over(with) > self.decision.tie;
        let missed = again.gain_over(without) > self.against(with, k);
        (better && missed && !again.vanishes(again.hypothesis.supposed().len() - 1))
            .then_some(again)
    }

    /// Nats against effect `k` of a fit beside the others.
    fn against(&self, fit: &Fit, k: usize) -> f64 {
        against_one(self.problem.model, &self.decision, fit.hypothesis.supposed(), k)
    }

    fn is_beyond_doubt(&self, named: &Named) -> bool {
        named.gain > self.decision.beyond_doubt()
    }

    /// Whether any effect is not beyond doubt: of such folds ask.
    fn is_doubted(&self, path: &Path) -> bool {
        path.named.iter().any(|n| !self.is_beyond_doubt(n))
    }

    /// The effects that folds do not speak against, where any may be doubted: those that are not beyond doubt by
    /// themselves, and, where none is, all of them together.
    fn kept_by_folds(&self, calibrated: &Fit<'p>, mut path: Path<'p>) -> Path<'p> {
        if !self.is_doubted(&path) || self.watch.skips(untried::FOLDS) {
            return path;
        }
        self.watch.tell("leaving recordings out");
        let (decision, least) = (&self.decision, self.decision.prior_odds);
        let mut folded = Folded::of(path.fit);
        for k in (0..path.named.len()).rev() {
            if self.is_beyond_doubt(&path.named[k]) || self.watch.skips(untried::FOLDS) {
                continue;
            }
            let nats = (path.named[k].gain, self.against(&folded.fit, k));
            if let Some(without) = folded.without_refuted(decision, k, nats) {
                path.named.remove(k);
                folded = Folded::of(without);
            }
        }
        let is_sure = path.named.is_empty() || path.named.iter().any(|n| self.is_beyond_doubt(n));
        let refuted = |alone: &Fit| folded.refuted(decision, alone, least);
        if !is_sure && self.like(&folded.fit, calibrated).is_some_and(|alone| refuted(&alone)) {
            return Path { fit: calibrated.clone(), named: vec![] };
        }
        Path { fit: folded.fit, ..path }
    }
}

/// Some laws written as others of their kind.
struct Rewritten<'p> {
    /// Under the noise that was last found.
    path: Path<'p>,
    /// Whether even that is no longer worth it.
    gone: bool,
}

/// What such a search ends with.
fn searched<'p>(calibrated: Fit<'p>, path: Path<'p>) -> Searched<'p> {
    let undriven = calibrated.reduced();
    let promise = f64::INFINITY;
    Searched { calibrated, path, floor: 1.0, undriven, promise, coloured: false }
}
