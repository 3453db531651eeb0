//! What recordings that are left out say of an effect.
//!
//! The training recordings are cut into folds: one recording each, or contiguous parts of a single
//! one. Each fold is left out in turn, theta fitted to the others, and the fold predicted, the
//! states at its windows' beginnings fitted with and without the effect. Let the effect change
//! those predictions by D (in units of the noise). If it is there, the squares fall by about
//! `|D|^2`; if it only fits what is peculiar to the recordings it was fitted to, they rise by about
//! as much. Where D is small, the folds do not touch what it describes and say nothing.

use super::{Named, Path, Rival, Search, chain, untried};
use crate::candidates::Candidate;
use crate::decision::Decision;
use crate::likelihood::{Effort, FULL, Fit, FitError, QUICK, STILL, Said};
use rayon::prelude::*;
use std::cell::OnceCell;
use std::ops::Add;

/// Most folds.
const FOLDS: usize = 4;
/// A fold's fit begins at the optimum of all.
const FEW: Effort = Effort { steps: 4, least: 0.3, undamped: false };

/// What a fit predicts of each fold without knowing it.
pub(super) struct LeftOut {
    temperature: f64,
    folds: Vec<Fold>,
}

/// Which windows are left out, and their residuals.
struct Fold {
    windows: Vec<bool>,
    residuals: Result<Vec<Vec<f64>>, FitError>,
}

impl LeftOut {
    /// Leave out each fold of a fit's windows in turn; what has no parts has no folds.
    pub(super) fn of(fit: &Fit) -> Self {
        let Ok(parts) = in_parts(fit) else { return Self { temperature: 1.0, folds: vec![] } };
        let leaving = parts.leaving_out();
        let ask = |windows: Vec<bool>| {
            let leaving = leaving.as_ref().map_err(FitError::clone);
            Fold { residuals: leaving.and_then(|l| l.predicted(&windows, FEW)), windows }
        };
        let folds = folds(&parts).into_par_iter().map(ask).collect();
        Self { temperature: parts.temperature(), folds }
    }

    /// Whether the folds speak against the fit `with`, compared with `without` in the same windows, of which it must
    /// be ahead by `least` nats.
    pub(super) fn refutes(
        &self,
        decision: &Decision,
        (with, without): (&Fit, &Fit),
        least: f64,
    ) -> bool {
        let ahead = with.gain_over(without);
        let Ok(without) = in_parts(without) else { return false };
        let Ok(leaving) = without.leaving_out() else { return false };
        let plain = self.folds.par_iter().map(|fold| leaving.predicted(&fold.windows, FEW).ok());
        let plain: Vec<Option<Vec<Vec<f64>>>> = plain.collect();
        let mut total = Said::default();
        for (plain, fold) in plain.into_iter().zip(&self.folds) {
            let Some(plain) = plain else { continue };
            let rich = match &fold.residuals {
                Ok(rich) => rich,
                // Those that were asked say what they say.
                Err(FitError::Cancelled) => break,
                // Whoever diverges where the plainer model does not has been refuted.
                Err(_) => return true,
            };
            for (a, b) in plain.iter().zip(rich) {
                let squares = |r: &[f64]| r.iter().map(|r| r * r).sum::<f64>();
                let size = a.iter().zip(b).map(|(a, b)| (a - b).powi(2)).sum();
                total = total + Said { size, drop: squares(a) - squares(b) };
            }
        }
        total.refutes(decision, self.temperature, (ahead, least))
    }
}

impl Said {
    /// Whether folds speak against an effect that is so many nats ahead and must be by `least`. Of a change that is
    /// large in them a share must come true. They do not touch one that is small, and what they say of it are so many
    /// nats more or less.
    fn refutes(&self, decision: &Decision, temperature: f64, (ahead, least): (f64, f64)) -> bool {
        let (size, drop) = (self.size / temperature, self.drop / temperature);
        if size > 2.0 * decision.prior_odds {
            return drop < decision.share * size;
        }
        drop < -2.0 * decision.tie && ahead + 0.5 * drop < least
    }
}

