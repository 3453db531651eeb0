//! A fitted hypothesis, and its ways to other windows.

use super::end::{End, FitError};
use super::minimise::{Effort, Linearised, Minimisation};
use super::normal::{Block, Precision};
use super::problem;
use super::sweep::{Run, Starts};
use super::windows::{Window, windows};
use super::{Filter, Hypothesis, Problem, ProcessNoise, What};
use lacuna_effects::{Law, Parameter};
use lacuna_plants::Substeps;
use lacuna_plants::model::{ModelEffect, System};
use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;
use std::borrow::Cow;
use std::sync::Arc;

/// Windows of one level with their states, recording by recording.
#[derive(Clone, Debug)]
pub struct Windowed {
    /// 2^level windows a recording.
    pub level: u32,
    /// The windows of each recording.
    pub windows: Vec<Vec<Window>>,
    /// Their states.
    pub starts: Vec<Starts>,
}

/// A hypothesis fitted to the recordings of a problem, as far as its [`End`] says.
#[derive(Clone)]
pub struct Fit<'p> {
    /// What it is fitted to.
    pub problem: &'p Problem<'p>,
    /// The fitted hypothesis.
    pub hypothesis: Hypothesis,
    /// Windows and states.
    pub windowed: Windowed,
    /// Runge-Kutta steps a sample.
    pub substeps: Substeps,
    /// What drives the machine beside what was recorded; nothing where there is none.
    pub noise: Option<Arc<ProcessNoise>>,
    /// A filter a window, recording by recording; empty where no noise drives the machine.
    pub filters: Arc<[Vec<Filter>]>,
    /// Sum of squares of the residual in units of the noise: of the innovations in units of their
    /// standard deviation.
    pub chi2: f64,
    /// Pull of the priors.
    pub penalty: f64,
    /// Number of residuals.
    pub count: usize,
    /// Residuals in units of the noise, a series a window.
    pub residuals: Arc<[Vec<f64>]>,
    /// What is known of theta in units of its prior.
    pub precision: Precision,
    /// By how much the misfit would yet fall if the residual were linear.
    pub promised: f64,
    /// Why it went no further.
    pub end: End,
    /// Its windows as they were linearised where it ended, where the same fit can go on from there.
    pub(super) linearised: Option<Arc<[Block]>>,
}

/// Least misfit for which noise of another size is looked at: what a nat is.
const LEAST_CALMED: f64 = 2.0;

/// Nothing moves.
pub const STILL: Effort = Effort { steps: 0, least: 0.0, undamped: false };
/// A few steps, enough to compare.
pub const QUICK: Effort = Effort { steps: 6, least: 0.3, undamped: false };
/// To the optimum.
pub const FULL: Effort = Effort { steps: 15, least: 0.05, undamped: false };
/// From there to where the priors have what the data hardly tell.
pub const LAST: Effort = Effort { undamped: true, ..FULL };

impl Windowed {
    /// Windows of a level that begin where the recordings' smoothed motion is.
    #[must_use]
    pub fn smoothed(problem: &Problem, level: u32) -> Self {
        let mut by_recording = vec![Vec::new(); problem.dataset.recordings.len()];
        for w in windows(problem.dataset, level) {
            by_recording[w.recording].push(w);
        }
        let starts = by_recording
            .iter()
            .map(|list| Starts {
                machine: list
                    .iter()
                    .map(|w| problem.smoothed[w.recording].state(w.range.start).to_vec())
                    .collect(),
                memory: vec![],
            })
            .collect();
        Self { level, windows: by_recording, starts }
    }

