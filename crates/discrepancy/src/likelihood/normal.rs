//! Normal equations in the shape of an arrow: every window's states know theta and nothing of
//! each other, so they are eliminated window by window.

use super::Hypothesis;
use super::end::FitError;
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
    ///
    /// # Errors
    /// [`FitError::Singular`].
    pub fn eliminable(&self) -> Result<Cholesky<f64, Dyn>, FitError> {
        ridged(&self.state, 0.0).cholesky().ok_or(FitError::Singular)
    }

    /// Precision of the memory in units of its prior, the machine's state eliminated; none where
    /// the window has no memory that is free.
    fn memory_precision(&self) -> Result<Option<DMatrix<f64>>, FitError> {
        let (n, z) = (self.machine, self.spread.len());
        if z == 0 {
            return Ok(None);
        }
        let state = ridged(&self.state, 0.0);
        let inner = state.view((0, 0), (n, n)).into_owned().cholesky().ok_or(FitError::Singular)?;
        let corner = state.view((0, n), (n, z)).into_owned();
        let mut schur =
            state.view((n, n), (z, z)).into_owned() - corner.tr_mul(&inner.solve(&corner));
        for i in 0..z {
            for j in 0..z {
                schur[(i, j)] *= self.spread[i] * self.spread[j];
            }
        }
        Ok(Some(schur))
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
    /// Whether a window is left out: its own states follow theta, which does not know of it.
    left_out: &'a [bool],
}

/// A step of theta and of every window's states.
pub struct Step {
    /// Of theta, bounds respected.
    pub theta: Vec<f64>,
    /// Of each window's states.
    pub states: Vec<DVector<f64>>,
    /// By how much the objective would fall if the residual were linear.
    pub promised: f64,
}

/// Normal equations of theta alone.
struct Reduced {
    schur: DMatrix<f64>,
    gradient: DVector<f64>,
    factors: Vec<Cholesky<f64, Dyn>>,
    /// By how much the objective would fall by the states alone.
    promised: f64,
}

impl<'a> Arrow<'a> {
    /// The blocks of all windows, for a hypothesis; those marked in `left_out` (as many, or none)
    /// do not count for theta.
    #[must_use]
    pub fn new(hypothesis: &'a Hypothesis, blocks: &'a [Block], left_out: &'a [bool]) -> Self {
        Self { hypothesis, blocks, left_out }
    }

    /// Eliminate the states: theta in units of its prior, whose precision is the identity.
    fn reduce(&self, theta: &[f64], damping: f64) -> Result<Reduced, FitError> {
        let free = &self.hypothesis.free;
        let p = free.len();
        let (mut schur, mut gradient) = (DMatrix::zeros(p, p), DVector::zeros(p));
        let mut factors = Vec::with_capacity(self.blocks.len());
        let mut promised = 0.0;
        for (k, b) in self.blocks.iter().enumerate() {
            let factor = ridged(&b.state, damping).cholesky().ok_or(FitError::Singular)?;
            if !self.left_out.get(k).is_some_and(|left_out| *left_out) {
                let solved = factor.solve(&b.cross);
                schur += &b.theta - b.cross.tr_mul(&solved);
                gradient += &b.theta_gradient - solved.tr_mul(&b.state_gradient);
                promised += b.state_gradient.dot(&factor.solve(&b.state_gradient));
            }
            factors.push(factor);
        }
        for i in 0..p {
            gradient[i] = gradient[i] * free[i].sd - (theta[i] - free[i].mean) / free[i].sd;
            for j in 0..p {
                schur[(i, j)] *= free[i].sd * free[j].sd;
            }
            schur[(i, i)] += 1.0;
        }
        Ok(Reduced { schur, gradient, factors, promised })
    }

    /// A damped Gauss-Newton step from `theta`.
    ///
    /// # Errors
    /// [`FitError::Singular`].
    pub fn step(&self, theta: &[f64], damping: f64) -> Result<Step, FitError> {
        let free = &self.hypothesis.free;
        let Reduced { mut schur, gradient, factors, mut promised } = self.reduce(theta, damping)?;
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
            let solved = matrix.cholesky().ok_or(FitError::Singular)?.solve(&right);
            step.fill(0.0);
            for (&i, d) in active.iter().zip(solved.iter()) {
                step[i] = d * free[i].sd;
            }
            let before = active.len();
            active.retain(|&i| !leaves(i, step[i]));
            if active.len() == before {
                promised += right.dot(&solved);
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
        Ok(Step { theta: moved, states, promised })
    }

    /// Precision of theta in units of its prior, states eliminated; and that of the memories at
    /// the recordings' beginnings.
    ///
    /// # Errors
    /// [`FitError::Singular`].
    pub fn precision(&self, theta: &[f64]) -> Result<Precision, FitError> {
        let theta = self.reduce(theta, 0.0)?.schur;
        let memory: Result<Vec<_>, _> = self.blocks.iter().map(Block::memory_precision).collect();
        Ok(Precision { theta, memory: memory?.into_iter().flatten().collect() })
    }
}

/// What is known of theta and of the memories, in units of their priors, whose precision is the
/// identity.
#[derive(Clone, Debug)]
pub struct Precision {
    /// Of theta.
    pub theta: DMatrix<f64>,
    /// Of the memory at the beginning of each recording that has one.
    pub memory: Vec<DMatrix<f64>>,
}

impl Precision {
    /// Log determinant where data are worth one in `temperature`.
    #[must_use]
    pub fn log_determinant(&self, temperature: f64) -> f64 {
        let one = |m: &DMatrix<f64>| {
            // Rounding may leave what no datum touches a little below the prior's one.
            let cooled = cooled(m, temperature);
            cooled.cholesky().map_or(0.0, |c| 2.0 * c.l().diagonal().map(f64::ln).sum())
        };
        one(&self.theta) + self.memory.iter().map(one).sum::<f64>()
    }

    /// Covariance of theta in units of its prior where data are worth one in `temperature`; none
    /// where it is not finite.
    #[must_use]
    pub fn covariance(&self, temperature: f64) -> Option<DMatrix<f64>> {
        Some(cooled(&self.theta, temperature).cholesky()?.inverse())
    }
}

/// The prior's precision is one; what data add is worth one in `temperature`.
fn cooled(precision: &DMatrix<f64>, temperature: f64) -> DMatrix<f64> {
    let n = precision.nrows();
    let prior = DMatrix::identity(n, n);
    &prior + (precision - &prior) / temperature
}
