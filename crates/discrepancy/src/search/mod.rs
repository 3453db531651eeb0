//! The search: which effects, judged by likelihood.
//!
//! A robot's begins with the laws of all its joints together, which the measured motion tells in the weak form
//! ([`crate::missing_force::laws`], `together`). Where there are none, or what they leave is more than noise,
//! effects are added one by one:
//!
//! 1. The model's parameters alone, in windows that grow as long as the model follows.
//! 2. Every candidate is screened along the fitted trajectory ([`crate::screen`]); the best are
//!    fitted with the differential equation itself, and the one with the most evidence stays if
//!    it is worth its prior odds ([`Decision`]).
//!    Where short windows name nothing of a mismatch, longer ones are tried. A law between two coordinates
//!    is tried as one of its own on each (`apart`).
//! 3. The same again with it, as long as a further effect says more than a force of the channel's own
//!    motion without a formula ([`Screen::remainder`](crate::screen::Screen::remainder)): no law is
//!    exactly reality's; or several that together say most of what such a force does (`several`). Where that leaves
//!    more than noise, a rival of the last effect that bars less from standing beside it begins anew (`barred`).
//! 4. Each effect must be missed when it is taken away, and must beat what else could stand in
//!    its place.
//! 5. Folds of the recordings that are left out must not speak against it, nor against what it
//!    says beyond a simpler law, which must be no draw (`folds`). Recordings that are held out for
//!    proof are not known here.
//! 6. Where more than noise is left, all this once more beside noise that drives the machine, whose
//!    intensities are found again with each effect; what predicts better stays (`driven`). Of a robot this comes
//!    first, and is the end where it leaves nothing but noise of the outputs. Where that is no
//!    answer either, the search is begun afresh, beside a constant force and along the measured motion (`afresh`).
//! 7. A free curve over one variable that beats all that the catalogue offers is an unknown
//!    function, unless one or two laws together follow it as well.

mod afresh;
mod apart;
mod barred;
pub mod chain;
mod confined;
mod driven;
mod folds;
mod forward;
mod prune;
mod rather;
mod remainder;
mod several;
mod spell;
mod together;
mod variants;

use crate::candidates::{Candidate, Term, candidates};
use crate::dataset::Observed;
use crate::decision::Decision;
use crate::likelihood::windows::first_level;
use crate::likelihood::{End, FULL, Fit, FitError, Hypothesis, Problem, QUICK, STILL};
use crate::{DiagnoseError, Scope, Watch};
use forward::Look;
use lacuna_effects::Law;
use lacuna_plants::model::ModelEffect;
use std::cell::OnceCell;

/// Most effects that are searched for: evidence stops the search long before; this guards against
/// a search without an end.
const MOST_EFFECTS: usize = 60;

/// What a search whose time is over has not tried, or not to the end, in words.
mod untried {
    pub const LENGTHS: &str = "windows of other lengths";
    pub const EFFECTS: &str = "the effects of the catalogue";
    pub const FURTHER: &str = "further effects";
    pub const CURVES: &str = "free curves in the place of laws";
    pub const MISSED: &str = "whether each effect is missed when it is taken away";
    pub const FOLDS: &str = "what recordings say that are left out in turn";
    pub const DRIVEN: &str = "noise on the inputs and random forces";
    pub const AFRESH: &str = "a search that begins elsewhere";
    pub const REMAINDER: &str = "what is left, as learned curves";
}

/// What the search found.
pub struct Found<'p> {
    /// The model as it is, states fitted.
    pub nominal: Fit<'p>,
    /// Its parameters fitted.
    pub calibrated: Fit<'p>,
    /// With the effects.
    pub chosen: Fit<'p>,
    /// Whether folds that are left out speak against the calibrated parameters.
    pub calibration_refuted: bool,
    /// Mean square residual of the model over the shortest windows, in units of the noise: where
    /// noise is larger than its estimate (coloured, in bursts, clocks that jitter), it shows here.
    pub floor: f64,
    /// Mean square residual of the model's own physics where nothing else drives the machine.
    pub undriven: f64,
    /// Nats that the best candidate or free curve promises beside the model's own physics, what
    /// is correlated counted once.
    pub promise: f64,
    /// Whether what the model's own physics leaves is noise of the outputs that is correlated in
    /// time.
    pub coloured: bool,
    /// One entry an effect of `chosen`; curves of the remainder stand after them.
    pub named: Vec<Named>,
}

