//! All kernels of one argument on a few points.
//!
//! Over the range of the data, a smooth function of one argument is its values at Chebyshev points times their cardinal
//! polynomials C, to rounding. The equations are integrated for these polynomials once; for every kernel with features
//! phi, Phi = C phi(points), and one evidence costs a few products of small matrices however many equations there are:
//!
//! ```text
//! Phi_b^T Phi_c = phi_b^T (C_b^T S^-1 C_c) phi_c
//! ```
//!
//! A kernel whose features leave part of its variance between the points is not of the span.

use faer::linalg::matmul::matmul;
use faer::{Accum, Mat, MatRef, Par};

use super::super::evidence::Normal;
use super::super::family::ScaledKernel;
use super::super::weak::WeakRow;
use crate::kernel::Kernel;

/// Number of points.
const POINTS: usize = 40;
/// Largest share of a kernel's variance that may be left between the points.
const LEFT: f64 = 1e-4;

/// The equations of one coordinate in cardinal polynomials.
pub(super) struct Span {
    points: Vec<f64>,
    /// Points between them, and the polynomials there.
    probes: Vec<f64>,
    at_probes: Mat<f64>,
    /// The polynomials at the candidates.
    pub at_candidates: Mat<f64>,
    /// Inner products for errors of variance 1, block after block.
    normal: Normal,
    pub log_determinant: f64,
}

impl Span {
    /// None for more than one argument, or where the errors' covariance cannot be factorised.
    pub fn of(row: &WeakRow<'_>, candidates: &[f64], d: usize, blocks: usize) -> Option<Self> {
        if d != 1 {
            return None;
        }
        let seen = row.arguments().chain(candidates);
        let (low, high) =
            seen.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), &x| (a.min(x), b.max(x)));
        let chart = Chart { middle: 0.5 * (low + high), half: 0.5 * (high - low) };
        let angle = |k: f64| std::f64::consts::PI * k / POINTS as f64;
        let place = |k: f64| chart.middle - chart.half * angle(k).cos();
        let points: Vec<f64> = (0..POINTS).map(|k| place(k as f64 + 0.5)).collect();
        let probes: Vec<f64> = (0..=POINTS).map(|k| place(k as f64)).collect();
        let cardinal = chart.cardinal(&points);
        let products = row.products(POINTS, blocks, |x| chart.polynomials(x));
        let (mut normal, log_determinant) = products.ok()?;
        for c in 0..blocks * POINTS {
            for r in 0..c {
                normal.gram[(r, c)] = normal.gram[(c, r)];
            }
        }
        let whole = Mat::from_fn(blocks * POINTS, blocks * POINTS, |r, c| {
            if r / POINTS == c / POINTS { cardinal[(r % POINTS, c % POINTS)] } else { 0.0 }
        });
        let half = product(whole.transpose(), normal.gram.as_ref());
        normal.gram = product(half.as_ref(), whole.as_ref());
        let moments = MatRef::from_column_major_slice(&normal.moment, blocks * POINTS, 1);
        normal.moment = product(whole.transpose(), moments).col_as_slice(0).to_vec();
        Some(Self {
            at_probes: chart.at(&probes, &cardinal),
            at_candidates: chart.at(candidates, &cardinal),
            points,
            probes,
            normal,
            log_determinant,
        })
    }

    /// The features of a kernel at the points, points x features; none where it is not of the span.
    pub fn features(&self, kernel: &ScaledKernel, enough: f64, most: usize) -> Option<Mat<f64>> {
        let factor = kernel.pivoted(&self.points, enough, most).factor;
        let features = Mat::from_fn(POINTS, factor.len(), |k, j| factor[j][k]);
        let between = product(self.at_probes.as_ref(), features.as_ref());
        let spec = kernel.family.kernel();
        let mut scaled = [0.0];
        let represented = |(p, &x): (usize, &f64)| {
            kernel.scale(&[x], &mut scaled);
            let whole = spec.evaluate(&scaled, &scaled);
            let found: f64 = (0..factor.len()).map(|j| between[(p, j)].powi(2)).sum();
            (whole - found).abs() <= LEFT * whole
        };
        self.probes.iter().enumerate().all(represented).then_some(features)
    }

    /// Inner products of the features of blocks, side by side in the order given.
    pub fn normal(&self, blocks: &[(usize, &Mat<f64>)]) -> Normal {
        let columns = blocks.iter().map(|(_, features)| features.ncols()).sum();
        let mut normal = Normal::new(columns);
        (normal.square, normal.equations) = (self.normal.square, self.normal.equations);
        let mut row = 0;
        for (i, (b, own)) in blocks.iter().enumerate() {
            for (r, moment) in normal.moment[row..row + own.ncols()].iter_mut().enumerate() {
                let moments = &self.normal.moment[b * POINTS..(b + 1) * POINTS];
                *moment = own.col_as_slice(r).iter().zip(moments).map(|(f, m)| f * m).sum();
            }
            let mut column = 0;
            for (c, other) in &blocks[..=i] {
                let products = self.products(*b, *c);
                let half = product(own.transpose(), products.as_ref());
                let to =
                    normal.gram.as_mut().submatrix_mut(row, column, own.ncols(), other.ncols());
                matmul(to, Accum::Replace, &half, *other, 1.0, Par::Seq);
                column += other.ncols();
            }
            row += own.ncols();
        }
        normal
    }

    /// C_b^T S^-1 C_c, of which the lower triangle is known.
    fn products(&self, b: usize, c: usize) -> Mat<f64> {
        let gram = &self.normal.gram;
        Mat::from_fn(POINTS, POINTS, |i, j| {
            let (i, j) = (b * POINTS + i, c * POINTS + j);
            gram[(i.max(j), i.min(j))]
        })
    }
}