    /// Windows of another level: those that begin at the same sample keep their state, others
    /// begin on the smoothed motion, or, in the entries of the machine's state that are `known`, on `path`.
    #[must_use]
    fn at(&self, problem: &Problem, level: u32, (path, known): (&[Vec<f64>], &[usize])) -> Self {
        let mut next = Self::smoothed(problem, level);
        let width = problem.model.machine_states();
        for (r, starts) in next.starts.iter_mut().enumerate() {
            starts.memory.clone_from(&self.starts[r].memory);
            let stride = width + starts.memory.len();
            for (w, x) in next.windows[r].iter().zip(&mut starts.machine) {
                let same = self.windows[r].iter().position(|o| o.range.start == w.range.start);
                if let Some(k) = same {
                    x.clone_from(&self.starts[r].machine[k]);
                } else if let Some(state) =
                    path.get(r).and_then(|p| p.get(w.range.start * stride..))
                {
                    for &i in known {
                        x[i] = state.get(i).copied().unwrap_or(x[i]);
                    }
                }
            }
        }
        next
    }

    /// The windows that are `marked`, with those of the same recordings that memory runs through;
    /// and which they are.
    pub(super) fn part(&self, marked: &[bool]) -> (Self, Vec<usize>) {
        let mut part = self.clone();
        let (mut kept, mut first) = (vec![], 0);
        for (windows, starts) in part.windows.iter_mut().zip(&mut part.starts) {
            let own = &marked[first..first + windows.len()];
            let whole = !starts.memory.is_empty() && own.contains(&true);
            let stays: Vec<usize> = (0..own.len()).filter(|&k| whole || own[k]).collect();
            *windows = stays.iter().map(|&k| windows[k].clone()).collect();
            starts.machine = stays.iter().map(|&k| starts.machine[k].clone()).collect();
            if windows.is_empty() {
                starts.memory.clear();
            }
            kept.extend(stays.iter().map(|&k| first + k));
            first += own.len();
        }
        (part, kept)
    }

    /// The same for effects whose memory begins at rest where it did not exist before.
    fn fitted_to(mut self, problem: &Problem, h: &Hypothesis) -> Self {
        let system = System::with(problem.model, &h.parameters, &h.effects);
        let machine = problem.model.machine_states();
        for starts in &mut self.starts {
            let rest = system.at_rest(&starts.machine[0]);
            let known = starts.memory.len().min(rest.len() - machine);
            starts.memory.truncate(known);
            starts.memory.extend_from_slice(&rest[machine + known..]);
        }
        self
    }
}

impl<'p> Fit<'p> {
    /// Fit a hypothesis from the smoothed motion in windows of a level: first the states alone,
    /// then everything.
    ///
    /// # Errors
    /// [`FitError`].
    pub fn begin(
        problem: &'p Problem<'p>,
        hypothesis: Hypothesis,
        level: u32,
    ) -> Result<Self, FitError> {
        let states = Effort { steps: 4, least: 1.0, undamped: false };
        let steps = problem.substeps(&hypothesis.parameters, &hypothesis.effects, false);
        in_finer_steps_at_need(steps, |steps| {
            let windowed = Windowed::smoothed(problem, level);
            let (h, driven) = (hypothesis.clone(), (None, steps));
            let held = minimise(problem, h.clone().held(), windowed, driven.clone(), states)?;
            minimise(problem, h, held.windowed, driven, FULL)
        })
    }

    /// A hypothesis as it is, along the smoothed motion in windows of a level: what filters begin from.
    ///
    /// # Errors
    /// [`FitError`].
    pub fn still(
        problem: &'p Problem<'p>,
        hypothesis: Hypothesis,
        level: u32,
    ) -> Result<Self, FitError> {
        let windowed = Windowed::smoothed(problem, level);
        let steps = problem.substeps(&hypothesis.parameters, &hypothesis.effects, true);
        minimise(problem, hypothesis, windowed, (None, steps), STILL)
    }

    /// Fit the same hypothesis for a machine that is driven by noise.
    ///
    /// # Errors
    /// [`FitError`].
    pub fn driven_by(
        &self,
        noise: Option<Arc<ProcessNoise>>,
        effort: Effort,
    ) -> Result<Self, FitError> {
        let (h, windowed) = (self.hypothesis.clone(), self.windowed.clone());
        let steps = self.steps_under(noise.is_some());
        minimise(self.problem, h, windowed, (noise, steps), effort)
    }

