//! A kernel as a few features, by pivoted Cholesky factorisation.
//!
//! ```text
//! K(x, y) ~ phi(x) . phi(y),   phi(x) = L^-1 k(x),   k_j(x) = K(x, z_j),   K(z_i, z_j) = (L L^T)_ij
//! ```
//!
//! Landmarks z are taken one by one where the kernel is worst represented, until no candidate is left with more than
//! a tolerance of its variance: then the features are the kernel on all candidates (Fine and Scheinberg, JMLR 2001).

use faer::{Mat, MatRef};

use super::family::ScaledKernel;
use crate::kernel::{Kernel, KernelSpec};
use crate::linear::{Factor, times_upper};
use crate::pivoted::Pivoted;
use crate::simd::dot;

/// The features of one kernel.
#[derive(Debug, Clone)]
pub(crate) struct Basis {
    pub kernel: ScaledKernel,
    spec: KernelSpec,
    /// Landmarks z, rank x d, not scaled.
    pub landmarks: Vec<f64>,
    /// Scaled landmarks, coordinate by coordinate.
    columns: Vec<f64>,
    /// Whether the landmarks leave nothing of the kernel on the candidates.
    complete: bool,
    /// L^-T, so that rows of features are rows of kernel values times it.
    pub inverse: Mat<f64>,
}

impl Basis {
    /// Landmarks from the candidates (rows of d): at most `most`, until the largest variance left is below `enough`, or
    /// lost in rounding.
    pub fn choose(kernel: ScaledKernel, candidates: &[f64], enough: f64, most: usize) -> Self {
        let (d, spec) = (kernel.widths.len(), kernel.family.kernel());
        let Pivoted { pivots, factor, complete, .. } = kernel.pivoted(candidates, enough, most);
        let landmarks: Vec<f64> =
            pivots.iter().flat_map(|&k| &candidates[k * d..(k + 1) * d]).copied().collect();
        let inverse = inverse_of_lower(pivots.len(), |i, j| factor[j][pivots[i]]);
        let columns = kernel.scaled_columns(&landmarks);
        Self { kernel, spec, landmarks, columns, complete, inverse }
    }

    /// All of the landmarks, in the order in which they were once chosen; none where they are not independent.
    pub fn of_landmarks(kernel: ScaledKernel, landmarks: Vec<f64>) -> Option<Self> {
        let spec = kernel.family.kernel();
        let columns = kernel.scaled_columns(&landmarks);
        let d = kernel.widths.len();
        let rank = landmarks.len() / d;
        let point = |k: usize| -> Vec<f64> { (0..d).map(|i| columns[i * rank + k]).collect() };
        let gram = Mat::from_fn(rank, rank, |i, j| spec.evaluate(&point(i), &point(j)));
        let factor = Factor::of(gram).ok()?;
        let inverse = inverse_of_lower(rank, |i, j| factor.entry(i, j));
        Some(Self { kernel, spec, landmarks, columns, complete: true, inverse })
    }

    /// Number of features.
    pub fn rank(&self) -> usize {
        self.inverse.nrows()
    }

    /// k(x), one value a landmark; `scaled` is room for d numbers and holds the scaled x afterwards.
    pub fn kernel_row(&self, x: &[f64], scaled: &mut [f64], values: &mut [f64]) {
        self.kernel.scale(x, scaled);
        self.spec.evaluate_row(scaled, &self.columns, values);
    }

    /// Adds factor * d/dx_i sum_j w_j K(x, z_j) to `gradient`, for the x that `scaled` was made from; `slopes` is room
    /// for one number a landmark.
    pub fn add_gradient(
        &self,
        scaled: &[f64],
        weights: &[f64],
        factor: f64,
        slopes: &mut [f64],
        gradient: &mut [f64],
    ) {
        let (rank, family) = (self.rank(), self.kernel.family);
        family.slope_row(scaled, &self.columns, slopes);
        slopes.iter_mut().zip(weights).for_each(|(slope, weight)| *slope *= weight);
        let total: f64 = if family.is_radial() { slopes.iter().sum() } else { 0.0 };
        for (i, entry) in gradient.iter_mut().enumerate() {
            let coordinates = &self.columns[i * rank..(i + 1) * rank];
            let moment = dot(slopes, coordinates);
            let sum = if family.is_radial() { total * scaled[i] - moment } else { moment };
            *entry += factor * sum / self.kernel.widths[i];
        }
    }

    /// Features of points (rows x d), one row a point.
    pub fn features(&self, points: &[f64]) -> Mat<f64> {
        let rows = points.len() / self.kernel.widths.len();
        let mut values = Vec::new();
        self.kernel_values(points, &mut values);
        self.to_features(MatRef::from_row_major_slice(&values, rows, self.rank()))
    }

    /// Writes kernel values of points (rows x d), a row a point.
    pub fn kernel_values(&self, points: &[f64], values: &mut Vec<f64>) {
        let (d, rank) = (self.kernel.widths.len(), self.rank());
        values.clear();
        values.resize(points.len() / d * rank, 0.0);
        let mut scaled = vec![0.0; d];
        for (x, values) in points.chunks_exact(d).zip(values.chunks_exact_mut(rank.max(1))) {
            self.kernel_row(x, &mut scaled, values);
        }
    }