/// A product on one thread.
pub(super) fn product(a: MatRef<'_, f64>, b: MatRef<'_, f64>) -> Mat<f64> {
    let mut product = Mat::zeros(a.nrows(), b.ncols());
    matmul(&mut product, Accum::Replace, a, b, 1.0, Par::Seq);
    product
}

/// The range of the data, for Chebyshev polynomials.
struct Chart {
    middle: f64,
    half: f64,
}

impl Chart {
    /// T_0, ..., T_(POINTS-1) at x, a row each.
    fn polynomials(&self, x: &[f64]) -> Vec<f64> {
        let mut values = vec![0.0; x.len() * POINTS];
        for (x, row) in x.iter().zip(values.chunks_exact_mut(POINTS)) {
            let s = (x - self.middle) / self.half;
            (row[0], row[1]) = (1.0, s);
            for j in 2..POINTS {
                row[j] = 2.0 * s * row[j - 1] - row[j - 2];
            }
        }
        values
    }

    /// Coefficients of the cardinal polynomials of the Chebyshev points in Chebyshev polynomials.
    fn cardinal(&self, points: &[f64]) -> Mat<f64> {
        let values = self.polynomials(points);
        let scale = |j: usize| if j == 0 { 1.0 } else { 2.0 } / POINTS as f64;
        Mat::from_fn(POINTS, POINTS, |j, k| scale(j) * values[k * POINTS + j])
    }

    /// The cardinal polynomials at x, a row each.
    fn at(&self, x: &[f64], cardinal: &Mat<f64>) -> Mat<f64> {
        let values = self.polynomials(x);
        product(MatRef::from_row_major_slice(&values, x.len(), POINTS), cardinal.as_ref())
    }
}

#[cfg(test)]
mod tests {
    use super::super::super::basis::Basis;
    use super::super::super::family::Family;
    use super::super::super::motion::{InputPath, Motion};
    use super::super::super::weak::WeakWindow;
    use super::super::side_by_side;
    use super::*;

    fn window(phase: f64) -> WeakWindow {
        let times: Vec<f64> = (0..24).map(|k| 0.05 * f64::from(k)).collect();
        let y: Vec<f64> = times.iter().map(|t| 2.0 * (2.0 * t + phase).sin() + t * t).collect();
        let u: Vec<f64> = times.iter().map(|t| (3.0 * t + phase).cos()).collect();
        let motion = Motion::new(times, y.clone(), u).unwrap();
        let zeros = vec![0.0; 24];
        let nothing = [zeros.as_slice(), zeros.as_slice()];
        WeakWindow::sampled(motion.into(), y, 2, InputPath::Smooth, nothing, &[0.0])
    }

    fn kernel(family: Family, width: f64) -> ScaledKernel {
        ScaledKernel { family, centre: vec![0.4], widths: vec![width] }
    }

    #[test]
    fn evidence_in_the_span_is_that_of_the_equations() {
        let windows: Vec<WeakWindow> = (0..8).map(|w| window(0.7 * f64::from(w))).collect();
        let row = WeakRow::new(&windows, 0, 0.01, None);
        let seen: Vec<f64> = row.arguments().copied().collect();
        let span = Span::of(&row, &seen, 1, 2).unwrap();
        let constant = kernel(Family::Polynomial(0), 1.0);
        for (kernel, tolerance) in [
            (kernel(Family::Gaussian, 1.5), 1e-3),
            (kernel(Family::Matern, 3.0), 3e-2),
            (kernel(Family::Polynomial(3), 2.0), 1e-6),
        ] {
            let kernels = [kernel.clone(), constant.clone()];
            let prior = |sizes: [usize; 2]| [vec![3.0; sizes[0]], vec![1.0; sizes[1]]].concat();
            let features = kernels.clone().map(|k| span.features(&k, 1e-10, 160).unwrap());
            let spanned = span.normal(&[(0, &features[0]), (1, &features[1])]);
            let sizes = features.each_ref().map(|f| f.ncols());
            let found = spanned.posterior(&prior(sizes), 0.01).unwrap().log_evidence
                - 0.5 * span.log_determinant;
            let bases = kernels.map(|k| Basis::choose(k, &seen, 1e-10, 160));
            let designs = [row.design(&bases[0], 0), row.design(&bases[1], 1)];
            let parts = [&designs[0], &designs[1]];
            let (dense, log_determinant) = row.normal(side_by_side(&parts), &[], 1.0).unwrap();
            let sizes = bases.each_ref().map(Basis::rank);
            let expected =
                dense.posterior(&prior(sizes), 0.01).unwrap().log_evidence - 0.5 * log_determinant;
            assert!((found - expected).abs() < tolerance, "{}: {found} {expected}", kernel.family);
        }
    }

    #[test]
    fn what_is_too_narrow_is_not_of_the_span() {
        let windows = [window(0.0)];
        let row = WeakRow::new(&windows, 0, 0.01, None);
        let seen: Vec<f64> = row.arguments().copied().collect();
        let span = Span::of(&row, &seen, 1, 2).unwrap();
        assert!(span.features(&kernel(Family::Gaussian, 0.02), 1e-10, 160).is_none());
    }
}