impl Found<'_> {
    /// The same with nothing found: what was looked for in the wrong numbers.
    #[must_use]
    pub fn withheld(self) -> Self {
        let (calibrated, chosen) = (self.nominal.clone(), self.nominal.clone());
        Self { calibrated, chosen, promise: f64::INFINITY, coloured: false, named: vec![], ..self }
    }
}

/// An effect with what speaks for it.
#[derive(Clone, Debug)]
pub struct Named {
    /// Nats that it gains.
    pub gain: f64,
    /// What could stand in its place.
    pub rivals: Vec<Rival>,
}

/// What could stand in the place of an effect.
#[derive(Clone, Debug)]
pub struct Rival {
    /// The rival.
    pub candidate: Candidate,
    /// Nats by which it lies behind.
    pub behind: f64,
    /// The fitted model with it.
    pub hypothesis: Hypothesis,
}

/// A search under way.
#[derive(Clone)]
pub struct Search<'p> {
    problem: &'p Problem<'p>,
    decision: Decision,
    /// What may be named.
    candidates: Vec<Candidate>,
    /// What may not, whatever it promises.
    excluded: Vec<Candidate>,
    scope: &'p Scope,
    /// Level of the first windows.
    level: u32,
    /// Whether it looks along the measured motion, and begins fits in several places.
    afresh: bool,
    watch: &'p Watch<'p>,
}

/// A model with effects, and what speaks for each.
#[derive(Clone)]
struct Path<'p> {
    fit: Fit<'p>,
    named: Vec<Named>,
}

/// A first effect, if there is one.
struct First<'p> {
    /// Without it, in the windows in which it was looked for.
    from: Path<'p>,
    /// What the screening said there.
    look: Look,
    path: Path<'p>,
}

/// A fit that several steps of a search ask for, if there is one: made when it is first asked for.
type Once<'p> = OnceCell<Option<Fit<'p>>>;

/// What a search ends with.
struct Searched<'p> {
    calibrated: Fit<'p>,
    path: Path<'p>,
    floor: f64,
    undriven: f64,
    promise: f64,
    coloured: bool,
}

impl<'p> Search<'p> {
    /// A search among all candidates within a scope.
    #[must_use]
    pub fn new(
        problem: &'p Problem<'p>,
        decision: Decision,
        scope: &'p Scope,
        watch: &'p Watch<'p>,
    ) -> Self {
        let model = problem.model;
        let measured = |state: &usize| problem.dataset.output_of_state(*state).is_some();
        let states = (0..model.channels()).map(|c| model.coordinate_index(c));
        let mut all = candidates(model, &states.filter(measured).collect::<Vec<_>>());
        // A force on an imposed coordinate moves nothing: it must be measured.
        let shown = |c: usize| !model.is_imposed(c) || problem.outputs_of_force(c).next().is_some();
        all.retain(|c| match c.effect.law {
            Law::Force(law) => shown(c.channel) || (law.reacts() && c.other.is_some_and(shown)),
            Law::Input(_) | Law::Sensor(_) | Law::Structure(_) => true,
        });
        let (candidates, excluded) = all.into_iter().partition(|c| scope.admits(model, c));
        let level = first_level(problem.dataset);
        Self { problem, decision, candidates, excluded, scope, level, afresh: false, watch }
    }