    /// By how much the misfit falls where all noise that drives the machine is larger or smaller by what this fit leaves: a law
    /// that says more leaves less of it, and one that frees a coordinate of inertia has the same force push it further.
    /// 0 where none drives it, or next to nothing could be gained.
    #[must_use]
    pub fn calmed(&self) -> f64 {
        // Of innovations that are all due to it, chi2 = n s^2, its likeliest size is s times as large; where outputs are
        // noisy too, not quite, and once more.
        const ROUNDS: usize = 4;
        let mut best = Cow::Borrowed(self);
        for _ in 0..ROUNDS {
            let (Some(noise), left) = (&best.noise, best.reduced()) else { break };
            let most = best.count as f64 * (left - 1.0 - left.ln());
            if most.is_nan() || most <= LEAST_CALMED {
                break;
            }
            let own = Arc::new(noise.times(left.sqrt()));
            match best.driven_by(Some(own), STILL) {
                Ok(calmer) if calmer.misfit() < best.misfit() - LEAST_CALMED => {
                    best = Cow::Owned(calmer);
                }
                _ => break,
            }
        }
        self.misfit() - best.misfit()
    }

    /// Fit another hypothesis from here, in the same windows.
    ///
    /// # Errors
    /// [`FitError`].
    pub fn refit(&self, h: Hypothesis, effort: Effort) -> Result<Self, FitError> {
        let steps = self.problem.substeps(&h.parameters, &h.effects, self.noise.is_some());
        self.refit_in(steps, h, effort)
    }

    /// Fit a special case of this hypothesis from here, in the same windows and by the same steps: it needs no finer
    /// ones.
    ///
    /// # Errors
    /// [`FitError`].
    pub fn refit_alike(&self, h: Hypothesis, effort: Effort) -> Result<Self, FitError> {
        self.refit_in(self.substeps, h, effort)
    }

