//! The evidence of functions of some variables for the weak rows of a channel.

use super::knots::{KNOTS, Knots};
use super::rows::Rows;
use faer::linalg::matmul::matmul;
use faer::{Accum, Mat, Par};
use lacuna_occupation::identification::evidence::{Normal, Posterior};
use lacuna_occupation::{Factor, Kernel, Matern, Smoothness};
use rayon::prelude::*;
use std::collections::HashMap;
use std::sync::OnceLock;

/// Kernels by their smoothness ...
const SMOOTHNESS: [Smoothness; 3] =
    [Smoothness::Half, Smoothness::ThreeHalves, Smoothness::FiveHalves];
/// ... and their length, as shares of the variable's range.
const LENGTHS: [f64; 8] = [0.03, 0.06, 0.12, 0.25, 0.5, 1.0, 2.0, 4.0];
/// Sizes of a function: 2^-9 to 2 times the force that moves the channel.
const SIZES: i32 = 11;
/// Features of a function: those of its kernel at the knots, a constant and a straight line.
pub(super) const FEATURES: usize = KNOTS + 2;
/// Size of the constant and the line, in units of the force that moves the channel. It is wide
/// and not chosen by evidence: what parameters could do as well must not be given to them by
/// making the function small.
const LINE: f64 = 0.5;
/// Of a white force beside the functions, in units of the rows' noise: none, then 2^-2 to 2^7.
const WHITE: i32 = 11;

/// The hyper-parameters of one function, as places in their grids.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) struct Part {
    /// Number of its variable.
    pub variable: usize,
    /// Smoothness, length, size.
    pub grid: [usize; 3],
}

/// A white force and functions of variables.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub(super) struct Supposed {
    pub white: usize,
    pub parts: Vec<Part>,
}

impl Supposed {
    /// Number of hyper-parameters.
    fn axes(&self) -> usize {
        1 + 3 * self.parts.len()
    }

    fn limit(axis: usize) -> usize {
        match axis.checked_sub(1).map(|a| a % 3) {
            None => WHITE as usize,
            Some(0) => SMOOTHNESS.len(),
            Some(1) => LENGTHS.len(),
            _ => SIZES as usize,
        }
    }

    fn at(&self, axis: usize) -> usize {
        axis.checked_sub(1).map_or(self.white, |a| self.parts[a / 3].grid[a % 3])
    }

    /// This and all that differ from it in one hyper-parameter.
    pub(super) fn about(&self) -> Vec<Self> {
        let mut all = vec![self.clone()];
        for axis in 0..self.axes() {
            let others = (0..Self::limit(axis)).filter(|v| *v != self.at(axis));
            all.extend(others.map(|v| self.with(axis, v)));
        }
        all
    }

    fn with(&self, axis: usize, value: usize) -> Self {
        let mut moved = self.clone();
        match axis.checked_sub(1) {
            None => moved.white = value,
            Some(a) => moved.parts[a / 3].grid[a % 3] = value,
        }
        moved
    }
}

/// The weak rows of a channel, ready for functions of any of its variables.
pub(super) struct Evidence<'a> {
    rows: &'a [(usize, Rows)],
    pub variables: &'a [Knots],
    /// Prior standard deviations of the uncertain parameters.
    pub tolerances: &'a [f64],
    /// What other channels say of the parameters: precision and its product with the mean.
    others: Option<(Mat<f64>, Vec<f64>)>,
    /// Right-hand sides, and what they lose by parameters and gain by knots, a column each.
    design: Mat<f64>,
    right: Vec<f64>,
    /// The force that moves the channel, and the rows' noise over that of a white force.
    scale: f64,
    ratio: f64,
    normal: [OnceLock<Option<(Normal, f64)>>; WHITE as usize],
}

impl<'a> Evidence<'a> {
    pub(super) fn new(
        rows: &'a [(usize, Rows)],
        variables: &'a [Knots],
        tolerances: &'a [f64],
        scale: f64,
    ) -> Self {
        let p = tolerances.len();
        let count = rows.iter().map(|(_, r)| r.right.len()).sum();
        let mut design = Mat::zeros(count, p + KNOTS * variables.len());
        let mut occupied = vec![0.0; KNOTS];
        let mut row = 0;
        for (recording, own) in rows {
            for (w, window) in own.windows.iter().enumerate() {
                for j in 0..p {
                    design[(row, j)] = -own.by_parameter[w * p + j];
                }
                for (v, knots) in variables.iter().enumerate() {
                    occupied.fill(0.0);
                    for (k, weight) in (window.first..).zip(&window.weights[0]) {
                        knots.occupy(*recording, k, *weight, &mut occupied);
                    }
                    for (j, value) in occupied.iter().enumerate() {
                        design[(row, p + v * KNOTS + j)] = *value;
                    }
                }
                row += 1;
            }
        }
        let sum = |of: &dyn Fn(&Rows, usize) -> f64| -> f64 {
            rows.iter().flat_map(|(_, r)| (0..r.right.len()).map(move |a| of(r, a))).sum()
        };
        let ratio = sum(&|r, a| r.measured.get(a, a)) / sum(&|r, a| r.white.get(a, a));
        Self {
            rows,
            variables,
            tolerances,
            others: None,
            design,
            right: rows.iter().flat_map(|(_, r)| &r.right).copied().collect(),
            scale,
            ratio,
            normal: std::array::from_fn(|_| OnceLock::new()),
        }
    }

