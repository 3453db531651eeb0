//! The equations of one coordinate.

use std::ops::Range;

use faer::linalg::matmul::matmul;
use faer::linalg::triangular_solve::solve_lower_triangular_in_place;
use faer::{Accum, Mat, Par};

use super::super::basis::Basis;
use super::super::evidence::Normal;
use super::reduction::Reduction;
use super::window::WeakWindow;
use crate::linear::{Factor, NonPositivePivot};

/// A jump below this share of the noise is no jump.
const NEGLIGIBLE: f64 = 1e-3;

/// The equations of one coordinate: windows with measurements, and their covariance.
#[derive(Debug)]
pub(crate) struct WeakRow<'w> {
    windows: Vec<RowWindow<'w>>,
    /// Equations of each window.
    ranges: Vec<Range<usize>>,
    /// Weighted and reduced measurements of all windows.
    right: Vec<f64>,
    /// Arguments at the nodes of all windows, and at the middle nodes.
    arguments: Vec<f64>,
    middles: Vec<f64>,
}

/// V (K - Phi Phi^T) V^T of each window, for amplitude 1; empty where landmarks leave nothing.
#[derive(Debug, Clone, Default)]
pub(crate) struct Remainders(Vec<Mat<f64>>);

#[derive(Debug)]
struct RowWindow<'w> {
    window: &'w WeakWindow,
    levels: usize,
    /// Row of the integrated features, and its weight, of each measurement.
    rows: Vec<(usize, f64)>,
    reduction: Reduction,
    /// The samples' and the quadrature's covariance over sigma^2, reduced; none where that is 1.
    covariance: Option<Mat<f64>>,
    /// V_b of each block b: what a constant over each rule's nodes does to the equations.
    responses: Vec<Mat<f64>>,
    /// Weighted and reduced measurements.
    right: Vec<f64>,
}

impl<'w> WeakRow<'w> {
    /// Coordinate `i` of the windows, with samples of standard deviation `noise_sd`; `rate_weight` is that over the
    /// standard deviation of the rates.
    pub fn new(
        windows: &'w [WeakWindow],
        i: usize,
        noise_sd: f64,
        rate_weight: Option<f64>,
    ) -> Self {
        let windows: Vec<RowWindow> = windows
            .iter()
            .map(|window| RowWindow::new(window, i, noise_sd, rate_weight))
            .filter(|row| !row.right.is_empty())
            .collect();
        let mut ranges = Vec::new();
        let mut first = 0;
        for window in &windows {
            ranges.push(first..first + window.right.len());
            first += window.right.len();
        }
        Self {
            ranges,
            right: windows.iter().flat_map(|w| &w.right).copied().collect(),
            arguments: windows.iter().flat_map(|w| &w.window.arguments).copied().collect(),
            middles: windows.iter().flat_map(|w| w.window.middle_arguments()).collect(),
            windows,
        }
    }

    /// Share of the errors' variance that is taken for jumps, from 0 to 1.
    pub fn share_of_jumps(&self) -> f64 {
        let total = |window: &RowWindow| match &window.covariance {
            Some(c) => (0..c.nrows()).map(|k| c[(k, k)]).sum(),
            None => window.right.len() as f64,
        };
        let total: f64 = self.windows.iter().map(total).sum();
        1.0 - self.equations() as f64 / total.max(1.0)
    }

    /// Number of equations.
    pub fn equations(&self) -> usize {
        self.right.len()
    }

    /// The design matrix of one block in the features of a basis.
    pub fn design(&self, basis: &Basis, block: usize) -> Mat<f64> {
        // Kernel values become features last: there are fewer equations than nodes.
        let values = basis.kernel_rows(&self.arguments);
        let mut design = Mat::zeros(self.right.len(), basis.rank());
        let (mut integrated, mut measured) = (Vec::new(), Vec::new());
        for c in 0..basis.rank() {
            let mut values = values.col_as_slice(c);
            for (window, range) in self.windows.iter().zip(&self.ranges) {
                let (own, rest) = values.split_at(window.window.nodes());
                window.window.integrate(own, block, window.levels, &mut integrated);
                window.reduce(&integrated, &mut measured);
                let lost = window.reduction.lost();
                design.col_as_slice_mut(c)[range.clone()].copy_from_slice(&measured[lost..]);
                values = rest;
            }
        }
        basis.to_features(design.as_ref())
    }

