//! Forward selection.

use super::{Named, Path, Rival, Search, chain, effect_of, term_of, untried};
use crate::candidates::{Candidate, Term};
use crate::decision::Decision;
use crate::likelihood::evidence::common_temperature;
use crate::likelihood::{Fit, FitError, Hypothesis, QUICK, STILL};
use crate::screen::{Scored, Screen};
use lacuna_effects::{Law, Prior, Variable};
use lacuna_plants::Model;
use lacuna_plants::model::ModelEffect;
use rayon::prelude::*;

/// A fit seen through the screening.
#[derive(Clone, Default)]
pub(super) struct Look {
    pub shortlist: Vec<Scored>,
    pub curves: Vec<Scored>,
    /// Nats that the best candidate or free curve promises, whether it may be named or not.
    pub promise: f64,
    /// Mean square by which inputs that were lost move predictions, in units of the noise.
    pub blur: f64,
}

/// What a further effect is.
enum Next<'p> {
    /// It is worth it by itself.
    Whole(Box<Fit<'p>>, Named),
    /// The best that were tried, the first of which is but a part of what is left.
    Part(Vec<Tried<'p>>),
}

/// A candidate fitted in the place of the next effect.
pub(super) struct Tried<'p> {
    pub candidate: Candidate,
    pub fit: Fit<'p>,
    /// By how much its misfit falls where the noise that drives the machine is as large as what it leaves.
    calmed: f64,
}

impl<'p> Tried<'p> {
    pub fn new(candidate: Candidate, fit: Fit<'p>) -> Self {
        let calmed = fit.calmed();
        Self { candidate, fit, calmed }
    }

    /// Log evidence at a temperature, beside noise of its own.
    pub fn log_evidence(&self, temperature: f64) -> f64 {
        self.fit.log_evidence(temperature) + 0.5 * self.calmed / temperature
    }

    /// The same with what its end still promises.
    fn hope(&self, temperature: f64) -> f64 {
        self.fit.hope(temperature) + 0.5 * self.calmed / temperature
    }
}