    /// The same with what other channels say of the parameters.
    pub(super) fn told(&mut self, others: Option<(Mat<f64>, Vec<f64>)>) {
        self.others = others;
    }

    /// Work out the inner products beside every white force at once: all of them are about to be asked for.
    pub(super) fn prepare(&self) {
        (0..WHITE as usize).into_par_iter().for_each(|white| {
            self.normal(white);
        });
    }

    /// Inner products of the whitened rows, and half the log determinant of their covariance.
    fn normal(&self, white: usize) -> Option<&(Normal, f64)> {
        let of = || {
            let share = if white == 0 { 0.0 } else { 2f64.powi(white as i32 - 3) };
            let (mut design, mut right) = (self.design.clone(), self.right.clone());
            let (mut first, mut half) = (0, 0.0);
            for (_, rows) in self.rows {
                let count = rows.right.len();
                let white = rows.measured.plus(&rows.white, share * share * self.ratio);
                let mut covariance = white.ok()?;
                covariance.add_diagonal(1e-12 * covariance.largest_diagonal());
                let factor = covariance.cholesky().ok()?;
                for j in 0..design.ncols() {
                    let column = &mut design.col_as_slice_mut(j)[first..first + count];
                    factor.solve_lower_in_place(column).ok()?;
                }
                factor.solve_lower_in_place(&mut right[first..first + count]).ok()?;
                half += (0..count).map(|a| factor.get(a, a).ln()).sum::<f64>();
                first += count;
            }
            let mut normal = Normal::new(design.ncols());
            normal.add(design.as_ref(), &right);
            Some((normal, half))
        };
        self.normal[white].get_or_init(of).as_ref()
    }

    /// The posterior of the parameters and of each part's features, for what is supposed, and
    /// the log evidence.
    pub(super) fn posterior(&self, s: &Supposed) -> Option<(Posterior, f64)> {
        let half = self.normal(s.white)?.1;
        self.posterior_by(&self.turned(s)?, half, s)
    }

    fn posterior_by(&self, turned: &Normal, half: f64, s: &Supposed) -> Option<(Posterior, f64)> {
        let sizes = (0..s.parts.len()).flat_map(|i| self.sizes(s, i));
        let prior: Vec<f64> = self.tolerances.iter().copied().chain(sizes).collect();
        let posterior = turned.posterior(&prior, 1.0).ok()?;
        let evidence = posterior.log_evidence - half;
        Some((posterior, evidence))
    }

    /// Inner products with the features of the parts for knots.
    fn turned(&self, s: &Supposed) -> Option<Normal> {
        let (normal, _) = self.normal(s.white)?;
        let p = self.tolerances.len();
        let (known, size) = (p + KNOTS * s.parts.len(), p + FEATURES * s.parts.len());
        let column = |i: usize| match i.checked_sub(p) {
            None => i,
            Some(i) => p + s.parts[i / KNOTS].variable * KNOTS + i % KNOTS,
        };
        let symmetric = |i: usize, j: usize| normal.gram[(i.max(j), i.min(j))];
        let full = Mat::from_fn(known, known, |i, j| symmetric(column(i), column(j)));
        let mut turn = Mat::zeros(known, size);
        (0..p).for_each(|j| turn[(j, j)] = 1.0);
        for i in 0..s.parts.len() {
            let (row, first) = (p + i * KNOTS, p + i * FEATURES);
            turn.submatrix_mut(row, first, KNOTS, FEATURES).copy_from(self.features(s, i)?);
        }
        let mut half = Mat::zeros(known, size);
        matmul(&mut half, Accum::Replace, &full, &turn, 1.0, Par::Seq);
        let mut own = Normal::new(size);
        matmul(&mut own.gram, Accum::Replace, turn.transpose(), &half, 1.0, Par::Seq);
        let moment = Mat::from_fn(known, 1, |i, _| normal.moment[column(i)]);
        let mut turned = Mat::zeros(size, 1);
        matmul(&mut turned, Accum::Replace, turn.transpose(), &moment, 1.0, Par::Seq);
        own.moment = turned.col_as_slice(0).to_vec();
        own.square = normal.square;
        own.equations = normal.equations;
        if let Some((precision, mean)) = &self.others {
            for i in 0..p {
                own.moment[i] += mean[i];
                (0..p).for_each(|j| own.gram[(i, j)] += precision[(i, j)]);
            }
        }
        Some(own)
    }

