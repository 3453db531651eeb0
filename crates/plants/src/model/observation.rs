//! What the recordings see of the machine's state.

use super::{Measured, Model, System};
use crate::dynamics::{Dynamics, Sizes};
use lacuna_numbers::Number;
use std::sync::Arc;

/// The measured quantities of a model.
#[derive(Clone, Debug)]
pub struct Observation {
    dynamics: Arc<dyn Dynamics>,
    sizes: Sizes,
    measured: Vec<Measured>,
    /// The imposed coordinates.
    imposed: Vec<usize>,
    /// Whether an output of the dynamics' own is measured.
    own: bool,
    /// Whether what is measured can hold a force on an imposed coordinate.
    forces: bool,
}

impl Observation {
    /// What is measured, in this order.
    #[must_use]
    pub fn of(model: &Model, measured: &[Measured]) -> Self {
        let dynamics = model.dynamics.clone();
        let imposed: Vec<usize> = model.imposed().collect();
        let any = |of: fn(&Measured) -> bool| measured.iter().any(of);
        let own = any(|m| matches!(m, Measured::Output(_)));
        let forces = !imposed.is_empty() && (own || any(|m| matches!(m, Measured::Force(_))));
        let measured = measured.to_vec();
        Self { sizes: dynamics.sizes(), dynamics, measured, imposed, own, forces }
    }

    /// Whether what is measured can hold a force on an imposed coordinate: it is then moved by
    /// effects at once, not only by what they do to the state.
    #[must_use]
    pub fn sees_forces(&self) -> bool {
        self.forces
    }

    /// The measured quantities of a system at a whole state and a row of inputs.
    pub fn evaluate<T: Number>(
        &self,
        system: &System<T>,
        t: f64,
        state: &[T],
        u: &[T],
        out: &mut [T],
    ) {
        let forces = if self.forces { system.imposing((t, state, u)) } else { vec![] };
        let own = if self.own { self.outputs(system, (t, state, u), &forces) } else { vec![] };
        for (out, m) in out.iter_mut().zip(&self.measured) {
            *out = match *m {
                Measured::State(i) => state[i],
                Measured::Input(j) => u[j],
                Measured::Force(c) => self.force_on(c, &forces),
                Measured::Output(k) => own[k],
            };
        }
    }

    /// The force on a coordinate; nothing but its own motion moves a free one.
    fn force_on<T: Number>(&self, coordinate: usize, forces: &[T]) -> T {
        let place = self.imposed.iter().position(|c| *c == coordinate);
        place.map_or(T::constant(0.0), |k| forces[k])
    }

    /// The outputs of the dynamics' own.
    fn outputs<T: Number>(
        &self,
        system: &System<T>,
        at: (f64, &[T], &[T]),
        forces: &[T],
    ) -> Vec<T> {
        let mut variables = vec![T::constant(0.0); self.sizes.variables()];
        system.variables(at, &mut variables);
        variables.extend_from_slice(forces);
        let mut outputs = vec![T::constant(0.0); self.dynamics.outputs()];
        system.bound().observe(&variables, &mut outputs);
        outputs
    }
}
