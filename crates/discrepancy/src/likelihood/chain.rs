//! A hypothesis on one recording, stepped from sample to sample in any kind of number.

use super::{Problem, Window};
use crate::dataset::Observed;
use lacuna_effects::Law;
use lacuna_numbers::Number;
use lacuna_plants::Hold;
use lacuna_plants::expression::Bound;
use lacuna_plants::model::{Measured, ModelEffect, System};

/// A value beyond this is divergence, not motion.
const DIVERGED: f64 = 1e12;

/// A hypothesis on one recording in one kind of number.
pub(super) struct Chain<'p, T: Number> {
    pub(super) problem: &'p Problem<'p>,
    pub(super) effects: &'p [ModelEffect],
    pub(super) observed: &'p Observed,
    pub(super) system: System<T>,
    pub(super) bound: Bound<T>,
    pub(super) inputs: Vec<f64>,
    /// Derivatives of the effective inputs: lane and series.
    pub(super) input_lanes: Vec<(usize, Vec<f64>)>,
    /// Parameters of sensors that move: effect, parameter, lane.
    pub(super) sensor_lanes: Vec<(usize, usize, usize)>,
    pub(super) substeps: usize,
}

impl<T: Number> Chain<'_, T> {
    /// Outputs over a window from a whole state, which is left at the window's end (of the
    /// sample after it where there is one); `None` where the model diverges.
    pub(super) fn window(
        &self,
        w: &Window,
        state: &mut [T],
        mut visit: impl FnMut(&[T]),
    ) -> Option<Vec<Vec<T>>> {
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
                return None;
            }
        }
        self.sense(&times[w.range.clone()], &mut out);
        Some(out)
    }

    fn input(&self, k: usize) -> Vec<T> {
        let mut u = vec![T::constant(0.0); self.problem.model.inputs.len()];
        self.input_at(k, &mut u);
        u
    }

    fn input_at(&self, k: usize, u: &mut [T]) {
        let m = u.len();
        for (j, u) in u.iter_mut().enumerate() {
            let at = k * m + j;
            let slope = |l: usize| {
                self.input_lanes.iter().filter(|s| s.0 == l).map(|s| s.1[at]).sum::<f64>()
            };
            *u = if self.input_lanes.is_empty() {
                T::constant(self.inputs[at])
            } else {
                T::with_tangent(self.inputs[at], slope)
            };
        }
    }

    /// What the sensors make of the outputs. Sensor laws are affine in the series, so that a
    /// tangent goes through them as a difference of two series does.
    fn sense(&self, times: &[f64], out: &mut [Vec<T>]) {
        for (index, e) in self.effects.iter().enumerate() {
            let Law::Sensor(law) = e.effect.law else { continue };
            for (series, output) in out.iter_mut().zip(&self.problem.dataset.outputs) {
                if !matches!(output.of, Measured::State(i) if i == e.channel) {
                    continue;
                }
                let truth: Vec<f64> = series.iter().map(|y| y.value()).collect();
                let values = law.observe(&e.parameters, times, &truth);
                let lanes = series.first().map_or(0, |y| y.tangent().len());
                let moved: Vec<Vec<f64>> = (0..lanes)
                    .map(|l| self.sensed_tangent(law, (index, e), times, series, (l, &values)))
                    .collect();
                for (k, y) in series.iter_mut().enumerate() {
                    *y = T::with_tangent(values[k], |l| moved[l][k]);
                }
            }
        }
    }

    fn sensed_tangent(
        &self,
        law: &dyn lacuna_effects::SensorLaw,
        (index, e): (usize, &ModelEffect),
        times: &[f64],
        series: &[T],
        (lane, values): (usize, &[f64]),
    ) -> Vec<f64> {
        let shifted: Vec<f64> = series.iter().map(|y| y.value() + y.tangent()[lane]).collect();
        let seen = law.observe(&e.parameters, times, &shifted);
        let mut tangent: Vec<f64> = seen.iter().zip(values).map(|(a, b)| a - b).collect();
        for &(_, j, _) in self.sensor_lanes.iter().filter(|s| s.0 == index && s.2 == lane) {
            let step = parameter_step(e, j, self.problem.sample);
            let mut parameters = e.parameters.clone();
            parameters[j] += step;
            let truth: Vec<f64> = series.iter().map(|y| y.value()).collect();
            for (t, (a, b)) in
                tangent.iter_mut().zip(law.observe(&parameters, times, &truth).iter().zip(values))
            {
                *t += (a - b) / step;
            }
        }
        tangent
    }
}

/// Step of a difference with respect to a parameter of an input or sensor effect: small beside
/// its value, or beside a sample where it begins at zero.
pub(super) fn parameter_step(e: &ModelEffect, j: usize, sample: f64) -> f64 {
    let value = e.parameters[j].abs();
    if value > 0.0 { 1e-4 * value } else { 1e-3 * sample }
}
