//! How far a model is off: its prediction over short windows against the truth, in units of the
//! noise.
//!
//! Each window starts from the state that fits it best (linearised), as a diagnosis would choose
//! it. The *calibrated* gap is what is left when the parameters, too, are moved to their best
//! values with the tolerance of the model file as a Gaussian prior: an effect whose calibrated gap is
//! nothing can be told from a wrong parameter by nobody.

use lacuna_plants::model::{Equations, ModelEffect};
use lacuna_plants::{Hold, Model, System, rk4_sampled};
use nalgebra::{DMatrix, DVector};

use super::sensor::Sensor;
use super::truth::Motion;
use crate::StudyError;

/// Windows of a recording.
pub const WINDOWS: usize = 12;
/// Samples of a window that are compared, about.
const COMPARED: usize = 40;
/// Runge-Kutta steps a sample.
const SUBSTEPS: usize = 2;
/// Share of a tolerance by which a parameter is moved to see what it does.
const NUDGE: f64 = 0.02;
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

/// Gaps by output, in noise standard deviations (root mean square over all windows).
#[derive(Clone, Debug, PartialEq)]
pub struct Gap {
    /// With the parameters as they are.
    pub raw: Vec<f64>,
    /// With the parameters at their best.
    pub calibrated: Vec<f64>,
    /// With the parameters at their best whatever their tolerance.
    pub free: Vec<f64>,
    /// Half the squared misfit over all samples (nats) at the best parameters.
    pub nats: f64,
    /// What is left at the best amplitude of each rival.
    pub rivals: Vec<Left>,
}

/// What a rival leaves at its best, linearised.
#[derive(Clone, Debug, PartialEq)]
pub struct Left {
    /// Half the squared misfit (nats), parameters moved as well.
    pub nats: f64,
    /// The rival's amplitude.
    pub amplitude: f64,
    /// How far the uncertain parameters move, in their tolerances.
    pub parameters: Vec<f64>,
}

/// The greatest of some gaps.
pub fn greatest(gaps: &[f64]) -> f64 {
    gaps.iter().copied().fold(0.0, f64::max)
}

/// Something that might explain the truth as well.
#[derive(Clone, Debug)]
pub enum Rival {
    /// An effect of the catalogue of small amplitude, on force channels or inputs.
    Effect(ModelEffect),
    /// A sensor that is slightly wrong on an output.
    Sensor(usize, Sensor),
}

/// A model that is moved a little, and by how much.
struct Variant {
    system: System,
    inputs: Vec<Vec<f64>>,
    sensor: Option<(usize, Sensor)>,
    nudge: f64,
}

/// A motion, and what undisturbed sensors show of it: a series an output.
pub type Shown<'a> = (&'a Motion, Vec<Vec<f64>>);

/// The gap between a model and motions of the truth; the motions have the same times.
///
/// # Errors
/// [`StudyError::Simulation`] where the model diverges within a window.
pub fn gap(
    believed: &Model,
    shown: &[Shown],
    outputs: &[Output],
    rivals: &[Rival],
) -> Result<Gap, StudyError> {
    let parameters = believed.parameters.iter().filter(|p| p.tolerance > 0.0).count();
    let variants = variants(believed, shown, rivals);
    let mut parts = Vec::new();
    for (r, (motion, seen)) in shown.iter().enumerate() {
        let length = motion.times.len() / WINDOWS;
        for w in 0..WINDOWS {
            let window = Window { r, motion, seen, begin: w * length, length, outputs };
            parts.push(window.linearised(&variants)?);
        }
    }
    let stride = stride(shown[0].0.times.len() / WINDOWS) as f64;
    let all: Vec<usize> = (0..parameters).collect();
    let (best, nats) = solve(&parts, &all, parameters, stride);
    let (free, _) = solve(&parts, &all, 0, stride);
    let left = |at: &DVector<f64>| {
        let misfits = parts.iter().map(|p| &p.misfit - p.columns.columns(0, parameters) * at);
        by_output(misfits, outputs.len())
    };
    let rivals = (0..rivals.len()).map(|k| {
        let columns: Vec<usize> = (0..parameters).chain([parameters + k]).collect();
        let (best, nats) = solve(&parts, &columns, parameters, stride);
        let at = best.as_slice();
        Left { nats, amplitude: at[parameters], parameters: at[..parameters].to_vec() }
    });
    Ok(Gap {
        raw: by_output(parts.iter().map(|p| p.misfit.clone()), outputs.len()),
        calibrated: left(&best),
        free: left(&free),
        nats,
        rivals: rivals.collect(),
    })
}