    /// The same hypothesis fitted on from here by such steps; as it is where they are its own, or where it has no fit
    /// by them.
    pub(super) fn by_steps(&self, steps: Substeps) -> Cow<'_, Self> {
        if steps == self.substeps {
            return Cow::Borrowed(self);
        }
        let fit = self.refit_in(steps, self.hypothesis.clone(), QUICK);
        fit.map_or(Cow::Borrowed(self), Cow::Owned)
    }

    fn refit_in(&self, steps: Substeps, h: Hypothesis, effort: Effort) -> Result<Self, FitError> {
        let windowed = self.kept_memory(&h);
        minimise(self.problem, h, windowed, (self.noise.clone(), steps), effort)
    }

    /// Fit the same hypothesis further, in the same windows.
    ///
    /// # Errors
    /// [`FitError`].
    pub fn further(&self, effort: Effort) -> Result<Self, FitError> {
        let (h, windowed) = (self.hypothesis.clone(), self.windowed.clone());
        let steps = self.problem.substeps(&h.parameters, &h.effects, self.noise.is_some());
        let known = self.known().filter(|_| steps == self.substeps);
        let begun = begun(self.problem, h, windowed, (self.noise.clone(), steps));
        Minimisation { known, ..begun }.run(effort)
    }

    /// Its windows as they were linearised where it ended, where the same fit can go on from there.
    pub(super) fn known(&self) -> Option<Linearised> {
        let blocks = self.linearised.clone()?;
        Some(Linearised { blocks, residuals: self.residuals.clone() })
    }

    /// The same fit along paths that are integrated in finer steps, where it goes astray in its own: its parameters
    /// stay, and what is known of them is right.
    #[must_use]
    pub fn in_finer_steps(&self) -> Option<Self> {
        let (h, windowed) = (self.hypothesis.clone(), self.windowed.clone());
        let noise = self.noise.clone();
        let steps = self.problem.finer_substeps(&h.parameters, &h.effects, noise.is_some())?;
        minimise(self.problem, h, windowed, (noise, steps), STILL).ok()
    }

    /// Fit the same hypothesis in windows of another level.
    ///
    /// # Errors
    /// [`FitError`].
    pub fn at_level(&self, level: u32, effort: Effort) -> Result<Self, FitError> {
        let windowed = self.windows_at(level)?;
        let driven = (self.noise.clone(), self.substeps);
        minimise(self.problem, self.hypothesis.clone(), windowed, driven, effort)
    }

    /// Fit the same hypothesis in windows of another level for a machine that no noise drives.
    ///
    /// # Errors
    /// [`FitError`].
    pub fn undriven(&self, level: u32, effort: Effort) -> Result<Self, FitError> {
        let (h, windowed) = (self.hypothesis.clone(), self.windows_at(level)?);
        minimise(self.problem, h, windowed, (None, self.steps_under(false)), effort)
    }

    /// Runge-Kutta steps a sample where noise drives the machine, or none does.
    fn steps_under(&self, noise: bool) -> Substeps {
        if noise == self.noise.is_some() {
            return self.substeps;
        }
        self.problem.substeps(&self.hypothesis.parameters, &self.hypothesis.effects, noise)
    }

    /// Windows of another level; what nothing measures begins on this fit's path.
    fn windows_at(&self, level: u32) -> Result<Windowed, FitError> {
        let hidden = self.problem.hidden();
        let path = if hidden.is_empty() { vec![] } else { self.paths()? };
        Ok(self.windowed.at(self.problem, level, (&path, hidden)))
    }

    /// Fit the states alone for a machine that no noise drives, in windows of another level that begin on this fit's path: what
    /// follows its recordings knows better where the machine was than what smooths them.
    ///
    /// # Errors
    /// [`FitError`].
    pub fn held_along(&self, level: u32, effort: Effort) -> Result<Self, FitError> {
        let all: Vec<usize> = (0..self.problem.model.machine_states()).collect();
        let windowed = self.windowed.at(self.problem, level, (&self.paths()?, &all));
        let h = self.hypothesis.clone().held();
        minimise(self.problem, h, windowed, (None, self.steps_under(false)), effort)
    }

    /// States alone, fitted in windows of another level.
    ///
    /// # Errors
    /// [`FitError`].
    pub fn states_at(&self, level: u32) -> Result<Self, FitError> {
        let windowed = self.windows_at(level)?;
        let effort = Effort { steps: 3, least: 1.0, undamped: false };
        let held = self.hypothesis.clone().held();
        let driven = (self.noise.clone(), self.substeps);
        let fit = minimise(self.problem, held, windowed, driven, effort)?;
        Ok(Self { hypothesis: self.hypothesis.clone(), linearised: None, ..fit })
    }

    /// The same hypothesis in windows of a level that begin where the recordings themselves are:
    /// where a model is not quite right, states that are free would take up part of its error.
    ///
    /// # Errors
    /// [`FitError`].
    pub fn anchored(&self, level: u32) -> Result<Self, FitError> {
        let windowed = Windowed::smoothed(self.problem, level);
        let windowed = windowed.fitted_to(self.problem, &self.hypothesis);
        self.anchor(self.hypothesis.clone(), windowed, STILL)
    }

    /// Theta fitted alone, in windows that begin where they are. Residuals that are larger or
    /// slower than white noise say as much less beside the priors.
    ///
    /// # Errors
    /// [`FitError`].
    pub fn moved(&self, effort: Effort) -> Result<Self, FitError> {
        let temperature = self.rough_temperature();
        let doubting = self.hypothesis.doubting(temperature);
        let mut fit = self.anchor(doubting, self.windowed.clone(), effort)?;
        fit.hypothesis = fit.hypothesis.doubting(1.0 / temperature);
        Ok(fit)
    }

    fn anchor(
        &self,
        hypothesis: Hypothesis,
        windowed: Windowed,
        effort: Effort,
    ) -> Result<Self, FitError> {
        // What runs free is not corrected.
        let steps = self.steps_under(false);
        let minimisation = Minimisation::new(self.problem, hypothesis, windowed, steps);
        Minimisation { anchored: true, ..minimisation }.run(effort)
    }

    /// Residuals of the windows that are marked, in which only the states are fitted.
    ///
    /// # Errors
    /// [`FitError`].
    pub fn foretold(&self, h: Hypothesis, marked: &[bool]) -> Result<Vec<Vec<f64>>, FitError> {
        let states = Effort { steps: 3, least: 0.3, undamped: false };
        let held = h.held();
        let fit = in_finer_steps_at_need(self.substeps, |steps| {
            self.in_part(held.clone(), marked, steps, states)
        });
        Ok(fit?.residuals.to_vec())
    }

    /// Another hypothesis in a few of the windows, spread evenly: enough for a guess, whose states
    /// elsewhere stay as they are.
    ///
    /// # Errors
    /// [`FitError`].
    pub fn glimpse(&self, h: Hypothesis, effort: Effort) -> Result<Self, FitError> {
        /// Fewest windows, and one of how many at most.
        const FEWEST: usize = 16;
        const OF: usize = 4;
        let count: usize = self.windowed.windows.iter().map(Vec::len).sum();
        let every = (count / FEWEST).clamp(1, OF);
        let marked: Vec<bool> = (0..count).map(|k| k % every == 0).collect();
        let steps = self.problem.substeps(&h.parameters, &h.effects, self.noise.is_some());
        self.in_part(h, &marked, steps, effort)
    }

    /// Another hypothesis in the windows that are marked.
    fn in_part(
        &self,
        hypothesis: Hypothesis,
        marked: &[bool],
        substeps: Substeps,
        effort: Effort,
    ) -> Result<Self, FitError> {
        let (windowed, kept) = self.windows_for(&hypothesis).part(marked);
        let left_out = kept.into_iter().map(|k| !marked[k]).collect();
        let minimisation = Minimisation::new(self.problem, hypothesis, windowed, substeps);
        Minimisation { left_out, noise: self.noise.clone(), ..minimisation }.run(effort)
    }

    /// Whether this fit is of all that another is of. Windows alone do not say it: those that memory only runs
    /// through are there too.
    #[must_use]
    pub fn is_of_all_of(&self, other: &Self) -> bool {
        let windows = |f: &Self| f.windowed.windows.iter().map(Vec::len).sum::<usize>();
        windows(self) == windows(other) && self.count == other.count
    }

    /// What another fit supposes, in the windows of this one, as well as the other follows its own.
    #[must_use]
    pub fn supposing(&self, other: Self) -> Self {
        Self { windowed: self.windows_for(&other.hypothesis), linearised: None, ..other }
    }

    /// The windows for another hypothesis, the memory of new effects at rest.
    fn windows_for(&self, h: &Hypothesis) -> Windowed {
        self.kept_memory(h).fitted_to(self.problem, h)
    }

    /// The windows for another hypothesis: memory stays as far as effects are the same.
    fn kept_memory(&self, h: &Hypothesis) -> Windowed {
        let kept = common_memory(&self.hypothesis, h);
        let mut windowed = self.windowed.clone();
        for starts in &mut windowed.starts {
            starts.memory.truncate(kept);
        }
        windowed
    }

    /// A run through the windows of each recording.
    pub(crate) fn runs(&self) -> Vec<Run<'_>> {
        let Windowed { windows, starts, .. } = &self.windowed;
        let run = |r: usize| Run {
            problem: self.problem,
            hypothesis: &self.hypothesis,
            windows: &windows[r],
            starts: &starts[r],
            filters: self.filters.get(r).map_or(&[], Vec::as_slice),
            substeps: self.substeps,
        };
        (0..windows.len()).map(run).collect()
    }

    /// The whole state at every sample of each recording.
    ///
    /// # Errors
    /// [`FitError::Diverged`].
    pub fn paths(&self) -> Result<Vec<Vec<f64>>, FitError> {
        let paths: Result<Vec<_>, _> = self.runs().par_iter().map(Run::trajectory).collect();
        Ok(paths?)
    }

    /// Covariance of the fitted values where data are worth one in `temperature`; none where it is
    /// not finite.
    #[must_use]
    pub fn covariance(&self, temperature: f64) -> Option<DMatrix<f64>> {
        let free = &self.hypothesis.free;
        let p = free.len();
        let scaled = self.precision.covariance(temperature)?;
        Some(DMatrix::from_fn(p, p, |i, j| scaled[(i, j)] * free[i].sd * free[j].sd))
    }

    /// The same, or that of the priors where it is not finite.
    fn covariance_or_prior(&self, temperature: f64) -> DMatrix<f64> {
        let priors = self.hypothesis.free.iter().map(|f| f.sd * f.sd).collect();
        let prior = || DMatrix::from_diagonal(&DVector::from_vec(priors));
        self.covariance(temperature).unwrap_or_else(prior)
    }

    /// Standard deviations of the fitted values where data are worth one in `temperature`.
    #[must_use]
    pub fn std(&self, temperature: f64) -> Vec<f64> {
        deviations(&self.covariance_or_prior(temperature))
    }

    /// Standard deviations of the model's parameters; 0 for those that are known.
    #[must_use]
    pub fn parameter_std(&self, temperature: f64) -> Vec<f64> {
        let mut out = vec![0.0; self.hypothesis.parameters.len()];
        for (f, std) in self.hypothesis.free.iter().zip(self.std(temperature)) {
            if let What::Parameter(k) = f.what {
                out[k] = std;
            }
        }
        out
    }

    /// Which of the model's parameters lie on a bound of what was tried.
    #[must_use]
    pub fn parameters_at_bound(&self) -> Vec<bool> {
        let mut out = vec![false; self.hypothesis.parameters.len()];
        for f in &self.hypothesis.free {
            if let What::Parameter(k) = f.what {
                out[k] = f.is_at_bound(f.fitted(self.hypothesis.parameters[k]));
            }
        }
        out
    }

    /// Which physical parameters of an effect are told by one that lies on a bound of what was tried.
    #[must_use]
    pub fn effect_at_bound(&self, effect: usize) -> Vec<bool> {
        self.told_by(effect, super::Free::is_at_bound)
    }

    /// Which physical parameters of an effect were fitted; the others were chosen.
    #[must_use]
    pub fn effect_is_fitted(&self, effect: usize) -> Vec<bool> {
        self.told_by(effect, |_, _| true)
    }

    /// Which physical parameters of an effect move with what is free and `counts` with its fitted value.
    fn told_by(&self, effect: usize, counts: impl Fn(&super::Free, f64) -> bool) -> Vec<bool> {
        let free = &self.hypothesis.free;
        let sd: Vec<f64> = free.iter().map(|f| f.sd).collect();
        let slopes = self.physical_slopes(effect, &sd);
        let theta = self.hypothesis.theta();
        let counting: Vec<usize> =
            (0..free.len()).filter(|&entry| counts(&free[entry], theta[entry])).collect();
        let told = |p: usize| counting.iter().any(|&entry| slopes[(p, entry)] != 0.0);
        (0..slopes.nrows()).map(told).collect()
    }

    /// Derivatives of an effect's physical parameters (rows) by the entries of theta (columns), from steps that are
    /// small beside these standard deviations.
    fn physical_slopes(&self, effect: usize, std: &[f64]) -> DMatrix<f64> {
        const SMALL: f64 = 1e-4;
        let e = &self.hypothesis.effects[effect];
        let here = e.internal();
        let mut slopes = DMatrix::zeros(e.parameters.len(), std.len());
        for (entry, f) in self.hypothesis.free.iter().enumerate() {
            let What::Effect(of, j) = f.what else { continue };
            let step = SMALL * std[entry];
            if of != effect || step <= 0.0 {
                continue;
            }
            let (mut moved, mut values) = (e.clone(), here.clone());
            values[j] += step * f.slope(f.fitted(here[j]));
            moved.set_internal(&values);
            for (p, (a, b)) in moved.parameters.iter().zip(&e.parameters).enumerate() {
                slopes[(p, entry)] = (a - b) / step;
            }
        }
        slopes
    }

    /// The effects with standard deviations of their physical parameters; samples tell of when something began to one
    /// of them.
    #[must_use]
    pub fn effects(&self, temperature: f64) -> Vec<ModelEffect> {
        let covariance = self.covariance_or_prior(temperature);
        let std = deviations(&covariance);
        let mut effects = self.hypothesis.effects.clone();
        for (index, e) in effects.iter_mut().enumerate().skip(self.hypothesis.own) {
            let slopes = self.physical_slopes(index, &std);
            let mut variances = (&slopes * &covariance * slopes.transpose()).diagonal();
            let is_onset = |p: &Parameter| Some(p.name) == e.effect.nature.onset;
            if let Some(p) = e.effect.parameters.iter().position(is_onset)
                && variances[p] > 0.0
            {
                variances[p] += self.problem.sample.powi(2) / 12.0;
            }
            e.std = variances.iter().map(|v| (*v > 0.0).then(|| v.sqrt())).collect();
        }
        effects
    }
}

