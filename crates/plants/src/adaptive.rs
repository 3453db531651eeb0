//! Adaptive integration of a plant: Dormand and Prince's method of order 5(4).
//!
//! The method is that of the `ode_solvers` crate (0.6.2). Two things are done about it:
//!
//! * a step never reaches across a breakpoint of the input, so that held inputs are exact:
//!   each interval between breakpoints is integrated on its own;
//! * time is carried as one more state and only the crate's sparse output (its own steps)
//!   is read. Its method of order 8 evaluates explicit time dependence at wrong nodes, and the
//!   last row of its dense output can be wrong; neither can then do harm. The tests of this
//!   module would fail if either did.

use crate::integrate::{check, segments};
use crate::{Input, Plant, SimulationError, Trajectory};
use ode_solvers::{DVector, Dopri5, OutputType, System};
use std::cell::RefCell;

/// Error that an adaptive integrator may make in a step:
/// `absolute + relative * |x_i|` in each state (root mean square over the states).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tolerance {
    /// Relative to the state.
    pub relative: f64,
    /// In the units of the state.
    pub absolute: f64,
}

impl Default for Tolerance {
    fn default() -> Self {
        Self { relative: 1e-9, absolute: 1e-11 }
    }
}

/// Integrate from `x0` at `times[0]` with steps chosen to meet `tolerance` and return the
/// states at `times`.
///
/// # Errors
/// [`SimulationError`] when the state diverges, the step becomes too small or the equation too
/// stiff, or times or `x0` do not fit.
pub fn dormand_prince(
    plant: &dyn Plant,
    x0: &[f64],
    input: &dyn Input,
    times: &[f64],
    tolerance: Tolerance,
) -> Result<Trajectory, SimulationError> {
    let width = plant.states();
    check(x0, width, times)?;
    let mut x = DVector::from_column_slice(x0);
    let mut states = x0.to_vec();
    for pair in times.windows(2) {
        for (from, to) in segments(pair[0], pair[1], input.breakpoints()) {
            x = across(plant, &x, input, (from, to), tolerance)?;
        }
        states.extend_from_slice(x.as_slice());
    }
    Ok(Trajectory { times: times.to_vec(), states, width })
}

/// The state at the end of an interval in which the input is smooth.
fn across(
    plant: &dyn Plant,
    x: &DVector<f64>,
    input: &dyn Input,
    (from, to): (f64, f64),
    tolerance: Tolerance,
) -> Result<DVector<f64>, SimulationError> {
    let width = x.len();
    let start = x.clone().insert_row(width, from);
    let system = WithTime { plant, input, from, u: RefCell::new(vec![0.0; plant.inputs()]) };
    let mut solver =
        Dopri5::new(system, from, to, to - from, start, tolerance.relative, tolerance.absolute);
    solver.set_output(OutputType::Sparse);
    let outcome = solver.integrate();
    let (time, last) = match (solver.x_out().last(), solver.y_out().last()) {
        (Some(&time), Some(y)) => (time, y.rows(0, width).into_owned()),
        _ => (from, x.clone()),
    };
    if let Some(state) = last.iter().position(|v| !v.is_finite()) {
        return Err(SimulationError::Diverged { time, state });
    }
    match outcome {
        Ok(_) => Ok(last),
        Err(e) => Err(SimulationError::Integrator { from, to, reason: e.to_string() }),
    }
}

/// A plant whose last state is the time.
struct WithTime<'a> {
    plant: &'a dyn Plant,
    input: &'a dyn Input,
    from: f64,
    u: RefCell<Vec<f64>>,
}