fn stride(length: usize) -> usize {
    (length / COMPARED).max(1)
}

/// The model itself, then each uncertain parameter and each rival moved a little.
fn variants(believed: &Model, shown: &[Shown], rivals: &[Rival]) -> Vec<Variant> {
    let equations = Equations::of(believed);
    let values = believed.values();
    let inputs = |effects: &[ModelEffect]| -> Vec<Vec<f64>> {
        let mut model = believed.clone();
        model.effects = effects.to_vec();
        shown.iter().map(|(m, _)| model.effective_inputs(&m.times, &m.commands)).collect()
    };
    let variant = |values: &[f64], effects: &[ModelEffect], sensor, nudge| Variant {
        system: System::with(believed, &equations, values, effects),
        inputs: inputs(effects),
        sensor,
        nudge,
    };
    let mut variants = vec![variant(&values, &believed.effects, None, 1.0)];
    for (k, p) in believed.parameters.iter().enumerate().filter(|(_, p)| p.tolerance > 0.0) {
        let mut moved = values.clone();
        moved[k] += NUDGE * p.std();
        variants.push(variant(&moved, &believed.effects, None, NUDGE));
    }
    for rival in rivals {
        variants.push(match rival {
            Rival::Effect(effect) => {
                let effects = [&believed.effects[..], std::slice::from_ref(effect)].concat();
                variant(&values, &effects, None, 1.0)
            }
            Rival::Sensor(k, sensor) => {
                variant(&values, &believed.effects, Some((*k, *sensor)), 1.0)
            }
        });
    }
    variants
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

/// A series through a sensor that is slightly wrong; a delay to first order.
fn distorted(series: &[f64], times: &[f64], sensor: Sensor) -> Vec<f64> {
    let last = series.len() - 1;
    let slope = |k: usize| {
        let (a, b) = (k.saturating_sub(1), (k + 1).min(last));
        (series[b] - series[a]) / (times[b] - times[a])
    };
    let one = |(k, x): (usize, &f64)| match sensor {
        Sensor::Scale(scale) => scale * x,
        Sensor::Bias(bias) => x + bias,
        Sensor::Delay(delay) => x - delay * slope(k),
    };
    series.iter().enumerate().map(one).collect()
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

/// Best coefficients of some columns, those of parameters (the first ones) under a unit Gaussian
/// prior, and half the penalised squared misfit that remains.
fn solve(parts: &[Part], columns: &[usize], parameters: usize, weight: f64) -> (DVector<f64>, f64) {
    let n = columns.len();
    let (mut gram, mut moments) = (DMatrix::zeros(n, n), DVector::zeros(n));
    let mut squares = 0.0;
    for part in parts {
        let chosen = part.columns.select_columns(columns);
        gram.gemm_tr(weight, &chosen, &chosen, 1.0);
        moments.gemv_tr(weight, &chosen, &part.misfit, 1.0);
        squares += weight * part.misfit.norm_squared();
    }
    for (a, &column) in columns.iter().enumerate() {
        // A rival that does nothing must not make the system singular.
        gram[(a, a)] += if column < parameters { 1.0 } else { 1e-12 * (1.0 + gram[(a, a)]) };
    }
    match gram.cholesky() {
        Some(factor) => {
            let best = factor.solve(&moments);
            let left = squares - best.dot(&moments);
            (best, 0.5 * left.max(0.0))
        }
        None => (DVector::zeros(n), 0.5 * squares),
    }
}

/// Root mean squares by output of vectors that hold the outputs one after the other.
fn by_output(misfits: impl Iterator<Item = DVector<f64>>, outputs: usize) -> Vec<f64> {
    let (mut sums, mut count) = (vec![0.0; outputs], 0);
    for misfit in misfits {
        let rows = misfit.len() / outputs;
        count += rows;
        for (k, sum) in sums.iter_mut().enumerate() {
            *sum += misfit.rows(k * rows, rows).norm_squared();
        }
    }
    sums.iter().map(|s| (s / count.max(1) as f64).sqrt()).collect()
}