    /// Prior standard deviations of a part's coefficients.
    pub(super) fn sizes(&self, s: &Supposed, i: usize) -> Vec<f64> {
        let size = self.scale * 2f64.powi(s.parts[i].grid[2] as i32 - 9);
        let mut sizes = vec![size; KNOTS];
        sizes.resize(FEATURES, LINE * self.scale);
        sizes
    }

    /// Features of a part, knots x features: values at knots are this times its coefficients.
    /// All but the first part have no mean along the recordings.
    pub(super) fn features(&self, s: &Supposed, i: usize) -> Option<Mat<f64>> {
        let part = s.parts[i];
        let root = root(part.grid[0], part.grid[1])?;
        let mut l = Mat::from_fn(KNOTS, FEATURES, |k, j| match j {
            j if j < KNOTS => root[(k, j)],
            KNOTS => 1.0,
            _ => 2.0 * k as f64 / (KNOTS - 1) as f64 - 1.0,
        });
        if i > 0 {
            let visits = &self.variables[part.variable].visits;
            for j in 0..FEATURES {
                let mean: f64 = (0..KNOTS).map(|k| visits[k] * l[(k, j)]).sum();
                (0..KNOTS).for_each(|k| l[(k, j)] -= mean);
            }
        }
        Some(l)
    }

    /// Climb to what is most evident; its log evidence less the price of having chosen it.
    pub(super) fn best(&self, start: &Supposed) -> Option<(Supposed, f64)> {
        let mut known: HashMap<Supposed, f64> = HashMap::new();
        // Sizes alone change nothing of the inner products.
        let mut turned: HashMap<Supposed, Option<Normal>> = HashMap::new();
        let mut of = |s: &Supposed| {
            *known.entry(s.clone()).or_insert_with(|| {
                let mut sizeless = s.clone();
                sizeless.parts.iter_mut().for_each(|p| p.grid[2] = 0);
                let turned = turned.entry(sizeless).or_insert_with(|| self.turned(s));
                let half = self.normal(s.white).map(|n| n.1);
                let found = turned.as_ref().zip(half).and_then(|(t, h)| self.posterior_by(t, h, s));
                found.map(|f| f.1).filter(|e| !e.is_nan()).unwrap_or(f64::NEG_INFINITY)
            })
        };
        let (mut best, mut top) = (start.clone(), of(start));
        loop {
            let before = top;
            for axis in 0..best.axes() {
                for direction in [1, -1] {
                    while let Some(value) = best.at(axis).checked_add_signed(direction) {
                        if value >= Supposed::limit(axis) {
                            break;
                        }
                        let moved = best.with(axis, value);
                        let found = of(&moved);
                        if found <= top {
                            break;
                        }
                        (best, top) = (moved, found);
                    }
                }
            }
            if top <= before {
                break;
            }
        }
        if !top.is_finite() {
            return None;
        }
        // The mean over each axis of the grid, in place of its largest.
        let mut price = 0.0;
        for axis in 1..best.axes() {
            let all = 0..Supposed::limit(axis);
            let sum: f64 = all.map(|v| (of(&best.with(axis, v)) - top).exp()).sum();
            price += (Supposed::limit(axis) as f64 / sum).ln();
        }
        Some((best, top - price))
    }
}

/// Lower Cholesky factor of the kernel's matrix at the knots.
fn root(smoothness: usize, length: usize) -> Option<&'static Mat<f64>> {
    static ROOTS: [[OnceLock<Option<Mat<f64>>>; LENGTHS.len()]; SMOOTHNESS.len()] =
        [const { [const { OnceLock::new() }; LENGTHS.len()] }; SMOOTHNESS.len()];
    let of = || {
        let widths = vec![LENGTHS[length]];
        let kernel = Matern { smoothness: SMOOTHNESS[smoothness], widths };
        let at = |k: usize| k as f64 / (KNOTS - 1) as f64;
        let gram = || Mat::from_fn(KNOTS, KNOTS, |i, j| kernel.evaluate(&[at(i)], &[at(j)]));
        let factor = Factor::of_nearly(gram).ok()?;
        Some(Mat::from_fn(KNOTS, KNOTS, |i, j| if i >= j { factor.entry(i, j) } else { 0.0 }))
    };
    ROOTS[smoothness][length].get_or_init(of).as_ref()
}
