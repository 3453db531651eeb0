//! Multiple shooting: parameters and effects fitted with the differential equation itself.
//!
//! Each recording is cut into windows with free initial states x_w; the model runs through
//! each window, and
//!
//! ```text
//! chi^2 = sum_w |(y_w - h(x(t; x_w, theta))) / sigma|^2 + |(theta - theta_0) / s|^2
//! ```
//!
//! is minimised over theta (calibrated parameters, parameters of effects) and all x_w by
//! Levenberg-Marquardt. The normal equations have the shape of an arrow; the states of each
//! window are eliminated by their Schur complement, so that the cost grows with the number of
//! windows and not with its cube.

use crate::candidates::Term;
use crate::dataset::Dataset;
use crate::evidence::colour;
use crate::prediction::{Driven, Predictor, state_step, windows};
use lacuna_effects::{Law, Range as Values};
use lacuna_plants::Model;
use lacuna_plants::model::{Equations, ModelEffect};
use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;
use std::ops::Range;

/// One entry of theta.
#[derive(Clone, Copy, Debug)]
struct Free {
    what: What,
    /// Whether its logarithm is fitted.
    logarithmic: bool,
    /// Prior mean and standard deviation of the fitted value; infinite for none.
    prior: (f64, f64),
    /// Step of finite differences.
    step: f64,
    /// Bounds of the fitted value.
    bounds: (f64, f64),
}

#[derive(Clone, Copy, Debug)]
enum What {
    Parameter(usize),
    Effect(usize, usize),
}

/// A model with effects to be fitted to a dataset.
pub struct Shooting<'a> {
    model: &'a Model,
    equations: Equations,
    dataset: &'a Dataset,
    effects: Vec<ModelEffect>,
    free: Vec<Free>,
}

/// A fitted model.
#[derive(Clone, Debug)]
pub struct ShootingFit {
    /// Parameters of the model.
    pub parameters: Vec<f64>,
    /// Standard deviations of the parameters; 0 for those that are known.
    pub parameter_std: Vec<f64>,
    /// Effects: those of the model, then the new ones.
    pub effects: Vec<ModelEffect>,
    /// Sum of squares of the weighted residuals.
    pub chi2: f64,
    /// Number of residuals.
    pub count: usize,
    /// How much more slowly than white noise the residual varies (1 is white).
    pub colour: f64,
    /// Length of the windows (s).
    pub horizon: f64,
    /// The windows with their states.
    windows: Vec<Window>,
}

impl ShootingFit {
    /// Mean square of the residual in units of the noise.
    #[must_use]
    pub fn reduced(&self) -> f64 {
        self.chi2 / self.count.max(1) as f64
    }
}

/// Parameters stay within this many tolerances.
const MOST_TOLERANCES: f64 = 4.0;
/// Windows grow as long as the residual's root mean square is below this many noise standard
/// deviations.
pub(crate) const MOST_RMS: f64 = 5.5;
/// Most Levenberg-Marquardt steps in windows of one length.
const MOST_STEPS: usize = 12;
/// Shapes stay within this natural logarithm of what the screening refined.
const ROOM: f64 = 1.5;

