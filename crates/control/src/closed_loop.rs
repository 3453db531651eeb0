//! A plant driven by a computed-torque law.

use crate::{ComputedTorque, ControlError};
use lacuna_plants::{InputFn, Plant, SimulationError, Trajectory, rk4};
use std::sync::OnceLock;

/// When the control law is evaluated.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Timing {
    /// At every stage of the integration: a continuous state feedback.
    Continuous,
    /// Once a period (seconds), the input being held in between, as a digital controller does.
    Held {
        /// Sampling period, seconds.
        period: f64,
    },
}

/// What a closed loop did.
#[derive(Clone, Debug)]
pub struct ClosedLoop {
    /// States of the plant at the requested times.
    pub trajectory: Trajectory,
    /// Inputs at the requested times, row-major `times.len() x m`: those that the law gives
    /// there (continuous) or that are being applied from there on (held).
    pub inputs: Vec<f64>,
}

/// Simulate `plant` under `law` from `x0` at `times[0]`, by RK4 steps no longer than `max_step`.
///
/// The first `2p` states of the plant are taken for positions and velocities.
///
/// # Errors
/// [`ControlError`] when law and plant do not fit, the law fails on the way, or the plant
/// diverges.
pub fn closed_loop(
    plant: &dyn Plant,
    law: &ComputedTorque<'_>,
    x0: &[f64],
    times: &[f64],
    max_step: f64,
    timing: Timing,
) -> Result<ClosedLoop, ControlError> {
    fits(plant, law)?;
    match timing {
        Timing::Continuous => continuous(plant, law, x0, times, max_step),
        Timing::Held { period } => held(plant, law, x0, times, max_step, period),
    }
}

fn fits(plant: &dyn Plant, law: &ComputedTorque<'_>) -> Result<(), ControlError> {
    let (expected, found) = (plant.inputs(), law.inputs());
    if expected != found {
        return Err(ControlError::Mismatch { what: "inputs of the law", expected, found });
    }
    let (needed, found) = (2 * law.coordinates(), plant.states());
    if found < needed {
        let what = "states of the plant";
        return Err(ControlError::Mismatch { what, expected: needed, found });
    }
    Ok(())
}

fn continuous(
    plant: &dyn Plant,
    law: &ComputedTorque<'_>,
    x0: &[f64],
    times: &[f64],
    max_step: f64,
) -> Result<ClosedLoop, ControlError> {
    let looped = Looped { plant, law, failure: OnceLock::new() };
    let outcome = rk4(&looped, x0, &InputFn(|_, _| {}), times, max_step);
    if let Some(failure) = looped.failure.into_inner() {
        return Err(failure);
    }
    let trajectory = outcome?;
    let m = law.inputs();
    let mut inputs = vec![0.0; times.len() * m];
    for (k, u) in inputs.chunks_exact_mut(m).enumerate() {
        law.input(times[k], trajectory.state(k), u)?;
    }
    Ok(ClosedLoop { trajectory, inputs })
}

/// The closed loop as a plant without inputs. A failure of the law is kept aside and makes the
/// derivative NaN, which ends the integration.
struct Looped<'a> {
    plant: &'a dyn Plant,
    law: &'a ComputedTorque<'a>,
    failure: OnceLock<ControlError>,
}

impl Plant for Looped<'_> {
    fn order(&self) -> usize {
        1
    }

    fn dimension(&self) -> usize {
        self.plant.states()
    }

    fn inputs(&self) -> usize {
        0
    }

    fn derivative(&self, t: f64, state: &[f64], _u: &[f64], derivative: &mut [f64]) {
        let mut u = vec![0.0; self.law.inputs()];
        match self.law.input(t, state, &mut u) {
            Ok(()) => self.plant.derivative(t, state, &u, derivative),
            Err(error) => {
                // Only the first failure tells anything; later ones follow from its NaN.
                self.failure.get_or_init(|| error);
                derivative.fill(f64::NAN);
            }
        }
    }
}

