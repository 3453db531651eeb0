//! Predictions over short windows, linearised in initial states, parameters and rivals.
//!
//! ```text
//! (y - y^(x0, p, a)) / sigma  ~  d - X dx0 - P dp - R a        each window
//! ```
//!
//! The initial states of the windows are eliminated at once by an orthonormal basis of X.

use lacuna_plants::{Hold, Model, rk4_sampled};
use nalgebra::{DMatrix, DVector};

use super::truth::Motion;
use super::variants::{Rival, Variant, distorted, variants};
use crate::StudyError;

/// Windows of a recording.
pub const WINDOWS: usize = 12;
/// Samples of a window that are compared, about.
const COMPARED: usize = 40;
/// Runge-Kutta steps a sample.
const SUBSTEPS: usize = 2;
/// Share of a direction that must be left of it to count as another direction.
const INDEPENDENT: f64 = 1e-6;

/// One measured entry of the machine's state: which, and the deviation of its noise.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Output {
    /// Entry of the machine's state.
    pub entry: usize,
    /// Standard deviation of what is added to it.
    pub sd: f64,
}

/// A motion, and what undisturbed sensors show of it: a series an output.
pub type Shown<'a> = (&'a Motion, Vec<Vec<f64>>);

/// Windows of some motions, linearised about a model.
pub struct Windows {
    parts: Vec<Part>,
    parameters: usize,
    outputs: usize,
    /// Samples that each compared one stands for.
    weight: f64,
}

/// Best coefficients, and what they leave.
#[derive(Clone, Debug, PartialEq)]
pub struct Best {
    /// How far the uncertain parameters move, in their tolerances; the rival's amplitude last.
    pub at: Vec<f64>,
    /// Half the squared misfit over all samples, that of the prior included (nats).
    pub nats: f64,
}

impl Windows {
    /// Linearise about a model; the motions have the same times.
    ///
    /// # Errors
    /// [`StudyError::Simulation`] where the model diverges within a window.
    pub fn linearised(
        believed: &Model,
        shown: &[Shown],
        outputs: &[Output],
        rivals: &[Rival],
    ) -> Result<Self, StudyError> {
        let variants = variants(believed, shown, rivals);
        let length = shown[0].0.times.len() / WINDOWS;
        let mut parts = Vec::new();
        for (r, (motion, seen)) in shown.iter().enumerate() {
            for w in 0..WINDOWS {
                let window = Window { r, motion, seen, begin: w * length, length, outputs };
                parts.push(window.linearised(&variants)?);
            }
        }
        let parameters = believed.parameters.iter().filter(|p| p.std() > 0.0).count();
        Ok(Self { parts, parameters, outputs: outputs.len(), weight: stride(length) as f64 })
    }

    /// Best parameters, and amplitude of a rival if one is given. The prior of the parameters is
    /// Gaussian with their tolerances, centred `offset` tolerances below where they are; without an
    /// offset there is no prior.
    pub fn best(&self, rival: Option<usize>, offset: Option<&[f64]>) -> Best {
        let p = self.parameters;
        let columns: Vec<usize> = (0..p).chain(rival.map(|k| p + k)).collect();
        let n = columns.len();
        let (mut gram, mut moments) = (DMatrix::zeros(n, n), DVector::zeros(n));
        let mut squares = 0.0;
        for part in &self.parts {
            let chosen = part.columns.select_columns(&columns);
            gram.gemm_tr(self.weight, &chosen, &chosen, 1.0);
            moments.gemv_tr(self.weight, &chosen, &part.misfit, 1.0);
            squares += self.weight * part.misfit.norm_squared();
        }
        for (a, offset) in offset.unwrap_or_default().iter().enumerate() {
            gram[(a, a)] += 1.0;
            moments[a] -= offset;
            squares += offset * offset;
        }
        // Directions that do nothing must not make the system singular.
        (0..n).for_each(|a| gram[(a, a)] += 1e-12 * (1.0 + gram[(a, a)]));
        let best = gram.cholesky().map(|f| f.solve(&moments));
        let best = best.unwrap_or_else(|| DVector::zeros(n));
        let nats = 0.5 * (squares - best.dot(&moments)).max(0.0);
        Best { at: best.as_slice().to_vec(), nats }
    }