    /// What the landmarks of a basis leave of its kernel.
    pub fn remainders(&self, basis: &Basis, block: usize) -> Remainders {
        if basis.is_complete() {
            return Remainders::default();
        }
        let features = basis.features(&self.middles);
        let d = basis.kernel.widths.len();
        let mut first = 0;
        let of_window = |window: &RowWindow| {
            let count = window.responses[block].ncols();
            let points = &self.middles[first * d..(first + count) * d];
            let own = features.subrows(first, count);
            first += count;
            let mut left = basis.kernel_matrix(points);
            matmul(&mut left, Accum::Add, own, own.transpose(), -1.0, Par::Seq);
            let response = &window.responses[block];
            let mut half = Mat::zeros(response.nrows(), count);
            matmul(&mut half, Accum::Replace, response, &left, 1.0, Par::Seq);
            let mut whole = Mat::zeros(response.nrows(), response.nrows());
            matmul(&mut whole, Accum::Replace, &half, response.transpose(), 1.0, Par::Seq);
            whole
        };
        Remainders(self.windows.iter().map(of_window).collect())
    }

    /// Inner products of the equations with independent errors of variance 1, and the logarithm of the determinant of
    /// their covariance before; `remainders` come with their amplitudes.
    pub fn normal(
        &self,
        mut design: Mat<f64>,
        remainders: &[(f64, &Remainders)],
        sigma: f64,
    ) -> Result<(Normal, f64), NonPositivePivot> {
        let mut right = self.right.clone();
        let mut log_determinant = 0.0;
        for (w, (window, range)) in self.windows.iter().zip(&self.ranges).enumerate() {
            let own_right = &mut right[range.clone()];
            let own = design.as_mut().subrows_mut(range.start, range.len());
            let left: Vec<(f64, &Mat<f64>)> =
                remainders.iter().filter_map(|(a, r)| Some((*a, r.0.get(w)?))).collect();
            if window.covariance.is_none() && left.is_empty() {
                own_right.iter_mut().for_each(|v| *v /= sigma);
                faer::zip!(own).for_each(|faer::unzip!(v)| *v /= sigma);
                log_determinant += 2.0 * range.len() as f64 * sigma.ln();
            } else {
                let factor = Factor::of(window.covariance(&left, sigma))?;
                factor.solve_lower_slice(own_right);
                solve_lower_triangular_in_place(factor.lower(), own, Par::Seq);
                log_determinant += factor.log_determinant();
            }
        }
        let mut normal = Normal::new(design.ncols());
        normal.add(design.as_ref(), &right, 0);
        Ok((normal, log_determinant))
    }
}

impl<'w> RowWindow<'w> {
    fn new(window: &'w WeakWindow, i: usize, noise_sd: f64, rate_weight: Option<f64>) -> Self {
        let motion = &window.motion;
        let (n, samples) = (motion.dimension(), motion.samples());
        let mut rows = Vec::new();
        let mut right = Vec::new();
        let mut add = |values: &[f64], level: usize, weight: f64| {
            for k in (0..samples).filter(|&k| !values[k * n + i].is_nan()) {
                rows.push((level * samples + k, weight));
                right.push(weight * values[k * n + i]);
            }
        };
        add(motion.coordinates(), 0, 1.0);
        let mut levels = 1;
        if let (Some(rates), Some(weight)) = (motion.rates(), rate_weight) {
            add(rates, 1, weight);
            levels = 2;
        }
        let reduction = Reduction::of(initial_columns(motion.times(), &rows, window.order));
        reduction.reflect(&mut right);
        let right = right.split_off(reduction.lost());
        let mut row = Self {
            window,
            levels,
            rows,
            reduction,
            covariance: None,
            responses: Vec::new(),
            right,
        };
        let jumps = window.jumps.iter().skip(i).step_by(n).map(|jump| jump / noise_sd).collect();
        let jumps = significant(jumps, window, rate_weight);
        if jumps.iter().any(|jump| *jump > 0.0) {
            row.covariance = Some(row.reduce_both(covariance(window, &row.rows, &jumps)));
        }
        row.responses = (0..=motion.input_count()).map(|b| row.response(b)).collect();
        row
    }

