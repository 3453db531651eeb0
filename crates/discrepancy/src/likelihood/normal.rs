//! Normal equations in the shape of an arrow: every window's states know theta and nothing of
//! each other, so they are eliminated window by window.

use super::Hypothesis;
use super::sweep::Columns;
use nalgebra::{Cholesky, DMatrix, DVector, Dyn};

/// What a window adds.
#[derive(Clone, Debug)]
pub struct Block {
    /// Normal matrix of the states.
    pub state: DMatrix<f64>,
    /// States by theta.
    pub cross: DMatrix<f64>,
    /// Normal matrix of theta.
    pub theta: DMatrix<f64>,
    /// Gradients.
    pub state_gradient: DVector<f64>,
    /// Gradient of theta.
    pub theta_gradient: DVector<f64>,
    /// Sum of squares.
    pub chi2: f64,
    /// Number of residuals.
    pub count: usize,
    /// Machine states of the window; memory stands after them.
    machine: usize,
    /// Prior standard deviations of the memory.
    spread: Vec<f64>,
}

impl Block {
    /// Of columns whose first `local` stand for states of the window.
    #[must_use]
    pub fn of(columns: &Columns, local: usize, unused: usize) -> Self {
        let rows = columns.residual.len();
        let matrix = |by: &[Vec<f64>]| DMatrix::from_fn(rows, by.len(), |i, j| by[j][i]);
        let (a, b) = (matrix(&columns.by[..local]), matrix(&columns.by[local + unused..]));
        let r = DVector::from_column_slice(&columns.residual);
        Self {
            state: a.tr_mul(&a),
            cross: a.tr_mul(&b),
            theta: b.tr_mul(&b),
            state_gradient: a.tr_mul(&r),
            theta_gradient: b.tr_mul(&r),
            chi2: r.norm_squared(),
            count: rows,
            machine: local,
            spread: vec![],
        }
    }

    /// Believe that the memory, which stands after `machine` states, begins `off` rest by at
    /// most a few `spread`.
    #[must_use]
    pub fn with_memory(mut self, machine: usize, off: &[f64], spread: &[f64]) -> Self {
        for (i, (off, sd)) in off.iter().zip(spread).enumerate() {
            let at = machine + i;
            self.state[(at, at)] += sd.powi(-2);
            self.state_gradient[at] -= off / (sd * sd);
        }
        self.machine = machine;
        self.spread = spread.to_vec();
        self
    }

    /// Factor of the states' normal matrix; a trace that nothing leaves is ridged.
    #[must_use]
    pub fn eliminable(&self) -> Option<Cholesky<f64, Dyn>> {
        ridged(&self.state, 0.0).cholesky()
    }

    /// Log determinant of the memory's precision in units of its prior, the machine's state
    /// eliminated.
    fn log_determinant(&self) -> f64 {
        let (n, z) = (self.machine, self.spread.len());
        if z == 0 {
            return 0.0;
        }
        let state = ridged(&self.state, 0.0);
        let Some(inner) = state.view((0, 0), (n, n)).into_owned().cholesky() else { return 0.0 };
        let corner = state.view((0, n), (n, z)).into_owned();
        let mut schur =
            state.view((n, n), (z, z)).into_owned() - corner.tr_mul(&inner.solve(&corner));
        for i in 0..z {
            for j in 0..z {
                schur[(i, j)] *= self.spread[i] * self.spread[j];
            }
        }
        schur.cholesky().map_or(0.0, |c| 2.0 * c.l().diagonal().map(f64::ln).sum())
    }
}

fn ridged(state: &DMatrix<f64>, damping: f64) -> DMatrix<f64> {
    let mut out = state.clone();
    let largest = state.diagonal().iter().fold(0.0f64, |a, d| a.max(*d));
    for i in 0..state.nrows() {
        out[(i, i)] += (damping + 1e-9) * state[(i, i)] + 1e-14 * largest + f64::MIN_POSITIVE;
    }
    out
}

/// The normal equations of all windows.
pub struct Arrow<'a> {
    hypothesis: &'a Hypothesis,
    blocks: &'a [Block],
}