/// What folds say of a fit's effects: by its windows as they were linearised, and by fits where those do not tell.
pub(super) struct Folded<'p> {
    pub fit: Fit<'p>,
    temperature: f64,
    said: Vec<Option<Said>>,
    /// Made when it is asked for.
    left_out: OnceCell<LeftOut>,
}

impl<'p> Folded<'p> {
    pub(super) fn of(fit: Fit<'p>) -> Self {
        let (mut temperature, mut said) = (1.0, vec![None; fit.hypothesis.supposed().len()]);
        if let Ok(parts) = in_parts(&fit)
            && let Ok(leaving) = parts.leaving_out()
        {
            let folds = folds(&parts);
            temperature = parts.temperature();
            for (k, said) in said.iter_mut().enumerate() {
                let each: Option<Vec<Said>> = folds.iter().map(|f| leaving.said_of(k, f)).collect();
                *said = each.map(|each| each.into_iter().fold(Said::default(), Add::add));
            }
        }
        Self { fit, temperature, said, left_out: OnceCell::new() }
    }

    /// The fit without effect `k`, which is so many nats ahead and must be by `least`, where the folds speak against it.
    pub(super) fn without_refuted(
        &self,
        decision: &Decision,
        k: usize,
        (ahead, least): (f64, f64),
    ) -> Option<Fit<'p>> {
        let said = &self.said[k];
        if said.is_some_and(|s| !s.refutes(decision, self.temperature, (ahead, least))) {
            return None;
        }
        let without = self.fit.without(k, QUICK).ok()?;
        (said.is_some() || self.refuted(decision, &without, least)).then_some(without)
    }

    /// Whether the folds speak against the fit beside another, by fits.
    pub(super) fn refuted(&self, decision: &Decision, without: &Fit, least: f64) -> bool {
        let left_out = self.left_out.get_or_init(|| LeftOut::of(&self.fit));
        left_out.refutes(decision, (&self.fit, without), least)
    }
}

