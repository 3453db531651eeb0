//! Integration of a plant along an input: fixed-step Runge-Kutta of order 4.

use crate::input::StepInput;
use crate::substeps::Place;
use crate::{Hold, Input, Plant};
use thiserror::Error;

/// States of a plant at requested times.
#[derive(Clone, Debug, Default)]
pub struct Trajectory {
    /// The requested times.
    pub times: Vec<f64>,
    /// States, row-major `times.len() x states`.
    pub states: Vec<f64>,
    /// Length of one state.
    pub width: usize,
}

impl Trajectory {
    /// State at sample `k`.
    pub fn state(&self, k: usize) -> &[f64] {
        &self.states[k * self.width..(k + 1) * self.width]
    }
}

/// Why a simulation could not be finished.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum SimulationError {
    /// The state left the range of finite numbers.
    #[error("the simulation diverged: state {state} is no longer finite at t = {time} s")]
    Diverged {
        /// Time of the first state that is not finite.
        time: f64,
        /// Index of the offending entry of the state.
        state: usize,
    },
    /// Requested times must increase.
    #[error("simulation times must increase: {next} s follows {time} s")]
    TimesNotIncreasing {
        /// A requested time.
        time: f64,
        /// The time requested after it.
        next: f64,
    },
    /// The initial state has the wrong length.
    #[error("the initial state has {found} entries, the plant has {expected}")]
    WrongState {
        /// The plant's state length.
        expected: usize,
        /// Length of what was given.
        found: usize,
    },
}

/// Integrate from `x0` at `times[0]` with RK4 steps no longer than `max_step` and return the
/// states at `times`. Steps end at the input's breakpoints, so a held input is exact.
///
/// # Errors
/// [`SimulationError`] when the state diverges, or times or `x0` do not fit.
pub fn rk4(
    plant: &dyn Plant,
    x0: &[f64],
    input: &dyn Input,
    times: &[f64],
    max_step: f64,
) -> Result<Trajectory, SimulationError> {
    let width = plant.states();
    check(x0, width, times)?;
    let mut stepper = Stepper::new(width, plant.inputs());
    let mut x = x0.to_vec();
    let mut states = Vec::with_capacity(times.len() * width);
    states.extend_from_slice(&x);
    for pair in times.windows(2) {
        for (a, b) in segments(pair[0], pair[1], input.breakpoints()) {
            let steps = ((b - a) / max_step * (1.0 - 1e-12)).ceil().max(1.0) as usize;
            let h = (b - a) / steps as f64;
            for k in 0..steps {
                stepper.step(plant, input, a + k as f64 * h, h, &mut x);
            }
        }
        if let Some(state) = x.iter().position(|v| !v.is_finite()) {
            return Err(SimulationError::Diverged { time: pair[1], state });
        }
        states.extend_from_slice(&x);
    }
    Ok(Trajectory { times: times.to_vec(), states, width })
}

/// Integrate along a sampled input from sample to sample with `substeps` RK4 steps each, and
/// return the states at the samples. The same as [`rk4`] with a [`crate::SampledInput`] whose times
/// are the requested ones, without searching for the sample at every stage: for hot loops.
///
/// `inputs` is row-major `times.len() x m`.
///
/// # Errors
/// [`SimulationError`] when the state diverges, or times or `x0` do not fit.
pub fn rk4_sampled(
    plant: &dyn Plant,
    x0: &[f64],
    times: &[f64],
    inputs: &[f64],
    hold: Hold,
    substeps: usize,
) -> Result<Trajectory, SimulationError> {
    let (width, m) = (plant.states(), plant.inputs());
    check(x0, width, times)?;
    let mut stepper = Stepper::new(width, m);
    let mut x = x0.to_vec();
    let mut states = Vec::with_capacity(times.len() * width);
    states.extend_from_slice(&x);
    let path = hold.along((times, inputs), 0..times.len(), m, substeps);
    for (k, pair) in times.windows(2).enumerate() {
        let input = Between { times: (pair[0], pair[1]), parts: 2 * substeps, input: path.step(k) };
        let h = (pair[1] - pair[0]) / substeps as f64;
        for s in 0..substeps {
            stepper.step(plant, &input, pair[0] + s as f64 * h, h, &mut x);
        }
        if let Some(state) = x.iter().position(|v| !v.is_finite()) {
            return Err(SimulationError::Diverged { time: pair[1], state });
        }
        states.extend_from_slice(&x);
    }
    Ok(Trajectory { times: times.to_vec(), states, width })
}