impl System<f64, DVector<f64>> for WithTime<'_> {
    fn system(&self, _t: f64, y: &DVector<f64>, dy: &mut DVector<f64>) {
        let width = y.len() - 1;
        let t = y[width];
        let mut u = self.u.borrow_mut();
        self.input.value(self.from, t, &mut u);
        let (x, dx) = (y.as_slice(), dy.as_mut_slice());
        self.plant.derivative(t, &x[..width], &u, &mut dx[..width]);
        dx[width] = 1.0;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Duffing, Hold, InputFn, SampledInput, TwoLinkArm, rk4};

    /// `x' = 3 t^2 cos(t^3) + u`: depends on time explicitly and, with `u = exp t`, has the
    /// closed form `x = x0 + sin t^3 + exp t - 1`.
    struct Driven;

    impl Plant for Driven {
        fn order(&self) -> usize {
            1
        }
        fn dimension(&self) -> usize {
            1
        }
        fn inputs(&self) -> usize {
            1
        }
        fn derivative(&self, t: f64, _state: &[f64], u: &[f64], derivative: &mut [f64]) {
            derivative[0] = 3.0 * t * t * t.powi(3).cos() + u[0];
        }
    }

    /// Every row, the last included, against the closed form of an explicitly time-dependent
    /// plant and input: catches wrong nodes and a wrong last row.
    #[test]
    fn explicit_time_dependence_is_right_in_every_row() {
        let times: Vec<f64> = (0..=40).map(|k| 0.0731 * k as f64).collect();
        let input = InputFn(|t: f64, u: &mut [f64]| u[0] = t.exp());
        let path = dormand_prince(&Driven, &[0.4], &input, &times, Tolerance::default()).unwrap();
        assert_eq!(path.states.len(), times.len());
        for (t, x) in times.iter().zip(&path.states) {
            let exact = 0.4 + t.powi(3).sin() + t.exp() - 1.0;
            approx::assert_abs_diff_eq!(*x, exact, epsilon = 1e-7);
        }
    }

    #[test]
    fn held_inputs_agree_with_rk4() {
        let knots = [0.0, 0.13, 0.4, 0.77, 1.0];
        let values = [1.0, -2.0, 3.0, 0.5, 0.0];
        let times = [0.0, 0.31, 0.4, 0.9, 1.0];
        for hold in [Hold::ZeroOrder, Hold::Linear] {
            let input = SampledInput { times: &knots, values: &values, hold };
            let plant = Duffing::default();
            let fine = rk4(&plant, &[1.0, -0.5], &input, &times, 1e-4).unwrap();
            let path =
                dormand_prince(&plant, &[1.0, -0.5], &input, &times, Tolerance::default()).unwrap();
            for (a, b) in path.states.iter().zip(&fine.states) {
                approx::assert_abs_diff_eq!(a, b, epsilon = 1e-8);
            }
        }
    }

    #[test]
    fn the_arm_agrees_with_rk4() {
        let arm = TwoLinkArm::default();
        let input = InputFn(|t: f64, u: &mut [f64]| {
            u[0] = 2.0 * (3.0 * t).sin();
            u[1] = (5.0 * t).cos();
        });
        let (x0, times) = ([0.5, -1.0, 2.0, -3.0], [0.0, 0.5, 1.0, 2.0]);
        let fine = rk4(&arm, &x0, &input, &times, 1e-4).unwrap();
        let path = dormand_prince(&arm, &x0, &input, &times, Tolerance::default()).unwrap();
        for (a, b) in path.states.iter().zip(&fine.states) {
            approx::assert_abs_diff_eq!(a, b, epsilon = 1e-8);
        }
    }

    /// `x' = x^2` from 1 is infinite at t = 1.
    struct Explosive;

    impl Plant for Explosive {
        fn order(&self) -> usize {
            1
        }
        fn dimension(&self) -> usize {
            1
        }
        fn inputs(&self) -> usize {
            0
        }
        fn derivative(&self, _t: f64, state: &[f64], _u: &[f64], derivative: &mut [f64]) {
            derivative[0] = state[0] * state[0];
        }
    }

    #[test]
    fn divergence_is_an_error() {
        let result = dormand_prince(
            &Explosive,
            &[1.0],
            &InputFn(|_, _| {}),
            &[0.0, 2.0],
            Tolerance::default(),
        );
        assert!(matches!(
            result,
            Err(SimulationError::Diverged { .. } | SimulationError::Integrator { .. })
        ));
    }
}