    /// Search, and fit what is found.
    ///
    /// # Errors
    /// A model that diverges on the recordings whatever its parameters, and a search that is
    /// cancelled.
    pub fn run(&self, learn_remainder: bool) -> Result<Found<'p>, DiagnoseError> {
        self.conclude(self.search()?, learn_remainder)
    }

    /// Search in a part of the recordings, and fit what is found there to all of them.
    ///
    /// # Errors
    /// As [`Search::run`].
    pub fn run_in(&self, part: &Search, learn_remainder: bool) -> Result<Found<'p>, DiagnoseError> {
        let Searched { path, promise, undriven, coloured, .. } = part.search()?;
        self.watch.tell("fitting all recordings");
        let (calibrated, floor) = self.calibrated()?;
        let path = if path.named.is_empty() {
            Path { fit: calibrated.clone(), named: vec![] }
        } else {
            self.in_all(&calibrated, path)?
        };
        let searched = Searched { calibrated, path, floor, undriven, promise, coloured };
        self.conclude(searched, learn_remainder)
    }

    /// The path of a part of the recordings in all of them, and what shows there alone.
    fn in_all(
        &self,
        calibrated: &Fit<'p>,
        Path { fit: part, named }: Path,
    ) -> Result<Path<'p>, DiagnoseError> {
        let (all, in_part) = (longest(self.problem), longest(part.problem));
        // All recordings are fitted as if nothing else drove the machine: windows that filters correct are no measure.
        let part = match part.noise {
            Some(_) => {
                let shortest = (0..self.level).rev().find(|l| in_part >> l >= all >> self.level);
                part.undriven(shortest.unwrap_or(0), QUICK).unwrap_or(part)
            }
            None => part,
        };
        // In windows no longer than those of the part.
        let level = (0..self.level).find(|l| all >> l <= in_part >> part.windowed.level);
        let begin = |level| Fit::begin(self.problem, part.hypothesis.clone(), level);
        let begun = begin(level.unwrap_or(self.level));
        let begun = begun.or_else(|_| self.watch.necessarily(|| begin(self.level)));
        let begun = match begun {
            Ok(begun) => begun,
            Err(FitError::Cancelled) => return Err(DiagnoseError::Cancelled),
            // What cannot be run along all recordings is in none of them.
            Err(error) => {
                self.watch.tell(&format!("in all recordings: {error}"));
                return Ok(Path { fit: calibrated.clone(), named: vec![] });
            }
        };
        let left = begun.excess();
        let path = Path { fit: self.lengthen(begun), named };
        // What showed in the part need not show in all of them.
        let path = self.simplified(path);
        // And most of what is left, in windows of the same length, need not be what was left there.
        let alike = part.excess() > (1.0 - self.decision.further_share) * left;
        if alike || path.fit.reduced() < self.decision.explained {
            return Ok(path);
        }
        let named = path.named.len();
        let path = self.forward(path, None, MOST_EFFECTS);
        // What was pruned in the part stays as it is.
        Ok(if path.named.len() > named { self.prune(calibrated, path) } else { path })
    }

    /// The effects that folds do not speak against.
    fn search(&self) -> Result<Searched<'p>, DiagnoseError> {
        if let Some(found) = self.search_together() {
            return Ok(found);
        }
        self.watch.tell("fitting the model's own parameters");
        let (begun, floor) = self.begun()?;
        let beside_noise = Once::new();
        // What little is left where the model follows its recordings from end to end is noise of
        // another colour or size than was estimated.
        let follows = |fit: &Fit| {
            let noise = if fit.windowed.level == 0 { floor } else { 1.0 };
            fit.reduced() < self.decision.explained * noise
        };
        // An arm may fall from where a controller held it: free runs run away, whatever they lack, and filters do not.
        let mut driven = None;
        if self.problem.is_robot() && !follows(&begun) {
            driven = self.search_driven(&begun, floor, &beside_noise);
            if let Some(found) = driven.take_if(|found| self.explains(found)) {
                return Ok(found);
            }
        }
        let calibrated = self.calibrated_from(begun);
        let follows = follows(&calibrated);
        let mut driven_once = || {
            let known = driven.take();
            known.or_else(|| self.search_driven(&calibrated, floor, &beside_noise))
        };
        if !follows
            && self.says_inputs(&calibrated, &beside_noise)
            && let Some(driven) = driven_once()
        {
            return Ok(driven);
        }
        let free = self.search_from(calibrated.clone(), floor, &beside_noise);
        if follows || (self.explains(&free) && !self.shows_noisy_inputs()) {
            return Ok(free);
        }
        let driven = if self.watch.is_late() { None } else { driven_once() };
        // What was cut short is not compared with what was not.
        if self.watch.skips(untried::DRIVEN) {
            return Ok(free);
        }
        let is_exact = |s: &Searched| s.path.fit.noise.is_none() && !s.path.named.is_empty();
        let free = match driven.as_ref().is_some_and(is_exact) {
            true => free,
            false => self.begun_afresh(&calibrated, free, &beside_noise),
        };
        Ok(match driven {
            Some(driven) => self.likelier(free, driven),
            None => free,
        })
    }

    /// Whether a search leaves nothing but noise of the outputs beside laws that have a name.
    fn explains(&self, found: &Searched) -> bool {
        let Path { fit, named } = &found.path;
        let by_name = fit.hypothesis.supposed().iter().all(|e| e.over().is_none());
        by_name && !named.is_empty() && fit.noise.is_none() && fit.reduced() < self.decision.noise
    }

    /// The effects beside a calibrated model that folds do not speak against; `driven` is that model beside
    /// what drives the machine.
    fn search_from(&self, calibrated: Fit<'p>, floor: f64, driven: &Once<'p>) -> Searched<'p> {
        if self.watch.skips(untried::EFFECTS) {
            return self.unsearched(calibrated, floor);
        }
        let look = self.look(&calibrated);
        let promise = look.promise * calibrated.inflation() / calibrated.temperature();
        let begun = Path { fit: calibrated, named: vec![] };
        let First { from, look, path: first } = self.first(begun, look, driven);
        let calibrated = from.fit;
        let curve = Once::new();
        let (mut path, is_curve) = self.curve_at_once(&calibrated, (&look, &curve), first);
        if !is_curve && !path.named.is_empty() {
            path = self.unbarred(self.forward(path, None, MOST_EFFECTS));
            path = self.unknown(&calibrated, (&look, &curve), path);
        }
        let path = self.selected(&calibrated, path);
        let undriven = calibrated.reduced();
        Searched { calibrated, path, floor, undriven, promise, coloured: false }
    }

    /// The effects of a path that are missed and that folds do not speak against.
    fn selected(&self, calibrated: &Fit<'p>, path: Path<'p>) -> Path<'p> {
        self.watch.tell("leaving recordings out");
        self.force_rather(self.select(calibrated, self.prune(calibrated, path)))
    }

    /// A search that ended before it began: all that is not noise may be missing.
    fn unsearched(&self, calibrated: Fit<'p>, floor: f64) -> Searched<'p> {
        let undriven = calibrated.reduced();
        let path = Path { fit: calibrated.clone(), named: vec![] };
        let promise = f64::INFINITY;
        Searched { calibrated, path, floor, undriven, promise, coloured: false }
    }

    /// The fits that a diagnosis compares, each at its best.
    fn conclude(
        &self,
        searched: Searched<'p>,
        learn_remainder: bool,
    ) -> Result<Found<'p>, DiagnoseError> {
        let Searched { calibrated, path, floor, undriven, promise, coloured } = searched;
        // The beginnings of recordings are known no better than their noise.
        let chosen = match coloured {
            true => chain::to_the_bottom(path.fit),
            false => self.best_length(path.fit),
        };
        let chosen = chosen.in_finer_steps().unwrap_or(chosen);
        let again = self.watch.necessarily(|| self.like(&chosen, &calibrated));
        // A model that runs away from where its effects follow stays in windows of its own.
        let again = again.unwrap_or(calibrated);
        let nominal = self.as_given(&again, path.named.is_empty())?;
        let calibrated = if path.named.is_empty() { chosen.clone() } else { again };
        // Where effects are named, parameters are no verdict of their own.
        let refuted = path.named.is_empty() && self.refuted(&nominal, &calibrated);
        let chosen = if learn_remainder { self.with_remainder(&chosen) } else { chosen };
        if self.watch.is_cancelled() {
            return Err(DiagnoseError::Cancelled);
        }
        let named = path.named;
        Ok(Found {
            nominal,
            calibrated,
            chosen,
            calibration_refuted: refuted,
            floor,
            undriven,
            promise,
            coloured,
            named,
        })
    }

    /// The model as it was given, in the windows of a calibrated fit: whichever is better of what begins at
    /// that fit's states and what grew as it did, from short windows. Over long ones a small step of a
    /// parameter moves the motion far, and from the states of another motion there is no way back. Where effects are
    /// named (not `alone`), all that is asked of it is how much of the mismatch they say; the first will do.
    fn as_given(&self, calibrated: &Fit<'p>, alone: bool) -> Result<Fit<'p>, DiagnoseError> {
        let held = Hypothesis::of(self.problem.model).held();
        let level = calibrated.windowed.level;
        let near = self.watch.necessarily(|| calibrated.refit(held.clone(), FULL));
        // What filters correct runs away from nothing.
        let follows = |fit: &Fit| fit.noise.is_some() || fit.reduced() < self.decision.explained;
        if near.as_ref().is_ok_and(|fit| !alone || follows(fit)) {
            return near.map_err(|e| self.failed(e));
        }
        let begun = self.watch.necessarily(|| Fit::begin(self.problem, held, self.level));
        let grown = begun.ok().map(|fit| chain::lengthen_to(fit, level, (f64::INFINITY, 1.0)));
        let grown = grown.filter(|fit| fit.windowed.level == level).map(chain::polish);
        match (near, grown) {
            (Ok(near), Some(grown)) if grown.misfit() < near.misfit() => Ok(grown),
            (Err(_), Some(grown)) => Ok(grown),
            (near, _) => near.map_err(|e| self.failed(e)),
        }
    }

    /// The first effect beside what is named, or none. A mismatch that short windows cannot name is
    /// looked for in longer ones, however badly the model follows them, as long as it does not go astray: free
    /// states, above all those that nothing measures, take up in a short window what varies slowly.
    fn first(&self, from: Path<'p>, look: Look, driven: &Once<'p>) -> First<'p> {
        let one = from.named.len() + 1;
        let path = self.forward(from.clone(), Some(look.clone()), one);
        let mut first = First { from, look, path };
        if first.path.named.len() >= one
            || first.from.fit.reduced() < self.decision.explained
            || self.is_driven(&first.from.fit, driven)
        {
            return first;
        }
        let mut longer = first.from.clone();
        while longer.fit.windowed.level > 0 {
            let level = longer.fit.windowed.level - 1;
            let Ok(fit) = longer.fit.at_level(level, FULL) else { break };
            longer.fit = fit;
            self.tell("in longer windows", &longer.fit);
            if chain::is_astray(&longer.fit) {
                break;
            }
            let look = self.look(&longer.fit);
            let path = self.forward(longer.clone(), Some(look.clone()), one);
            let gain = |p: &Path| p.named.get(one - 1).map_or(0.0, |n| n.gain);
            if gain(&path) > gain(&first.path) {
                first = First { from: longer.clone(), look, path };
            }
        }
        first
    }

    /// Why there is no fit: nobody waits for it, or the model diverges.
    fn diverges(&self) -> DiagnoseError {
        if self.watch.is_cancelled() {
            return DiagnoseError::Cancelled;
        }
        DiagnoseError::Diverges { model: self.problem.model.name.clone() }
    }

    fn failed(&self, error: FitError) -> DiagnoseError {
        match error {
            FitError::Cancelled => DiagnoseError::Cancelled,
            _ => self.diverges(),
        }
    }

    /// The model's parameters alone, in the longest windows that it follows; and the mean square
    /// residual over the shortest.
    fn calibrated(&self) -> Result<(Fit<'p>, f64), DiagnoseError> {
        let (begun, floor) = self.begun()?;
        Ok((self.calibrated_from(begun), floor))
    }

    /// The same before it is at its optimum.
    fn begun(&self) -> Result<(Fit<'p>, f64), DiagnoseError> {
        let h = Hypothesis::of(self.problem.model);
        let begun = self.watch.necessarily(|| Fit::begin(self.problem, h, self.level));
        let begun = begun.map_err(|e| self.failed(e))?;
        let floor = begun.inflation();
        // Whether anything is missing shows in windows that are long enough for it to add up.
        Ok((self.lengthen(begun), floor))
    }

    fn calibrated_from(&self, begun: Fit<'p>) -> Fit<'p> {
        let fit = chain::polish(begun);
        self.tell("calibrated", &fit);
        fit
    }

    /// The hypothesis of `own` in the windows of a fit and under its noise: from its states, or,
    /// where the model runs away from those, from its own.
    fn like<'f>(&self, fit: &Fit<'f>, own: &Fit<'f>) -> Option<Fit<'f>> {
        fit.refit(own.hypothesis.clone(), QUICK).ok().or_else(|| {
            let own = own.at_level(fit.windowed.level, QUICK).ok()?;
            own.driven_by(fit.noise.clone(), QUICK).ok()
        })
    }

    /// Tell how a fit went.
    fn tell(&self, what: &str, fit: &Fit) {
        self.watch.tell(&format!(
            "{what}: {} windows a recording, residual {:.2} of the noise{}{}",
            1u32 << fit.windowed.level,
            fit.reduced().sqrt(),
            names(fit),
            if fit.end == End::Converged { String::new() } else { format!(" ({})", fit.end) },
        ));
    }

    /// A hypothesis with one more effect.
    fn with(&self, h: &Hypothesis, effect: ModelEffect) -> Hypothesis {
        let scales = self.problem.scales_of(&effect);
        h.clone().with(effect, &scales)
    }

    /// Whether a candidate may be named beside the effects of a hypothesis.
    fn may_join(&self, h: &Hypothesis, candidate: &Candidate) -> bool {
        let is_barred = h.supposed().iter().any(|e| Candidate::of(e).excludes(candidate));
        !is_barred && self.candidates.contains(candidate)
    }
}

