//! The equations of one coordinate.

use std::ops::Range;
use std::sync::OnceLock;

use faer::linalg::matmul::matmul;
use faer::linalg::triangular_solve::solve_lower_triangular_in_place;
use faer::prelude::*;
use faer::{Accum, Mat, MatMut, MatRef, Par};
use rayon::prelude::*;

use super::super::basis::Basis;
use super::super::evidence::Normal;
use super::integral::{Integral, Reflection};
use super::reduction::Reduction;
use super::window::WeakWindow;
use crate::linear::{Factor, NonPositivePivot};

/// Jumps that together stay below this share of the noise (a hundredth of its variance) are none.
const NEGLIGIBLE: f64 = 0.1;
/// Windows whose inner products are summed by one thread, in order.
const GROUP: usize = 16;

/// The equations of one coordinate: windows with measurements, and their covariance.
#[derive(Debug)]
pub(crate) struct WeakRow<'w> {
    windows: Vec<RowWindow<'w>>,
    /// Equations of each window.
    ranges: Vec<Range<usize>>,
    /// Weighted and reduced measurements of all windows.
    right: Vec<f64>,
    /// Arguments at the middle nodes of all windows.
    middles: Vec<f64>,
}

/// V (K - Phi Phi^T) V^T of each window, for amplitude 1; empty where landmarks leave nothing.
#[derive(Debug, Clone, Default)]
pub(crate) struct Remainders(Vec<Mat<f64>>);

