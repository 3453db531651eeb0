//! What one density makes of series.

use super::super::{Matrix, Step, Vector, rotation, unit, unit_drive};
use super::{Samples, SharedSmoother};

/// Series that pass side by side.
pub(super) const LANES: usize = 8;
/// Steps that differ by less are equal, and so are factors.
const SAME: f64 = 1e-11;
/// Columns of the widest system: driving noise, state, and what it may depend on.
const COLUMNS: usize = 14;

/// What a density makes of the series; R = D + 2.
#[derive(Debug)]
pub(super) struct Gain<const D: usize, const R: usize> {
    distinct: Vec<StepGain<D, R>>,
    /// Which of them belongs to each sample.
    index: Vec<usize>,
    /// R_N^-1.
    last: Matrix<D>,
    pub log_determinant: f64,
}

#[derive(Clone, Debug)]
struct StepGain<const D: usize, const R: usize> {
    /// (z, e) of a sample from z of the one before it and what was measured.
    forward: [[f64; R]; R],
    /// The mean before the step is F^-1 m' - G (E z - R_ws m'), from the mean m' after it and z before it.
    inverse: Matrix<D>,
    gain: Matrix<D>,
    of_state: Matrix<D>,
    of_z: Matrix<D>,
}

type Lane = [f64; LANES];

impl<const D: usize, const R: usize> Gain<D, R> {
    pub fn new(shared: &SharedSmoother, density: f64) -> Self {
        let unit_drive = unit_drive::<D>(density);
        let mut made = Self {
            distinct: Vec::new(),
            index: Vec::new(),
            last: [[0.0; D]; D],
            log_determinant: 0.0,
        };
        let mut factor = [[0.0; D]; D];
        // Width, measurements and log determinant of the step before, once its factor came out as it went in.
        let mut steady: Option<(f64, [bool; 2], f64)> = None;
        let times = &shared.times;
        for (k, &present) in shared.present.iter().enumerate() {
            let width = if k == 0 { 0.0 } else { times[k] - times[k - 1] };
            if let Some((before, was, log_determinant)) = steady
                && (before - width).abs() < SAME * width
                && was == present
            {
                made.index.push(made.distinct.len() - 1);
                made.log_determinant += log_determinant;
                continue;
            }
            let step = (k > 0).then(|| Step::new(width, &unit_drive));
            let (gain, after, log_determinant) =
                StepGain::new(step.as_ref(), &factor, present, shared.rate_weight);
            steady = same(&factor, &after).then_some((width, present, log_determinant));
            factor = after;
            made.index.push(made.distinct.len());
            made.distinct.push(gain);
            made.log_determinant += log_determinant;
        }
        made.log_determinant += (0..D).map(|j| factor[j][j].abs().ln()).sum::<f64>();
        made.last = inverse_of_upper(&factor);
        made
    }

