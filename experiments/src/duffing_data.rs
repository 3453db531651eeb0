//! The Duffing study: its settings, its data, and its errors.
//!
//! `x'' = (x - x^3) + (2 + sin x) u`, identified as a second-order system in `x` alone.
//! Settings are the paper's where it states them; the sample step and the duration are
//! inferred from its published curves.

use lacuna_excitation::{Axis, SinusoidRanges, SumOfSinusoids, add_gaussian_noise, grid, rng};
use lacuna_occupation::TrajectoryData;
use lacuna_plants::{Duffing, InputFn, rk4};
use rand_chacha::ChaCha8Rng;
use serde::{Deserialize, Serialize};

use crate::StudyError;
use crate::identified::Evaluate;

/// Half width of the region of initial states and of evaluation.
const BOUND: f64 = 3.0;
/// Initial positions and initial velocities: 13 x 13 = 169 trajectories.
const STATES_PER_AXIS: usize = 13;
/// Number of samples of a trajectory: 1 s every 0.02 s.
const SAMPLES: usize = 51;
/// Sample step, seconds.
const STEP: f64 = 0.02;
/// Longest integration step, seconds; the error it makes is far below the noise.
const INTEGRATION_STEP: f64 = 0.005;
/// Sinusoids of an input.
const TERMS: usize = 3;
/// Standard deviation of the noise on the position in the paper.
pub const NOISE: f64 = 0.001;
/// Points at which the errors are evaluated.
const POINTS: usize = 61;

/// The trajectories of trial number `trial` of the study `seed`: true inputs, and positions with
/// noise of standard deviation `noise`.
///
/// The same trial has the same inputs, and the same noise but for its size, whatever `noise` is.
///
/// # Errors
/// [`StudyError`] when the plant cannot be simulated, or for a negative or infinite `noise`.
pub fn trajectories(seed: u64, trial: u64, noise: f64) -> Result<Vec<TrajectoryData>, StudyError> {
    let mut rng = rng(seed, trial);
    let axis = Axis { from: -BOUND, to: BOUND, count: STATES_PER_AXIS };
    let states = grid(&[axis, axis])?;
    states.iter().map(|x0| trajectory(x0, noise, &mut rng)).collect()
}

fn trajectory(x0: &[f64], noise: f64, rng: &mut ChaCha8Rng) -> Result<TrajectoryData, StudyError> {
    let ranges =
        SinusoidRanges { amplitude: -1.0..=1.0, angular_frequency: 1.0..=3.0, phase: 0.0..=0.0 };
    let input = SumOfSinusoids::random(rng, 1, TERMS, &ranges)?;
    let times: Vec<f64> = (0..SAMPLES).map(|k| STEP * k as f64).collect();
    // The integration asks at the ends and middles of its steps alone.
    let half = 0.5 * INTEGRATION_STEP;
    let every = (STEP / half).round() as usize;
    let values = input.sample_evenly(half, every * (SAMPLES - 1) + 1);
    let drive = InputFn(|t, u: &mut [f64]| u[0] = values[(t / half + 0.5) as usize]);
    let path = rk4(&Duffing::default(), x0, &drive, &times, INTEGRATION_STEP)?;
    let mut positions: Vec<f64> = path.states.chunks_exact(2).map(|state| state[0]).collect();
    add_gaussian_noise(&mut positions, noise, rng)?;
    let inputs = values.into_iter().step_by(every).collect();
    Ok(TrajectoryData::new(times, positions.clone(), inputs, positions)?)
}

/// Points `x` at which the identified functions are compared with the true ones.
pub fn evaluation_points() -> Vec<f64> {
    Axis { from: -BOUND, to: BOUND, count: POINTS }.values()
}

/// Absolute errors of the identified drift and control effectiveness at the evaluation points.
#[derive(Clone, Debug, PartialEq)]
pub struct Errors {
    /// `|f - f^|` at each point.
    pub f: Vec<f64>,
    /// `|g - g^|` at each point.
    pub g: Vec<f64>,
    /// Standard deviations of f and of g at each point, from recipes that know them.
    pub deviations: Option<[Vec<f64>; 2]>,
}

