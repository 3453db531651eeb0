//! The weak form with free initial values.
//!
//! ```text
//! y_k^(p) = sum_(q >= p) a_q t^(q-p) / (q-p)! + int_0^(t_k) (t_k - r)^(s-1-p) / (s-1-p)! [f + g u](gamma(r)) dr + e_k
//! ```
//!
//! for every sample k of a window at once: the paper's test function, with each sample for its end T, and with the
//! initial values a as unknowns instead of estimates. The errors e are those of the samples, independent; the a are
//! projected out. For p = 0 this is, equation for equation, generalised least squares on the divided differences of order
//! s of the samples (int of x^(s) under a B-spline, the compact test function of shortest support), whitened by their
//! exact noise covariance: the difference operator's null space are the polynomials that a spans
//! (`tests::projection_is_whitening_of_divided_differences`).
//!
//! The integrand between samples is the kernel's cubic through four neighbouring samples times the input's path. Where
//! the motion is too quick for that, the smoothed trajectory disobeys its own weak form; the error that shows there is
//! taken for a random jump of the highest derivative, r_k ~ N(0, q_k^2), and whitened away with the samples' errors:
//! their covariance is sigma^2 (I + sum_k (q_k / sigma)^2 s_k s_k^T), s_k the response of the samples to the jump.

use faer::{Mat, MatRef};

use super::basis::Basis;
use super::inputs::{first_of_four, input_at, lagrange};
use super::motion::{InputPath, Motion};
use crate::linear::Factor;

/// Nodes and weights of the Gauss-Legendre rule of four points on \[0, 1\], exact to degree 7: a cubic times a cubic
/// times (t - r).
const GAUSS: [(f64, f64); 4] = [
    (0.069_431_844_202_973_71, 0.173_927_422_568_726_93),
    (0.330_009_478_207_571_87, 0.326_072_577_431_273_07),
    (0.669_990_521_792_428_1, 0.326_072_577_431_273_07),
    (0.930_568_155_797_026_3, 0.173_927_422_568_726_93),
];

/// Where the quadrature's error is above this share of the integral, the interval says nothing.
const UNRESOLVED: f64 = 0.03;
/// Least jump over an interval of a window with intervals that say nothing, relative to the integral of a typical
/// y^(s): without it, kernels chosen on stiff motion that is nearly free of noise follow the errors of quadrature.
const NUGGET: f64 = 5e-3;
/// A jump below this share of the noise is no jump.
const NEGLIGIBLE: f64 = 1e-3;

/// A window: a stretch of motion with free initial values.
#[derive(Debug, Clone)]
pub(crate) struct WeakWindow {
    pub motion: Motion,
    /// Estimated kernel arguments, N x d.
    pub arguments: Vec<f64>,
    /// Error of the quadrature over each interval, for each coordinate: (N - 1) x n, units of y^(s-1).
    jumps: Vec<f64>,
    /// Interval k, block j, moment r: weights of four samples, at ((k (m + 1) + j) s + r).
    weights: Vec<[f64; 4]>,
    order: usize,
}

impl WeakWindow {
    /// A window with the smoothed derivatives y^(s-1) and y^(s) of its coordinates, N x n each, and the typical size
    /// (`scale`) of each y^(s).
    pub fn new(
        motion: Motion,
        arguments: Vec<f64>,
        order: usize,
        path: InputPath,
        [below, highest]: [&[f64]; 2],
        scale: &[f64],
    ) -> Self {
        let weights = interval_weights(&motion, order, path);
        let mut window = Self { motion, arguments, jumps: Vec::new(), weights, order };
        window.jumps = window.quadrature_errors(below, highest, scale);
        window
    }

