//! Levenberg-Marquardt on theta and the states of all windows.

use super::normal::{Arrow, Block, Step};
use super::sweep::{self, Starts};
use super::{Fit, Hypothesis, Problem, Window, Windowed};
use lacuna_effects::Law;
use lacuna_plants::model::System;
use rayon::prelude::*;

/// How long a minimisation goes on.
#[derive(Clone, Copy, Debug)]
pub struct Effort {
    /// Most steps.
    pub steps: usize,
    /// A step that gains less than this (of chi^2) is the last.
    pub least: f64,
}

/// A minimisation under way.
pub(super) struct Minimisation<'p> {
    pub problem: &'p Problem<'p>,
    pub hypothesis: Hypothesis,
    pub windowed: Windowed,
    pub substeps: usize,
    /// Whether the windows begin where they are, and theta alone moves.
    pub anchored: bool,
}

impl Minimisation<'_> {
    /// Minimise; `None` where the model diverges from the very beginning.
    pub(super) fn run(mut self, effort: Effort) -> Option<Fit> {
        let mut theta = self.hypothesis.theta();
        let mut damping = 1e-3;
        let mut blocks = self.blocks()?;
        for _ in 0..effort.steps {
            let before = self.objective(&theta, blocks.iter().map(|b| b.chi2).sum());
            if !before.is_finite() {
                return None;
            }
            let mut gained = None;
            for _ in 0..6 {
                let step = Arrow::new(&self.hypothesis, &blocks).step(&theta, damping);
                if let Some(after) = step.and_then(|s| self.try_step(s, before, &mut theta)) {
                    gained = Some(before - after);
                    damping = f64::max(0.125 * damping, 1e-7);
                    break;
                }
                damping *= if damping > 1e-4 { 8.0 } else { 50.0 };
            }
            let Some(gained) = gained else { break };
            blocks = self.blocks()?;
            if gained < effort.least {
                break;
            }
        }
        self.result(&theta, &blocks)
    }

    /// Take a step if it lowers the objective; the objective after it.
    fn try_step(&mut self, step: Step, before: f64, theta: &mut Vec<f64>) -> Option<f64> {
        let old = (self.hypothesis.clone(), self.windowed.starts.clone());
        self.hypothesis.set(&step.theta);
        let mut states = step.states.iter();
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
        let after = self.objective(&step.theta, self.squares());
        if after < before {
            *theta = step.theta;
            return Some(after);
        }
        (self.hypothesis, self.windowed.starts) = old;
        None
    }

    fn squares(&self) -> f64 {
        let Windowed { windows, starts, .. } = &self.windowed;
        let one = |(w, s): (&Vec<Window>, &Starts)| {
            sweep::squares(self.problem, &self.hypothesis, w, s, self.substeps)
        };
        let sums: Vec<f64> = windows.par_iter().zip(starts).map(one).collect();
        sums.iter().sum()
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
        let system =
            System::with(self.problem.model, &self.problem.equations, &h.parameters, &h.effects);
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

    fn blocks(&self) -> Option<Vec<Block>> {
        let Windowed { windows, starts, .. } = &self.windowed;
        let per_recording: Option<Vec<Vec<Block>>> =
            windows.par_iter().zip(starts).map(|(w, s)| self.blocks_of(w, s)).collect();
        Some(per_recording?.into_iter().flatten().collect())
    }

    fn blocks_of(&self, windows: &[Window], starts: &Starts) -> Option<Vec<Block>> {
        let all = sweep::linearise(self.problem, &self.hypothesis, windows, starts, self.substeps)?;
        let machine = self.problem.model.machine_states();
        let z = starts.memory.len();
        let (off, spread) = self.memory(starts);
        let block = |(k, columns): (usize, sweep::Columns)| {
            if self.anchored {
                Block::of(&columns, 0, machine + z)
            } else if k == 0 {
                Block::of(&columns, machine + z, 0).with_memory(machine, &off, &spread)
            } else {
                Block::of(&columns, machine, z)
            }
        };
        Some(all.into_iter().enumerate().map(block).collect())
    }

    fn result(self, theta: &[f64], blocks: &[Block]) -> Option<Fit> {
        let chi2: f64 = blocks.iter().map(|b| b.chi2).sum();
        let penalty = self.objective(theta, 0.0);
        let count = blocks.iter().map(|b| b.count).sum();
        let (precision, log_determinant) = Arrow::new(&self.hypothesis, blocks).precision(theta)?;
        let Self { hypothesis, windowed, substeps, .. } = self;
        (chi2 + penalty).is_finite().then_some(Fit {
            hypothesis,
            windowed,
            substeps,
            chi2,
            penalty,
            count,
            precision,
            log_determinant,
        })
    }
}
