//! Levenberg-Marquardt on theta and the states of all windows.

use super::end::{End, FitError};
use super::maps::Maps;
use super::normal::{Arrow, Block, Memory, Step};
use super::sweep::{self, Piece, Run, Starts};
use super::{Filter, Fit, Hypothesis, Problem, ProcessNoise, Window, Windowed};
use lacuna_effects::Law;
use lacuna_plants::Substeps;
use lacuna_plants::model::System;
use nalgebra::DVector;
use rayon::prelude::*;
use std::sync::Arc;

/// How long a minimisation goes on.
#[derive(Clone, Copy, Debug)]
pub struct Effort {
    /// Most steps.
    pub steps: usize,
    /// A step that gains less than this is the last: of chi^2, or of as much more as the mean square
    /// of the residual is above the noise.
    pub least: f64,
    /// Whether the last steps are damped by nothing, down valleys that are all but flat.
    pub undamped: bool,
}

/// A minimisation under way.
pub(super) struct Minimisation<'p> {
    pub problem: &'p Problem<'p>,
    pub hypothesis: Hypothesis,
    pub windowed: Windowed,
    pub substeps: Substeps,
    /// Whether the windows begin where they are, and theta alone moves.
    pub anchored: bool,
    /// Windows that theta must not know, one mark a window; empty where it may know all.
    pub left_out: Vec<bool>,
    /// What drives the machine beside what was recorded.
    pub noise: Option<Arc<ProcessNoise>>,
    /// A filter a window, recording by recording, made where the minimisation begins if they are not given.
    pub filters: Vec<Vec<Filter>>,
    /// The windows where it begins, where they are linearised already: along those filters, if noise drives the
    /// machine.
    pub known: Option<Linearised>,
}

/// Damping with which a minimisation begins; what a step promises with no more is what the
/// optimum is below.
const BELIEVED: f64 = 1e-3;

/// How far linearised windows are believed.
struct Trust {
    damping: f64,
    /// Whether the last step was taken at once.
    at_once: bool,
    /// Whether damped steps gain no more: one that nothing damps is the last that is tried.
    settled: bool,
    /// Whether what is left may be noise.
    is_right: bool,
    /// Damping of the last steps.
    last: f64,
}

/// Least damping of steps that gain.
const LEAST: f64 = 1e-7;
/// Steps in which a whole one may come back to what the data tell. Each leaves about the square of what was off: from a
/// third, six leave nothing that a double holds.
const BACK: usize = 6;
/// Mean square of the residual, in units of the noise, up to which a step that nothing damps is tried: twice that of noise
/// alone. What is left beyond is another law's, and combinations that the data hardly tell would take it up.
const RIGHT: f64 = 2.0;

impl Trust {
    /// Damp no more. What the data hardly tell is where its prior has it, and the damping, a share of what they tell
    /// of each entry by itself, holds that most: where deviations are a ten millionth of a tolerance, any share does.
    fn settle(&mut self) {
        *self = Self { damping: self.last, at_once: false, settled: true, ..*self };
    }

    /// Whether nothing is left to try where a step gains little.
    fn is_done(&self) -> bool {
        self.settled || !self.is_right
    }
}

/// What came of a step.
enum Descent {
    /// It was taken: what it gained, the windows there.
    Taken { gained: f64, there: Linearised },
    /// None was taken.
    Ended(End),
}

/// The windows of all recordings, linearised.
pub(super) struct Linearised {
    pub blocks: Arc<[Block]>,
    pub residuals: Arc<[Vec<f64>]>,
}

impl<'p> Minimisation<'p> {
    /// Of theta and the states of all windows, no noise driving the machine.
    pub(super) fn new(
        problem: &'p Problem<'p>,
        hypothesis: Hypothesis,
        windowed: Windowed,
        substeps: Substeps,
    ) -> Self {
        let (left_out, filters, noise, known) = (vec![], vec![], None, None);
        let anchored = false;
        Self { problem, hypothesis, windowed, substeps, anchored, left_out, noise, filters, known }
    }

