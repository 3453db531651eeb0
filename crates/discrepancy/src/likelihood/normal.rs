//! Normal equations in the shape of an arrow: every window's states know theta and nothing of
//! each other, so they are eliminated window by window.
//!
//! A window's columns are A by its states and B by theta, its residual r. With A = Q R what theta says that the
//! states cannot is
//!
//! ```text
//! B - Q Q' B,    and its normal matrix  S = (B - Q Q' B)' (B - Q Q' B)
//! ```
//!
//! S is never the difference of two large matrices, and never negative: along a motion that runs away from
//! itself states and theta are nearly the same, and all digits of such a difference would be lost.

use super::end::FitError;
use super::sweep::Columns;
use super::{Free, Hypothesis, boxed};
use nalgebra::{DMatrix, DVector};

/// What a window adds.
#[derive(Clone, Debug)]
pub struct Block {
    /// R.
    states: DMatrix<f64>,
    /// Q' B.
    cross: DMatrix<f64>,
    /// Q' r.
    state_residual: DVector<f64>,
    /// S.
    theta: DMatrix<f64>,
    /// Gradient of theta beside states that follow it.
    theta_gradient: DVector<f64>,
    /// Sum of squares.
    pub chi2: f64,
    /// Number of residuals.
    pub count: usize,
    /// Prior standard deviations of the states that are memory, the last ones.
    spread: Vec<f64>,
}

/// What is believed of the memory with which a window begins: how far off rest it is, and the standard
/// deviation of that.
#[derive(Clone, Copy, Debug, Default)]
pub struct Memory<'a> {
    /// How far off rest it is.
    pub off: &'a [f64],
    /// By how much it usually is.
    pub spread: &'a [f64],
}

impl Block {
    /// Of columns whose first `local` stand for states of the window, memory the last of them.
    #[must_use]
    pub fn of(columns: &Columns, (local, unused): (usize, usize), memory: Memory) -> Self {
        let (rows, z) = (columns.residual.len(), memory.spread.len());
        // What is believed of the memory is as good as measured.
        let believed = |i: usize, j: usize| {
            if j + z == local + i - rows { memory.spread[i - rows].recip() } else { 0.0 }
        };
        let a = DMatrix::from_fn(rows + z, local, |i, j| {
            if i < rows { columns.by[j][i] } else { believed(i, j) }
        });
        let theta = &columns.by[local + unused..];
        let mut b = DMatrix::zeros(rows + z, theta.len());
        for (mut to, from) in b.column_iter_mut().zip(theta) {
            to.as_mut_slice()[..rows].copy_from_slice(from);
        }
        let off = memory.off.iter().zip(memory.spread).map(|(off, sd)| -off / sd);
        let residual: Vec<f64> = columns.residual.iter().copied().chain(off).collect();
        let r = DVector::from_vec(residual);
        let Parted { triangle, cross, state_residual, rest } = parted(a, b, &r);
        Self {
            states: triangle,
            cross,
            state_residual,
            theta: rest.tr_mul(&rest),
            theta_gradient: rest.tr_mul(&r),
            chi2: columns.residual.iter().map(|r| r * r).sum(),
            count: rows,
            spread: memory.spread.to_vec(),
        }
    }

    /// The states eliminated, each held where it is as if that were known with a share `damping` of what
    /// the window says of it. What nothing tells is held a little in any case.
    #[must_use]
    pub fn eliminated(&self, damping: f64) -> Eliminated {
        let (k, n) = self.states.shape();
        let told: Vec<f64> = self.states.column_iter().map(|c| c.norm_squared()).collect();
        let largest = told.iter().fold(0.0f64, |a, d| a.max(*d));
        let held =
            |j: usize| ((damping + 1e-20) * told[j] + 1e-20 * largest + f64::MIN_POSITIVE).sqrt();
        let a = DMatrix::from_fn(k + n, n, |i, j| match i {
            i if i < k => self.states[(i, j)],
            i if i == k + j => held(j),
            _ => 0.0,
        });
        let cross = self.cross.clone().resize_vertically(k + n, 0.0);
        let r = self.state_residual.clone().resize_vertically(k + n, 0.0);
        let Parted { triangle, cross, state_residual, rest } = parted(a, cross, &r);
        Eliminated {
            triangle,
            cross,
            state_residual,
            theta: &self.theta + rest.tr_mul(&rest),
            gradient: &self.theta_gradient + rest.tr_mul(&r),
        }
    }