    /// Measurements of integrated features, reduced: entries `lost()` and on.
    fn reduce(&self, integrated: &[f64], measured: &mut Vec<f64>) {
        measured.clear();
        measured.extend(self.rows.iter().map(|&(row, weight)| weight * integrated[row]));
        self.reduction.reflect(measured);
    }

    /// P^T C P for the rows P^T that are left.
    fn reduce_both(&self, mut matrix: Mat<f64>) -> Mat<f64> {
        let (size, lost) = (matrix.nrows(), self.reduction.lost());
        for _ in 0..2 {
            (0..size).for_each(|c| self.reduction.reflect(matrix.col_as_slice_mut(c)));
            matrix = matrix.transpose().to_owned();
        }
        matrix.submatrix(lost, lost, size - lost, size - lost).to_owned()
    }

    /// V of block b.
    fn response(&self, block: usize) -> Mat<f64> {
        let (mut integrated, mut measured) = (Vec::new(), Vec::new());
        let groups = self.window.groups();
        let mut response = Mat::zeros(self.right.len(), groups.len());
        let mut indicator = vec![0.0; self.window.nodes()];
        for (c, group) in groups.into_iter().enumerate() {
            indicator[group.clone()].fill(1.0);
            self.window.integrate(&indicator, block, self.levels, &mut integrated);
            indicator[group].fill(0.0);
            self.reduce(&integrated, &mut measured);
            response.col_as_slice_mut(c).copy_from_slice(&measured[self.reduction.lost()..]);
        }
        response
    }

    /// sigma^2 (I + jumps) + sum_b a_b^2 remainder_b.
    fn covariance(&self, remainders: &[(f64, &Mat<f64>)], sigma: f64) -> Mat<f64> {
        let size = self.right.len();
        let mut whole = Mat::zeros(size, size);
        for c in 0..size {
            let column = whole.col_as_slice_mut(c);
            match &self.covariance {
                Some(own) => {
                    column
                        .iter_mut()
                        .zip(own.col_as_slice(c))
                        .for_each(|(v, j)| *v = sigma * sigma * j);
                }
                None => column[c] = sigma * sigma,
            }
            for (amplitude, remainder) in remainders {
                let factor = amplitude * amplitude;
                column
                    .iter_mut()
                    .zip(remainder.col_as_slice(c))
                    .for_each(|(v, r)| *v += factor * r);
            }
        }
        // Rounding of differences between kernels.
        let trace: f64 = (0..size).map(|c| whole[(c, c)]).sum();
        (0..size).for_each(|c| whole[(c, c)] += 1e-11 * trace);
        whole
    }
}

/// Jumps over sigma, zero where no measurement of the window sees as much as a small share of its noise.
fn significant(mut jumps: Vec<f64>, window: &WeakWindow, rate_weight: Option<f64>) -> Vec<f64> {
    let times = window.motion.times();
    let span = times[times.len() - 1] - times[0];
    let reach = span.powi(window.order as i32 - 1).max(rate_weight.unwrap_or(0.0));
    jumps.iter_mut().filter(|jump| **jump * reach < NEGLIGIBLE).for_each(|jump| *jump = 0.0);
    jumps
}

