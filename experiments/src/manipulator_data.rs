//! The two-link manipulator study: its settings, its data, and its errors.
//!
//! A first-order system of four states `(q1, q2, dq1, dq2)` and two torques. The paper states
//! the parameters, the regularisation and the gains; the layout of the data, the absence of
//! noise, the kernel's width and the range of the inputs are inferred from its published
//! curves. For the amplitudes the curves of g allow anything from 1 to 2; the middle is taken.

use lacuna_excitation::{SinusoidRanges, SumOfSinusoids, add_gaussian_noise, halton_cube, rng};
use lacuna_occupation::TrajectoryData;
use lacuna_plants::{InputFn, Plant, TwoLinkArm, rk4};
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use crate::StudyError;
use crate::identified::Evaluate;
use crate::statistics::OverPoints;

/// Number of trajectories.
const TRAJECTORIES: usize = 1000;
/// Side of the cube of initial states, rad and rad/s.
const SIDE: f64 = 6.0;
/// Samples of a trajectory: 1 s every 0.05 s.
const SAMPLES: usize = 21;
/// Duration of a trajectory, seconds.
const DURATION: f64 = 1.0;
/// Longest integration step, seconds: the fast friction mode (about -60/s) needs a short one.
const INTEGRATION_STEP: f64 = 0.0025;
/// Sinusoids of each torque.
const TERMS: usize = 3;
/// Greatest coefficient of a sinusoid, N m.
const AMPLITUDE: f64 = 1.5;
/// Number of evaluation points and side of their cube.
const POINTS: usize = 100;
const EVALUATION_SIDE: f64 = 4.0;

/// The trajectories of the study `seed`, with noise of standard deviation `noise` (rad and rad/s)
/// on all states; trajectory `k` draws from stream `k`, first its input, then its noise.
///
/// # Errors
/// [`StudyError`] when the plant cannot be simulated, or for a negative or infinite `noise`.
pub fn trajectories(seed: u64, noise: f64) -> Result<Vec<TrajectoryData>, StudyError> {
    let states = initial_states(TRAJECTORIES)?;
    let one =
        |(k, x0): (usize, &Vec<f64>)| trajectory(x0, SAMPLES, noise, &mut rng(seed, k as u64));
    states.par_iter().enumerate().map(one).collect()
}

/// The first `count` initial states: a Halton sequence.
///
/// # Errors
/// [`StudyError`] when no states can be laid out.
pub fn initial_states(count: usize) -> Result<Vec<Vec<f64>>, StudyError> {
    Ok(halton_cube(count, SIDE, &[0.0; 4])?)
}

/// One trajectory from `x0` with a number of samples, evenly over a second.
///
/// # Errors
/// As [`trajectories`].
pub fn trajectory(
    x0: &[f64],
    samples: usize,
    noise: f64,
    rng: &mut ChaCha8Rng,
) -> Result<TrajectoryData, StudyError> {
    let ranges = SinusoidRanges {
        amplitude: -AMPLITUDE..=AMPLITUDE,
        angular_frequency: 1.0..=3.0,
        phase: 0.0..=0.0,
    };
    let input = SumOfSinusoids::random(rng, 2, TERMS, &ranges)?;
    let step = DURATION / (samples - 1) as f64;
    let times: Vec<f64> = (0..samples).map(|k| step * k as f64).collect();
    let drive = InputFn(|t, u: &mut [f64]| input.value(t, u));
    let mut states = rk4(&TwoLinkArm::default(), x0, &drive, &times, INTEGRATION_STEP)?.states;
    add_gaussian_noise(&mut states, noise, rng)?;
    let inputs = input.sample(&times);
    Ok(TrajectoryData::new(times, states.clone(), inputs, states)?)
}

/// Evaluation points by decreasing distance from the origin.
///
/// # Errors
/// [`StudyError`] when no points can be laid out.
pub fn evaluation_points() -> Result<Vec<Vec<f64>>, StudyError> {
    let mut points = halton_cube(POINTS, EVALUATION_SIDE, &[0.0; 4])?;
    points.sort_by(|a, b| norm(b).total_cmp(&norm(a)));
    Ok(points)
}

fn norm(x: &[f64]) -> f64 {
    x.iter().map(|v| v * v).sum::<f64>().sqrt()
}