impl Errors {
    /// The errors of an identified model of the Duffing oscillator.
    ///
    /// # Errors
    /// [`StudyError::Evaluation`] for a model of another plant.
    pub fn of(model: &dyn Evaluate) -> Result<Self, StudyError> {
        let plant = Duffing::default();
        let mut errors = Self { f: Vec::new(), g: Vec::new(), deviations: None };
        for x in evaluation_points() {
            let [f, g] = values(model, x)?;
            errors.f.push((f - plant.f(x)).abs());
            errors.g.push((g - plant.g(x)).abs());
            if let Some(sd) = model.standard_deviations(&[x])? {
                let [f, g] = errors.deviations.get_or_insert_default();
                f.push(sd.f[0]);
                g.push(sd.g[0]);
            }
        }
        Ok(errors)
    }

    /// Greatest and mean errors.
    pub fn summary(&self) -> TrialErrors {
        let max = |values: &[f64]| values.iter().copied().fold(f64::NAN, f64::max);
        let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len() as f64;
        let covered = |errors: &[f64], deviations: &[f64]| {
            let within = errors.iter().zip(deviations).filter(|(e, sd)| **e <= 2.0 * **sd).count();
            within as f64 / errors.len() as f64
        };
        let coverage =
            self.deviations.as_ref().map(|[f, g]| [covered(&self.f, f), covered(&self.g, g)]);
        TrialErrors {
            coverage,
            max_f: max(&self.f),
            max_g: max(&self.g),
            mean_f: mean(&self.f),
            mean_g: mean(&self.g),
        }
    }
}

/// `[f^(x), g^(x)]` of an identified model.
///
/// # Errors
/// [`StudyError::Evaluation`] for a model of another plant.
pub fn values(model: &dyn Evaluate, x: f64) -> Result<[f64; 2], StudyError> {
    let (mut f, mut g) = ([0.0], [0.0]);
    model.evaluate(&[x], &mut f, &mut g)?;
    Ok([f[0], g[0]])
}

/// Errors of one trial over the evaluation points.
#[derive(Clone, Copy, Debug, Deserialize, PartialEq, Serialize)]
pub struct TrialErrors {
    /// Greatest `|f - f^|`.
    pub max_f: f64,
    /// Greatest `|g - g^|`.
    pub max_g: f64,
    /// Mean `|f - f^|`.
    pub mean_f: f64,
    /// Mean `|g - g^|`.
    pub mean_g: f64,
    /// Share of the points at which f and g are within two of their standard deviations.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub coverage: Option<[f64; 2]>,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_trial_has_the_papers_layout() {
        let data = trajectories(1, 0, NOISE).unwrap();
        assert_eq!(data.len(), 169);
        assert!(data.iter().all(|d| d.samples() == 51 && d.input_count() == 1));
        assert!((data[0].times()[50] - 1.0).abs() < 1e-12);
        // The first position differs from the grid by the noise alone, the first input is 0.
        let noise: Vec<f64> = data
            .iter()
            .zip(0..)
            .map(|(d, k)| d.coordinates()[0] + 3.0 - 0.5 * f64::from(k / 13))
            .collect();
        assert!(noise.iter().all(|e| e.abs() < 5.0 * NOISE && *e != 0.0));
        assert!(data.iter().all(|d| d.inputs()[0] == 0.0));
    }

    #[test]
    fn trials_and_seeds_differ_and_repeat() {
        let draw = |seed, trial| trajectories(seed, trial, NOISE).unwrap();
        assert_eq!(draw(1, 3), draw(1, 3));
        assert_ne!(draw(1, 3), draw(1, 4));
        assert_ne!(draw(1, 3), draw(2, 3));
    }

    #[test]
    fn noise_scales_and_nothing_else_changes() {
        let [none, small, large] =
            [0.0, 0.01, 0.02].map(|noise| trajectories(1, 3, noise).unwrap());
        for ((a, b), c) in none.iter().zip(&small).zip(&large) {
            assert!(a.inputs() == b.inputs() && b.inputs() == c.inputs());
            let samples = a.coordinates().iter().zip(b.coordinates()).zip(c.coordinates());
            assert!(samples.map(|((a, b), c)| c - a - 2.0 * (b - a)).all(|e| e.abs() < 1e-12));
        }
        assert!(matches!(trajectories(1, 3, -1.0), Err(StudyError::Noise(_))));
    }
}