/// I + sum_k (q_k / sigma)^2 s_k s_k^T.
fn covariance(window: &WeakWindow, rows: &[(usize, f64)], jumps: &[f64]) -> Mat<f64> {
    let times = window.motion.times();
    let samples = times.len();
    let mut covariance = Mat::identity(rows.len(), rows.len());
    for k in 0..samples - 1 {
        let jump = jumps[k];
        if jump == 0.0 {
            continue;
        }
        let response = |&(row, weight): &(usize, f64)| {
            let (level, sample) = (row / samples, row % samples);
            let power = window.order - 1 - level;
            let factorial: f64 = (1..=power).map(|j| j as f64).product();
            let time = times[sample] - times[k];
            if sample > k { jump * weight * time.powi(power as i32) / factorial } else { 0.0 }
        };
        let column: Vec<f64> = rows.iter().map(response).collect();
        for b in 0..rows.len() {
            let entries = covariance.col_as_slice_mut(b);
            entries.iter_mut().zip(&column).for_each(|(c, a)| *c += a * column[b]);
        }
    }
    covariance
}

/// What the initial values a_q do to the measurements: weight t^(q-p) / (q-p)!, up to a factor.
fn initial_columns(
    times: &[f64],
    rows: &[(usize, f64)],
    order: usize,
) -> impl Iterator<Item = Vec<f64>> {
    let (samples, span) = (times.len(), times[times.len() - 1] - times[0]);
    (0..order).map(move |q| {
        let entry = |&(row, weight): &(usize, f64)| {
            let (level, t) = (row / samples, (times[row % samples] - times[0]) / span);
            let falling: f64 = (0..level).map(|j| q as f64 - j as f64).product();
            let scale = falling / span.powi(level as i32);
            weight * scale * if q >= level { t.powi((q - level) as i32) } else { 0.0 }
        };
        rows.iter().map(entry).collect()
    })
}

#[cfg(test)]
mod tests {
    use super::super::super::family::{Family, ScaledKernel};
    use super::super::super::motion::{InputPath, Motion};
    use super::*;
    use crate::Functional;
    use crate::whitening::BandedCholesky;

    fn window(order: usize) -> WeakWindow {
        // Uneven times.
        let times: Vec<f64> =
            (0..24).map(|k| 0.05 * f64::from(k) + 0.01 * f64::from(k % 3)).collect();
        let y: Vec<f64> = times.iter().map(|t| (2.0 * t).sin() + t * t).collect();
        let u: Vec<f64> = times.iter().map(|t| (3.0 * t).cos()).collect();
        let motion = Motion::new(times, y.clone(), u).unwrap();
        let zeros = vec![0.0; 24];
        WeakWindow::sampled(motion, y, order, InputPath::Smooth, [&zeros, &zeros], &[0.0])
    }

    /// int int cos(3 t) from known derivatives.
    #[test]
    fn integrals_are_those_of_the_integrand() {
        let w = window(2);
        let mut found = Vec::new();
        w.integrate(&[1.0; 24], 1, 2, &mut found);
        for (k, t) in w.motion.times().iter().enumerate() {
            let expected = [(1.0 - (3.0 * t).cos()) / 9.0, (3.0 * t).sin() / 3.0];
            for (p, e) in expected.iter().enumerate() {
                assert!((found[p * 24 + k] - e).abs() < 2e-5, "{p} {k}");
            }
        }
    }

    /// int int sin(2 t) from values at the nodes within the intervals.
    #[test]
    fn integrals_along_a_path_are_those_of_the_integrand() {
        let motion = window(2).motion;
        let times = motion.times().to_vec();
        let shares = crate::identification::weak::shares_within(2);
        let between = |t: &[f64]| {
            let (start, step) = (t[0], t[1] - t[0]);
            shares.iter().map(move |share| (2.0 * (start + share * step)).sin())
        };
        let values: Vec<f64> = times.windows(2).flat_map(between).collect();
        let none = vec![0.0; 23];
        let w = WeakWindow::along(motion, values.clone(), 2, InputPath::Smooth, 2, none);
        let mut found = Vec::new();
        w.integrate(&values, 0, 2, &mut found);
        for (k, t) in times.iter().enumerate() {
            let expected = [0.5 * t - 0.25 * (2.0 * t).sin(), 0.5 - 0.5 * (2.0 * t).cos()];
            for (p, e) in expected.iter().enumerate() {
                assert!((found[p * 24 + k] - e).abs() < 1e-12, "{p} {k}");
            }
        }
    }

