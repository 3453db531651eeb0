//! A fitted hypothesis, its evidence, and its ways to other windows.

use super::minimise::{Effort, Minimisation};
use super::sweep::{self, Starts};
use super::windows::{Window, windows};
use super::{Hypothesis, Problem, What};
use crate::colour::{RELIABLE, ROUGH, colour};
use lacuna_effects::Law;
use lacuna_plants::model::{ModelEffect, System};
use nalgebra::DMatrix;
use rayon::prelude::*;

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

/// A hypothesis at its optimum.
#[derive(Clone, Debug)]
pub struct Fit {
    /// The fitted hypothesis.
    pub hypothesis: Hypothesis,
    /// Windows and states.
    pub windowed: Windowed,
    /// Runge-Kutta steps a sample.
    pub substeps: usize,
    /// Sum of squares of the residual in units of the noise.
    pub chi2: f64,
    /// Pull of the priors.
    pub penalty: f64,
    /// Number of residuals.
    pub count: usize,
    /// Precision of theta in units of its prior.
    pub precision: DMatrix<f64>,
    /// Its log determinant, with that of the memories' beginnings.
    pub log_determinant: f64,
}

/// Nothing moves.
pub const STILL: Effort = Effort { steps: 0, least: 0.0 };
/// A few steps, enough to compare.
pub const QUICK: Effort = Effort { steps: 6, least: 0.3 };
/// To the optimum.
pub const FULL: Effort = Effort { steps: 15, least: 0.05 };

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
    /// begin on the smoothed motion, or, what is not measured, on `path`.
    #[must_use]
    fn at(&self, problem: &Problem, level: u32, path: &[Vec<f64>]) -> Self {
        let mut next = Self::smoothed(problem, level);
        let width = problem.model.machine_states();
        let hidden = problem.hidden();
        for (r, starts) in next.starts.iter_mut().enumerate() {
            starts.memory.clone_from(&self.starts[r].memory);
            let stride = width + starts.memory.len();
            for (w, x) in next.windows[r].iter().zip(&mut starts.machine) {
                let same = self.windows[r].iter().position(|o| o.range.start == w.range.start);
                if let Some(k) = same {
                    x.clone_from(&self.starts[r].machine[k]);
                } else if let Some(state) = path[r].get(w.range.start * stride..) {
                    for &i in hidden {
                        x[i] = state.get(i).copied().unwrap_or(x[i]);
                    }
                }
            }
        }
        next
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

impl Fit {
    /// Fit a hypothesis from the smoothed motion in windows of a level: first the states alone,
    /// then everything.
    #[must_use]
    pub fn begin(problem: &Problem, hypothesis: Hypothesis, level: u32) -> Option<Self> {
        let windowed = Windowed::smoothed(problem, level);
        let states = Effort { steps: 4, least: 1.0 };
        let held = hypothesis.clone().held();
        let held = minimise(problem, held, windowed, states)?;
        minimise(problem, hypothesis, held.windowed, FULL)
    }

    /// Fit another hypothesis from here, in the same windows.
    #[must_use]
    pub fn refit(&self, problem: &Problem, h: Hypothesis, effort: Effort) -> Option<Self> {
        let kept = common_memory(&self.hypothesis, &h);
        let mut windowed = self.windowed.clone();
        for starts in &mut windowed.starts {
            starts.memory.truncate(kept);
        }
        minimise(problem, h, windowed, effort)
    }

    /// Fit the same hypothesis in windows of another level.
    #[must_use]
    pub fn at_level(&self, problem: &Problem, level: u32, effort: Effort) -> Option<Self> {
        let path = self.paths(problem);
        let windowed = self.windowed.at(problem, level, &path);
        minimise(problem, self.hypothesis.clone(), windowed, effort)
    }

    /// States alone, fitted in windows of another level.
    #[must_use]
    pub fn states_at(&self, problem: &Problem, level: u32) -> Option<Self> {
        let path = self.paths(problem);
        let windowed = self.windowed.at(problem, level, &path);
        let effort = Effort { steps: 3, least: 1.0 };
        let mut fit = minimise(problem, self.hypothesis.clone().held(), windowed, effort)?;
        fit.hypothesis = self.hypothesis.clone();
        Some(fit)
    }

    /// The same hypothesis in windows of a level that begin where the recordings themselves are:
    /// where a model is not quite right, states that are free would take up part of its error.
    #[must_use]
    pub fn anchored(&self, problem: &Problem, level: u32) -> Option<Self> {
        let windowed = Windowed::smoothed(problem, level).fitted_to(problem, &self.hypothesis);
        self.anchor(problem, self.hypothesis.clone(), windowed, STILL)
    }

    /// Theta fitted alone, in windows that begin where they are. Residuals that are larger or
    /// slower than white noise say as much less beside the priors.
    #[must_use]
    pub fn moved(&self, problem: &Problem, effort: Effort) -> Option<Self> {
        let residuals = self.residuals(problem);
        let doubt = self.inflation() * colour(residuals.iter().map(Vec::as_slice), ROUGH);
        let doubting = self.hypothesis.doubting(doubt);
        let mut fit = self.anchor(problem, doubting, self.windowed.clone(), effort)?;
        fit.hypothesis = fit.hypothesis.doubting(1.0 / doubt);
        Some(fit)
    }

    fn anchor(
        &self,
        problem: &Problem,
        hypothesis: Hypothesis,
        windowed: Windowed,
        effort: Effort,
    ) -> Option<Self> {
        let substeps = self.substeps;
        Minimisation { problem, hypothesis, windowed, substeps, anchored: true }.run(effort)
    }

    /// The whole state at every sample of each recording.
    #[must_use]
    pub fn paths(&self, problem: &Problem) -> Vec<Vec<f64>> {
        let Windowed { windows, starts, .. } = &self.windowed;
        let one = |(w, s): (&Vec<Window>, &Starts)| {
            sweep::trajectory(problem, &self.hypothesis, w, s, self.substeps)
        };
        windows.par_iter().zip(starts).map(one).collect()
    }

    /// Mean square of the residual in units of the noise.
    #[must_use]
    pub fn reduced(&self) -> f64 {
        self.chi2 / self.count.max(1) as f64
    }

    /// By how much the noise must be larger for the residual to be noise.
    #[must_use]
    pub fn inflation(&self) -> f64 {
        self.reduced().max(1.0)
    }

    /// What priors and precision take off the likelihood (nats), the noise inflated.
    #[must_use]
    pub fn price(&self, inflation: f64) -> f64 {
        let entries = self.hypothesis.free.len() as f64;
        0.5 * (self.penalty + (self.log_determinant - entries * inflation.ln()).max(0.0))
    }

    /// Log evidence by Laplace's method, the noise inflated to what is left.
    #[must_use]
    pub fn log_evidence(&self) -> f64 {
        let s = self.inflation();
        -0.5 * self.count as f64 * s.ln() - 0.5 * self.chi2 / s - self.price(s)
    }

    /// Residuals, a series an output and window.
    #[must_use]
    pub fn residuals(&self, problem: &Problem) -> Vec<Vec<f64>> {
        let Windowed { windows, starts, .. } = &self.windowed;
        let one = |(w, s): (&Vec<Window>, &Starts)| {
            let mut out = Vec::new();
            sweep::residuals(problem, &self.hypothesis, w, s, self.substeps, |r| out.push(r));
            out
        };
        windows.par_iter().zip(starts).map(one).collect::<Vec<_>>().concat()
    }

    /// How much more slowly than white noise the residual varies (1 is white).
    #[must_use]
    pub fn colour(&self, problem: &Problem) -> f64 {
        let residuals = self.residuals(problem);
        colour(residuals.iter().map(Vec::as_slice), RELIABLE)
    }

    /// Covariance of the fitted values, the noise inflated; none where it is not finite.
    #[must_use]
    pub fn covariance(&self, inflation: f64) -> Option<DMatrix<f64>> {
        let free = &self.hypothesis.free;
        let p = free.len();
        // The prior's precision is one; what data add is worth less where noise is inflated.
        let data = &self.precision - DMatrix::identity(p, p);
        let scaled = (DMatrix::identity(p, p) + data / inflation).cholesky()?.inverse();
        Some(DMatrix::from_fn(p, p, |i, j| scaled[(i, j)] * free[i].sd * free[j].sd))
    }

    /// Standard deviations of the fitted values, the noise inflated.
    #[must_use]
    pub fn std(&self, inflation: f64) -> Vec<f64> {
        let covariance = self.covariance(inflation);
        let own = |(i, f): (usize, &super::Free)| {
            covariance.as_ref().map_or(f.sd, |c| c[(i, i)].max(0.0).sqrt())
        };
        self.hypothesis.free.iter().enumerate().map(own).collect()
    }

    /// Parameters of the model with standard deviations; 0 for those that are known.
    #[must_use]
    pub fn parameter_std(&self, inflation: f64) -> Vec<f64> {
        let mut out = vec![0.0; self.hypothesis.parameters.len()];
        for (f, std) in self.hypothesis.free.iter().zip(self.std(inflation)) {
            if let What::Parameter(k) = f.what {
                out[k] = std;
            }
        }
        out
    }

    /// The effects with standard deviations of their physical parameters.
    #[must_use]
    pub fn effects(&self, inflation: f64) -> Vec<ModelEffect> {
        let std = self.std(inflation);
        let mut effects = self.hypothesis.effects.clone();
        for (index, e) in effects.iter_mut().enumerate().skip(self.hypothesis.own) {
            let mut internal = vec![0.0; e.internal().len()];
            for (f, s) in self.hypothesis.free.iter().zip(&std) {
                if let What::Effect(of, j) = f.what
                    && of == index
                {
                    internal[j] = s * f.slope(f.fitted(e.internal()[j]));
                }
            }
            e.std = physical_std(e, &internal);
        }
        effects
    }
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

/// Standard deviations of physical parameters from those of internal ones, which are taken as
/// independent.
fn physical_std(e: &ModelEffect, internal: &[f64]) -> Vec<Option<f64>> {
    let here = e.internal();
    let mut variance = vec![0.0; e.parameters.len()];
    for (j, s) in internal.iter().enumerate().filter(|(_, s)| **s > 0.0) {
        let step = 1e-4 * s;
        let mut moved = e.clone();
        let mut values = here.clone();
        values[j] += step;
        moved.set_internal(&values);
        for (v, (a, b)) in variance.iter_mut().zip(moved.parameters.iter().zip(&e.parameters)) {
            *v += ((a - b) / step * s).powi(2);
        }
    }
    variance.into_iter().map(|v: f64| (v > 0.0).then(|| v.sqrt())).collect()
}

fn minimise(
    problem: &Problem,
    hypothesis: Hypothesis,
    windowed: Windowed,
    effort: Effort,
) -> Option<Fit> {
    let substeps = problem.substeps(&hypothesis.parameters, &hypothesis.effects);
    let windowed = windowed.fitted_to(problem, &hypothesis);
    Minimisation { problem, hypothesis, windowed, substeps, anchored: false }.run(effort)
}