    /// Precision of the memory in units of its prior, the machine's state eliminated; none where
    /// the window has no memory that is free.
    fn memory_precision(&self) -> Option<DMatrix<f64>> {
        let z = self.spread.len();
        if z == 0 {
            return None;
        }
        let triangle = self.eliminated(0.0).triangle;
        let n = triangle.nrows() - z;
        let mut own = triangle.view((n, n), (z, z)).into_owned();
        own.column_iter_mut().zip(&self.spread).for_each(|(mut c, sd)| c *= *sd);
        Some(own.tr_mul(&own))
    }
}

/// A window without its states.
#[derive(Clone, Debug)]
pub struct Eliminated {
    /// R, with what holds the states.
    triangle: DMatrix<f64>,
    cross: DMatrix<f64>,
    state_residual: DVector<f64>,
    /// Normal matrix of theta.
    pub theta: DMatrix<f64>,
    /// Gradient of theta.
    pub gradient: DVector<f64>,
}

impl Eliminated {
    /// `(A'A)^-1` times something.
    #[must_use]
    pub fn solve(&self, of: &DMatrix<f64>) -> DMatrix<f64> {
        let mut x = of.clone();
        // Of a triangle without a zero on its diagonal.
        let _ = self.triangle.tr_solve_upper_triangular_mut(&mut x);
        let _ = self.triangle.solve_upper_triangular_mut(&mut x);
        x
    }

    /// By how much the states move with theta: `(A'A)^-1 A'B`.
    #[must_use]
    pub fn by_theta(&self) -> DMatrix<f64> {
        let mut x = self.cross.clone();
        let _ = self.triangle.solve_upper_triangular_mut(&mut x);
        x
    }

    /// The states' step where theta takes one.
    #[must_use]
    pub fn states(&self, theta: &DVector<f64>) -> DVector<f64> {
        let mut x = &self.state_residual - &self.cross * theta;
        let _ = self.triangle.solve_upper_triangular_mut(&mut x);
        x
    }

    /// By how much the squares rise where theta takes a step and the states follow it.
    #[must_use]
    pub fn squares(&self, theta: &DVector<f64>) -> f64 {
        theta.dot(&(&self.theta * theta)) - 2.0 * self.gradient.dot(theta)
    }

    /// By how much the squares fall by the states alone.
    fn promised(&self) -> f64 {
        self.state_residual.norm_squared()
    }
}

/// Columns A = Q R, and what others have along Q and beside it.
struct Parted {
    /// R.
    triangle: DMatrix<f64>,
    /// Q' B.
    cross: DMatrix<f64>,
    /// Q' r.
    state_residual: DVector<f64>,
    /// B - Q Q' B.
    rest: DMatrix<f64>,
}

