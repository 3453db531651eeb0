//! The normal equations of the features, and their solution.

use faer::linalg::matmul::matmul;
use faer::{Accum, Mat, MatRef, Par};
use rayon::prelude::*;

use super::landmarks::Landmarks;
use super::{LowRank, Way};
use crate::identified::{Expansion, IdentifiedModel, SavedExpansion};
use crate::linear::{NonPositivePivot, solve_positive_definite};
use crate::regression::{FitError, Regression, check_finite};

/// Rows and columns of a part of F^T F that one thread sums.
const TILE: usize = 384;
/// Points at which two answers are compared.
const COMPARED: usize = 500;

/// Some rows of F and Y, whitened.
pub(super) struct Rows {
    pub features: Mat<f64>,
    pub right: Mat<f64>,
}

/// F^T F, in tiles of its lower triangle, and F^T Y.
pub(super) struct Normal {
    columns: usize,
    /// Rows so far.
    rows: usize,
    tiles: Vec<Tile>,
    moment: Mat<f64>,
}

struct Tile {
    row: usize,
    column: usize,
    sums: Mat<f64>,
}

impl Normal {
    pub fn new(columns: usize, dimension: usize) -> Self {
        let size = |start: usize| TILE.min(columns - start);
        let starts = || (0..columns).step_by(TILE);
        let tile = |(row, column): (usize, usize)| Tile {
            row,
            column,
            sums: Mat::zeros(size(row), size(column)),
        };
        let tiles =
            starts().flat_map(|row| starts().filter(move |c| *c <= row).map(move |c| (row, c)));
        Self {
            columns,
            rows: 0,
            tiles: tiles.map(tile).collect(),
            moment: Mat::zeros(columns, dimension),
        }
    }

    /// Adds rows; each tile is summed in their order, by one thread.
    pub fn add(&mut self, rows: &[Rows]) {
        self.tiles.par_iter_mut().for_each(|tile| {
            for Rows { features, .. } in rows {
                let left = features.as_ref().subcols(tile.row, tile.sums.nrows()).transpose();
                let right = features.as_ref().subcols(tile.column, tile.sums.ncols());
                matmul(tile.sums.as_mut(), Accum::Add, left, right, 1.0, Par::Seq);
            }
        });
        for Rows { features, right } in rows {
            self.rows += features.nrows();
            matmul(&mut self.moment, Accum::Add, features.transpose(), right, 1.0, Par::Seq);
        }
    }

    /// The model, and how far it is from the one with half of the landmarks.
    pub fn solve(
        &self,
        regression: &Regression,
        landmarks: &Landmarks,
        shape: [usize; 3],
        candidates: &[f64],
    ) -> Result<(IdentifiedModel, Way), FitError> {
        let [n, m, d] = shape;
        let rank = landmarks.rank();
        let whole = self.whole();
        let all = self.coefficients(&whole, regression.lambda, rank, rank)?;
        let half = self.coefficients(&whole, regression.lambda, rank, rank.div_ceil(2))?;
        let few = candidates.len().min(COMPARED * d);
        let features = landmarks.features_at(&candidates[..few]);
        let differs = |blocks: std::ops::Range<usize>| {
            relative_difference(features.as_ref(), &all[blocks.clone()], &half[blocks])
        };
        let change = [differs(0..1), if m > 0 { differs(1..m + 1) } else { 0.0 }];
        let way = LowRank { functionals: self.rows, landmarks: rank, left: landmarks.left, change };
        let entries: Vec<(usize, usize)> =
            (0..=m).flat_map(|block| (0..n).map(move |i| (i, block))).collect();
        let weights = all.iter().flat_map(|c| {
            let weights = landmarks.to_weights(c.as_ref());
            (0..n).flat_map(move |i| weights.col_as_slice(i).to_vec()).collect::<Vec<_>>()
        });
        let saved = SavedExpansion {
            kernel: regression.kernel.clone(),
            centre: Vec::new(),
            widths: Vec::new(),
            points: landmarks.points.clone(),
            entries,
            weights: weights.collect(),
        };
        let expansion = Expansion::new(saved, d);
        let model = IdentifiedModel::of_expansions(regression.order, shape, vec![expansion], None);
        Ok((model, Way::LowRank(way)))
    }

    fn whole(&self) -> Mat<f64> {
        let mut whole = Mat::zeros(self.columns, self.columns);
        for tile in &self.tiles {
            let (rows, columns) = (tile.sums.nrows(), tile.sums.ncols());
            let mut place = whole.as_mut().submatrix_mut(tile.row, tile.column, rows, columns);
            place.copy_from(&tile.sums);
        }
        whole
    }

    /// C (landmarks x n) of 1, u_1, ..., with the first `kept` of `rank` landmarks.
    fn coefficients(
        &self,
        whole: &Mat<f64>,
        lambda: f64,
        rank: usize,
        kept: usize,
    ) -> Result<Vec<Mat<f64>>, FitError> {
        let blocks = self.columns / rank;
        let place = |k: usize| k / kept * rank + k % kept;
        let mut matrix = Mat::from_fn(blocks * kept, blocks * kept, |i, j| {
            let (low, high) = (place(i).max(place(j)), place(i).min(place(j)));
            whole[(low, high)] + if i == j { lambda } else { 0.0 }
        });
        let n = self.moment.ncols();
        let mut right = Mat::from_fn(blocks * kept, n, |k, i| self.moment[(place(k), i)]);
        solve_positive_definite(&mut matrix, &mut right).map_err(
            |NonPositivePivot { index }| FitError::NotPositiveDefinite { index, lambda },
        )?;
        check_finite(&right)?;
        Ok((0..blocks).map(|b| right.as_ref().subrows(b * kept, kept).to_owned()).collect())
    }
}

/// |phi (C - C')| / |phi C| over points, for C' of the first features alone.
fn relative_difference(features: MatRef<'_, f64>, all: &[Mat<f64>], half: &[Mat<f64>]) -> f64 {
    let (mut difference, mut size) = (0.0, 0.0);
    for (all, half) in all.iter().zip(half) {
        let whole = features * all;
        let part = features.subcols(0, half.nrows()) * half;
        difference += (&whole - &part).squared_norm_l2();
        size += whole.squared_norm_l2();
    }
    (difference / size.max(f64::MIN_POSITIVE)).sqrt()
}