/// Relative errors `||h^(x) - h(x)|| / ||h(x)||` of the drift and of both columns of the
/// control effectiveness, at points of decreasing distance from the origin.
#[derive(Clone, Debug, PartialEq)]
pub struct Errors {
    /// Of the drift `f`.
    pub f: Vec<f64>,
    /// Of the first column of `g`.
    pub g1: Vec<f64>,
    /// Of the second column of `g`.
    pub g2: Vec<f64>,
}

impl Errors {
    /// The errors of an identified model of the arm.
    ///
    /// # Errors
    /// [`StudyError`] when no points can be laid out, or the model is of another plant.
    pub fn of(model: &dyn Evaluate) -> Result<Self, StudyError> {
        let mut errors = Self { f: Vec::new(), g1: Vec::new(), g2: Vec::new() };
        for x in evaluation_points()? {
            let (found, truth) = (identified_columns(model, &x)?, true_columns(&x));
            errors.f.push(relative(&found[0], &truth[0]));
            errors.g1.push(relative(&found[1], &truth[1]));
            errors.g2.push(relative(&found[2], &truth[2]));
        }
        Ok(errors)
    }

    /// Greatest, median and mean errors.
    pub fn summary(&self) -> Summary {
        let [f, g1, g2] = [&self.f, &self.g1, &self.g2].map(|e| OverPoints::of(e));
        Summary { f, g1, g2 }
    }
}

fn true_columns(x: &[f64]) -> [[f64; 4]; 3] {
    let arm = TwoLinkArm::default();
    let (mut f, mut g) = ([0.0; 4], [0.0; 8]);
    arm.drift(x, &mut f);
    arm.control_effectiveness(x, &mut g);
    split(f, &g)
}

fn identified_columns(model: &dyn Evaluate, x: &[f64]) -> Result<[[f64; 4]; 3], StudyError> {
    let (mut f, mut g) = ([0.0; 4], [0.0; 8]);
    model.evaluate(x, &mut f, &mut g)?;
    Ok(split(f, &g))
}

/// The columns `f`, `g1`, `g2`.
fn split(f: [f64; 4], g: &[f64; 8]) -> [[f64; 4]; 3] {
    [f, std::array::from_fn(|i| g[2 * i]), std::array::from_fn(|i| g[2 * i + 1])]
}

fn relative(found: &[f64; 4], truth: &[f64; 4]) -> f64 {
    let difference: [f64; 4] = std::array::from_fn(|i| found[i] - truth[i]);
    norm(&difference) / norm(truth)
}

/// Relative errors over the evaluation points.
#[derive(Clone, Copy, Debug, Deserialize, PartialEq, Serialize)]
pub struct Summary {
    /// Of the drift.
    pub f: OverPoints,
    /// Of the first column of the control effectiveness.
    pub g1: OverPoints,
    /// Of its second column.
    pub g2: OverPoints,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn points_come_by_decreasing_distance() {
        let points = evaluation_points().unwrap();
        assert_eq!(points.len(), 100);
        assert_eq!(points[0], [-2.0; 4]);
        assert!(points.windows(2).all(|p| norm(&p[0]) >= norm(&p[1])));
    }

    #[test]
    fn the_error_of_a_scaled_vector_is_the_scale() {
        let truth = [3.0, 0.0, -4.0, 1.0];
        assert!((relative(&truth.map(|v| 1.25 * v), &truth) - 0.25).abs() < 1e-12);
    }

    #[test]
    fn trajectories_start_at_halton_points_and_repeat() {
        let data = trajectories(5, 0.0).unwrap();
        assert_eq!(data.len(), 1000);
        assert_eq!(data[0].coordinates()[..4], [-3.0; 4]);
        assert!(data.iter().all(|d| d.samples() == 21 && d.inputs()[..2] == [0.0; 2]));
        let threads = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
        assert_eq!(threads.install(|| trajectories(5, 0.0)).unwrap(), data);
    }

    #[test]
    fn noise_is_on_all_states_and_leaves_the_inputs() {
        let (plain, noisy) = (trajectories(5, 0.0).unwrap(), trajectories(5, 0.01).unwrap());
        let mut squares = [0.0; 4];
        for (a, b) in plain.iter().zip(&noisy) {
            assert_eq!(a.inputs(), b.inputs());
            let differences = a.coordinates().iter().zip(b.coordinates()).map(|(a, b)| b - a);
            differences.enumerate().for_each(|(k, e)| squares[k % 4] += e * e);
        }
        // The standard error of each sum is its mean times sqrt(2 / 21000) = 0.98 %.
        assert!(squares.iter().all(|s| (s / 21_000.0 / 1e-4 - 1.0).abs() < 0.05), "{squares:?}");
    }
}