/// Standard deviations of entries with such a covariance.
fn deviations(covariance: &DMatrix<f64>) -> Vec<f64> {
    covariance.diagonal().iter().map(|v| v.max(0.0).sqrt()).collect()
}

/// Memory states that the same effects have at the head of two lists.
fn common_memory(a: &Hypothesis, b: &Hypothesis) -> usize {
    let same = |(x, y): &(&ModelEffect, &ModelEffect)| {
        (x.effect.class, x.channel, x.other) == (y.effect.class, y.channel, y.other)
    };
    let memory = |e: &ModelEffect| match e.effect.law {
        Law::Force(law) => law.memory(),
        _ => 0,
    };
    a.effects.iter().zip(&b.effects).take_while(same).map(|(e, _)| memory(e)).sum()
}

/// A fit in so many Runge-Kutta steps a sample, or in finer ones: what diverges in steps that were chosen for another
/// theta, or elsewhere in the recordings, and in finer ones does not, is integrated badly and nothing worse.
fn in_finer_steps_at_need<'p>(
    mut steps: Substeps,
    fit: impl Fn(Substeps) -> Result<Fit<'p>, FitError>,
) -> Result<Fit<'p>, FitError> {
    loop {
        let finer = problem::finer(steps);
        match (fit(steps), finer) {
            (Err(FitError::Diverged(_)), Some(finer)) => steps = finer,
            (ended, _) => return ended,
        }
    }
}

fn minimise<'p>(
    problem: &'p Problem<'p>,
    hypothesis: Hypothesis,
    windowed: Windowed,
    driven: (Option<Arc<ProcessNoise>>, Substeps),
    effort: Effort,
) -> Result<Fit<'p>, FitError> {
    begun(problem, hypothesis, windowed, driven).run(effort)
}

/// A minimisation in windows that are fitted to the hypothesis, beside noise with so many steps a sample.
fn begun<'p>(
    problem: &'p Problem<'p>,
    hypothesis: Hypothesis,
    windowed: Windowed,
    (noise, substeps): (Option<Arc<ProcessNoise>>, Substeps),
) -> Minimisation<'p> {
    let windowed = windowed.fitted_to(problem, &hypothesis);
    let minimisation = Minimisation::new(problem, hypothesis, windowed, substeps);
    Minimisation { noise, ..minimisation }
}