impl<'a> Shooting<'a> {
    /// Fit `terms` with the amplitudes `amplitudes` in addition to the model's own effects.
    #[must_use]
    pub fn new(model: &'a Model, dataset: &'a Dataset, new: Vec<ModelEffect>) -> Self {
        let mut free = Vec::new();
        for (k, p) in model.parameters.iter().enumerate().filter(|(_, p)| p.std() > 0.0) {
            let room = MOST_TOLERANCES * p.std();
            free.push(Free {
                what: What::Parameter(k),
                logarithmic: false,
                prior: (p.value, p.std()),
                step: 1e-4 * p.std(),
                bounds: (p.value - room, p.value + room),
            });
        }
        let own = model.effects.len();
        let mut effects = model.effects.clone();
        effects.extend(new);
        for (e, effect) in effects.iter().enumerate().skip(own) {
            let largest = effect.parameters.iter().fold(0.0f64, |m, v| m.max(v.abs()));
            for (j, p) in effect.effect.parameters.iter().enumerate() {
                let value = effect.parameters[j];
                // A side is a sign, not a magnitude.
                if p.name == "side" {
                    continue;
                }
                let logarithmic = p.range == Values::Positive;
                let (step, bounds) = if logarithmic {
                    (1e-3, (value.ln() - ROOM, value.ln() + ROOM))
                } else {
                    let low = if p.range == Values::NonNegative { 0.0 } else { f64::NEG_INFINITY };
                    // A value that begins at 0 still needs a step that is seen.
                    let size = value.abs().max(1e-3 * largest).max(1e-3);
                    (1e-5 * size, (low, f64::INFINITY))
                };
                let prior = if logarithmic { (value.ln(), 1.0) } else { (value, f64::INFINITY) };
                free.push(Free { what: What::Effect(e, j), logarithmic, prior, step, bounds });
            }
        }
        Self { model, equations: Equations::of(model), dataset, effects, free }
    }

    /// No parameter of the model moves: only states (and effects) are fitted.
    #[must_use]
    pub fn with_parameters_held(mut self) -> Self {
        self.free.retain(|f| !matches!(f.what, What::Parameter(_)));
        self
    }

    fn start(&self, parameters: &[f64]) -> DVector<f64> {
        let value = |f: &Free| {
            let raw = match f.what {
                What::Parameter(k) => parameters[k],
                What::Effect(e, j) => self.effects[e].parameters[j],
            };
            let fitted = if f.logarithmic { raw.ln() } else { raw };
            fitted.clamp(f.bounds.0, f.bounds.1)
        };
        DVector::from_iterator(self.free.len(), self.free.iter().map(value))
    }

    /// Parameters and effects that theta stands for.
    fn unpack(&self, theta: &DVector<f64>, parameters: &[f64]) -> (Vec<f64>, Vec<ModelEffect>) {
        let (mut parameters, mut effects) = (parameters.to_vec(), self.effects.clone());
        for (f, &fitted) in self.free.iter().zip(theta.iter()) {
            let value = if f.logarithmic { fitted.exp() } else { fitted };
            match f.what {
                What::Parameter(k) => parameters[k] = value,
                What::Effect(e, j) => effects[e].parameters[j] = value,
            }
        }
        (parameters, effects)
    }

    fn predictor(
        &self,
        theta: &DVector<f64>,
        parameters: &[f64],
        substeps: usize,
    ) -> Predictor<'a> {
        let (p, e) = self.unpack(theta, parameters);
        Predictor::with_substeps(self.model, &self.equations, &p, &e, self.dataset, substeps)
    }

    /// Fit from `parameters`, with windows that grow from `horizon` seconds to the whole
    /// recordings as long as the model can follow them.
    #[must_use]
    pub fn fit(&self, parameters: &[f64], horizon: f64, longest: f64) -> ShootingFit {
        let mut run = Run::new(self, parameters, horizon);
        run.minimise(MOST_STEPS);
        let mut horizon = horizon;
        while horizon < longest && run.follows() {
            let shorter = (run.clone(), horizon);
            // A model at the noise will follow much longer windows too.
            let growth = if run.rms() < 1.2 { 4.0 } else { 2.0 };
            horizon = (growth * horizon).min(longest);
            run.lengthen(horizon);
            run.minimise(MOST_STEPS);
            if !run.follows() {
                (run, horizon) = shorter;
                break;
            }
        }
        run.result(horizon)
    }

    /// Fit from `parameters` in the very windows of another fit, beginning from its states:
    /// what differs by little ends in the same valley.
    #[must_use]
    pub fn fit_like(&self, parameters: &[f64], other: &ShootingFit) -> ShootingFit {
        let predictor = self.predictor(&self.start(parameters), parameters, 1);
        let mut windows = other.windows.clone();
        for w in &mut windows {
            w.state = predictor.with_memory_at_rest(&w.state);
        }
        let mut run = Run::in_windows(self, parameters, windows);
        run.minimise(MOST_STEPS);
        run.result(other.horizon)
    }
}