    /// What landmarks leave is what dense kernels have and features have not.
    #[test]
    fn remainders_make_few_landmarks_as_good_as_all() {
        let w = [window(2)];
        let row = WeakRow::new(&w, 0, 1.0, None);
        let kernel = ScaledKernel { family: Family::Matern, centre: vec![0.5], widths: vec![0.4] };
        let covariance = |most: usize| {
            let basis = Basis::choose(kernel.clone(), &w[0].arguments, 1e-12, most);
            let design = row.design(&basis, 0);
            let mut whole = &design * design.transpose();
            if let Some(left) = row.remainders(&basis, 0).0.first() {
                whole += left;
            }
            whole
        };
        let (all, few) = (covariance(24), covariance(3));
        for i in 0..all.nrows() {
            for j in 0..=i {
                let scale = (all[(i, i)] * all[(j, j)]).sqrt();
                assert!((all[(i, j)] - few[(i, j)]).abs() < 1e-8 * scale, "{i} {j}");
            }
        }
    }

    /// y'' = 2 - 4 sin 2t is explained to the quadrature's accuracy.
    #[test]
    fn the_true_integrand_explains_the_samples() {
        let w = window(2);
        let truth = w.motion.times().iter().map(|t| 2.0 - 4.0 * (2.0 * t).sin());
        let truth: Vec<f64> = truth.collect();
        let mut explained = Vec::new();
        w.integrate(&truth, 0, 1, &mut explained);
        let row = RowWindow::new(&w, 0, 1.0, None);
        row.reduction.reflect(&mut explained);
        for (a, b) in explained[row.reduction.lost()..].iter().zip(&row.right) {
            assert!((a - b).abs() < 3e-6, "{a} {b}");
        }
    }

    #[test]
    fn reduction_is_whitening_of_divided_differences() {
        let w = window(2);
        let times = w.motion.times();
        let difference = |k: usize| {
            let t = &times[k..k + 3];
            let weight =
                |l: usize| (0..3).filter(|&j| j != l).map(|j| 1.0 / (t[l] - t[j])).product::<f64>();
            Functional { first: k, weights: (0..3).map(weight).collect() }
        };
        let functionals: Vec<Functional> = (0..22).map(difference).collect();
        let whitener = BandedCholesky::of_functionals(&functionals).unwrap();
        let integrated = [1.0, 2.0].map(|rate| {
            let feature: Vec<f64> = times.iter().map(|t| (t * rate).cos()).collect();
            let mut integrated = Vec::new();
            w.integrate(&feature, 1, 1, &mut integrated);
            integrated
        });
        let row = RowWindow::new(&w, 0, 1.0, None);
        let whitened = |values: &[f64]| {
            let mut out: Vec<f64> =
                functionals.iter().map(|f| f.apply_column(values, 1, 0)).collect();
            whitener.solve_lower_in_place(&mut out).unwrap();
            out
        };
        let reduced = |values: &[f64]| {
            let mut out = values.to_vec();
            row.reduction.reflect(&mut out);
            out.split_off(row.reduction.lost())
        };
        let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(x, y)| x * y).sum::<f64>();
        let (y, a, b) =
            (w.motion.coordinates(), integrated[0].as_slice(), integrated[1].as_slice());
        for (p, q) in [(y, y), (y, a), (a, b), (b, b)] {
            let (left, right) = (dot(&whitened(p), &whitened(q)), dot(&reduced(p), &reduced(q)));
            let size = (dot(p, p) * dot(q, q)).sqrt();
            assert!((left - right).abs() < 1e-9 * size, "{left} {right}");
        }
    }
}