/// The likelihood about the model as it is, in the longest windows that it follows: what the
/// recordings can tell of its parameters.
///
/// # Errors
/// A model that diverges on the recordings.
pub fn about_nominal<'p>(problem: &'p Problem<'p>) -> Result<Fit<'p>, DiagnoseError> {
    let diverges = |_| DiagnoseError::Diverges { model: problem.model.name.clone() };
    let h = Hypothesis::of(problem.model);
    let held = Fit::begin(problem, h.clone().held(), first_level(problem.dataset));
    let held = chain::lengthen(held.map_err(diverges)?, Decision::default().window_misfit);
    held.refit(h, STILL).map_err(diverges)
}

/// Samples of the longest recording.
fn longest(problem: &Problem) -> usize {
    problem.dataset.recordings.iter().map(Observed::len).max().unwrap_or(0)
}

/// The effects of a fit, for a line of progress.
fn names(fit: &Fit) -> String {
    fit.hypothesis.supposed().iter().map(|e| format!(", {}", e.effect.words)).collect()
}

/// What is screened of an effect: all but its amplitudes.
fn term_of(e: &ModelEffect) -> Term {
    let shape = match e.effect.law {
        Law::Force(law) => e.internal().split_off(law.amplitudes()),
        Law::Structure(law) => e.internal().split_off(law.amplitudes()),
        Law::Input(_) => e.parameters.clone(),
        Law::Sensor(_) => vec![],
    };
    Term { candidate: Candidate::of(e), shape }
}

/// An effect with internal parameters of the screening.
fn effect_of(c: &Candidate, amplitudes: &[f64], shape: &[f64]) -> ModelEffect {
    let parameters = match c.effect.law {
        Law::Force(law) => {
            let internal: Vec<f64> = amplitudes.iter().chain(shape).copied().collect();
            law.physical(&internal)
        }
        Law::Structure(_) => amplitudes.iter().chain(shape).copied().collect(),
        Law::Input(_) => shape.to_vec(),
        Law::Sensor(_) => {
            c.effect.nature.ideal.iter().zip(amplitudes).map(|(i, a)| i + a).collect()
        }
    };
    c.with(parameters)
}