fn held(
    plant: &dyn Plant,
    law: &ComputedTorque<'_>,
    x0: &[f64],
    times: &[f64],
    max_step: f64,
    period: f64,
) -> Result<ClosedLoop, ControlError> {
    if !(period > 0.0 && period.is_finite()) {
        return Err(ControlError::BadPeriod { found: period });
    }
    if x0.len() != plant.states() {
        let (expected, found) = (plant.states(), x0.len());
        return Err(SimulationError::WrongState { expected, found }.into());
    }
    if let Some(p) = times.windows(2).find(|p| p[1] <= p[0]) {
        return Err(SimulationError::TimesNotIncreasing { time: p[0], next: p[1] }.into());
    }
    let (mut x, mut u) = (x0.to_vec(), vec![0.0; law.inputs()]);
    let mut trajectory = Trajectory { times: times.to_vec(), width: x.len(), states: Vec::new() };
    let mut inputs = Vec::new();
    let start = times.first().copied().unwrap_or(0.0);
    let (mut now, mut samples) = (start, 0_u64);
    for &time in times {
        loop {
            let next = start + samples as f64 * period;
            if next > time + 1e-9 * period {
                break;
            }
            advance(plant, &u, &mut x, &mut now, next, max_step)?;
            law.input(next, &x, &mut u)?;
            samples += 1;
        }
        advance(plant, &u, &mut x, &mut now, time, max_step)?;
        trajectory.states.extend_from_slice(&x);
        inputs.extend_from_slice(&u);
    }
    Ok(ClosedLoop { trajectory, inputs })
}

