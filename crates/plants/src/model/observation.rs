//! What the recordings see of the machine's state.

use super::{Measured, Model};
use crate::dynamics::{Bound, Dynamics, Evaluated, Sizes};
use lacuna_numbers::Number;
use std::sync::Arc;

/// The measured quantities of a model.
#[derive(Clone, Debug)]
pub struct Observation {
    dynamics: Arc<dyn Dynamics>,
    sizes: Sizes,
    measured: Vec<Measured>,
    /// Whether all are entries of the state or inputs, as most are.
    plain: bool,
}

impl Observation {
    /// What is measured, in this order.
    #[must_use]
    pub fn of(model: &Model, measured: &[Measured]) -> Self {
        let plain = !measured.iter().any(|m| matches!(m, Measured::Output(_)));
        let dynamics = model.dynamics.clone();
        Self { sizes: dynamics.sizes(), dynamics, measured: measured.to_vec(), plain }
    }

    /// Set the parameters.
    #[must_use]
    pub fn bind<T: Evaluated>(&self, parameters: &[T]) -> Bound<T> {
        T::bind(&*self.dynamics, parameters)
    }

    /// The measured quantities at a state (memory beyond the machine's state is ignored).
    pub fn evaluate<T: Number>(
        &self,
        bound: &Bound<T>,
        t: f64,
        state: &[T],
        u: &[T],
        out: &mut [T],
    ) {
        let own = if self.plain { vec![] } else { self.outputs(bound, t, state, u) };
        for (out, m) in out.iter_mut().zip(&self.measured) {
            *out = match *m {
                Measured::State(i) => state[i],
                Measured::Input(j) => u[j],
                Measured::Output(k) => own[k],
            };
        }
    }

    /// The outputs of the dynamics' own.
    fn outputs<T: Number>(&self, bound: &Bound<T>, t: f64, state: &[T], u: &[T]) -> Vec<T> {
        let mut variables = Vec::with_capacity(self.sizes.variables());
        variables.extend_from_slice(&state[..self.sizes.machine_states()]);
        variables.extend_from_slice(u);
        variables.push(T::constant(t));
        let mut outputs = vec![T::constant(0.0); self.dynamics.outputs()];
        bound.observe(&variables, &mut outputs);
        outputs
    }
}
