//! Landmarks and their features.

use faer::linalg::matmul::triangular::{BlockStructure, matmul};
use faer::linalg::triangular_solve::solve_lower_triangular_in_place;
use faer::{Accum, Mat, MatRef, Par};
use rayon::prelude::*;

use super::{Limits, form};
use crate::kernel::{Kernel, KernelSpec};
use crate::occupation_kernels::OccupationKernels;
use crate::simd::{LANES, coordinate_by_coordinate, dot};

/// Variance that rounding leaves, relative to the largest.
const ROUNDING: f64 = 1e-13;
/// Candidates that one thread looks at.
const GROUP: usize = 256;

/// phi(x) = L^-1 k(x).
pub(super) struct Landmarks {
    kernel: KernelSpec,
    /// r x d, in the order in which they were taken.
    pub points: Vec<f64>,
    /// L^-T.
    inverse: Mat<f64>,
    /// What is left of the largest variance.
    pub left: f64,
    arguments: usize,
}

impl Landmarks {
    /// Pivoted Cholesky factorisation of the candidates' kernel matrix.
    pub fn choose(kernel: &KernelSpec, d: usize, candidates: &[f64], limits: Limits) -> Self {
        let count = candidates.len() / d;
        let most = limits.landmarks.min(count);
        let point = |k: usize| &candidates[k * d..(k + 1) * d];
        let mut left: Vec<f64> = (0..count).map(|k| kernel.evaluate(point(k), point(k))).collect();
        let largest = left.iter().copied().fold(0.0, f64::max);
        let stop = limits.left.max(ROUNDING) * largest;
        // Rows of the factor, one a candidate, so that inner products run along memory.
        let mut factor = vec![0.0; count * most];
        let mut columns = Vec::new();
        coordinate_by_coordinate(candidates, d, &mut columns);
        let mut values = vec![0.0; count];
        let mut pivots = Vec::new();
        let mut variance = largest;
        while pivots.len() < most {
            let (pivot, found) = greatest(&left);
            variance = found;
            if variance <= stop || !variance.is_finite() {
                break;
            }
            let rank = pivots.len();
            kernel.evaluate_row(point(pivot), &columns, &mut values);
            let own: Vec<f64> = factor[pivot * most..pivot * most + rank].to_vec();
            let root = variance.sqrt();
            factor
                .par_chunks_mut(GROUP * most)
                .zip(values.par_chunks(GROUP))
                .zip(left.par_chunks_mut(GROUP))
                .for_each(|((rows, values), left)| {
                    for ((row, value), left) in rows.chunks_exact_mut(most).zip(values).zip(left) {
                        let entry = (value - dot(&row[..rank], &own)) / root;
                        row[rank] = entry;
                        *left = (*left - entry * entry).max(0.0);
                    }
                });
            left[pivot] = 0.0;
            pivots.push(pivot);
        }
        if pivots.len() == most {
            variance = greatest(&left).1;
        }
        let rank = pivots.len();
        let lower =
            Mat::from_fn(rank, rank, |i, j| if j > i { 0.0 } else { factor[pivots[i] * most + j] });
        let mut inverse = Mat::identity(rank, rank);
        solve_lower_triangular_in_place(lower.as_ref(), inverse.as_mut(), Par::Seq);
        Self {
            kernel: kernel.clone(),
            points: pivots.iter().flat_map(|&k| point(k)).copied().collect(),
            inverse: inverse.transpose().to_owned(),
            left: variance / largest,
            arguments: d,
        }
    }

    pub fn rank(&self) -> usize {
        self.inverse.nrows()
    }

    /// int phi_a (1, u) phi(x) dt of every functional, a row each: features for 1, then for u_1, ...
    pub fn features_of(&self, occupation: &OccupationKernels) -> Mat<f64> {
        let (rank, columns) = (self.rank(), occupation.input_count() + 1);
        let sums = occupation.sums(form(&self.kernel, self.arguments));
        let mut scaled = vec![0.0; self.points.len()];
        let rows = self.points.chunks_exact(self.arguments);
        rows.zip(scaled.chunks_exact_mut(self.arguments)).for_each(|(z, to)| sums.scale(z, to));
        let mut kernels = Mat::zeros(sums.count(), rank * columns);
        let mut values = vec![0.0; rank * columns * LANES];
        for block in 0..sums.blocks() {
            sums.block(block, &scaled, &mut values);
            let first = block * LANES;
            let lanes = LANES.min(sums.count() - first);
            for (entry, values) in values.as_chunks::<LANES>().0.iter().enumerate() {
                let column = entry % columns * rank + entry / columns;
                kernels.col_as_slice_mut(column)[first..first + lanes]
                    .copy_from_slice(&values[..lanes]);
            }
        }
        let mut features = Mat::zeros(sums.count(), rank * columns);
        for j in 0..columns {
            self.to_features(
                kernels.as_ref().subcols(j * rank, rank),
                features.as_mut().subcols_mut(j * rank, rank),
            );
        }
        features
    }

    /// phi of points (rows of d), a row each.
    pub fn features_at(&self, points: &[f64]) -> Mat<f64> {
        let (rank, d) = (self.rank(), self.arguments);
        let count = points.len() / d;
        let mut columns = Vec::new();
        coordinate_by_coordinate(points, d, &mut columns);
        let mut kernels = Mat::zeros(count, rank);
        for (j, z) in self.points.chunks_exact(d).enumerate() {
            self.kernel.evaluate_row(z, &columns, kernels.col_as_slice_mut(j));
        }
        let mut features = Mat::zeros(count, rank);
        self.to_features(kernels.as_ref(), features.as_mut());
        features
    }

    fn to_features(&self, kernels: MatRef<'_, f64>, features: faer::MatMut<'_, f64>) {
        matmul(
            features,
            BlockStructure::Rectangular,
            Accum::Replace,
            kernels,
            BlockStructure::Rectangular,
            self.inverse.as_ref(),
            BlockStructure::TriangularUpper,
            1.0,
            Par::Seq,
        );
    }

    /// Weights of the kernel values from coefficients of the features: L^-T C.
    pub fn to_weights(&self, coefficients: MatRef<'_, f64>) -> Mat<f64> {
        &self.inverse * coefficients
    }
}

fn greatest(values: &[f64]) -> (usize, f64) {
    let mut best = (0, 0.0);
    for (k, &value) in values.iter().enumerate() {
        if value > best.1 {
            best = (k, value);
        }
    }
    best
}