impl<'p> Search<'p> {
    /// Add effects as long as they are worth it, at most `most`. `look` is a screening of the
    /// path's fit, if there is one.
    pub(super) fn forward(
        &self,
        mut path: Path<'p>,
        mut look: Option<Look>,
        most: usize,
    ) -> Path<'p> {
        while path.named.len() < most {
            let untried = if path.named.is_empty() { untried::EFFECTS } else { untried::FURTHER };
            if self.watch.skips(untried) {
                break;
            }
            self.watch.tell(&format!("looking for effect {}", path.named.len() + 1));
            let seen = look.take().unwrap_or_else(|| self.look(&path.fit));
            let found = match self.next(&mut path, &seen) {
                Some(Next::Whole(fit, one)) => {
                    self.tell("found", &fit);
                    let mut named = std::mem::take(&mut path.named);
                    named.push(one);
                    Some(self.apart(Path { fit: *fit, named }))
                }
                Some(Next::Part(tried)) => self.several(&path, tried, most),
                None => None,
            };
            let Some(found) = found else {
                self.watch.skips(untried);
                break;
            };
            path = found;
        }
        path
    }

    /// The effect that gains most, if it is worth it.
    fn next(&self, path: &mut Path<'p>, look: &Look) -> Option<Next<'p>> {
        let (base, decision) = (&path.fit, &self.decision);
        let further = base.hypothesis.supposed().iter().any(leaves_remainder);
        let mut shortlist = look.shortlist.clone();
        // What cannot settle what is left need not be fitted.
        let nats = 0.5 * base.count as f64;
        if base.reduced() < decision.explained {
            // The screening is nearly exact there: half of what settles is well below it.
            let least = 0.5 * decision.relevant * nats / base.inflation();
            shortlist.retain(|s| s.gain > least);
        } else if further {
            let hope = decision.share * nats * (1.0 - 1.0 / base.inflation());
            shortlist.retain(|s| s.gain > hope || is_undervalued(s));
        }
        let mut tried = self.fit_all(base, &shortlist);
        self.add_variants(&mut tried);
        rank(&mut tried);
        // Where some were not fitted, the best of the others is no name.
        if self.watch.is_late() {
            return None;
        }
        let best = tried.first()?;
        let share = if further { decision.further_share } else { decision.share };
        if !settles(decision, (base, &best.fit), share, look.blur) {
            return further.then_some(Next::Part(tried));
        }
        if further && let Some(better) = self.better_without(base, &best.fit) {
            self.tell("from there", &better);
            path.fit = better;
            let look = self.look(&path.fit);
            return self.next(path, &look);
        }
        let leads = if further {
            let effect = best.fit.hypothesis.supposed().last()?;
            let seen = look.shortlist.iter().find(|s| s.term.candidate == best.candidate);
            self.leads_over_remainders(base, (&best.fit, effect), seen)?
        } else {
            vec![]
        };
        // What the best leaves to noise is what all are judged by.
        let driven = base.noise.is_some();
        let (base, mut tried, gone) = self.quieter(base, tried)?;
        let best = tried.first()?;
        let gained = best.fit.gain_over(&base);
        if gained < decision.prior_odds {
            return None;
        }
        // A random force is a name for what is not understood; noise on a recorded input is not.
        let left = match driven {
            true => !gone && best.fit.noise.as_ref().is_some_and(|noise| !noise.pushes_nothing()),
            false => best.fit.reduced() > decision.explained,
        };
        if leads.iter().any(|l| l.is_beaten(left, decision)) {
            return Some(Next::Part(tried));
        }
        if gone {
            tried = self.undriven(tried, gained);
            tried.first()?;
            if self.watch.is_late() {
                return None;
            }
        }
        let rivals = self.lengthened(tried, gained);
        let named = named(&rivals, gained);
        Some(Next::Whole(Box::new(rivals.into_iter().next()?.fit), named))
    }

    /// The model without its last effect, begun where that took it, where it is better there than at the
    /// optimum it was left in: what a further effect gains must not be a way out of that alone.
    fn better_without(&self, base: &Fit<'p>, with: &Fit<'p>) -> Option<Fit<'p>> {
        let last = with.hypothesis.supposed().len() - 1;
        let without = with.without(last, QUICK).ok()?;
        let better = without.gain_over(base) > self.decision.prior_odds;
        better.then(|| chain::polish(without))
    }

    /// By how much a further effect of a fit leads a force without a formula, on each channel that moves;
    /// `seen` is what the screening said of it.
    pub(super) fn leads_over_remainders(
        &self,
        base: &Fit<'p>,
        (with, effect): (&Fit<'p>, &ModelEffect),
        seen: Option<&Scored>,
    ) -> Option<Vec<Lead>> {
        let screen = Screen::new(base).ok()?;
        // By the shape that the fit found.
        let again = screen.gain(term_of(effect));
        let promised = seen.into_iter().chain(&again).map(|s| s.gain).fold(0.0, f64::max);
        let inflation = base.inflation();
        let fitted = match base.noise {
            Some(_) => promised,
            None => with.log_evidence(inflation) - base.log_evidence(inflation),
        };
        let (model, laws) = (self.problem.model, base.hypothesis.supposed());
        let further = Candidate::of(effect);
        let alike: Vec<usize> =
            laws.iter().filter(|e| says_alike(e, &further)).map(|e| e.channel).collect();
        let lead = |channel: usize| {
            let remainder = screen.remainder(channel)?;
            let acts = laws.iter().any(|e| leaves_remainder(e) && acts_on(model, e, channel));
            let first = !acts && acts_on(model, effect, channel);
            let alike = alike.contains(&channel);
            Some(Lead { acts, first, alike, remainder, promised, fitted: fitted.max(promised) })
        };
        let leads: Vec<Lead> = (0..model.channels()).into_par_iter().filter_map(lead).collect();
        for lead in &leads {
            self.watch.tell(&format!(
                "{}: {:.1} nats before a force without a formula",
                effect.effect.words,
                lead.promised - lead.remainder
            ));
        }
        Some(leads)
    }

    /// What the screening finds worth a fit, and the free curves.
    pub(super) fn look(&self, base: &Fit) -> Look {
        let screen = if self.afresh { Screen::along_measured(base) } else { Screen::new(base) };
        let Ok(screen) = screen else { return Look::default() };
        let supposed = base.hypothesis.supposed();
        let have: Vec<Candidate> = supposed.iter().map(Candidate::of).collect();
        let left = |c: &&Candidate| {
            !have.iter().any(|h| h.excludes(c))
                && !supposed.iter().any(|e| curve_covers(e, c) || moves_curve(e, c))
        };
        let candidates: Vec<Candidate> = self.candidates.iter().filter(left).copied().collect();
        let (mut shortlist, (mut curves, blur)) = rayon::join(
            || screen.score(&candidates),
            || rayon::join(|| screen.curves(), || screen.blurred_by_lost_inputs()),
        );
        let top = shortlist.first().map_or(0.0, |s| s.gain);
        // Near the noise the screening is nearly exact.
        let decision = &self.decision;
        let near = base.reduced() < decision.explained;
        let promising = if near { 0.5 * decision.prior_odds } else { decision.tie };
        let hopeless = ((1.0 - decision.screening_error) * top).min(top - decision.prior_odds);
        // What is taken up by a parameter at the end of what it may be, the screening lets it take up beyond.
        let pressed = !near && base.parameters_at_bound().contains(&true);
        let (mut rank, mut structures) = (0, vec![]);
        shortlist.retain(|s| {
            rank += 1;
            let class = s.term.candidate.effect.class;
            let first = !near && is_undervalued(s) && !structures.contains(&class);
            if first {
                structures.push(class);
            }
            let hopes = rank <= decision.shortlist && (rank <= 3 || s.gain > hopeless);
            (s.gain > promising && (hopes || first)) || (pressed && first)
        });
        // What may not be named is missing all the same.
        let mut excluded = screen.score(&self.excluded);
        excluded.retain(|s| s.gain > promising);
        let all = shortlist.iter().chain(&excluded).chain(&curves);
        let promise = all.map(|s| s.gain).fold(0.0, f64::max);
        curves.retain(|s| self.scope.admits(self.problem.model, &s.term.candidate));
        Look { shortlist, curves, promise, blur }
    }

    /// Fit each of a shortlist on top of a fit: all of them in short windows, and those that can
    /// still win in the fit's own.
    pub(super) fn fit_all(&self, base: &Fit<'p>, shortlist: &[Scored]) -> Vec<Tried<'p>> {
        self.fit_instead((base, &self.shorter(base)), shortlist, None)
    }

    /// The same, `short` being the fit in short windows, of those that can still win against what stands in their
    /// place: a candidate, and the hypothesis with it. What takes up what the formula of a stop leaves is none of them.
    pub(super) fn fit_instead(
        &self,
        (base, short): (&Fit<'p>, &Fit<'p>),
        shortlist: &[Scored],
        holder: Option<(Candidate, &Hypothesis)>,
    ) -> Vec<Tried<'p>> {
        let begun = shortlist.par_iter().map(|s| {
            let begun = self.beginnings(s, &base.hypothesis).into_iter();
            let fits = begun.map(|h| chain::begin(short, h));
            let misfit = |f: &Result<Fit, _>| f.as_ref().map_or(f64::INFINITY, Fit::misfit);
            let best = fits.min_by(|a, b| misfit(a).total_cmp(&misfit(b)));
            (s.term.candidate, best.expect("a fit begins somewhere"))
        });
        let mut tried = self.told(begun.collect());
        if let Some((candidate, with)) = holder
            && let Ok(fit) = chain::begin(short, with.clone())
        {
            tried.push(Tried::new(candidate, fit));
        }
        self.keep_likely(&mut tried, short);
        tried.retain(|t| holder.is_none_or(|(candidate, _)| t.candidate != candidate));
        let grown = tried.into_par_iter().map(|t| (t.candidate, chain::grow(base, short, t.fit)));
        let mut grown = self.told(grown.collect());
        grown.retain(|t| !self.is_confined(&t.fit));
        grown
    }

    /// Where a fit of a further effect begins: beside all that is fitted without it; beside laws as the screening has them
    /// with it, where there are some, since they may have taken its place as far as they could (dry friction that of a dead
    /// zone) and both at once are far from either; and so in a search afresh, there beside what the model was given with,
    /// too. What changes a robot's structure does what wrong parameters of its links do: these have taken its place, and
    /// stand back as the screening says.
    fn beginnings(&self, s: &Scored, base: &Hypothesis) -> Vec<Hypothesis> {
        let Term { candidate, shape } = &s.term;
        let is_structure = matches!(candidate.effect.law, Law::Structure(_));
        let mut beside = vec![];
        if !is_structure {
            beside.push(base.clone());
        }
        if is_structure || self.afresh || !base.supposed().is_empty() {
            let mut screened = base.clone();
            screened.set(&s.theta);
            beside.push(screened);
        }
        if self.afresh {
            beside.push(Hypothesis { parameters: self.problem.model.values(), ..base.clone() });
        }
        let with = |h| self.with(h, effect_of(candidate, &s.amplitudes, shape));
        let mut all: Vec<Hypothesis> = beside.iter().map(with).collect();
        if let Some(amplitudes) = self.expected(candidate, shape) {
            let given = Hypothesis { parameters: self.problem.model.values(), ..base.clone() };
            all.push(self.with(&given, effect_of(candidate, &amplitudes, shape)));
        }
        all
    }

    /// Amplitudes as they are expected of a candidate that has no more of them than there is, as the load behind a drive has of the
    /// inertia: the screening knows of no end, and begins it at that.
    fn expected(&self, candidate: &Candidate, shape: &[f64]) -> Option<Vec<f64>> {
        let Law::Force(law) = candidate.effect.law else { return None };
        let amplitudes = law.amplitudes();
        let effect = effect_of(candidate, &vec![0.0; amplitudes], shape);
        let priors = (candidate.effect.priors)(&self.problem.scales_of(&effect));
        let mean = |prior: &Prior| match *prior {
            Prior::Normal { mean, high, .. } if high.is_finite() => Some(mean),
            _ => None,
        };
        priors[..amplitudes].iter().map(mean).collect()
    }

    /// The fits that succeeded; of the others it is told why.
    fn told(&self, all: Vec<(Candidate, Result<Fit<'p>, FitError>)>) -> Vec<Tried<'p>> {
        let mut tried = Vec::with_capacity(all.len());
        for (candidate, fit) in all {
            match fit {
                Ok(fit) => tried.push(Tried::new(candidate, fit)),
                Err(error) => {
                    self.watch.tell(&format!("{}: {error}", candidate.effect.words));
                }
            }
        }
        tried
    }

    /// Drop what lies so far behind the best that longer windows cannot bring it back: where the
    /// best leaves nothing but noise, likelihoods are what they say.
    fn keep_likely(&self, tried: &mut Vec<Tried<'p>>, short: &Fit<'p>) {
        let temperature = rank(tried);
        let Some(best) = tried.first() else { return };
        let decision = &self.decision;
        let top = best.log_evidence(temperature);
        let mut room = self.settled_room();
        if best.fit.reduced() > decision.noise
            && let Ok(base) = short.glimpse(short.hypothesis.clone(), STILL)
        {
            let gained = top - base.log_evidence(temperature);
            room = room.max((1.0 - decision.screening_error) * gained);
        }
        tried.retain(|t| t.hope(temperature) > top - room);
    }

    /// Nats behind what leaves nothing but noise that no longer windows bring back.
    pub(super) fn settled_room(&self) -> f64 {
        6.0 * self.decision.prior_odds
    }

    /// The same model in windows a quarter as long, where a guess does little harm.
    pub(super) fn shorter(&self, base: &Fit<'p>) -> Fit<'p> {
        // What is corrected by what is measured goes astray in no window.
        if base.noise.is_some() {
            return base.clone();
        }
        let level = (base.windowed.level + 2).min(self.level.max(base.windowed.level));
        if level == base.windowed.level {
            return base.clone();
        }
        base.states_at(level).unwrap_or_else(|_| base.clone())
    }

    pub(super) fn fit_one(
        &self,
        base: &Fit<'p>,
        short: &Fit<'p>,
        effect: ModelEffect,
    ) -> Result<Fit<'p>, FitError> {
        let begun = chain::begin(short, self.with(&base.hypothesis, effect))?;
        chain::grow(base, short, begun)
    }

    /// The best in the longest windows that it follows, with those that came close.
    fn lengthened(&self, tried: Vec<Tried<'p>>, gained: f64) -> Vec<Tried<'p>> {
        let decision = &self.decision;
        let temperature = common_temperature(tried.iter().map(|t| &t.fit));
        let top = tried[0].log_evidence(temperature);
        // Where the best leaves nothing but noise, likelihoods are what they say; where it does
        // not, longer windows may turn the order.
        let least = 3.0 * decision.prior_odds;
        let settled = tried[0].fit.reduced() < decision.noise;
        let room = if settled { least } else { (0.5 * decision.share * gained).max(least) };
        let close: Vec<Tried> =
            tried.into_iter().filter(|t| t.log_evidence(temperature) > top - room).collect();
        let longest = |fit: &Fit<'p>, level, slack| {
            chain::lengthen_at_once(fit, level, decision.noise).unwrap_or_else(|| {
                chain::lengthen_to(fit.clone(), level, (decision.window_misfit, slack))
            })
        };
        let first = longest(&close[0].fit, 0, 1.0);
        let level = first.windowed.level;
        let mut long: Vec<Tried> = close
            .par_iter()
            .enumerate()
            .filter_map(|(k, t)| {
                let fit = match k {
                    0 => first.clone(),
                    _ => longest(&t.fit, level, 10.0),
                };
                (fit.windowed.level == level).then(|| Tried::new(t.candidate, chain::polish(fit)))
            })
            .collect();
        // Rivals that were not brought to the same windows are rivals all the same.
        if self.watch.is_late() {
            return close;
        }
        rank(&mut long);
        // A constant force and what moves a hidden state before it are the same but for the beginning.
        self.prefer(&mut long, |c| self.is_measured(c));
        long
    }

    /// Put first the best that is `wanted`, where it is as good as the best of all.
    pub(super) fn prefer(&self, ranked: &mut [Tried<'p>], wanted: impl Fn(&Candidate) -> bool) {
        let temperature = common_temperature(ranked.iter().map(|t| &t.fit));
        let evidence = |t: &Tried| t.log_evidence(temperature);
        let Some(best) = ranked.first() else { return };
        let least = evidence(best) - self.decision.tie;
        let equal = |t: &Tried| wanted(&t.candidate) && evidence(t) > least;
        if let (false, Some(k)) = (wanted(&best.candidate), ranked.iter().position(equal)) {
            ranked[..=k].rotate_right(1);
        }
    }

    /// Whether something measures the channel that a force acts on.
    fn is_measured(&self, c: &Candidate) -> bool {
        let state = self.problem.model.coordinate_index(c.channel);
        let measured = || self.problem.dataset.output_of_state(state).is_some();
        !matches!(c.effect.law, Law::Force(_)) || measured()
    }
}

/// A further effect beside a force without a formula on a channel, in nats: the laws so far need
/// not be quite reality's, and what they leave belongs to them.
pub(super) struct Lead {
    /// Whether one of the laws so far acts on the channel.
    acts: bool,
    /// Whether none does, and the further effect is the first.
    first: bool,
    /// Whether one acts there by the same variables as the further effect.
    alike: bool,
    /// What the force without a formula promises.
    remainder: f64,
    /// What the further effect promises, as the screening sees it.
    promised: f64,
    /// What the fit says of the effect, where that is more: what is large is not linear.
    fitted: f64,
}

impl Lead {
    /// Whether the force without a formula is the likelier. Where even the further effect leaves more
    /// than noise, such a force is there in any case, on whichever channel, and one more effect beside
    /// it has its price; so it is where a law of the same variables acts, whose formula need not be
    /// quite right. Only of the channel on which the further effect is the first is nobody's remainder left:
    /// there any force beats every formula that is not quite reality's, and one that says most of it is its
    /// name. Where it leaves nothing, either may be all that there is, and where no law acts on the
    /// channel, the force without a formula is one more that has its price.
    pub(super) fn is_beaten(&self, left: bool, decision: &Decision) -> bool {
        if left && self.first {
            return self.promised < decision.further_share * self.remainder;
        }
        // Two formulas of the same variables, and one that is not quite right, are a draw where neither leads by more.
        let price = decision.prior_odds + if self.alike { decision.tie } else { 0.0 };
        if left {
            return self.promised - self.remainder < price;
        }
        let least = match (self.acts, self.alike) {
            (_, true) => price,
            (true, false) => 0.0,
            (false, false) => -decision.prior_odds,
        };
        self.fitted - self.remainder < least
    }
}

/// The first of what was ranked, with the others as its rivals.
pub(super) fn named(ranked: &[Tried], gain: f64) -> Named {
    let temperature = ranked[0].fit.temperature();
    let evidence = |t: &Tried| t.log_evidence(temperature);
    let rival = |t: &Tried| Rival {
        candidate: t.candidate,
        behind: evidence(&ranked[0]) - evidence(t),
        hypothesis: t.fit.hypothesis.clone(),
    };
    Named { gain, rivals: ranked.iter().skip(1).map(rival).collect() }
}

/// The most evidence first; the temperature at which it is compared. All are judged by what the one
/// that fits best leaves: where that is no noise, a law with more freedom must earn it by as much
/// more.
pub(super) fn rank(tried: &mut [Tried]) -> f64 {
    let temperature = common_temperature(tried.iter().map(|t| &t.fit));
    tried.sort_by(|a, b| b.log_evidence(temperature).total_cmp(&a.log_evidence(temperature)));
    temperature
}

/// Whether an effect settles what is left: either the residual comes down to the noise, or a share
/// of what was above it goes. A law whose formula is not quite reality's leaves a remainder that
/// many others can nibble at, and so does noise that comes in bursts; that is no sign of more
/// physics.
///
/// What changes predictions by less than a twentieth of the noise settles nothing, however many
/// samples make it significant: integrators, clocks and rounding do as much. Nor does what changes them by
/// no more than the inputs that were lost with dropped rows (`blur`).
pub(super) fn settles(
    decision: &Decision,
    (before, after): (&Fit, &Fit),
    share: f64,
    blur: f64,
) -> bool {
    let relevant = decision.relevant.max(blur);
    takes_enough(decision, (before.excess(), after.excess()), share, relevant)
}

/// The same of mean square residuals beyond the noise, before and after, of which more than `relevant` must go. Where
/// the residual was no more than noise before, it is so after any effect: noise of another colour than is thought can be
/// nibbled at as the remainder of a formula can, and an effect must take as much of it as a further one of that.
fn takes_enough(
    decision: &Decision,
    (before, left): (f64, f64),
    share: f64,
    relevant: f64,
) -> bool {
    let (drop, noise) = (before - left, decision.noise - 1.0);
    let settled = match before > noise {
        true => left < noise || drop > share * before,
        false => drop > share.max(decision.further_share) * before,
    };
    drop > relevant && settled
}

/// Whether a term may be worth far more than the screening says. There parameters move freely, and those of
/// links do beyond their bounds what a change of structure does: of each class the best is fitted whatever
/// promises more, while more than noise is left.
fn is_undervalued(s: &Scored) -> bool {
    matches!(s.term.candidate.effect.law, Law::Structure(_))
}

/// Whether an effect is a force on a channel.
fn acts_on(model: &Model, e: &ModelEffect, channel: usize) -> bool {
    match e.effect.law {
        Law::Force(law) => e.channel == channel || (law.reacts() && e.other == Some(channel)),
        Law::Structure(_) => model.joints_under(e.effect.acts, e.channel).contains(&channel),
        Law::Input(_) | Law::Sensor(_) => false,
    }
}

/// Whether the formula of an effect need not be quite right: a constant's is.
fn leaves_remainder(e: &ModelEffect) -> bool {
    !Candidate::of(e).is_constant()
}

/// Whether what a candidate says could be the remainder of a law: it acts on the same channel by the same
/// variables, or by some of them. A constant depends on none: no formula leaves it.
pub(super) fn says_alike(e: &ModelEffect, c: &Candidate) -> bool {
    let variables = e.effect.variables(&e.parameters);
    e.channel == c.channel && !c.effect.depends_on.is_empty() && c.says_only(variables)
}

/// Whether an unknown function covers all that a candidate could say: a law of the same single
/// variable on the same channel.
pub(super) fn curve_covers(e: &ModelEffect, c: &Candidate) -> bool {
    if e.over().is_none() || e.channel != c.channel {
        return false;
    }
    let over = e.effect.variables(&e.parameters);
    over.iter().any(|v| c.says_only(&[*v]))
}

/// Whether a candidate but moves an unknown function along its variable: an offset of the sensor of the
/// coordinate that it is over.
fn moves_curve(e: &ModelEffect, c: &Candidate) -> bool {
    e.over() == Some(Variable::Coordinate) && e.channel == c.channel && c.is_offset()
}

#[cfg(test)]
mod tests {
    use super::takes_enough;
    use crate::decision::Decision;

    #[test]
    fn noise_is_not_nibbled_at() {
        let decision = Decision::default();
        let (share, relevant) = (decision.share, decision.relevant);
        let takes =
            |before: f64, left: f64| takes_enough(&decision, (before, left), share, relevant);
        // Down to the noise, or a share of what is above it.
        assert!(takes(0.07, 0.04) && takes(3.0, 0.04) && takes(3.0, 2.0) && !takes(3.0, 2.5));
        // Of noise most, and more than is worth a word.
        assert!(takes(0.02, 0.008) && takes(0.02, -0.01) && !takes(0.02, 0.014));
        assert!(!takes(0.004, 0.002) && takes(-0.01, -0.02));
        // Of a remainder most, too, as before.
        assert!(!takes_enough(&decision, (3.0, 2.0), decision.further_share, relevant));
    }
}
