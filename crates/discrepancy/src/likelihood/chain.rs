//! A hypothesis on one recording, stepped from sample to sample in any kind of number.

use super::end::Diverged;
use super::{Problem, Window};
use crate::dataset::Observed;
use lacuna_numbers::Number;
use lacuna_plants::Hold;
use lacuna_plants::dynamics::Bound;
use lacuna_plants::model::{Measured, SeriesEffect, System};

/// A value beyond this is divergence, not motion.
const DIVERGED: f64 = 1e12;

/// A hypothesis on one recording in one kind of number.
pub(super) struct Chain<'p, T: Number> {
    pub(super) problem: &'p Problem<'p>,
    pub(super) observed: &'p Observed,
    pub(super) system: System<T>,
    pub(super) bound: Bound<T>,
    pub(super) inputs: Inputs<T>,
    pub(super) sensors: Vec<SeriesEffect<T>>,
    pub(super) substeps: usize,
}

/// The effective inputs, row-major.
pub(super) enum Inputs<T> {
    /// They depend on nothing that moves.
    Fixed(Vec<f64>),
    /// They carry derivatives by parameters of actuators.
    Moving(Vec<T>),
}

impl<T: Number> Chain<'_, T> {
    /// Outputs over a window from a whole state, which is left at the window's end (of the
    /// sample after it where there is one).
    ///
    /// # Errors
    /// [`Diverged`].
    pub(super) fn window(
        &self,
        w: &Window,
        state: &mut [T],
        mut visit: impl FnMut(&[T]),
    ) -> Result<Vec<Vec<T>>, Diverged> {
        let mut workspace = self.system.workspace();
        let count = self.problem.dataset.outputs.len();
        let mut out = vec![Vec::with_capacity(w.range.len()); count];
        let mut y = vec![T::constant(0.0); count];
        let times = &self.observed.times;
        let (mut here, mut next) = (self.input(w.range.start), self.input(w.range.start));
        for k in w.range.clone() {
            visit(state);
            self.input_at(k, &mut here);
            self.problem.observation.evaluate(&self.bound, times[k], state, &here, &mut y);
            for (series, value) in out.iter_mut().zip(&y) {
                series.push(*value);
            }
            if k + 1 == times.len() {
                break;
            }
            match self.problem.model.hold {
                Hold::ZeroOrder => next.copy_from_slice(&here),
                Hold::Linear => self.input_at(k + 1, &mut next),
            }
            let span = (times[k], times[k + 1]);
            self.system.advance(&mut workspace, span, (&here, &next), self.substeps, state);
            let diverged = |x: &T| x.value().is_nan() || x.value().abs() > DIVERGED;
            if state.iter().any(diverged) {
                return Err(Diverged { recording: self.observed.name.clone(), time: times[k + 1] });
            }
        }
        self.sense(&times[w.range.clone()], &mut out);
        Ok(out)
    }

    fn input(&self, k: usize) -> Vec<T> {
        let mut u = vec![T::constant(0.0); self.problem.model.inputs.len()];
        self.input_at(k, &mut u);
        u
    }

    fn input_at(&self, k: usize, u: &mut [T]) {
        let m = u.len();
        for (j, u) in u.iter_mut().enumerate() {
            *u = match &self.inputs {
                Inputs::Fixed(inputs) => T::constant(inputs[k * m + j]),
                Inputs::Moving(inputs) => inputs[k * m + j],
            };
        }
    }

    /// What the sensors make of the outputs.
    fn sense(&self, times: &[f64], out: &mut [Vec<T>]) {
        for (series, output) in out.iter_mut().zip(&self.problem.dataset.outputs) {
            let Measured::State(state) = output.of else { continue };
            for sensor in self.sensors.iter().filter(|s| s.channel == state) {
                *series = sensor.applied(times, series);
            }
        }
    }
}