/// One window and its state.
#[derive(Clone, Debug)]
struct Window {
    recording: usize,
    range: Range<usize>,
    state: Vec<f64>,
}

/// A minimisation under way.
#[derive(Clone)]
struct Run<'a, 'b> {
    shooting: &'b Shooting<'a>,
    parameters: Vec<f64>,
    theta: DVector<f64>,
    windows: Vec<Window>,
    substeps: usize,
    damping: f64,
    cost: f64,
    /// Posterior precision of theta, states eliminated.
    precision: DMatrix<f64>,
}

/// What a window adds to the normal equations.
struct Block {
    /// Normal matrix and gradient of the state.
    state: DMatrix<f64>,
    state_gradient: DVector<f64>,
    /// State by theta.
    cross: DMatrix<f64>,
    theta: DMatrix<f64>,
    theta_gradient: DVector<f64>,
    chi2: f64,
}

/// One simulation of a window: as it is, or with one thing moved.
#[derive(Clone, Copy)]
enum Job {
    Base,
    State(usize),
    Theta(usize),
}

impl<'a, 'b> Run<'a, 'b> {
    /// Windows of `horizon` seconds, their states fitted to the parameters.
    fn new(shooting: &'b Shooting<'a>, parameters: &[f64], horizon: f64) -> Self {
        let (p, e) = shooting.unpack(&shooting.start(parameters), parameters);
        let predictor =
            Predictor::with(shooting.model, &shooting.equations, &p, &e, shooting.dataset);
        let list: Vec<(usize, Range<usize>)> = shooting
            .dataset
            .recordings
            .iter()
            .enumerate()
            .flat_map(|(r, o)| windows(&o.times, horizon).into_iter().map(move |w| (r, w)))
            .collect();
        let windows = list
            .into_par_iter()
            .map(|(recording, range)| {
                let driven = predictor.drive(&shooting.dataset.recordings[recording]);
                let state = predictor.fit_state(&driven, range.clone());
                Window { recording, range, state }
            })
            .collect();
        Self::in_windows(shooting, parameters, windows)
    }

    fn in_windows(shooting: &'b Shooting<'a>, parameters: &[f64], windows: Vec<Window>) -> Self {
        let theta = shooting.start(parameters);
        let (p, e) = shooting.unpack(&theta, parameters);
        let predictor =
            Predictor::with(shooting.model, &shooting.equations, &p, &e, shooting.dataset);
        let (substeps, n) = (predictor.substeps(), theta.len());
        let mut this = Self {
            shooting,
            parameters: parameters.to_vec(),
            theta,
            windows,
            substeps,
            damping: 1e-3,
            cost: f64::INFINITY,
            precision: DMatrix::zeros(n, n),
        };
        this.cost = this.cost_at(&this.theta, &this.windows);
        this
    }