    /// Root mean square misfit by output, in noise standard deviations, with the parameters moved.
    pub fn misfit(&self, at: &[f64]) -> Vec<f64> {
        let at = DVector::from_column_slice(&at[..self.parameters]);
        let (mut sums, mut count) = (vec![0.0; self.outputs], 0);
        for part in &self.parts {
            let left = &part.misfit - part.columns.columns(0, self.parameters) * &at;
            let rows = left.len() / self.outputs;
            count += rows;
            for (k, sum) in sums.iter_mut().enumerate() {
                *sum += left.rows(k * rows, rows).norm_squared();
            }
        }
        sums.iter().map(|s| (s / count.max(1) as f64).sqrt()).collect()
    }

    /// Number of uncertain parameters.
    pub fn parameters(&self) -> usize {
        self.parameters
    }
}

fn stride(length: usize) -> usize {
    (length / COMPARED).max(1)
}

struct Window<'a> {
    r: usize,
    motion: &'a Motion,
    seen: &'a [Vec<f64>],
    begin: usize,
    length: usize,
    outputs: &'a [Output],
}

/// A window's misfit and what each variant does to its prediction, both in noise units and with
/// all that another initial state could do taken out.
struct Part {
    misfit: DVector<f64>,
    columns: DMatrix<f64>,
}

impl Window<'_> {
    fn linearised(&self, variants: &[Variant]) -> Result<Part, StudyError> {
        let start = self.motion.state(self.begin).to_vec();
        let base = self.predict(&variants[0], &start)?;
        let mut columns = Vec::new();
        for variant in &variants[1..] {
            columns.push((self.predict(variant, &start)? - &base) / variant.nudge);
        }
        let mut misfit = self.truth() - &base;
        let mut basis: Vec<DVector<f64>> = Vec::new();
        for i in 0..start.len() {
            let mut moved = start.clone();
            // A step well within the noise of one output, whatever the unit.
            let step = 1e-4 * (1e-3 + self.size(i));
            moved[i] += step;
            let mut direction = (self.predict(&variants[0], &moved)? - &base) / step;
            let before = direction.norm();
            project(&basis, &mut direction);
            if direction.norm() > INDEPENDENT * before {
                basis.push(direction.normalize());
            }
        }
        project(&basis, &mut misfit);
        columns.iter_mut().for_each(|c| project(&basis, c));
        let columns = match columns.is_empty() {
            true => DMatrix::zeros(misfit.len(), 0),
            false => DMatrix::from_columns(&columns),
        };
        Ok(Part { misfit, columns })
    }

    /// Greatest absolute value of an entry of the state within the window.
    fn size(&self, entry: usize) -> f64 {
        (self.begin..self.begin + self.length)
            .fold(0.0, |a: f64, k| a.max(self.motion.state(k)[entry].abs()))
    }

    fn rows(&self) -> impl Iterator<Item = usize> {
        (0..self.length).step_by(stride(self.length))
    }

    /// What the sensors show, in noise units: all rows of the first output, then of the next.
    fn truth(&self) -> DVector<f64> {
        let value = |k: usize, row: usize| self.seen[k][self.begin + row] / self.outputs[k].sd;
        let values: Vec<f64> =
            (0..self.outputs.len()).flat_map(|k| self.rows().map(move |r| value(k, r))).collect();
        DVector::from_vec(values)
    }

    fn predict(&self, variant: &Variant, start: &[f64]) -> Result<DVector<f64>, StudyError> {
        let end = self.begin + self.length;
        let m = variant.inputs[self.r].len() / self.motion.times.len();
        let path = rk4_sampled(
            &variant.system,
            &variant.system.at_rest(start),
            &self.motion.times[self.begin..end],
            &variant.inputs[self.r][self.begin * m..end * m],
            Hold::ZeroOrder,
            SUBSTEPS,
        )?;
        let mut values = Vec::new();
        for (k, output) in self.outputs.iter().enumerate() {
            let series: Vec<f64> = (0..self.length).map(|r| path.state(r)[output.entry]).collect();
            let series = match variant.sensor {
                Some((on, sensor)) if on == k => distorted(&series, &path.times, sensor),
                _ => series,
            };
            values.extend(self.rows().map(|r| series[r] / output.sd));
        }
        Ok(DVector::from_vec(values))
    }
}

/// Take the directions of an orthonormal basis out of a vector; twice, against rounding.
fn project(basis: &[DVector<f64>], vector: &mut DVector<f64>) {
    for _ in 0..2 {
        for direction in basis {
            let share = direction.dot(vector);
            vector.axpy(-share, direction, 1.0);
        }
    }
}