    /// Error of the integral of the smoothed y^(s) over each interval, the largest of three intervals: what is missing to
    /// the difference of y^(s-1), or what the integral changes if the cubic gives way to a parabola.
    fn quadrature_errors(&self, below: &[f64], highest: &[f64], scale: &[f64]) -> Vec<f64> {
        let (n, samples) = (self.motion.dimension(), self.motion.samples());
        let times = self.motion.times();
        let error = |k: usize, i: usize| -> (f64, bool) {
            let first = first_of_four(k, samples);
            let weights = &self.weights[self.index(k, 0, 0)];
            let values: [f64; 4] = std::array::from_fn(|l| highest[(first + l) * n + i]);
            let integral: f64 = weights.iter().zip(values).map(|(w, v)| w * v).sum();
            let missing = below[(k + 1) * n + i] - below[k * n + i] - integral;
            let rougher = integral - parabola(times, first, k, values);
            let found = missing.abs().max(rougher.abs());
            let largest = values.iter().fold(0.1 * scale[i], |m, v| m.max(v.abs()));
            let unresolved = found > UNRESOLVED * (times[k + 1] - times[k]) * largest;
            (if unresolved { scale[i] } else { found }, unresolved)
        };
        let mut jumps = vec![0.0; (samples - 1) * n];
        for i in 0..n {
            let found: Vec<(f64, bool)> = (0..samples - 1).map(|k| error(k, i)).collect();
            let nugget = if found.iter().any(|(_, unresolved)| *unresolved) { NUGGET } else { 0.0 };
            for k in 0..samples - 1 {
                let near = &found[k.saturating_sub(1)..(k + 2).min(samples - 1)];
                let least = nugget * (times[k + 1] - times[k]) * scale[i];
                jumps[k * n + i] = near.iter().map(|(jump, _)| *jump).fold(least, f64::max);
            }
        }
        jumps
    }

    /// Rows of features at the samples (N x r), times input `block` (0 for none), integrated: for p = 0, ...,
    /// `levels` - 1 the N rows of derivative p, one level below the other.
    pub fn integrate(&self, features: MatRef<'_, f64>, block: usize, levels: usize) -> Mat<f64> {
        let (samples, order) = (self.motion.samples(), self.order);
        let mut rows = Mat::zeros(levels * samples, features.ncols());
        let times = self.motion.times();
        for c in 0..features.ncols() {
            let column = features.col(c);
            // y, y', ..., y^(s-1) of the integrated feature.
            let mut state = vec![0.0; order];
            for k in 0..samples - 1 {
                let step = times[k + 1] - times[k];
                advance(&mut state, step);
                let first = first_of_four(k, samples);
                for (p, entry) in state.iter_mut().enumerate() {
                    let weights = &self.weights[self.index(k, block, order - 1 - p)];
                    *entry += (0..4).map(|l| weights[l] * column[first + l]).sum::<f64>();
                }
                (0..levels).for_each(|p| rows[(p * samples + k + 1, c)] = state[p]);
            }
        }
        rows
    }

    fn index(&self, k: usize, block: usize, moment: usize) -> usize {
        (k * (self.motion.input_count() + 1) + block) * self.order + moment
    }
}

/// Integral over interval k of the parabola through three of the four samples from `first` on, those around the interval.
fn parabola(times: &[f64], first: usize, k: usize, values: [f64; 4]) -> f64 {
    let from = (k - first).min(1);
    let (t, v) = (&times[first + from..first + from + 3], &values[from..from + 3]);
    let step = times[k + 1] - times[k];
    let value = |time: f64| -> f64 {
        let share = |l: usize| {
            (0..3).filter(|&j| j != l).map(|j| (time - t[j]) / (t[l] - t[j])).product::<f64>()
        };
        (0..3).map(|l| v[l] * share(l)).sum()
    };
    GAUSS.iter().map(|&(node, weight)| weight * step * value(times[k] + node * step)).sum()
}

/// Taylor: y^(p) += sum_(q > p) h^(q-p) / (q-p)! y^(q).
fn advance(state: &mut [f64], step: f64) {
    for p in 0..state.len() {
        let mut taylor = 1.0;
        for q in p + 1..state.len() {
            taylor *= step / (q - p) as f64;
            state[p] += taylor * state[q];
        }
    }
}

/// int (t_(k+1) - r)^moment / moment! u_block(r) l(r) dr for the four Lagrange polynomials l of the interval.
fn interval_weights(motion: &Motion, order: usize, path: InputPath) -> Vec<[f64; 4]> {
    let (times, m) = (motion.times(), motion.input_count());
    let samples = times.len();
    let mut weights = vec![[0.0; 4]; (samples - 1) * (m + 1) * order];
    let mut u = vec![1.0; m + 1];
    for k in 0..samples - 1 {
        let (start, step) = (times[k], times[k + 1] - times[k]);
        let first = first_of_four(k, samples);
        for (node, weight) in GAUSS {
            let t = start + node * step;
            input_at(motion, path, k, t, &mut u[1..]);
            let cubic = lagrange(&times[first..first + 4], t);
            for (j, u) in u.iter().enumerate() {
                let mut factor = weight * step * u;
                for moment in 0..order {
                    let entry = &mut weights[(k * (m + 1) + j) * order + moment];
                    entry.iter_mut().zip(cubic).for_each(|(w, l)| *w += factor * l);
                    factor *= (times[k + 1] - t) / (moment + 1) as f64;
                }
            }
        }
    }
    weights
}