    /// Sums of squared residuals of up to [`LANES`] series; `seen` is given z after each sample.
    pub fn filter(
        &self,
        shared: &SharedSmoother,
        series: &[Samples<'_>],
        wanted: &[usize],
        mut seen: impl FnMut([Lane; D]),
    ) -> Lane {
        let mut z = [[0.0; LANES]; D];
        let mut squares = [0.0; LANES];
        for (k, (&index, present)) in self.index.iter().zip(&shared.present).enumerate() {
            let forward = &self.distinct[index].forward;
            let mut input = [[0.0; LANES]; R];
            input[..D].copy_from_slice(&z);
            for (lane, &s) in wanted.iter().enumerate() {
                if present[0] {
                    input[D][lane] = series[s].values[k];
                }
                if present[1] {
                    input[D + 1][lane] = series[s].rates[k] * shared.rate_scale;
                }
            }
            let rows = if present[1] { R } else { D + 1 };
            for (i, row) in forward.iter().enumerate().take(rows) {
                let sum = combined(&row[..rows], &input[..rows]);
                if i < D {
                    z[i] = sum;
                } else {
                    squares.iter_mut().zip(sum).for_each(|(square, e)| *square += e * e);
                }
            }
            seen(z);
        }
        squares
    }

    /// Writes the states of up to [`LANES`] series, in units per second.
    pub fn smooth(
        &self,
        shared: &SharedSmoother,
        series: &[Samples<'_>],
        wanted: &[usize],
        states: &mut [Option<Vec<f64>>],
    ) {
        let count = self.index.len();
        let mut filtered = Vec::with_capacity(count);
        self.filter(shared, series, wanted, |z| filtered.push(z));
        for &s in wanted {
            states[s] = Some(vec![0.0; count * D]);
        }
        let scale: [f64; D] = std::array::from_fn(|p| shared.step.powi(-(p as i32)));
        let mut mean = [[0.0; LANES]; D];
        for k in (0..count).rev() {
            let z = &filtered[k];
            mean = if k + 1 == count {
                std::array::from_fn(|i| combined(&self.last[i], z))
            } else {
                let step = &self.distinct[self.index[k + 1]];
                // What the driving noise was: small where its two parts may be large.
                let noise = std::array::from_fn(|i| {
                    difference(combined(&step.of_z[i], z), combined(&step.of_state[i], &mean))
                });
                let noise: [Lane; D] = noise;
                std::array::from_fn(|i| {
                    difference(combined(&step.inverse[i], &mean), combined(&step.gain[i], &noise))
                })
            };
            for (lane, &s) in wanted.iter().enumerate() {
                let Some(states) = &mut states[s] else { continue };
                (0..D).for_each(|p| states[k * D + p] = mean[p][lane] * scale[p]);
            }
        }
    }
}

#[inline(always)]
fn combined(weights: &[f64], lanes: &[Lane]) -> Lane {
    let mut sum = [0.0; LANES];
    for (weight, lane) in weights.iter().zip(lanes) {
        for (sum, value) in sum.iter_mut().zip(lane) {
            *sum += weight * value;
        }
    }
    sum
}

fn difference(a: Lane, b: Lane) -> Lane {
    std::array::from_fn(|lane| a[lane] - b[lane])
}

impl<const D: usize, const R: usize> StepGain<D, R> {
    /// Gains of a step and the measurements after it (of the first measurements without one), the factor afterwards, and
    /// what the step adds to the log determinant.
    fn new(
        step: Option<&Step<D>>,
        factor: &Matrix<D>,
        present: [bool; 2],
        rate_weight: f64,
    ) -> (Self, Matrix<D>, f64) {
        // Columns: driving noise, state after the step; then z before it, value, rate.
        let mut rows = [[0.0; COLUMNS]; 10];
        if let Some(step) = step {
            for i in 0..D {
                rows[i][i] = 1.0;
                let state = step.back_row(&factor[i]);
                for j in 0..D {
                    rows[D + i][j] = -(j..D).map(|k| state[k] * step.drive[k][j]).sum::<f64>();
                    rows[D + i][D + j] = state[j];
                }
                rows[D + i][2 * D + i] = 1.0;
            }
            triangularise(&mut rows[..2 * D], 0, D);
        }
        if present[0] {
            (rows[2 * D][D], rows[2 * D][3 * D]) = (1.0, 1.0);
        }
        if present[1] {
            (rows[2 * D + 1][D + 1], rows[2 * D + 1][3 * D + 1]) = (rate_weight, 1.0);
        }
        triangularise(&mut rows[D..2 * D + 2], D, D);
        let after = std::array::from_fn(|i| std::array::from_fn(|j| rows[D + i][D + j]));
        let forward = std::array::from_fn(|i| std::array::from_fn(|j| rows[D + i][2 * D + j]));
        let none = [[0.0; D]; D];
        let mut made = Self { forward, inverse: none, gain: none, of_state: none, of_z: none };
        let mut log_determinant = 0.0;
        if let Some(step) = step {
            made.retreat(step, &rows);
            log_determinant = (0..D).map(|j| rows[j][j].abs()).product::<f64>().ln();
        }
        (made, after, log_determinant)
    }

    /// The way back, for the rows R_w w + R_ws s' = E z + e: s = F^-1 (s' - L w).
    fn retreat(&mut self, step: &Step<D>, rows: &[[f64; COLUMNS]; 10]) {
        let mut gain = step.drive;
        for row in &mut gain {
            for j in 0..D {
                let known: f64 = (0..j).map(|k| row[k] * rows[k][j]).sum();
                row[j] = (row[j] - known) / rows[j][j];
            }
        }
        for j in 0..D {
            let column: Vector<D> = std::array::from_fn(|i| gain[i][j]);
            let (gain, inverse) = (step.column(&column, false), step.column(&unit(j, 1.0), false));
            for i in 0..D {
                (self.gain[i][j], self.inverse[i][j]) = (gain[i], inverse[i]);
                (self.of_state[i][j], self.of_z[i][j]) = (rows[i][D + j], rows[i][2 * D + j]);
            }
        }
    }
}

/// Rotates all below the diagonal out of `count` columns from `first` on.
fn triangularise(rows: &mut [[f64; COLUMNS]], first: usize, count: usize) {
    for j in 0..count {
        let (top, below) = rows.split_at_mut(j + 1);
        for row in below {
            let top = &mut top[j];
            let Some((c, s, _)) = rotation(top[first + j], row[first + j]) else { continue };
            for (a, b) in top.iter_mut().zip(row.iter_mut()) {
                (*a, *b) = (c * *a + s * *b, c * *b - s * *a);
            }
            row[first + j] = 0.0;
        }
    }
}

fn same<const D: usize>(before: &Matrix<D>, after: &Matrix<D>) -> bool {
    let pairs = before.iter().flatten().zip(after.iter().flatten());
    let largest = after.iter().flatten().fold(0.0f64, |m, v| m.max(v.abs()));
    pairs.clone().all(|(a, b)| (a.abs() - b.abs()).abs() <= SAME * largest)
        && pairs.clone().all(|(a, b)| (a - b).abs() <= SAME * largest)
}

fn inverse_of_upper<const D: usize>(upper: &Matrix<D>) -> Matrix<D> {
    let mut inverse = [[0.0; D]; D];
    for j in 0..D {
        for i in (0..=j).rev() {
            let one = if i == j { 1.0 } else { 0.0 };
            let known: f64 = (i + 1..=j).map(|k| upper[i][k] * inverse[k][j]).sum();
            inverse[i][j] = (one - known) / upper[i][i];
        }
    }
    inverse
}