/// A step of theta and of every window's states.
pub struct Step {
    /// Of theta, bounds respected.
    pub theta: Vec<f64>,
    /// Of each window's states.
    pub states: Vec<DVector<f64>>,
}

/// Normal equations of theta alone.
struct Reduced {
    schur: DMatrix<f64>,
    gradient: DVector<f64>,
    factors: Vec<Cholesky<f64, Dyn>>,
}

impl<'a> Arrow<'a> {
    /// The blocks of all windows, for a hypothesis.
    #[must_use]
    pub fn new(hypothesis: &'a Hypothesis, blocks: &'a [Block]) -> Self {
        Self { hypothesis, blocks }
    }

    /// Eliminate the states: theta in units of its prior, whose precision is the identity.
    fn reduce(&self, theta: &[f64], damping: f64) -> Option<Reduced> {
        let free = &self.hypothesis.free;
        let p = free.len();
        let (mut schur, mut gradient) = (DMatrix::zeros(p, p), DVector::zeros(p));
        let mut factors = Vec::with_capacity(self.blocks.len());
        for b in self.blocks {
            let factor = ridged(&b.state, damping).cholesky()?;
            let solved = factor.solve(&b.cross);
            schur += &b.theta - b.cross.tr_mul(&solved);
            gradient += &b.theta_gradient - solved.tr_mul(&b.state_gradient);
            factors.push(factor);
        }
        for i in 0..p {
            gradient[i] = gradient[i] * free[i].sd - (theta[i] - free[i].mean) / free[i].sd;
            for j in 0..p {
                schur[(i, j)] *= free[i].sd * free[j].sd;
            }
            schur[(i, i)] += 1.0;
        }
        Some(Reduced { schur, gradient, factors })
    }

    /// A damped Gauss-Newton step from `theta`.
    #[must_use]
    pub fn step(&self, theta: &[f64], damping: f64) -> Option<Step> {
        let free = &self.hypothesis.free;
        let Reduced { mut schur, gradient, factors } = self.reduce(theta, damping)?;
        for i in 0..free.len() {
            schur[(i, i)] *= 1.0 + damping;
        }
        let leaves = |i: usize, step: f64| {
            let (low, high) = free[i].bounds;
            (theta[i] <= low && step < 0.0) || (theta[i] >= high && step > 0.0)
        };
        let mut active: Vec<usize> = (0..free.len()).collect();
        let mut step = vec![0.0; free.len()];
        // Entries at a bound that the step would leave stay there.
        while !active.is_empty() {
            let matrix = schur.select_rows(&active).select_columns(&active);
            let right = gradient.select_rows(&active);
            let solved = matrix.cholesky()?.solve(&right);
            step.fill(0.0);
            for (&i, d) in active.iter().zip(solved.iter()) {
                step[i] = d * free[i].sd;
            }
            let before = active.len();
            active.retain(|&i| !leaves(i, step[i]));
            if active.len() == before {
                break;
            }
        }
        if active.is_empty() {
            step.fill(0.0);
        }
        let moved: Vec<f64> = (0..free.len())
            .map(|i| (theta[i] + step[i]).clamp(free[i].bounds.0, free[i].bounds.1))
            .collect();
        let taken = DVector::from_fn(free.len(), |i, _| moved[i] - theta[i]);
        let states = self
            .blocks
            .iter()
            .zip(&factors)
            .map(|(b, factor)| factor.solve(&(&b.state_gradient - &b.cross * &taken)))
            .collect();
        Some(Step { theta: moved, states })
    }

    /// Precision of theta in units of its prior, states eliminated, and its log determinant
    /// together with the memories'.
    #[must_use]
    pub fn precision(&self, theta: &[f64]) -> Option<(DMatrix<f64>, f64)> {
        let schur = self.reduce(theta, 0.0)?.schur;
        let log = 2.0 * schur.clone().cholesky()?.l().diagonal().map(f64::ln).sum();
        let memory: f64 = self.blocks.iter().map(Block::log_determinant).sum();
        Some((schur, log + memory))
    }
}