/// The equations of one coordinate: windows with measurements, their noise scale, and projections.
#[derive(Debug)]
pub(crate) struct WeakRow<'w> {
    windows: Vec<RowWindow<'w>>,
}

#[derive(Debug)]
struct RowWindow<'w> {
    window: &'w WeakWindow,
    levels: usize,
    /// Row of the integrated features, and its weight, of each measurement.
    rows: Vec<(usize, f64)>,
    /// Factor of the errors' covariance over sigma^2.
    whitener: Factor,
    /// Orthonormal columns that the initial values span, measurement by measurement, whitened.
    initial: Vec<Vec<f64>>,
    /// Weighted and projected measurements.
    right: Vec<f64>,
}

impl<'w> WeakRow<'w> {
    /// Coordinate `i` of the windows, with samples of standard deviation `noise_sd`; `rate_weight` is that over the
    /// standard deviation of the rates.
    pub fn new(
        windows: impl Iterator<Item = &'w WeakWindow>,
        i: usize,
        noise_sd: f64,
        rate_weight: Option<f64>,
    ) -> Self {
        let windows: Vec<RowWindow> = windows
            .filter_map(|window| RowWindow::new(window, i, noise_sd, rate_weight))
            .filter(|row| row.rows.len() > row.initial.len())
            .collect();
        Self { windows }
    }

    /// Right-hand sides window by window, and how many of each are spent on initial values.
    pub fn right_hand_sides(&self) -> impl Iterator<Item = (&[f64], usize)> {
        self.windows.iter().map(|w| (w.right.as_slice(), w.initial.len()))
    }

    /// The design matrices of one block in the features of a basis, window by window.
    pub fn designs(&self, basis: &Basis, block: usize) -> Vec<Mat<f64>> {
        self.windows.iter().map(|w| w.design(basis, block)).collect()
    }
}

impl<'w> RowWindow<'w> {
    /// None where the covariance cannot be factorised.
    fn new(
        window: &'w WeakWindow,
        i: usize,
        noise_sd: f64,
        rate_weight: Option<f64>,
    ) -> Option<Self> {
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
        let whitener = Factor::of(covariance(window, &rows, i, noise_sd)).ok()?;
        let initial = initial_columns(motion.times(), &rows, window.order, &whitener);
        whitener.solve_lower_slice(&mut right);
        project(&initial, &mut right);
        Some(Self { window, levels, rows, whitener, initial, right })
    }

    fn design(&self, basis: &Basis, block: usize) -> Mat<f64> {
        let features = basis.features(&self.window.arguments);
        let integrated = self.window.integrate(features.as_ref(), block, self.levels);
        let mut design = Mat::zeros(self.rows.len(), basis.rank());
        for c in 0..basis.rank() {
            let column = design.col_as_slice_mut(c);
            for (entry, &(row, weight)) in column.iter_mut().zip(&self.rows) {
                *entry = weight * integrated[(row, c)];
            }
        }
        self.whitener.solve_lower(&mut design);
        for c in 0..basis.rank() {
            project(&self.initial, design.col_as_slice_mut(c));
        }
        design
    }
}

