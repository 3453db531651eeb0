//! Fits in windows that grow.

use super::{Search, untried};
use crate::dataset::Observed;
use crate::likelihood::{Effort, End, FULL, Fit, FitError, Hypothesis, LAST, QUICK, STILL};
use crate::prediction::{Predictor, warmup};
use rayon::prelude::*;

/// Until nothing is gained.
const LONG: Effort = Effort { steps: 60, least: 0.05, undamped: false };
/// Steps for a new effect.
const BEGIN: Effort = Effort { steps: 8, least: 0.3, undamped: false };

/// Whether the model has lost its way in windows of this length, `slack` times as far as is usual.
fn lost(fit: &Fit, most: f64, slack: f64) -> bool {
    let misfit = (fit.reduced() - 1.0).max(0.0).sqrt() * fit.problem.coarsest;
    misfit > slack * most
}

/// Whether a model misses its windows by more than its machine moves: it has run away, and what it has run from
/// no longer shows.
pub fn is_astray(fit: &Fit) -> bool {
    const ALL: f64 = 1.0;
    lost(fit, ALL, 1.0)
}

/// The same hypothesis in the longest windows that it follows: as long as what is not noise stays
/// below a share `most` of half a channel's range. What a model leaves out adds up along a window,
/// and long windows would weigh little else.
#[must_use]
pub fn lengthen(fit: Fit, most: f64) -> Fit {
    lengthen_to(fit, 0, (most, 1.0))
}

/// The same in windows no longer than those of a level, following them `slack` times as badly.
#[must_use]
pub fn lengthen_to(fit: Fit, level: u32, (most, slack): (f64, f64)) -> Fit {
    lengthen_while(fit, level, |longer| !lost(longer, most, slack))
}

/// The same in windows no longer than those of a level, as long as what it leaves there will do.
#[must_use]
pub fn lengthen_while<'p>(mut fit: Fit<'p>, level: u32, will_do: impl Fn(&Fit) -> bool) -> Fit<'p> {
    while fit.windowed.level > level {
        match fit.at_level(fit.windowed.level - 1, QUICK) {
            Ok(longer) if will_do(&longer) => fit = longer,
            _ => break,
        }
    }
    fit
}

/// The same in windows of a level at once; none unless a fit that leaves nothing but `noise` still
/// does so there.
#[must_use]
pub fn lengthen_at_once<'p>(fit: &Fit<'p>, level: u32, noise: f64) -> Option<Fit<'p>> {
    if fit.windowed.level <= level + 1 || fit.reduced() > noise {
        return None;
    }
    fit.at_level(level, QUICK).ok().filter(|longer| longer.reduced() < noise)
}

/// Fit a hypothesis that has just been given one more effect, whose parameters are a guess, in
/// a few short windows, where a wrong guess does little harm.
///
/// # Errors
/// [`FitError`].
pub fn begin<'p>(short: &Fit<'p>, h: Hypothesis) -> Result<Fit<'p>, FitError> {
    short.glimpse(h, BEGIN)
}

/// What was begun in a few of the windows of `short`, in all those of `base`.
///
/// # Errors
/// [`FitError::RanAway`] where it loses its way, and others.
pub fn grow<'p>(base: &Fit<'p>, short: &Fit<'p>, begun: Fit<'p>) -> Result<Fit<'p>, FitError> {
    let whole = begun.is_of_all_of(short);
    if !whole && short.windowed.level == base.windowed.level {
        return short.refit(begun.hypothesis, BEGIN);
    }
    let mut fit = if whole { begun } else { short.supposing(begun) };
    while fit.windowed.level > base.windowed.level {
        let (most, found) = (5.0 * base.inflation() + 20.0, fit.reduced());
        if found > most {
            return Err(FitError::RanAway { most, found });
        }
        let level = fit.windowed.level - 1;
        let effort = if level > base.windowed.level { QUICK } else { BEGIN };
        fit = fit.at_level(level, effort)?;
    }
    Ok(fit)
}

/// To the optimum, in the same windows. Few fits take long: those of many parameters that move together
/// along a bent valley. What has not arrived is judged by what it has yet to gain.
#[must_use]
pub fn polish(fit: Fit) -> Fit {
    let fit = improved(fit, FULL);
    if fit.end == End::OutOfSteps { improved(fit, LONG) } else { fit }
}

/// To the optimum, and from there to where the priors have what the data hardly tell.
#[must_use]
pub fn to_the_bottom(fit: Fit) -> Fit {
    improved(polish(fit), LAST)
}

/// Further in the same windows, where that is no worse.
#[must_use]
pub fn improved(fit: Fit, effort: Effort) -> Fit {
    match fit.further(effort) {
        Ok(better) if better.misfit() <= fit.misfit() => better,
        _ => fit,
    }
}

/// Squares of what free runs through the recordings leave, as a proof makes them, in units of the noise.
fn free_runs(fit: &Fit) -> f64 {
    let (problem, h) = (fit.problem, &fit.hypothesis);
    let (model, dataset, steps) = (problem.model, problem.dataset, fit.substeps);
    let predictor = Predictor::with_substeps(model, &h.parameters, &h.effects, dataset, steps);
    let left = |o: &Observed| {
        let run = predictor.free_run(o, warmup(o));
        let outputs = problem.weights.iter().enumerate();
        outputs.map(|(k, weight)| run.squares(o, k).0 * weight * weight).sum::<f64>()
    };
    dataset.recordings.par_iter().map(left).sum()
}

impl Search<'_> {
    /// The same hypothesis in the longest windows that it follows.
    pub(super) fn lengthen<'p>(&self, fit: Fit<'p>) -> Fit<'p> {
        lengthen(fit, self.decision.window_misfit)
    }

    /// The fit that predicts best. Where a model leaves nothing but noise, windows of all lengths
    /// agree. Where its formulas are not quite reality's, each length weighs their remainder
    /// differently, and so do windows whose states are free and windows that begin where the
    /// recordings are; the parameters are kept that run best through whole training recordings.
    pub(super) fn best_length<'p>(&self, fit: Fit<'p>) -> Fit<'p> {
        if fit.reduced() < self.decision.explained || self.watch.skips(untried::LENGTHS) {
            return to_the_bottom(fit);
        }
        // Parameters that are fitted in windows of other lengths begin near.
        let fit = improved(fit, FULL);
        // Where a hidden state is at the beginning of a window must be fitted, in the longest ones of all.
        if !fit.problem.hidden().is_empty() {
            return fit.at_level(0, FULL).map_or(fit, polish);
        }
        let mut best = (free_runs(&fit), None);
        let mut from = fit.clone();
        for level in (0..=fit.windowed.level + 2).rev() {
            let Ok(moved) = from.anchored(level).and_then(|f| f.moved(LONG)) else { break };
            let error = free_runs(&moved);
            if error < best.0 {
                best = (error, Some(moved.clone()));
            }
            from = moved;
        }
        let Some(better) = best.1 else { return fit };
        // What is left is judged in the windows that were fitted, their states free again.
        let h = better.hypothesis;
        let states = fit.refit(h.clone().held(), FULL);
        states.and_then(|s| s.refit(h, STILL)).unwrap_or(fit)
    }
}