/// Bring the state `x` from `now` to `to` under the constant input `u`.
fn advance(
    plant: &dyn Plant,
    u: &[f64],
    x: &mut Vec<f64>,
    now: &mut f64,
    to: f64,
    max_step: f64,
) -> Result<(), SimulationError> {
    // A sampling instant may miss a requested time by rounding.
    if to - *now > 1e-12 * (1.0 + to.abs()) {
        let constant = InputFn(|_, v: &mut [f64]| v.copy_from_slice(u));
        *x = rk4(plant, x, &constant, &[*now, to], max_step)?.state(1).to_vec();
        *now = to;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Gains, Origin, PlantAccelerations, ReferenceFn, VelocityRows};
    use lacuna_plants::{Duffing, TwoLinkArm};

    fn every(step: f64, count: usize) -> Vec<f64> {
        (0..=count).map(|k| step * k as f64).collect()
    }

    /// With the true model the error obeys e'' + 30 e' + 20 e = 0, whose closed form gives the
    /// paper's q(5 s) = 0.0105 and q(10 s) = 0.0003.
    #[test]
    fn the_regulated_arm_follows_the_closed_form_of_its_error() {
        let arm = TwoLinkArm::default();
        let model = PlantAccelerations::new(&arm).unwrap();
        let law = ComputedTorque::new(&model, &Origin, Gains::uniform(2, 20.0, 30.0)).unwrap();
        let times = every(0.5, 20);
        let run = closed_loop(&arm, &law, &[0.3; 4], &times, 0.01, Timing::Continuous).unwrap();
        let root = 205.0_f64.sqrt();
        let (fast, slow) = (-15.0 - root, -15.0 + root);
        let (a, b) = (0.3 * (1.0 - slow) / (fast - slow), 0.3 * (fast - 1.0) / (fast - slow));
        for (k, t) in times.iter().enumerate() {
            let exact = a * (fast * t).exp() + b * (slow * t).exp();
            for q in &run.trajectory.state(k)[..2] {
                assert!((q - exact).abs() < 1e-6, "{t}: {q} {exact}");
            }
        }
        assert!((run.trajectory.state(10)[0] - 0.0105).abs() < 5e-5);
        assert!((run.trajectory.state(20)[1] - 0.0003).abs() < 5e-5);
    }

    #[test]
    fn a_reference_is_followed_exactly_once_reached() {
        let duffing = Duffing::default();
        let model = PlantAccelerations::new(&duffing).unwrap();
        let reference = ReferenceFn(|t: f64, q: &mut [f64], dq: &mut [f64], ddq: &mut [f64]| {
            (q[0], dq[0], ddq[0]) = (t.sin(), t.cos(), -t.sin());
        });
        let law = ComputedTorque::new(&model, &reference, Gains::uniform(1, 4.0, 4.0)).unwrap();
        let times = every(0.5, 20);
        let run = closed_loop(&duffing, &law, &[0.0, 1.0], &times, 0.005, Timing::Continuous);
        let run = run.unwrap();
        for (k, t) in times.iter().enumerate() {
            assert!((run.trajectory.state(k)[0] - t.sin()).abs() < 1e-8);
            let torque = (-t.sin() - duffing.f(t.sin())) / duffing.g(t.sin());
            assert!((run.inputs[k] - torque).abs() < 1e-6);
        }
    }

    /// q'' = u under u = -q - 2 q' held for a period: exact discrete recursion.
    #[test]
    fn a_held_input_is_constant_over_its_period() {
        let double = Double;
        let model = PlantAccelerations::new(&double).unwrap();
        let law = ComputedTorque::new(&model, &Origin, Gains::uniform(1, 1.0, 2.0)).unwrap();
        let (period, times) = (0.3, every(0.1, 30));
        let held = Timing::Held { period };
        let run = closed_loop(&double, &law, &[1.0, 0.0], &times, 0.01, held).unwrap();
        let (mut q, mut v) = (1.0, 0.0);
        for k in 0..=10 {
            let u = -q - 2.0 * v;
            let state = run.trajectory.state(3 * k);
            assert!((state[0] - q).abs() < 1e-10 && (state[1] - v).abs() < 1e-10);
            for j in 3 * k..(3 * k + 3).min(times.len()) {
                assert!((run.inputs[j] - u).abs() < 1e-10);
            }
            (q, v) = (q + v * period + 0.5 * u * period * period, v + u * period);
        }
    }

    struct Double;

    impl Plant for Double {
        fn order(&self) -> usize {
            2
        }
        fn dimension(&self) -> usize {
            1
        }
        fn inputs(&self) -> usize {
            1
        }
        fn derivative(&self, _t: f64, x: &[f64], u: &[f64], dx: &mut [f64]) {
            (dx[0], dx[1]) = (x[1], u[0]);
        }
    }

    #[test]
    fn failures_of_the_law_are_reported_and_not_lost_in_the_integration() {
        // A model whose g2 vanishes left of q = 0.5, which the loop has to cross.
        let model = VelocityRows::new(1, 1, |x: &[f64], _: &mut [f64], g: &mut [f64]| {
            g[1] = (x[0] - 0.5).max(0.0);
        });
        let law = ComputedTorque::new(&model, &Origin, Gains::uniform(1, 4.0, 1.0)).unwrap();
        let times = every(0.1, 100);
        for timing in [Timing::Continuous, Timing::Held { period: 0.05 }] {
            let error = closed_loop(&Double, &law, &[1.0, 0.0], &times, 0.01, timing).unwrap_err();
            assert!(matches!(error, ControlError::Singular { .. }), "{error:?}");
        }
    }

    #[test]
    fn what_does_not_fit_is_refused() {
        let arm = TwoLinkArm::default();
        let model = PlantAccelerations::new(&arm).unwrap();
        let law = ComputedTorque::new(&model, &Origin, Gains::uniform(2, 1.0, 1.0)).unwrap();
        let go = |plant: &dyn Plant, x0: &[f64], timing| {
            closed_loop(plant, &law, x0, &[0.0, 1.0], 0.1, timing).unwrap_err()
        };
        assert!(matches!(
            go(&Double, &[0.0; 2], Timing::Continuous),
            ControlError::Mismatch { what: "inputs of the law", expected: 1, found: 2 }
        ));
        assert_eq!(
            go(&arm, &[0.0; 4], Timing::Held { period: 0.0 }),
            ControlError::BadPeriod { found: 0.0 }
        );
        let backwards = SimulationError::TimesNotIncreasing { time: 1.0, next: 0.5 };
        for timing in [Timing::Continuous, Timing::Held { period: 0.1 }] {
            let error = closed_loop(&arm, &law, &[0.0; 4], &[0.0, 1.0, 0.5], 0.1, timing);
            assert_eq!(error.unwrap_err(), backwards.clone().into());
        }
        let wrong = SimulationError::WrongState { expected: 4, found: 2 };
        assert_eq!(go(&arm, &[0.0; 2], Timing::Continuous), wrong.clone().into());
        assert_eq!(go(&arm, &[0.0; 2], Timing::Held { period: 0.1 }), wrong.into());
    }
}