    fn drives(&self, predictor: &Predictor) -> Vec<Driven<'a>> {
        self.shooting.dataset.recordings.iter().map(|o| predictor.drive(o)).collect()
    }

    fn penalty(&self, theta: &DVector<f64>) -> f64 {
        let pull = |(f, t): (&Free, &f64)| ((t - f.prior.0) / f.prior.1).powi(2);
        self.shooting.free.iter().zip(theta.iter()).map(pull).sum()
    }

    fn cost_at(&self, theta: &DVector<f64>, windows: &[Window]) -> f64 {
        let predictor = self.shooting.predictor(theta, &self.parameters, self.substeps);
        let drives = self.drives(&predictor);
        let costs: Vec<f64> = windows
            .par_iter()
            .map(|w| predictor.residual(&drives[w.recording], &w.range, &w.state).norm_squared())
            .collect();
        costs.iter().sum::<f64>() + self.penalty(theta)
    }

    fn blocks(&self) -> Vec<Block> {
        let shooting = self.shooting;
        let predictor = |theta: &DVector<f64>| {
            let p = shooting.predictor(theta, &self.parameters, self.substeps);
            let drives = self.drives(&p);
            (p, drives)
        };
        let base = predictor(&self.theta);
        let moved: Vec<_> = (0..self.theta.len())
            .map(|j| {
                let mut theta = self.theta.clone();
                theta[j] += shooting.free[j].step;
                predictor(&theta)
            })
            .collect();
        let run = |(p, drives): &(Predictor, Vec<Driven>), w: &Window, x: &[f64]| {
            p.residual(&drives[w.recording], &w.range, x)
        };
        // Every run of every window is a job of its own: few long windows keep all cores
        // as busy as many short ones.
        let jobs: Vec<(usize, Job)> = (0..self.windows.len())
            .flat_map(|w| {
                let states = (0..self.windows[w].state.len()).map(Job::State);
                let entries = (0..moved.len()).map(Job::Theta);
                std::iter::once(Job::Base).chain(states).chain(entries).map(move |j| (w, j))
            })
            .collect();
        let results: Vec<DVector<f64>> = jobs
            .par_iter()
            .map(|&(w, job)| {
                let w = &self.windows[w];
                match job {
                    Job::Base => run(&base, w, &w.state),
                    Job::Theta(j) => run(&moved[j], w, &w.state),
                    Job::State(i) => {
                        let mut x = w.state.clone();
                        x[i] += state_step(x[i]);
                        run(&base, w, &x)
                    }
                }
            })
            .collect();
        let per_window = 1 + self.windows[0].state.len() + moved.len();
        results.chunks_exact(per_window).zip(&self.windows).map(|(r, w)| self.block(r, w)).collect()
    }

    /// Normal equations of a window from the residuals of its runs: base, states, theta.
    fn block(&self, runs: &[DVector<f64>], w: &Window) -> Block {
        let (residual, rest) = (&runs[0], &runs[1..]);
        let (states, entries) = rest.split_at(w.state.len());
        let columns = |moved: &[DVector<f64>], step: &dyn Fn(usize) -> f64| {
            let columns: Vec<_> =
                moved.iter().enumerate().map(|(j, m)| (residual - m) / step(j)).collect();
            if columns.is_empty() {
                DMatrix::zeros(residual.len(), 0)
            } else {
                DMatrix::from_columns(&columns)
            }
        };
        let a = columns(states, &|i| state_step(w.state[i]));
        let b = columns(entries, &|j| self.shooting.free[j].step);
        Block {
            state: a.tr_mul(&a),
            state_gradient: a.tr_mul(residual),
            cross: a.tr_mul(&b),
            theta: b.tr_mul(&b),
            theta_gradient: b.tr_mul(residual),
            chi2: residual.norm_squared(),
        }
    }

    /// Levenberg-Marquardt until a step gains next to nothing.
    fn minimise(&mut self, most: usize) {
        for _ in 0..most {
            let blocks = self.blocks();
            let before = blocks.iter().map(|b| b.chi2).sum::<f64>() + self.penalty(&self.theta);
            self.cost = before;
            let mut gained = None;
            for _ in 0..7 {
                if let Some((theta, windows)) = self.step(&blocks) {
                    let cost = self.cost_at(&theta, &windows);
                    if cost < before {
                        (self.theta, self.windows, self.cost) = (theta, windows, cost);
                        self.damping = (0.1 * self.damping).max(1e-8);
                        gained = Some(before - cost);
                        break;
                    }
                }
                self.damping *= 10.0;
            }
            if gained.is_none_or(|g| g < 0.1 + 1e-5 * before) {
                break;
            }
        }
        self.update_precision();
    }

    /// Schur complement of theta and its gradient, with factors of the state blocks.
    fn reduce(&self, blocks: &[Block], damping: f64) -> Option<Reduced> {
        let p = self.theta.len();
        let (mut schur, mut gradient) = (DMatrix::zeros(p, p), DVector::zeros(p));
        let mut factors = Vec::with_capacity(blocks.len());
        for b in blocks {
            let mut state = b.state.clone();
            let largest = state.diagonal().max();
            for i in 0..state.nrows() {
                state[(i, i)] += damping * b.state[(i, i)] + 1e-13 * largest + f64::MIN_POSITIVE;
            }
            let factor = state.cholesky()?;
            let solved = factor.solve(&b.cross);
            schur += &b.theta - b.cross.tr_mul(&solved);
            gradient += &b.theta_gradient - solved.tr_mul(&b.state_gradient);
            factors.push(factor);
        }
        for (j, f) in self.shooting.free.iter().enumerate() {
            let weight = f.prior.1.powi(-2);
            schur[(j, j)] += weight;
            gradient[j] -= weight * (self.theta[j] - f.prior.0).clamp(-1e300, 1e300);
        }
        Some(Reduced { schur, gradient, factors })
    }

    fn step(&self, blocks: &[Block]) -> Option<(DVector<f64>, Vec<Window>)> {
        let Reduced { schur, gradient, factors } = self.reduce(blocks, self.damping)?;
        let p = self.theta.len();
        let mut held = vec![false; p];
        let mut step = DVector::zeros(p);
        // Entries at a bound that the step would leave are held there.
        for _ in 0..=p {
            let mut damped = schur.clone();
            let mut right = gradient.clone();
            for j in 0..p {
                damped[(j, j)] += self.damping * schur[(j, j)] + 1e-30;
                if held[j] {
                    damped.row_mut(j).fill(0.0);
                    damped.column_mut(j).fill(0.0);
                    damped[(j, j)] = 1.0;
                    right[j] = 0.0;
                }
            }
            // Entries differ by many orders of magnitude: scale to a unit diagonal.
            let scale = damped.diagonal().map(|d| 1.0 / d.max(f64::MIN_POSITIVE).sqrt());
            let scaled = DMatrix::from_fn(p, p, |i, j| damped[(i, j)] * scale[i] * scale[j]);
            step = scaled.cholesky()?.solve(&right.component_mul(&scale)).component_mul(&scale);
            let leaves = (0..p).find(|&j| {
                let (low, high) = self.shooting.free[j].bounds;
                let t = self.theta[j];
                !held[j] && ((t <= low && step[j] < 0.0) || (t >= high && step[j] > 0.0))
            });
            match leaves {
                Some(j) => held[j] = true,
                None => break,
            }
        }
        let mut theta = &self.theta + &step;
        for (j, f) in self.shooting.free.iter().enumerate() {
            theta[j] = theta[j].clamp(f.bounds.0, f.bounds.1);
        }
        let taken = &theta - &self.theta;
        let windows = self
            .windows
            .iter()
            .zip(blocks.iter().zip(&factors))
            .map(|(w, (b, factor))| {
                let change = factor.solve(&(&b.state_gradient - &b.cross * &taken));
                let state = w.state.iter().zip(change.iter()).map(|(x, d)| x + d).collect();
                Window { state, ..w.clone() }
            })
            .collect();
        Some((theta, windows))
    }

    fn update_precision(&mut self) {
        let blocks = self.blocks();
        if let Some(reduced) = self.reduce(&blocks, 0.0) {
            self.precision = reduced.schur;
        }
    }

    /// Root mean square residual in units of the noise.
    fn rms(&self) -> f64 {
        let predictor = self.shooting.predictor(&self.theta, &self.parameters, self.substeps);
        let drives = self.drives(&predictor);
        let squares: Vec<(f64, usize)> = self
            .windows
            .par_iter()
            .map(|w| {
                let r = predictor.residual(&drives[w.recording], &w.range, &w.state);
                (r.norm_squared(), r.len())
            })
            .collect();
        let (sum, count) = squares.iter().fold((0.0, 0), |(s, n), (a, b)| (s + a, n + b));
        (sum / count.max(1) as f64).sqrt()
    }

    /// Whether the model follows the windows well enough to be tried on longer ones. Beyond a
    /// few times the noise the model is wrong somewhere, what is wrong adds up with the
    /// length, and long windows would weigh little else.
    fn follows(&self) -> bool {
        self.rms() < MOST_RMS
    }

    /// Cut the recordings into windows of `horizon` seconds, the states taken from where the
    /// present windows run through.
    fn lengthen(&mut self, horizon: f64) {
        let predictor = self.shooting.predictor(&self.theta, &self.parameters, self.substeps);
        let drives = self.drives(&predictor);
        let mut longer = Vec::new();
        for (recording, observed) in self.shooting.dataset.recordings.iter().enumerate() {
            for range in windows(&observed.times, horizon) {
                let begins = |w: &&Window| w.recording == recording && w.range.start == range.start;
                let state = match self.windows.iter().find(begins) {
                    Some(w) => w.state.clone(),
                    None => predictor.fit_state(&drives[recording], range.clone()),
                };
                longer.push(Window { recording, range, state });
            }
        }
        self.windows = longer;
        self.damping = 1e-3;
        self.cost = self.cost_at(&self.theta, &self.windows);
    }

    fn result(&self, horizon: f64) -> ShootingFit {
        let predictor = self.shooting.predictor(&self.theta, &self.parameters, self.substeps);
        let drives = self.drives(&predictor);
        let residuals: Vec<DVector<f64>> = self
            .windows
            .par_iter()
            .map(|w| predictor.residual(&drives[w.recording], &w.range, &w.state))
            .collect();
        let chi2 = residuals.iter().map(|r| r.norm_squared()).sum::<f64>();
        let count = residuals.iter().map(|r| r.len()).sum::<usize>();
        let colour = colour(residuals.iter().map(|r| r.as_slice()));
        // Residuals that are larger or slower than white noise say less.
        let inflation = (chi2 / count.max(1) as f64).max(1.0) * colour;
        let variance = |j: usize| {
            let scale = self.precision.diagonal().map(|d| 1.0 / d.max(f64::MIN_POSITIVE).sqrt());
            let n = self.theta.len();
            let scaled =
                DMatrix::from_fn(n, n, |a, b| self.precision[(a, b)] * scale[a] * scale[b]);
            scaled.pseudo_inverse(1e-12).map_or(f64::NAN, |inv| inv[(j, j)] * scale[j] * scale[j])
        };
        let (parameters, mut effects) = self.shooting.unpack(&self.theta, &self.parameters);
        let mut parameter_std = vec![0.0; parameters.len()];
        for (j, f) in self.shooting.free.iter().enumerate() {
            let variance = variance(j) * inflation;
            let known = variance.is_finite() && variance > 0.0;
            let scale = if f.logarithmic { self.theta[j].exp() } else { 1.0 };
            let std = known.then(|| variance.sqrt() * scale);
            match f.what {
                What::Parameter(k) => {
                    let prior = self.shooting.model.parameters[k].std();
                    parameter_std[k] = std.map_or(prior, |s| s.min(prior));
                }
                What::Effect(e, j) => effects[e].std[j] = std,
            }
        }
        let windows = self.windows.clone();
        ShootingFit { parameters, parameter_std, effects, chi2, count, colour, horizon, windows }
    }
}

struct Reduced {
    schur: DMatrix<f64>,
    gradient: DVector<f64>,
    factors: Vec<nalgebra::Cholesky<f64, nalgebra::Dyn>>,
}

/// A term of the screening as an effect of the model.
#[must_use]
pub fn model_effect(term: &Term, amplitudes: &[f64]) -> ModelEffect {
    let effect = term.candidate.effect;
    let mut parameters = match effect.law {
        Law::Force(law) => {
            let internal: Vec<f64> = amplitudes.iter().chain(&term.shape).copied().collect();
            law.physical(&internal)
        }
        _ => term.shape.clone(),
    };
    for (value, p) in parameters.iter_mut().zip(effect.parameters) {
        if p.range == Values::NonNegative {
            *value = value.max(0.0);
        }
    }
    let std = vec![None; parameters.len()];
    let (channel, other) = (term.candidate.channel, term.candidate.other);
    ModelEffect { effect, channel, other, parameters, std }
}
