//! Fits in windows that grow.

use crate::likelihood::{Effort, FULL, Fit, Hypothesis, Problem, QUICK, STILL};

/// Windows grow as long as what is not noise stays below this share of half a channel's range:
/// what a model leaves out adds up along a window, and long windows would weigh little else.
const MOST_MISFIT: f64 = 0.02;

/// Mean square residual, in units of the noise, up to which all lengths of windows agree.
const AT_EVERY_LENGTH: f64 = 2.0;

/// Until nothing is gained.
const LONG: Effort = Effort { steps: 60, least: 0.05 };
/// Steps for a new effect.
const BEGIN: Effort = Effort { steps: 8, least: 0.3 };

/// Whether the model has lost its way in windows of this length.
fn lost(problem: &Problem, fit: &Fit, slack: f64) -> bool {
    let misfit = (fit.reduced() - 1.0).max(0.0).sqrt() * problem.coarsest;
    misfit > slack * MOST_MISFIT
}

/// The same hypothesis in the longest windows that it follows.
#[must_use]
pub fn lengthen(problem: &Problem, fit: Fit) -> Fit {
    lengthen_to(problem, fit, 0, 1.0)
}

/// The same in windows no longer than those of a level, following them `slack` times as badly.
#[must_use]
pub fn lengthen_to(problem: &Problem, mut fit: Fit, level: u32, slack: f64) -> Fit {
    while fit.windowed.level > level {
        match fit.at_level(problem, fit.windowed.level - 1, QUICK) {
            Some(longer) if !lost(problem, &longer, slack) => fit = longer,
            _ => break,
        }
    }
    fit
}

/// Fit a hypothesis that has just been given one more effect, whose parameters are a guess, in
/// short windows, where a wrong guess does little harm.
#[must_use]
pub fn begin(problem: &Problem, short: &Fit, h: Hypothesis) -> Option<Fit> {
    short.refit(problem, h, BEGIN)
}

/// What was begun in short windows, in those of `base`.
#[must_use]
pub fn grow(problem: &Problem, base: &Fit, mut fit: Fit) -> Option<Fit> {
    while fit.windowed.level > base.windowed.level {
        if fit.reduced() > 5.0 * base.inflation() + 20.0 {
            return None;
        }
        let level = fit.windowed.level - 1;
        let effort = if level > base.windowed.level { QUICK } else { BEGIN };
        fit = fit.at_level(problem, level, effort)?;
    }
    Some(fit)
}

/// The fit that predicts best. Where a model leaves nothing but noise, windows of all lengths
/// agree. Where its formulas are not quite reality's, each length weighs their remainder
/// differently, and so do windows whose states are free and windows that begin where the
/// recordings are; the parameters are kept that run best through whole training recordings.
#[must_use]
pub fn best_length(problem: &Problem, fit: Fit) -> Fit {
    if fit.reduced() < AT_EVERY_LENGTH || !problem.hidden().is_empty() {
        return fit;
    }
    let whole = |f: &Fit| f.anchored(problem, 0).map_or(f64::INFINITY, |run| run.chi2);
    let mut best = (whole(&fit), None);
    let mut from = fit.clone();
    for level in (0..=fit.windowed.level + 2).rev() {
        let moved = from.anchored(problem, level).and_then(|f| f.moved(problem, LONG));
        let Some(moved) = moved else { break };
        let error = whole(&moved);
        if error < best.0 {
            best = (error, Some(moved.clone()));
        }
        from = moved;
    }
    let Some(better) = best.1 else { return fit };
    // What is left is judged in the windows that were fitted, their states free again.
    let h = better.hypothesis;
    let states = fit.refit(problem, h.clone().held(), FULL);
    states.and_then(|s| s.refit(problem, h, STILL)).unwrap_or(fit)
}

/// To the optimum, in the same windows.
#[must_use]
pub fn polish(problem: &Problem, fit: Fit) -> Fit {
    match fit.refit(problem, fit.hypothesis.clone(), FULL) {
        Some(better) if better.chi2 + better.penalty <= fit.chi2 + fit.penalty => better,
        _ => fit,
    }
}
