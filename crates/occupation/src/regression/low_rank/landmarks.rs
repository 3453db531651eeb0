//! Landmarks and their features.

use faer::linalg::triangular_solve::solve_lower_triangular_in_place;
use faer::{Mat, MatRef, Par};

use super::Limits;
use crate::kernel::{Kernel, KernelSpec};
use crate::linear::times_upper;
use crate::occupation_kernels::OccupationKernels;
use crate::pivoted::{Pivoted, Stop};
use crate::simd::{LANES, coordinate_by_coordinate};

/// Variance that rounding leaves, relative to the largest.
const ROUNDING: f64 = 1e-13;

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
        let point = |k: usize| &candidates[k * d..(k + 1) * d];
        let mut columns = Vec::new();
        coordinate_by_coordinate(candidates, d, &mut columns);
        let relative = limits.left.max(ROUNDING);
        let stop = Stop { most: limits.landmarks, absolute: 0.0, relative };
        let Pivoted { pivots, factor, left, .. } = Pivoted::of(kernel, &columns, d, stop);
        let rank = pivots.len();
        let lower = Mat::from_fn(rank, rank, |i, j| if j > i { 0.0 } else { factor[j][pivots[i]] });
        let mut inverse = Mat::identity(rank, rank);
        solve_lower_triangular_in_place(lower.as_ref(), inverse.as_mut(), Par::Seq);
        Self {
            kernel: kernel.clone(),
            points: pivots.iter().flat_map(|&k| point(k)).copied().collect(),
            inverse: inverse.transpose().to_owned(),
            left,
            arguments: d,
        }
    }

    pub fn rank(&self) -> usize {
        self.inverse.nrows()
    }

    /// int phi_a (1, u) phi(x) dt of every functional, a row each: features for 1, then for u_1, ...
    pub fn features_of(&self, occupation: &OccupationKernels) -> Mat<f64> {
        let (rank, columns) = (self.rank(), occupation.input_count() + 1);
        let sums = occupation.sums(self.kernel.parts(self.arguments));
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
            times_upper(
                features.as_mut().subcols_mut(j * rank, rank),
                kernels.as_ref().subcols(j * rank, rank),
                self.inverse.as_ref(),
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
        times_upper(features.as_mut(), kernels.as_ref(), self.inverse.as_ref());
        features
    }

    /// Weights of the kernel values from coefficients of the features: L^-T C.
    pub fn to_weights(&self, coefficients: MatRef<'_, f64>) -> Mat<f64> {
        &self.inverse * coefficients
    }
}