    /// Minimise.
    pub(super) fn run(mut self, effort: Effort) -> Result<Fit<'p>, FitError> {
        let mut theta = self.hypothesis.theta();
        let last = if effort.undamped { 0.0 } else { LEAST };
        let mut trust =
            Trust { damping: BELIEVED, at_once: true, settled: false, is_right: true, last };
        let mut here = self.begin()?;
        let mut end = End::OutOfSteps;
        for _ in 0..effort.steps {
            let before = self.objective(&theta, self.counted(here.blocks.iter().map(|b| b.chi2)));
            let count = self.count(&here.blocks);
            let mean_square = before / count.max(1) as f64;
            let least = effort.least * mean_square.max(1.0);
            trust.is_right = mean_square <= RIGHT;
            match self.descend(&here.blocks, (before, least), &mut theta, &mut trust)? {
                Descent::Taken { gained, there } => {
                    here = there;
                    if gained >= least {
                        trust.settled = false;
                    } else if trust.is_done() {
                        end = End::Converged;
                        break;
                    } else {
                        trust.settle();
                    }
                }
                Descent::Ended(why) => {
                    end = why;
                    break;
                }
            }
        }
        self.result(&theta, here, end)
    }

    /// The windows where it begins, linearised along filters that are made there, as far as these are not known.
    pub(super) fn begin(&mut self) -> Result<Linearised, FitError> {
        if self.filters.is_empty() {
            self.make_filters()?;
        }
        // What is no step is not called off.
        self.known.take().map_or_else(|| self.linearise(|| Ok(())), Ok)
    }

    /// Take one step that lowers the objective, shorter and shorter ones being tried. None is taken
    /// where the linearised windows promise less than is asked for, nor of a step that nothing damps.
    fn descend(
        &mut self,
        blocks: &[Block],
        (before, least): (f64, f64),
        theta: &mut Vec<f64>,
        trust: &mut Trust,
    ) -> Result<Descent, FitError> {
        const TRIES: i32 = 6;
        let mut attempt = 0;
        while attempt < TRIES {
            self.go_on()?;
            let damping = trust.damping;
            let step = Arrow::new(&self.hypothesis, blocks, &self.left_out).step(theta, damping);
            let promised = step.as_ref().map_or(f64::INFINITY, |s| s.promised);
            let is_little = attempt == 0 && damping <= BELIEVED && promised < least;
            // Where a whole step does not come back one that is damped least is tried.
            let tries = if trust.last == 0.0 { 2 } else { 1 };
            if is_little && trust.is_done() || attempt >= tries && trust.settled {
                return Ok(Descent::Ended(End::Converged));
            }
            if is_little {
                trust.settle();
                continue;
            }
            // A singular step is damped more, as one that does not descend is. The first step is
            // nearly always taken, so that its derivatives are computed at once; after a failure
            // the sum of squares alone is tried first.
            let eager = attempt == 0 && trust.at_once;
            let taken = step.ok().and_then(|s| match trust.settled && damping == 0.0 {
                true => self.leap(s, before, theta),
                false => self.try_step(s, before, theta, eager),
            });
            if let Some((after, there)) = taken {
                let damping = f64::max(0.125 * damping, LEAST);
                *trust = Trust { damping, at_once: attempt == 0, ..*trust };
                let there = there.map_or_else(|| self.linearise(|| self.go_on()), Ok)?;
                return Ok(Descent::Taken { gained: before - after, there });
            }
            // Gently at first: the longest step that descends is the best.
            attempt += 1;
            trust.damping = f64::max(damping, LEAST) * 2.0f64.powi(attempt);
        }
        self.go_on()?;
        Ok(Descent::Ended(End::Stalled))
    }

    /// Take a step if it lowers the objective: the objective after it, and the windows there if
    /// they were `linearised`.
    fn try_step(
        &mut self,
        step: Step,
        before: f64,
        theta: &mut Vec<f64>,
        linearised: bool,
    ) -> Option<(f64, Option<Linearised>)> {
        let old = (self.hypothesis.clone(), self.windowed.starts.clone());
        self.hypothesis.set(&step.theta);
        self.move_states(&step.states);
        // Where the model diverges the step was too long.
        let there = if linearised { self.linearise(|| self.go_on()).map(Some) } else { Ok(None) };
        let after = there.and_then(|there| {
            let chi2 = match &there {
                Some(l) => self.counted(l.blocks.iter().map(|b| b.chi2)),
                None => self.squares()?,
            };
            Ok((self.objective(&step.theta, chi2), there))
        });
        if let Ok((after, there)) = after
            && after < before
        {
            *theta = step.theta;
            return Some((after, there));
        }
        (self.hypothesis, self.windowed.starts) = old;
        None
    }

    /// Take a whole step and further ones from where it ends, as long as each lowers the objective, until it is lower
    /// than before: combinations that the data do not tell are bent where a product or a logarithm is one of them, and
    /// a straight step along them leaves what the data tell.
    fn leap(
        &mut self,
        mut step: Step,
        before: f64,
        theta: &mut Vec<f64>,
    ) -> Option<(f64, Option<Linearised>)> {
        let old = (self.hypothesis.clone(), self.windowed.starts.clone());
        let mut limit = f64::INFINITY;
        for _ in 0..BACK {
            let mut at = step.theta.clone();
            let Some((after, Some(there))) = self.try_step(step, limit, &mut at, true) else {
                break;
            };
            if after < before {
                *theta = at;
                return Some((after, Some(there)));
            }
            limit = after;
            let arrow = Arrow::new(&self.hypothesis, &there.blocks, &self.left_out);
            let Ok(next) = arrow.step(&at, 0.0) else { break };
            step = next;
        }
        (self.hypothesis, self.windowed.starts) = old;
        None
    }

    /// Where the linearised windows have theta and all states if some entries of theta take steps that are given.
    pub(super) fn leapt(
        mut self,
        given: &[(usize, f64)],
    ) -> Result<(Hypothesis, Windowed), FitError> {
        let blocks = self.begin()?.blocks;
        let theta = self.hypothesis.theta();
        let arrow = Arrow::new(&self.hypothesis, &blocks, &[]);
        let (step, states) = arrow.learned_with_states(&theta, given)?;
        let moved: Vec<f64> = theta.iter().zip(step.iter()).map(|(x, step)| x + step).collect();
        self.hypothesis.set(&moved);
        self.move_states(&states);
        Ok((self.hypothesis, self.windowed))
    }

    fn move_states(&mut self, steps: &[DVector<f64>]) {
        let mut states = steps.iter();
        let machine = self.problem.model.machine_states();
        for starts in &mut self.windowed.starts {
            for (k, x) in starts.machine.iter_mut().enumerate() {
                let Some(d) = states.next() else { continue };
                x.iter_mut().zip(d.iter()).for_each(|(x, d)| *x += d);
                if k == 0 {
                    let memory = d.iter().skip(machine);
                    starts.memory.iter_mut().zip(memory).for_each(|(z, d)| *z += d);
                }
            }
        }
    }

    /// Sum over the windows that count.
    fn counted(&self, chi2: impl Iterator<Item = f64>) -> f64 {
        chi2.zip(self.counts()).filter(|(_, counts)| *counts).map(|(c, _)| c).sum()
    }

    /// Residuals in the windows that count.
    fn count(&self, blocks: &[Block]) -> usize {
        blocks.iter().zip(self.counts()).filter(|(_, counts)| *counts).map(|(b, _)| b.count).sum()
    }

    /// Whether each window counts.
    fn counts(&self) -> impl Iterator<Item = bool> + '_ {
        self.left_out.iter().map(|out| !out).chain(std::iter::repeat(true))
    }

    /// The filters along the run with which the minimisation begins.
    fn make_filters(&mut self) -> Result<(), FitError> {
        let Some(noise) = self.noise.clone() else { return Ok(()) };
        let Windowed { windows, starts, .. } = &self.windowed;
        let one = |(w, s): (&Vec<Window>, &Starts)| {
            if w.is_empty() {
                return Ok(vec![]);
            }
            Ok(Maps::along(&self.piece(w, s, &[]), Some(&noise))?.filters)
        };
        let filters: Result<Vec<_>, FitError> = windows.par_iter().zip(starts).map(one).collect();
        self.filters = filters?;
        Ok(())
    }

    fn piece<'s>(
        &'s self,
        windows: &'s [Window],
        starts: &'s Starts,
        filters: &'s [Filter],
    ) -> Run<'s> {
        let Self { problem, hypothesis, substeps, .. } = self;
        Run { problem, hypothesis, windows, starts, filters, substeps: *substeps }
    }

    /// The windows of all recordings in pieces.
    fn pieces(&self) -> Vec<Piece<'_>> {
        let Windowed { windows, starts, .. } = &self.windowed;
        let of = |r: usize| {
            let filters = self.filters.get(r).map_or(&[][..], Vec::as_slice);
            sweep::pieces(&windows[r], &starts[r], filters)
        };
        (0..windows.len()).flat_map(of).collect()
    }

    /// Go on, unless nobody waits for it any more: asked before each piece, as one may take long.
    fn go_on(&self) -> Result<(), FitError> {
        if self.problem.is_cancelled() { Err(FitError::Cancelled) } else { Ok(()) }
    }

    fn squares(&self) -> Result<f64, FitError> {
        let one = |(w, s, f): &Piece| {
            self.go_on()?;
            Ok(self.piece(w, s, f).squares()?)
        };
        let sums: Result<Vec<_>, FitError> = self.pieces().par_iter().map(one).collect();
        Ok(self.counted(sums?.into_iter().flatten()))
    }

    /// chi^2 with the pulls of all priors.
    fn objective(&self, theta: &[f64], chi2: f64) -> f64 {
        let pull = |s: &Starts| {
            let (off, spread) = self.memory(s);
            off.iter().zip(&spread).map(|(o, s)| (o / s).powi(2)).sum::<f64>()
        };
        let memory: f64 = self.windowed.starts.iter().map(pull).sum();
        chi2 + self.hypothesis.penalty(theta) + memory
    }

    /// How far from rest the memory begins, and how far it may.
    fn memory(&self, starts: &Starts) -> (Vec<f64>, Vec<f64>) {
        if starts.memory.is_empty() {
            return (vec![], vec![]);
        }
        let h = &self.hypothesis;
        let system = System::with(self.problem.model, &h.parameters, &h.effects);
        let rest = system.at_rest(&starts.machine[0]);
        let rest = &rest[self.problem.model.machine_states()..];
        let off = starts.memory.iter().zip(rest).map(|(z, r)| z - r).collect();
        let mut spread = Vec::with_capacity(rest.len());
        for e in &h.effects {
            let Law::Force(law) = e.effect.law else { continue };
            let mut own = vec![0.0; law.memory()];
            let internal = e.internal();
            let (shape, scales) = (&internal[law.amplitudes()..], self.problem.scales_of(e));
            (e.effect.nature.memory_spread)(shape, &scales, &mut own);
            spread.extend(own.into_iter().map(|s| s.max(f64::MIN_POSITIVE)));
        }
        (off, spread)
    }

    /// The windows of all recordings, as long as it may `go_on`.
    fn linearise(
        &self,
        go_on: impl Fn() -> Result<(), FitError> + Sync,
    ) -> Result<Linearised, FitError> {
        let pieces = self.pieces();
        let all = pieces.len();
        let one = |(w, s, f): &Piece| {
            go_on()?;
            self.linearise_piece((w, all), s, f)
        };
        let parts: Result<Vec<_>, FitError> = pieces.par_iter().map(one).collect();
        let (blocks, residuals): (Vec<_>, Vec<_>) = parts?.into_iter().flatten().unzip();
        Ok(Linearised { blocks: blocks.into(), residuals: residuals.into() })
    }

    fn linearise_piece(
        &self,
        (windows, pieces): (&[Window], usize),
        starts: &Starts,
        filters: &[Filter],
    ) -> Result<Vec<(Block, Vec<f64>)>, FitError> {
        let run = self.piece(windows, starts, filters);
        let all = match self.anchored {
            true => run.linearise_by_theta(pieces)?,
            false => run.linearise(pieces)?,
        };
        let machine = self.problem.model.machine_states();
        let z = starts.memory.len();
        let (off, spread) = self.memory(starts);
        let block = |(k, columns): (usize, sweep::Columns)| {
            let believed = Memory { off: &off, spread: &spread };
            let block = if self.anchored {
                Block::of(&columns, (0, 0), Memory::default())
            } else if k == 0 {
                Block::of(&columns, (machine + z, 0), believed)
            } else {
                Block::of(&columns, (machine, z), Memory::default())
            };
            (block, columns.residual)
        };
        Ok(all.into_iter().enumerate().map(block).collect())
    }

    fn result(self, theta: &[f64], here: Linearised, end: End) -> Result<Fit<'p>, FitError> {
        let Linearised { blocks, residuals } = here;
        let chi2 = self.counted(blocks.iter().map(|b| b.chi2));
        let penalty = self.objective(theta, 0.0);
        let count = self.count(&blocks);
        let counted = || residuals.iter().zip(self.counts()).filter(|(_, c)| *c);
        let residuals = match self.left_out.is_empty() {
            true => residuals,
            false => counted().map(|(r, _)| r.clone()).collect(),
        };
        let arrow = Arrow::new(&self.hypothesis, &blocks, &self.left_out);
        let precision = arrow.precision(theta)?;
        let promised = arrow.step(theta, BELIEVED).map_or(f64::INFINITY, |s| s.promised);
        if !(chi2 + penalty).is_finite() {
            return Err(FitError::Singular);
        }
        // Beside noise a fit begins with filters of its own.
        let goes_on = !self.anchored && self.left_out.is_empty() && self.noise.is_none();
        let linearised = goes_on.then_some(blocks);
        let Self { problem, hypothesis, windowed, substeps, noise, filters, .. } = self;
        let fit = Fit {
            problem,
            hypothesis,
            windowed,
            substeps,
            noise,
            filters: filters.into(),
            chi2,
            penalty,
            count,
            residuals,
            precision,
            promised,
            end,
            linearised,
        };
        Ok(fit)
    }
}