/// The input between two samples, where the stages of Runge-Kutta steps are.
struct Between<'a> {
    times: (f64, f64),
    parts: usize,
    input: StepInput<'a, f64>,
}

impl Input for Between<'_> {
    fn value(&self, _start: f64, t: f64, u: &mut [f64]) {
        let share = (t - self.times.0) / (self.times.1 - self.times.0);
        let part = (share * self.parts as f64).round() as usize;
        self.input.at(Place::of(part, self.parts), u);
    }
}

fn check(x0: &[f64], width: usize, times: &[f64]) -> Result<(), SimulationError> {
    if x0.len() != width {
        return Err(SimulationError::WrongState { expected: width, found: x0.len() });
    }
    match times.windows(2).find(|p| p[1].partial_cmp(&p[0]) != Some(std::cmp::Ordering::Greater)) {
        Some(p) => Err(SimulationError::TimesNotIncreasing { time: p[0], next: p[1] }),
        None => Ok(()),
    }
}

/// The interval `[from, to]` cut at the breakpoints inside it.
fn segments(from: f64, to: f64, breakpoints: &[f64]) -> impl Iterator<Item = (f64, f64)> + '_ {
    let slack = 1e-9 * (1.0 + to.abs());
    let first = breakpoints.partition_point(|&b| b <= from + slack);
    let last = breakpoints.partition_point(|&b| b < to - slack).max(first);
    let cuts = &breakpoints[first..last];
    let starts = std::iter::once(from).chain(cuts.iter().copied());
    let ends = cuts.iter().copied().chain(std::iter::once(to));
    starts.zip(ends)
}

/// One RK4 step and the room it needs.
struct Stepper {
    slope: [Vec<f64>; 4],
    stage: Vec<f64>,
    u: Vec<f64>,
}

impl Stepper {
    fn new(states: usize, inputs: usize) -> Self {
        let zero = || vec![0.0; states];
        Self { slope: [zero(), zero(), zero(), zero()], stage: zero(), u: vec![0.0; inputs] }
    }

    fn step(&mut self, plant: &dyn Plant, input: &dyn Input, t: f64, h: f64, x: &mut [f64]) {
        let [k1, k2, k3, k4] = &mut self.slope;
        let (stage, u) = (&mut self.stage, &mut self.u);
        input.value(t, t, u);
        plant.derivative(t, x, u, k1);
        input.value(t, t + 0.5 * h, u);
        shift(x, k1, 0.5 * h, stage);
        plant.derivative(t + 0.5 * h, stage, u, k2);
        shift(x, k2, 0.5 * h, stage);
        plant.derivative(t + 0.5 * h, stage, u, k3);
        input.value(t, t + h, u);
        shift(x, k3, h, stage);
        plant.derivative(t + h, stage, u, k4);
        for i in 0..x.len() {
            x[i] += h / 6.0 * (k1[i] + 2.0 * k2[i] + 2.0 * k3[i] + k4[i]);
        }
    }
}

/// `stage = x + h * slope`.
fn shift(x: &[f64], slope: &[f64], h: f64, stage: &mut [f64]) {
    for ((s, x), k) in stage.iter_mut().zip(x).zip(slope) {
        *s = x + h * k;
    }
}

#[cfg(test)]
mod tests {
    use super::{rk4, rk4_sampled};
    use crate::{Duffing, Hold, SampledInput};

    #[test]
    fn the_hot_loop_agrees_with_the_general_one() {
        let times: Vec<f64> =
            (0..60).map(|k| 0.02 * f64::from(k) + 0.003 * f64::from(k % 3)).collect();
        let values: Vec<f64> = times.iter().map(|t| (5.0 * t).sin()).collect();
        for hold in [Hold::ZeroOrder, Hold::Linear, Hold::BandLimited] {
            let input = SampledInput { times: &times, values: &values, hold };
            let plant = Duffing::default();
            let general = rk4(&plant, &[0.3, -1.0], &input, &times, 1.0).expect("finite");
            let hot = rk4_sampled(&plant, &[0.3, -1.0], &times, &values, hold, 1).expect("finite");
            for (a, b) in general.states.iter().zip(&hot.states) {
                assert!((a - b).abs() < 1e-13, "{a} {b}");
            }
        }
    }
}