fn parted(a: DMatrix<f64>, b: DMatrix<f64>, r: &DVector<f64>) -> Parted {
    if a.ncols() == 0 {
        let (cross, none) = (DMatrix::zeros(0, b.ncols()), DVector::zeros(0));
        return Parted { triangle: DMatrix::zeros(0, 0), cross, state_residual: none, rest: b };
    }
    let (q, triangle) = a.qr().unpack();
    let cross = q.tr_mul(&b);
    let mut rest = b;
    rest.gemm(-1.0, &q, &cross, 1.0);
    Parted { triangle, cross, state_residual: q.tr_mul(r), rest }
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
    windows: Vec<Eliminated>,
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
    ///
    /// # Errors
    /// [`FitError::Singular`] where a derivative is no number.
    fn reduce(&self, theta: &[f64], damping: f64) -> Result<Reduced, FitError> {
        let free = &self.hypothesis.free;
        let p = free.len();
        let (mut schur, mut gradient) = (DMatrix::zeros(p, p), DVector::zeros(p));
        let windows: Vec<Eliminated> = self.blocks.iter().map(|b| b.eliminated(damping)).collect();
        let mut promised = 0.0;
        for (k, window) in windows.iter().enumerate() {
            if !self.left_out.get(k).is_some_and(|left_out| *left_out) {
                schur += &window.theta;
                gradient += &window.gradient;
                promised += window.promised();
            }
        }
        for i in 0..p {
            gradient[i] = gradient[i] * free[i].sd - (theta[i] - free[i].mean) / free[i].sd;
            for j in 0..p {
                schur[(i, j)] *= free[i].sd * free[j].sd;
            }
            schur[(i, i)] += 1.0;
        }
        let finite = promised.is_finite() && schur.iter().chain(&gradient).all(|x| x.is_finite());
        finite.then_some(Reduced { schur, gradient, windows, promised }).ok_or(FitError::Singular)
    }

    /// A damped Gauss-Newton step from `theta` within its bounds.
    ///
    /// # Errors
    /// [`FitError::Singular`].
    pub fn step(&self, theta: &[f64], damping: f64) -> Result<Step, FitError> {
        let free = &self.hypothesis.free;
        let Reduced { schur, gradient, windows, promised } = self.reduce(theta, damping)?;
        let mut damped = schur.clone();
        for i in 0..free.len() {
            damped[(i, i)] *= 1.0 + damping;
        }
        let within: Vec<(f64, f64)> = self.room(theta).collect();
        let scaled = boxed::minimiser(&damped, &gradient, &within).ok_or(FitError::Singular)?;
        let promised = promised + 2.0 * gradient.dot(&scaled) - scaled.dot(&(&schur * &scaled));
        let moved =
            |(f, (x, step)): (&Free, (&f64, &f64))| (x + step * f.sd).clamp(f.bounds.0, f.bounds.1);
        let moved: Vec<f64> = free.iter().zip(theta.iter().zip(scaled.iter())).map(moved).collect();
        let taken = DVector::from_fn(free.len(), |i, _| moved[i] - theta[i]);
        let states = windows.iter().map(|w| w.states(&taken)).collect();
        Ok(Step { theta: moved, states, promised })
    }

    /// How far each entry of theta can go within its bounds, in units of its prior.
    fn room(&self, theta: &[f64]) -> impl Iterator<Item = (f64, f64)> {
        self.hypothesis.free.iter().zip(theta).map(|(f, x)| {
            let (low, high) = f.bounds;
            (((low - x) / f.sd).min(0.0), ((high - x) / f.sd).max(0.0))
        })
    }

    /// The whole step of theta from `theta` to the optimum within its bounds, some of its entries taking those that are
    /// given.
    ///
    /// # Errors
    /// [`FitError::Singular`].
    pub fn learned(&self, theta: &[f64], given: &[(usize, f64)]) -> Result<DVector<f64>, FitError> {
        self.whole_step(&self.reduce(theta, 0.0)?, theta, given)
    }

    /// The same, and how the states of each window follow.
    ///
    /// # Errors
    /// [`FitError::Singular`].
    pub fn learned_with_states(
        &self,
        theta: &[f64],
        given: &[(usize, f64)],
    ) -> Result<(DVector<f64>, Vec<DVector<f64>>), FitError> {
        let reduced = self.reduce(theta, 0.0)?;
        let step = self.whole_step(&reduced, theta, given)?;
        let states = reduced.windows.iter().map(|w| w.states(&step)).collect();
        Ok((step, states))
    }

    fn whole_step(
        &self,
        Reduced { schur, gradient, .. }: &Reduced,
        theta: &[f64],
        given: &[(usize, f64)],
    ) -> Result<DVector<f64>, FitError> {
        let free = &self.hypothesis.free;
        let mut step = DVector::zeros(free.len());
        let mut within: Vec<(f64, f64)> = self.room(theta).collect();
        for &(i, taken) in given {
            (step[i], within[i]) = (taken / free[i].sd, (0.0, 0.0));
        }
        let pull = gradient - schur * &step;
        step += boxed::minimiser(schur, &pull, &within).ok_or(FitError::Singular)?;
        Ok(DVector::from_fn(free.len(), |i, _| step[i] * free[i].sd))
    }

    /// Precision of theta in units of its prior, states eliminated; and that of the memories at
    /// the recordings' beginnings.
    ///
    /// # Errors
    /// [`FitError::Singular`].
    pub fn precision(&self, theta: &[f64]) -> Result<Precision, FitError> {
        let theta = self.reduce(theta, 0.0)?.schur;
        let memory = self.blocks.iter().filter_map(Block::memory_precision).collect();
        Ok(Precision { theta, memory })
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

#[cfg(test)]
mod tests {
    use super::{Block, Columns, Memory};
    use lacuna_excitation::rng;
    use nalgebra::{DMatrix, DVector};
    use rand::RngExt;

    const ROWS: usize = 40;
    const STATES: usize = 3;
    const THETA: usize = 4;

    fn drawn(seed: u64, columns: usize) -> DMatrix<f64> {
        let mut rng = rng(seed, 0);
        DMatrix::from_fn(ROWS, columns, |_, _| rng.random_range(-1.0..1.0))
    }

    fn block(a: &DMatrix<f64>, b: &DMatrix<f64>, r: &DVector<f64>) -> Block {
        let by = a.column_iter().chain(b.column_iter()).map(|c| c.iter().copied().collect());
        let columns = Columns { residual: r.iter().copied().collect(), by: by.collect() };
        Block::of(&columns, (a.ncols(), 0), Memory::default())
    }

    /// Well apart, theta beside its states is what the normal equations say.
    #[test]
    fn elimination_solves_the_normal_equations() {
        let (a, b, r) = (drawn(1, STATES), drawn(2, THETA), drawn(3, 1).column(0).into_owned());
        for damping in [0.0, 0.3] {
            let eliminated = block(&a, &b, &r).eliminated(damping);
            let mut state = a.tr_mul(&a);
            (0..STATES).for_each(|i| state[(i, i)] *= 1.0 + damping);
            let inverse = state.try_inverse().expect("regular");
            let cross = a.tr_mul(&b);
            let theta = b.tr_mul(&b) - cross.tr_mul(&(&inverse * &cross));
            let gradient = b.tr_mul(&r) - cross.tr_mul(&(&inverse * a.tr_mul(&r)));
            assert!((&eliminated.theta - theta).norm() < 1e-6);
            assert!((&eliminated.gradient - gradient).norm() < 1e-6);
            let step = DVector::from_element(THETA, 0.1);
            let states = &inverse * (a.tr_mul(&r) - &cross * &step);
            assert!((eliminated.states(&step) - states).norm() < 1e-6);
            assert!((eliminated.by_theta() - &inverse * &cross).norm() < 1e-6);
            assert!((eliminated.solve(&cross) - inverse * cross).norm() < 1e-6);
        }
    }

    /// What theta says beside the states is a ten millionth of what it says: of its square nothing would be left
    /// in the difference of two normal matrices.
    #[test]
    fn what_states_can_nearly_say_is_told_from_them() {
        let (a, beside) = (drawn(4, STATES), drawn(5, THETA));
        let none = DVector::zeros(ROWS);
        let known = block(&a, &beside, &none).eliminated(0.0).theta * 1e-6;
        let b = &a * drawn(6, THETA).rows(0, STATES) * 1e4 + beside * 1e-3;
        let eliminated = block(&a, &b, &none).eliminated(0.0).theta;
        assert!((eliminated - &known).norm() < 1e-5 * known.norm());
    }

    /// Memory that is believed to be near rest is told by that alone where no measurement shows it.
    #[test]
    fn memory_is_as_precise_as_it_is_believed() {
        let columns = Columns { residual: vec![0.5; 5], by: vec![vec![1.0; 5], vec![0.0; 5]] };
        let memory = Memory { off: &[0.2], spread: &[0.1] };
        let block = Block::of(&columns, (2, 0), memory);
        assert!((block.chi2 - 1.25).abs() < 1e-12);
        let precision = block.memory_precision().expect("it has memory");
        assert!((precision[(0, 0)] - 1.0).abs() < 1e-6);
        let states = block.eliminated(0.0).states(&DVector::zeros(0));
        assert!((states[0] - 0.5).abs() < 1e-6 && (states[1] + 0.2).abs() < 1e-6, "{states}");
    }
}
