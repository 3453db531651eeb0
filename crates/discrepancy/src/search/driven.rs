//! Machines that are driven by more than what was recorded: noise on the recorded inputs, random
//! forces.
//!
//! Where the search leaves more than the outputs' noise, either physics is missing that it did not
//! name, or something else drives the machine. Then it is repeated with filters in the place of
//! free runs: the intensities of what drives are fitted with the model's parameters and again with
//! every effect, and what an effect gains is what it spares them.

use super::forward::{Tried, rank};
use super::{Once, Path, Search, Searched, chain, untried};
use crate::candidates::Candidate;
use crate::likelihood::{FULL, Fit, FitError, ProcessNoise, QUICK, intensity};
use rayon::prelude::*;
use std::sync::Arc;

/// Rounds in which intensities and parameters are fitted in turn.
const ROUNDS: usize = 3;
/// Share of an input's standard deviation above which its noise shows.
const SHOWN: f64 = 0.01;

/// A fit with the noise that drives the machine most likely.
pub(super) struct Quieted<'p> {
    /// Under the noise that was last found.
    pub fit: Fit<'p>,
    /// Whether even that is no longer worth it: nothing drives the machine.
    pub gone: bool,
}

impl<'p> Search<'p> {
    /// The search where the model's parameters leave more than noise: beside what drives the
    /// machine, as long as anything does. None where nothing does from the beginning.
    pub(super) fn search_driven(
        &self,
        exact: &Fit<'p>,
        floor: f64,
        driven: &Once<'p>,
    ) -> Option<Searched<'p>> {
        self.watch.tell("looking for what drives the machine beside its inputs");
        let calibrated = self.calibrated_once(exact, driven).clone()?;
        let found = self.search_from(calibrated, floor, &Once::new());
        let found = Searched { undriven: exact.reduced(), ..found };
        if found.path.fit.noise.is_none() {
            return Some(found);
        }
        let Quieted { fit, gone } = self.quieted(&found.path.fit).ok()?;
        let fit = match gone {
            true => self.exactly(&fit).ok()?,
            false => self.without_faint(&fit, exact).unwrap_or(fit),
        };
        Some(Searched { path: Path { fit, ..found.path }, ..found })
    }

    /// A fit without the noise of inputs that is no more than shows, where nothing but noise of the outputs is left
    /// without it either, in windows no shorter than those of `calibrated`, which leaves more there. An unstable
    /// machine runs away from the least error of a parameter, which a filter calls noise that drives it.
    fn without_faint(&self, fit: &Fit<'p>, calibrated: &Fit<'p>) -> Option<Fit<'p>> {
        let (problem, noise) = (self.problem, fit.noise.as_deref()?);
        let faint = |(j, sd): (usize, &f64)| *sd <= SHOWN * problem.input_deviation(j);
        if !noise.pushes_nothing() || !noise.inputs.iter().enumerate().all(faint) {
            return None;
        }
        let is_noise = |fit: &Fit| fit.reduced() < self.decision.noise;
        let short = fit.undriven(self.level, FULL).ok().filter(is_noise)?;
        let exact = chain::lengthen_while(short, 0, is_noise);
        (exact.windowed.level <= calibrated.windowed.level).then_some(exact)
    }

    /// Whether noise shows on a recorded input: what free runs explain may then be that.
    pub(super) fn shows_noisy_inputs(&self) -> bool {
        let problem = self.problem;
        let shows = |j: usize| problem.input_noise(j) > SHOWN * problem.input_deviation(j);
        (0..problem.model.inputs.len()).any(shows)
    }

    /// Whichever of two searches predicts better, that of free runs or that beside noise that drives
    /// the machine; of those that predict alike, the one that explains more, and of those that explain the same beside
    /// noisy inputs the one that knows of the noise. A filter is blind to
    /// what is wrong in the very sensors that it follows, and to what adds up slowly; free runs take
    /// what drives the machine for physics.
    pub(super) fn likelier(&self, free: Searched<'p>, driven: Searched<'p>) -> Searched<'p> {
        // What names nothing explains nothing: moved parameters take up what drives the machine.
        if free.path.named.is_empty() {
            let nothing = driven.path.named.is_empty();
            return match nothing && self.is_coloured(&free.path.fit, &driven.path.fit) {
                true => Searched { coloured: true, ..free },
                false => driven,
            };
        }
        self.watch.tell("which predicts better");
        let [a, b] = [&free, &driven].map(|s| self.error(&s.path.fit).unwrap_or(f64::INFINITY));
        let exact = self.told_exactly(&free, &driven);
        if self.watch.skips(untried::DRIVEN) {
            return free;
        }
        if let Some((fit, error)) = exact
            && error * self.decision.noise < a.min(b)
        {
            return Searched { path: Path { fit, ..driven.path }, ..driven };
        }
        if self.tells_noisy_inputs(&free, &driven) && b <= a * (1.0 + chance(&free.path.fit)) {
            return driven;
        }
        // Errors are as uncertain as the variance of the noise is.
        if a * self.decision.noise < b
            || (a <= b * self.decision.noise && self.says_more(&free, &driven))
        {
            free
        } else {
            driven
        }
    }

    /// What a search beside noise names and one by free runs does not, fitted for a machine that nothing drives, and the error
    /// of its predictions. Beside noise the laws that there are show where free runs lose their way; a filter then calls noise what is not
    /// quite right of them, and its numbers are those that follow it best, not those that predict best.
    fn told_exactly(&self, free: &Searched<'p>, driven: &Searched<'p>) -> Option<(Fit<'p>, f64)> {
        let Path { fit, named } = &driven.path;
        if named.is_empty() || fit.noise.is_none() || names_alike(free, driven) {
            return None;
        }
        // Where next to nothing drives it, in the same windows; else in those that grow as long as it follows.
        let direct = || fit.driven_by(None, FULL);
        let grown = || Ok(self.lengthen(fit.undriven(self.level, FULL)?));
        let (direct, grown) = rayon::join(direct, grown);
        let with_error = |fit: Fit<'p>| {
            let error = self.error(&fit).ok()?;
            self.tell("for a machine that nothing drives", &fit);
            Some((fit, error))
        };
        let all = [direct, grown].into_iter().flatten().filter_map(with_error);
        all.min_by(|a, b| a.1.total_cmp(&b.1))
    }

    /// Whether a search beside noise names what one by free runs does, and what that leaves beyond the outputs' noise is
    /// all that of inputs: numbers are then as certain as noisy inputs let them be.
    fn tells_noisy_inputs(&self, free: &Searched<'p>, driven: &Searched<'p>) -> bool {
        let same = names_alike(free, driven);
        let is_noise = |s: &Searched| s.path.fit.reduced() < self.decision.noise;
        let noise = driven.path.fit.noise.as_deref();
        same && noise.is_some_and(ProcessNoise::pushes_nothing)
            && is_noise(driven)
            && !is_noise(free)
    }

    /// Whether what a machine leaves that follows its recordings from end to end is noise of its
    /// outputs, of another colour than was estimated: more likely that than what drives it.
    fn is_coloured(&self, free: &Fit<'p>, driven: &Fit<'p>) -> bool {
        let whole = |fit: &Fit| fit.windowed.level == 0;
        let gained = 0.5 * (free.chi2 + free.width() - driven.chi2 - driven.width());
        whole(free) && whole(driven) && self.colour(free) > gained
    }

    /// By how many nats noise of the outputs that is correlated in time makes a residual more likely.
    fn colour(&self, free: &Fit<'p>) -> f64 {
        let all = intensity::coloured(free).unwrap_or_default();
        all.iter().map(|c| c.gain).sum()
    }

    /// Whether a search by free runs explains as much as one beside noise, each with the noise that
    /// it leaves.
    fn says_more(&self, free: &Searched<'p>, driven: &Searched<'p>) -> bool {
        let level = driven.path.fit.windowed.level.max(free.path.fit.windowed.level);
        let at_level = |fit: Fit<'p>| match fit.windowed.level == level {
            true => Ok(fit),
            false => fit.at_level(level, QUICK),
        };
        let under_noise = self.quieted(&free.path.fit).and_then(|Quieted { fit, gone }| {
            at_level(if gone { self.exactly(&fit)? } else { fit })
        });
        match (under_noise, at_level(driven.path.fit.clone())) {
            (Ok(fit), Ok(rival)) => rival.gain_over(&fit) <= self.decision.tie,
            (fit, _) => fit.is_ok(),
        }
    }

    /// The model's parameters, with the noise that drives it; none where no noise does. What drives
    /// a machine shows in windows that are long enough for it to add up.
    fn calibrated_driven(&self, exact: &Fit<'p>) -> Result<Option<Fit<'p>>, FitError> {
        let mut begun = exact.clone();
        let fit = loop {
            let Quieted { fit, gone } = self.quieted(&begun)?;
            if !gone {
                break fit;
            }
            if begun.windowed.level == 0 {
                return Ok(None);
            }
            begun = begun.at_level(begun.windowed.level - 1, QUICK)?;
        };
        let Quieted { fit, gone } = self.quieted(&chain::polish(self.lengthen(fit)))?;
        if gone {
            return Ok(None);
        }
        self.tell("calibrated", &fit);
        Ok(Some(fit))
    }

    /// Whether noise that drives the machine says all that is missing: beside it nothing promises to
    /// be worth its prior odds.
    pub(super) fn is_driven(&self, exact: &Fit<'p>, driven: &Once<'p>) -> bool {
        let driven = self.calibrated_once(exact, driven).as_ref();
        driven.is_some_and(|fit| self.look(fit).promise < self.decision.prior_odds)
    }

    /// Whether noise on inputs that shows it says all that is missing, and no force is needed beside it: free runs
    /// could but take it for physics.
    pub(super) fn says_inputs(&self, exact: &Fit<'p>, driven: &Once<'p>) -> bool {
        if !self.shows_noisy_inputs() {
            return false;
        }
        let noise = self.calibrated_once(exact, driven).as_ref().and_then(|fit| fit.noise.clone());
        noise.is_some_and(|noise| noise.pushes_nothing()) && self.is_driven(exact, driven)
    }

    fn calibrated_once<'o>(&self, exact: &Fit<'p>, driven: &'o Once<'p>) -> &'o Option<Fit<'p>> {
        driven.get_or_init(|| self.calibrated_driven(exact).ok().flatten())
    }

    /// A fit with the intensities that are most likely along it.
    pub(super) fn quieted<'f>(&self, fit: &Fit<'f>) -> Result<Quieted<'f>, FitError> {
        self.quieted_from(fit, None)
    }

    /// The same, sought from intensities that are known already.
    fn quieted_from<'f>(
        &self,
        fit: &Fit<'f>,
        mut near: Option<Arc<ProcessNoise>>,
    ) -> Result<Quieted<'f>, FitError> {
        let mut fit = fit.clone();
        if fit.noise.is_none() && fit.reduced() < self.decision.noise {
            return Ok(Quieted { fit, gone: true });
        }
        for _ in 0..ROUNDS {
            let (noise, gained) = intensity::most_likely(&fit, self.decision.tie, near.as_deref())?;
            if noise.is_none() || gained < self.decision.prior_odds {
                return Ok(Quieted { fit, gone: true });
            }
            let list = |all: &[f64]| -> Vec<String> {
                all.iter().map(|size| format!("{size:.1e}")).collect()
            };
            let (inputs, forces) = (list(&noise.inputs).join(", "), list(&noise.forces).join(", "));
            self.watch.tell(&format!(
                "noise on inputs [{inputs}], on forces [{forces}]: {gained:.0} nats"
            ));
            let settled = fit.noise.as_deref().is_some_and(|old| old.is_near(&noise));
            near = Some(Arc::new(noise));
            fit = fit.driven_by(near.clone(), QUICK)?;
            if settled {
                break;
            }
        }
        Ok(Quieted { fit, gone: false })
    }

    /// A fit and those that were tried on top of it, the best first, under the noise that the best
    /// of them leaves; and whether it leaves none.
    pub(super) fn quieter(
        &self,
        base: &Fit<'p>,
        mut tried: Vec<Tried<'p>>,
    ) -> Option<(Fit<'p>, Vec<Tried<'p>>, bool)> {
        if base.noise.is_none() {
            return Some((base.clone(), tried, false));
        }
        let best = self.quieted_from(&tried.first()?.fit, base.noise.clone());
        let (noise, gone) = best.map_or((base.noise.clone(), false), |b| (b.fit.noise, b.gone));
        // Without what the best of them explains, a filter that trusts the model may run away: it then stays under its
        // own noise, the most likely for it.
        let base = base.driven_by(noise.clone(), QUICK).unwrap_or_else(|_| base.clone());
        tried.truncate(self.decision.shortlist);
        let mut tried = each(tried, |f| f.driven_by(noise.clone(), QUICK));
        rank(&mut tried);
        Some((base, tried, gone))
    }

    /// What was tried, for a machine that nothing drives. What cannot win is left out.
    pub(super) fn undriven(&self, mut tried: Vec<Tried<'p>>, gained: f64) -> Vec<Tried<'p>> {
        let temperature = rank(&mut tried);
        let Some(best) = tried.first() else { return tried };
        let room = (0.5 * self.decision.share * gained).max(3.0 * self.decision.prior_odds);
        let least = best.fit.log_evidence(temperature) - room;
        let direct = best.fit.driven_by(None, FULL);
        tried.retain(|t| t.fit.log_evidence(temperature) >= least);
        let mut tried = match direct {
            Ok(fit) if fit.reduced() < self.decision.noise => {
                let best = Tried::new(tried.remove(0).candidate, fit);
                let mut all = each(tried, |f| f.driven_by(None, FULL));
                all.insert(0, best);
                all
            }
            // Long windows carry too far what is not yet quite right.
            _ => each(tried, |f| f.undriven(self.level, QUICK)),
        };
        rank(&mut tried);
        tried
    }

    /// A fit for a machine that nothing drives, in the longest windows that it follows.
    pub(super) fn exactly(&self, fit: &Fit<'p>) -> Result<Fit<'p>, FitError> {
        match fit.driven_by(None, FULL) {
            Ok(f) if f.reduced() < self.decision.noise => Ok(f),
            _ => Ok(self.lengthen(fit.undriven(self.level, FULL)?)),
        }
    }
}

/// Whether two searches end with the same effects.
fn names_alike(one: &Searched, other: &Searched) -> bool {
    let names = |s: &Searched| -> Vec<Candidate> {
        s.path.fit.hypothesis.supposed().iter().map(Candidate::of).collect()
    };
    let (own, others) = (names(one), names(other));
    own.len() == others.len() && own.iter().all(|name| others.contains(name))
}

/// Standard deviation of a mean square residual, as a share of it: of n samples of which c are worth one
/// `sqrt(2 c / n)`.
fn chance(fit: &Fit) -> f64 {
    let colour = fit.temperature() / fit.inflation();
    (2.0 * colour / fit.count.max(1) as f64).sqrt()
}

/// All that can be fitted again.
fn each<'p>(
    tried: Vec<Tried<'p>>,
    again: impl Fn(&Fit<'p>) -> Result<Fit<'p>, FitError> + Sync,
) -> Vec<Tried<'p>> {
    tried
        .into_par_iter()
        .filter_map(|t| Some(Tried::new(t.candidate, again(&t.fit).ok()?)))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::super::{Named, Path, Search, Searched};
    use crate::likelihood::{FULL, Fit, Hypothesis, Problem, ProcessNoise};
    use crate::{Dataset, Decision, Scope, Watch};
    use lacuna_excitation::{add_gaussian_noise, rng};
    use lacuna_plants::{Model, System, integrate::rk4_sampled};
    use lacuna_recordings::{Column, Recording};
    use std::sync::Arc;

    const MODEL: &str = "name = \"slider\"\n[[input]]\nname = \"u\"\nunit = \"N\"\n\
        [[coordinate]]\nname = \"q\"\nvelocity = \"v\"\nunit = \"m\"\n\
        [mechanics]\nmass = [[\"1\"]]\nforce = [\"u - 0.3*v - 4*q\"]\n";
    const SPRING: &str =
        "[[effect]]\nclass = \"cubic_stiffness\"\nchannel = \"q\"\nstiffness = 2.0\n";

    /// A slider on a hard spring; what it got differs from what was recorded by a tenth.
    fn recording(truth: &Model) -> Recording {
        let time: Vec<f64> = (0..800).map(|k| 0.02 * f64::from(k)).collect();
        let drawn = |sd: f64, of: u64| {
            let mut values = vec![0.0; time.len()];
            add_gaussian_noise(&mut values, sd, &mut rng(5, of)).expect("a deviation");
            values
        };
        let (got, off, noise) = (drawn(10.0, 0), drawn(1.0, 1), drawn(1e-3, 2));
        let system = System::new(truth);
        let start = system.at_rest(&[0.1, 0.0]);
        let motion = rk4_sampled(&system, &start, &time, &got, truth.hold, 4).expect("a motion");
        let q = (0..time.len()).map(|k| motion.state(k)[0] + noise[k]).collect();
        let u = got.iter().zip(&off).map(|(got, off)| got + off).collect();
        let column = |name: &str, values| Column { name: name.into(), values };
        Recording { name: "run".into(), columns: vec![column("q", q), column("u", u)], time }
    }

    fn searched(fit: Fit) -> Searched {
        let named = fit.hypothesis.supposed().iter();
        let named = named.map(|_| Named { gain: 100.0, rivals: vec![] }).collect();
        let (calibrated, path) = (fit.clone(), Path { fit, named });
        let (floor, undriven, promise) = (0.0, calibrated.reduced(), 0.0);
        Searched { calibrated, path, floor, undriven, promise, coloured: false }
    }

    #[test]
    fn noise_of_another_size_counts_for_nothing() {
        let model = Model::from_text(MODEL, "slider.toml").expect("a model");
        let dataset = Dataset::new(&model, &[recording(&model)]).expect("a dataset");
        let problem = Problem::new(&model, &dataset).expect("a problem");
        let exact = Fit::begin(&problem, Hypothesis::of(&model), 0).expect("a fit");
        let beside = |size: f64| {
            let noise = ProcessNoise { inputs: vec![size], ..ProcessNoise::none(&problem) };
            exact.driven_by(Some(Arc::new(noise)), FULL).expect("a fit")
        };
        // What is left is twice and half as large as it should be, then.
        let [right, large, small] = [1.0, 2.0, 0.5].map(beside);
        for off in [large, small] {
            let (lost, calmed) = (off.misfit() - right.misfit(), off.calmed());
            assert!(lost > 100.0 && calmed > 0.8 * lost, "{calmed} of {lost}");
        }
        assert_eq!(exact.calmed(), 0.0);
    }

    #[test]
    fn the_same_law_beside_nothing_but_noise_on_an_input_is_told_with_it() {
        let model = Model::from_text(MODEL, "slider.toml").expect("a model");
        let truth = Model::from_text(&format!("{MODEL}{SPRING}"), "slider.toml").expect("a law");
        let dataset = Dataset::new(&model, &[recording(&truth)]).expect("a dataset");
        let problem = Problem::new(&model, &dataset).expect("a problem");
        let (scope, watch) = (Scope::default(), Watch::default());
        let search = Search::new(&problem, Decision::default(), &scope, &watch);
        let spring = truth.effects[0].clone();
        let h = Hypothesis::of(&model).with(spring.clone(), &problem.scales_of(&spring));
        let free = Fit::begin(&problem, h, 0).expect("a fit");
        let beside = |inputs: f64, forces: f64| {
            let noise =
                ProcessNoise { inputs: vec![inputs], forces: vec![forces], outputs: vec![1.0] };
            searched(free.driven_by(Some(Arc::new(noise)), FULL).expect("a fit"))
        };
        let tells = |driven: &Searched| search.tells_noisy_inputs(&searched(free.clone()), driven);
        assert!(free.reduced() > 2.0, "{}", free.reduced());
        assert!(tells(&beside(1.0, 0.0)));
        // Where a force is pushed too, where more than noise is left, and where the law is another.
        assert!(!tells(&beside(1.0, 0.1)));
        assert!(!tells(&beside(0.5, 0.0)));
        let nothing = free.refit(Hypothesis::of(&model), FULL).expect("a fit");
        let noise = ProcessNoise { inputs: vec![1.0], ..ProcessNoise::none(&problem) };
        let nothing = nothing.driven_by(Some(Arc::new(noise)), FULL).expect("a fit");
        assert!(!tells(&searched(nothing)));
    }
}