impl Remainders {
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }
}

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
    responses: OnceLock<Vec<Mat<f64>>>,
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

    /// Arguments at the nodes of all windows, one entry after the other.
    pub fn arguments(&self) -> impl Iterator<Item = &f64> {
        self.windows.iter().flat_map(|w| &w.window.arguments)
    }

    /// The design matrix of one block in the features of a basis.
    pub fn design(&self, basis: &Basis, block: usize) -> Mat<f64> {
        // Kernel values become features last: there are fewer equations than nodes. One window after the other, so that its
        // nodes' values stay near the processor.
        let columns = basis.rank();
        let mut integrated = Mat::zeros(columns, self.right.len());
        let (mut values, mut room) = (Vec::new(), Vec::new());
        for (window, range) in self.windows.iter().zip(&self.ranges) {
            basis.kernel_values(&window.window.arguments, &mut values);
            let reduced = window.reduced(&values, columns, block, &mut room);
            for (equation, row) in range.clone().zip(reduced.chunks_exact(columns.max(1))) {
                integrated.col_as_slice_mut(equation).copy_from_slice(row);
            }
        }
        basis.to_features(integrated.transpose())
    }

    /// Inner products for functions whose values at arguments are `values` (a row an argument), block after block, with errors of
    /// variance sigma^2, and the logarithm of the determinant of their covariance for sigma 1.
    pub fn products(
        &self,
        columns: usize,
        blocks: usize,
        values: impl Fn(&[f64]) -> Vec<f64> + Sync,
    ) -> Result<(Normal, f64), NonPositivePivot> {
        let group = |windows: &[usize]| {
            let (mut normal, mut log_determinant) = (Normal::new(blocks * columns), 0.0);
            let mut room = Vec::new();
            for &w in windows {
                let (window, range) = (&self.windows[w], self.ranges[w].clone());
                let values = values(&window.window.arguments);
                let mut design = Mat::zeros(range.len(), blocks * columns);
                for block in 0..blocks {
                    let reduced = window.reduced(&values, columns, block, &mut room);
                    let reduced = MatRef::from_row_major_slice(reduced, range.len(), columns);
                    design.as_mut().subcols_mut(block * columns, columns).copy_from(reduced);
                }
                let mut right = self.right[range].to_vec();
                log_determinant += window.whiten(design.as_mut(), &mut right, &[], 1.0)?;
                normal.add(design.as_ref(), &right);
            }
            Ok((normal, log_determinant))
        };
        let all: Vec<usize> = (0..self.windows.len()).collect();
        let groups: Vec<Result<(Normal, f64), NonPositivePivot>> =
            all.par_chunks(GROUP).map(group).collect();
        let (mut total, mut log_determinant) = (Normal::new(blocks * columns), 0.0);
        for found in groups {
            let (normal, own) = found?;
            total.merge(&normal);
            log_determinant += own;
        }
        Ok((total, log_determinant))
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
            let count = window.responses()[block].ncols();
            let points = &self.middles[first * d..(first + count) * d];
            let own = features.subrows(first, count);
            first += count;
            let mut left = basis.kernel_matrix(points);
            matmul(&mut left, Accum::Add, own, own.transpose(), -1.0, Par::Seq);
            let response = &window.responses()[block];
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
            log_determinant += window.whiten(own, own_right, &left, sigma)?;
        }
        let mut normal = Normal::new(design.ncols());
        normal.add(design.as_ref(), &right);
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
            responses: OnceLock::new(),
            right,
        };
        let jumps = window.jumps.iter().skip(i).step_by(n).map(|jump| jump / noise_sd).collect();
        let jumps = significant(jumps, window, rate_weight);
        if jumps.iter().any(|jump| *jump > 0.0) {
            row.covariance = Some(row.reduce_both(covariance(window, &row.rows, &jumps)));
        }
        row
    }

    /// Functions' values at the nodes times input `block`, integrated, measured and reduced, a row an equation; in `room`.
    fn reduced<'r>(
        &self,
        values: &[f64],
        columns: usize,
        block: usize,
        room: &'r mut Vec<f64>,
    ) -> &'r [f64] {
        let (window, levels) = (self.window, self.levels);
        let integrated_rows = levels * window.motion.samples();
        room.clear();
        room.resize((integrated_rows + self.rows.len()) * columns, 0.0);
        let (integrated, measured) = room.split_at_mut(integrated_rows * columns);
        Integral { window, block, levels, columns, values, integrated }.work_out();
        for (&(row, weight), to) in self.rows.iter().zip(measured.chunks_exact_mut(columns.max(1)))
        {
            let from = &integrated[row * columns..(row + 1) * columns];
            to.iter_mut().zip(from).for_each(|(to, from)| *to = weight * from);
        }
        Reflection { reduction: &self.reduction, columns, rows: measured }.work_out();
        &measured[self.reduction.lost() * columns..]
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

    /// Makes errors independent with variance 1, and returns the logarithm of the determinant of their covariance before.
    fn whiten(
        &self,
        mut design: MatMut<'_, f64>,
        right: &mut [f64],
        remainders: &[(f64, &Mat<f64>)],
        sigma: f64,
    ) -> Result<f64, NonPositivePivot> {
        if self.covariance.is_some() || !remainders.is_empty() {
            // Differences of kernels that the landmarks hold nearly are lost in rounding, and may come out negative.
            let factor = Factor::of_nearly(|| self.covariance(remainders, sigma))?;
            factor.solve_lower_slice(right);
            solve_lower_triangular_in_place(factor.lower(), design, Par::Seq);
            return Ok(factor.log_determinant());
        }
        if sigma != 1.0 {
            right.iter_mut().for_each(|v| *v /= sigma);
            faer::zip!(design.rb_mut()).for_each(|faer::unzip!(v)| *v /= sigma);
        }
        Ok(2.0 * right.len() as f64 * sigma.ln())
    }

    fn responses(&self) -> &[Mat<f64>] {
        let blocks = 0..=self.window.motion.input_count();
        self.responses.get_or_init(|| blocks.map(|b| self.response(b)).collect())
    }

    /// V of block b.
    fn response(&self, block: usize) -> Mat<f64> {
        let groups = self.window.groups();
        let columns = groups.len();
        let mut indicators = vec![0.0; self.window.nodes() * columns];
        for (c, group) in groups.into_iter().enumerate() {
            group.for_each(|node| indicators[node * columns + c] = 1.0);
        }
        let mut room = Vec::new();
        let reduced = self.reduced(&indicators, columns, block, &mut room);
        Mat::from_fn(self.right.len(), columns, |r, c| reduced[r * columns + c])
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

/// Jumps over sigma, zero where no measurement of the window sees more of them than a small share of its noise.
fn significant(mut jumps: Vec<f64>, window: &WeakWindow, rate_weight: Option<f64>) -> Vec<f64> {
    let times = window.motion.times();
    let span = times[times.len() - 1] - times[0];
    let reach = span.powi(window.order as i32 - 1).max(rate_weight.unwrap_or(0.0));
    let together = jumps.iter().map(|jump| jump * jump).sum::<f64>().sqrt();
    if together * reach < NEGLIGIBLE {
        jumps.fill(0.0);
    }
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
mod tests;