/// I + sum_k (q_k / sigma)^2 s_k s_k^T.
fn covariance(window: &WeakWindow, rows: &[(usize, f64)], i: usize, noise_sd: f64) -> Mat<f64> {
    let times = window.motion.times();
    let (n, samples) = (window.motion.dimension(), times.len());
    let mut covariance = Mat::identity(rows.len(), rows.len());
    for k in 0..samples - 1 {
        let jump = window.jumps[k * n + i] / noise_sd;
        if jump < NEGLIGIBLE {
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

/// Orthonormal basis of what the initial values a_q do to the measurements: weight t^(q-p) / (q-p)!, whitened.
fn initial_columns(
    times: &[f64],
    rows: &[(usize, f64)],
    order: usize,
    whitener: &Factor,
) -> Vec<Vec<f64>> {
    let (samples, span) = (times.len(), times[times.len() - 1] - times[0]);
    let mut columns: Vec<Vec<f64>> = Vec::new();
    for q in 0..order {
        let entry = |&(row, weight): &(usize, f64)| {
            let (level, t) = (row / samples, (times[row % samples] - times[0]) / span);
            let falling: f64 = (0..level).map(|j| q as f64 - j as f64).product();
            let scale = falling / span.powi(level as i32);
            weight * scale * if q >= level { t.powi((q - level) as i32) } else { 0.0 }
        };
        let mut column: Vec<f64> = rows.iter().map(entry).collect();
        whitener.solve_lower_slice(&mut column);
        let before = norm(&column);
        // Twice is enough (Kahan).
        project(&columns, &mut column);
        project(&columns, &mut column);
        let length = norm(&column);
        if length > 1e-10 * before {
            column.iter_mut().for_each(|v| *v /= length);
            columns.push(column);
        }
    }
    columns
}

fn norm(values: &[f64]) -> f64 {
    values.iter().map(|v| v * v).sum::<f64>().sqrt()
}

fn project(columns: &[Vec<f64>], values: &mut [f64]) {
    for column in columns {
        let share: f64 = column.iter().zip(values.iter()).map(|(c, v)| c * v).sum();
        values.iter_mut().zip(column).for_each(|(v, c)| *v -= share * c);
    }
}

#[cfg(test)]
mod tests {
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
        WeakWindow::new(motion, y, order, InputPath::Smooth, [&zeros, &zeros], &[0.0])
    }

    /// int int cos(3 t) from known derivatives.
    #[test]
    fn integrals_are_those_of_the_integrand() {
        let w = window(2);
        let ones = Mat::from_fn(24, 1, |_, _| 1.0);
        let found = w.integrate(ones.as_ref(), 1, 2);
        for (k, t) in w.motion.times().iter().enumerate() {
            let expected = [(1.0 - (3.0 * t).cos()) / 9.0, (3.0 * t).sin() / 3.0];
            for (p, e) in expected.iter().enumerate() {
                assert!((found[(p * 24 + k, 0)] - e).abs() < 2e-5, "{p} {k}");
            }
        }
    }

    /// y'' = 2 - 4 sin 2t is explained to the quadrature's accuracy.
    #[test]
    fn the_true_integrand_explains_the_samples() {
        let w = window(2);
        let truth = w.motion.times().iter().map(|t| 2.0 - 4.0 * (2.0 * t).sin());
        let truth: Vec<f64> = truth.collect();
        let column = MatRef::from_column_major_slice(&truth, 24, 1);
        let row = RowWindow::new(&w, 0, 1.0, None).unwrap();
        let mut explained: Vec<f64> = w.integrate(column, 0, 1).col_as_slice(0).to_vec();
        project(&row.initial, &mut explained);
        for (a, b) in explained.iter().zip(&row.right) {
            assert!((a - b).abs() < 3e-6, "{a} {b}");
        }
    }

    #[test]
    fn projection_is_whitening_of_divided_differences() {
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
        let features = Mat::from_fn(24, 2, |k, c| (times[k] * (c + 1) as f64).cos());
        let integrated = w.integrate(features.as_ref(), 1, 1);
        let row = RowWindow::new(&w, 0, 1.0, None).unwrap();
        let whitened = |values: &[f64]| {
            let mut out: Vec<f64> =
                functionals.iter().map(|f| f.apply_column(values, 1, 0)).collect();
            whitener.solve_lower_in_place(&mut out).unwrap();
            out
        };
        let projected = |values: &[f64]| {
            let mut out = values.to_vec();
            project(&row.initial, &mut out);
            out
        };
        let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(x, y)| x * y).sum::<f64>();
        let (y, a, b) =
            (w.motion.coordinates(), integrated.col_as_slice(0), integrated.col_as_slice(1));
        for (p, q) in [(y, y), (y, a), (a, b), (b, b)] {
            let (left, right) =
                (dot(&whitened(p), &whitened(q)), dot(&projected(p), &projected(q)));
            let size = (dot(p, p) * dot(q, q)).sqrt();
            assert!((left - right).abs() < 1e-9 * size, "{left} {right}");
        }
    }
}