impl Search<'_> {
    /// Whether folds that are left out speak against `with`, compared with `without` in the same
    /// windows, of which it must be ahead by more than a tie.
    pub(super) fn refuted(&self, without: &Fit, with: &Fit) -> bool {
        LeftOut::of(with).refutes(&self.decision, (with, without), self.decision.tie)
    }

    /// Mean square error of predictions by a fit that did not know of what it predicts, in windows
    /// that are long enough to predict, and short enough for what drives the machine not to add
    /// up for ever: they run free, of the states only their beginnings are fitted.
    ///
    /// # Errors
    /// [`FitError`].
    pub(super) fn error(&self, fit: &Fit) -> Result<f64, FitError> {
        // Eight windows: about the horizon of the proof.
        const LEVEL: u32 = 3;
        let parts = in_parts(fit)?;
        // Memory runs on from windows that are not asked into those that are.
        let held = match fit.reduced() < self.decision.explained {
            true => fit.held_along(LEVEL, STILL)?,
            false => fit.refit(fit.hypothesis.clone().held(), STILL)?.undriven(LEVEL, STILL)?,
        };
        let (mut squares, mut count) = (0.0, 0);
        let leaving = parts.leaving_out()?;
        for (out, asked) in folds(&parts).iter().zip(&folds(&held)) {
            let learned = leaving.learned_without(out, FEW)?;
            for residual in held.foretold(learned, asked)? {
                squares += residual.iter().map(|r| r * r).sum::<f64>();
                count += residual.len();
            }
        }
        Ok(squares / count.max(1) as f64)
    }

    /// Take away the effects that folds speak against, and what an effect says beyond a simpler law
    /// if they speak against that; all of them, if they speak against them together.
    pub(super) fn select<'p>(&self, calibrated: &Fit<'p>, path: Path<'p>) -> Path<'p> {
        if path.named.is_empty() || self.watch.skips(untried::FOLDS) {
            return path;
        }
        let mut path = self.simplified(path);
        let mut with = LeftOut::of(&path.fit);
        // What was not refuted beside an effect that was must stand without it.
        while self.refute_each(&mut path, &mut with) {}
        // A single effect was left out alone already.
        if path.named.len() < 2 {
            return path;
        }
        let Some(alone) = self.like(&path.fit, calibrated) else { return path };
        if with.refutes(&self.decision, (&path.fit, &alone), self.decision.prior_odds) {
            return Path { fit: calibrated.clone(), named: vec![] };
        }
        path
    }

    /// Take away each effect that is not missed or that folds speak against, the last first, with what the path
    /// predicts of the folds; whether there was one.
    fn refute_each(&self, path: &mut Path, with: &mut LeftOut) -> bool {
        let (least, before) = (self.decision.prior_odds, path.named.len());
        for k in (0..path.named.len()).rev() {
            let Ok(without) = path.fit.without(k, FULL) else { continue };
            let missed = path.fit.gain_over(&without) > least;
            if !missed || with.refutes(&self.decision, (&path.fit, &without), least) {
                path.named.remove(k);
                path.fit = chain::polish(without);
                *with = LeftOut::of(&path.fit);
            }
        }
        path.named.len() < before
    }

    /// Whether a simpler law in the place of effect `k` leaves as much as the richer one, as far as noise is known, and
    /// what that says beyond it is less than the least share of what either says: no formula is better. Friction that
    /// stands still is too steep for any smooth law: beside a peak of a hundredth of it one gains many nats.
    fn says_as_much(&self, rich: &Fit, k: usize, simple: &Fit) -> bool {
        if simple.reduced() > self.decision.noise * rich.inflation() {
            return false;
        }
        let said = simple.reduced() - rich.reduced();
        // What diverges without it leaves more than can be told.
        let without = rich.without(k, QUICK).map_or(f64::INFINITY, |fit| fit.excess());
        said <= self.decision.relevant * without
    }

    /// Simpler laws where a richer one does not lead them, or folds speak against it beside them.
    pub(super) fn simplified<'p>(&self, mut path: Path<'p>) -> Path<'p> {
        for k in (0..path.named.len()).rev() {
            let Some(simple) = self.special_case(&path.fit, k) else { continue };
            let lead = path.fit.gain_over(&simple);
            let words = path.fit.hypothesis.supposed()[k].effect.words;
            self.watch.tell(&format!("{words} leads a simpler law by {lead:.1} nats"));
            let is_drawn = lead < self.decision.tie || self.says_as_much(&path.fit, k, &simple);
            if is_drawn || self.refuted(&simple, &path.fit) {
                let rich = &path.fit.hypothesis;
                let candidate = Candidate::of(&rich.supposed()[k]);
                let behind = self.decision.tie;
                let rival = Rival { candidate, behind, hypothesis: rich.clone() };
                let mut named = path.named.remove(k);
                named.rivals.retain(|r| !r.candidate.excludes(&candidate));
                named.rivals.push(rival);
                // It may bring a constant force with it.
                let known = path.named.len();
                let more = known..simple.hypothesis.supposed().len() - 1;
                path.named.extend(more.map(|k| Named {
                    gain: simple.gained_by(k).unwrap_or(self.decision.tie),
                    rivals: vec![],
                }));
                path.named.push(named);
                path.fit = simple;
            }
        }
        path
    }
}

/// A fit in windows of which some can be left out: those of few recordings are parts of them.
fn in_parts<'p>(fit: &Fit<'p>) -> Result<Fit<'p>, FitError> {
    const LEVEL: u32 = 2;
    if fit.windowed.windows.len() >= FOLDS || fit.windowed.level >= LEVEL {
        return Ok(fit.clone());
    }
    fit.states_at(LEVEL)
}

/// Folds of a fit's windows: for each, which windows are left out.
fn folds(fit: &Fit) -> Vec<Vec<bool>> {
    let windows = &fit.windowed.windows;
    // Recordings in turn; of a few, contiguous windows: half of them do not tell what all do.
    let parts = FOLDS.div_ceil(windows.len());
    let part = |(r, w): (usize, &Vec<_>)| {
        let count = w.len();
        (0..count).map(move |k| (r * parts + k * parts / count) % FOLDS).collect::<Vec<_>>()
    };
    let of: Vec<usize> = windows.iter().enumerate().flat_map(part).collect();
    let used = (0..FOLDS).filter(|f| of.contains(f));
    used.map(|f| of.iter().map(|o| *o == f).collect()).collect()
}