    /// Whether features times features are the kernel, on all candidates.
    pub fn is_complete(&self) -> bool {
        self.complete
    }

    /// Kernel values of points (rows x d) with one another.
    pub fn kernel_matrix(&self, points: &[f64]) -> Mat<f64> {
        let d = self.kernel.widths.len();
        let count = points.len() / d;
        let columns = self.kernel.scaled_columns(points);
        let mut values = Mat::zeros(count, count);
        for j in 0..count {
            let point: Vec<f64> = (0..d).map(|i| columns[i * count + j]).collect();
            self.spec.evaluate_row(&point, &columns, values.col_as_slice_mut(j));
        }
        values
    }

    /// Rows of kernel values, or integrals of them, to rows of features.
    pub fn to_features(&self, kernel_rows: MatRef<'_, f64>) -> Mat<f64> {
        let mut features = Mat::zeros(kernel_rows.nrows(), self.rank());
        times_upper(features.as_mut(), kernel_rows, self.inverse.as_ref());
        features
    }

    /// Weights on the kernel values from coefficients of the features: L^-T c.
    pub fn to_weights(&self, coefficients: &[f64]) -> Vec<f64> {
        let column = |i: usize| {
            let entries = (i..self.rank()).zip(&coefficients[i..]);
            entries.map(|(j, c)| self.inverse[(i, j)] * c).sum()
        };
        (0..self.rank()).map(column).collect()
    }
}

/// L^-T for a lower triangular L.
fn inverse_of_lower(size: usize, entry: impl Fn(usize, usize) -> f64) -> Mat<f64> {
    let mut inverse: Mat<f64> = Mat::zeros(size, size);
    // Column j of L^-1 by forward substitution is row j of L^-T.
    for j in 0..size {
        inverse[(j, j)] = 1.0 / entry(j, j);
        for i in j + 1..size {
            let sum: f64 = (j..i).map(|k| entry(i, k) * inverse[(j, k)]).sum();
            inverse[(j, i)] = -sum / entry(i, i);
        }
    }
    inverse
}

#[cfg(test)]
mod tests {
    use super::super::family::Family;
    use super::*;

    fn points() -> Vec<f64> {
        let pair =
            |k: usize| [(k * 37 % 101) as f64 / 50.0 - 1.0, (k * k % 97) as f64 / 48.0 - 1.0];
        (0..60).flat_map(pair).map(|x| 2.0 * x).collect()
    }

    #[test]
    fn features_reproduce_the_kernel() {
        for family in Family::ALL {
            let kernel = ScaledKernel { family, centre: vec![0.3, -0.2], widths: vec![1.5, 2.5] };
            let basis = Basis::choose(kernel.clone(), &points(), 1e-10, 60);
            let features = basis.features(&points());
            let (mut a, mut b) = ([0.0; 2], [0.0; 2]);
            for (k, x) in points().chunks_exact(2).enumerate() {
                for (l, y) in points().chunks_exact(2).enumerate() {
                    kernel.scale(x, &mut a);
                    kernel.scale(y, &mut b);
                    let product: f64 =
                        (0..basis.rank()).map(|j| features[(k, j)] * features[(l, j)]).sum();
                    let exact = family.kernel().evaluate(&a, &b);
                    assert!((product - exact).abs() < 1e-4 * exact.abs().max(1.0), "{family}");
                }
            }
        }
    }

    #[test]
    fn a_polynomial_needs_as_many_features_as_it_has_monomials() {
        let kernel = ScaledKernel {
            family: Family::Polynomial(3),
            centre: vec![0.0; 2],
            widths: vec![1.0; 2],
        };
        assert_eq!(Basis::choose(kernel, &points(), 1e-10, 60).rank(), 10);
    }

    #[test]
    fn gradients_are_those_of_the_weighted_sum() {
        let weights: Vec<f64> = (0..60).map(|k| f64::from(k % 7) - 3.0).collect();
        for family in Family::ALL {
            let kernel = ScaledKernel { family, centre: vec![0.1, 0.0], widths: vec![2.0, 3.0] };
            let basis = Basis::choose(kernel, &points(), 1e-6, 30);
            let weights = &weights[..basis.rank()];
            let mut values = vec![0.0; basis.rank()];
            let mut sum = |x: [f64; 2]| {
                let mut scaled = [0.0; 2];
                basis.kernel_row(&x, &mut scaled, &mut values);
                values.iter().zip(weights).map(|(v, w)| v * w).sum::<f64>()
            };
            let x = [0.3, -0.8];
            let expected = [
                (sum([x[0] + 1e-5, x[1]]) - sum([x[0] - 1e-5, x[1]])) / 2e-5,
                (sum([x[0], x[1] + 1e-5]) - sum([x[0], x[1] - 1e-5])) / 2e-5,
            ];
            let mut scaled = [0.0; 2];
            basis.kernel_row(&x, &mut scaled, &mut vec![0.0; basis.rank()]);
            let mut gradient = [0.0; 2];
            let mut room = vec![0.0; basis.rank()];
            basis.add_gradient(&scaled, weights, 2.0, &mut room, &mut gradient);
            for i in 0..2 {
                let off = (gradient[i] - 2.0 * expected[i]).abs();
                assert!(off < 1e-6 * expected[i].abs().max(1.0), "{family}: {off}");
            }
        }
    }
}
