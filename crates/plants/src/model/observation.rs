//! What the recordings see of the machine's state.

use super::{Measured, Model};
use crate::expression::{Bound, Program};
use lacuna_numbers::Number;

/// The measured quantities of a model, compiled.
#[derive(Clone, Debug)]
pub struct Observation {
    program: Program,
    measured: Vec<Measured>,
    states: usize,
    inputs: usize,
}

impl Observation {
    /// Compile what is measured, in this order.
    #[must_use]
    pub fn of(model: &Model, measured: &[Measured]) -> Self {
        let mut graph = model.equations.graph.clone();
        let (p, states) = (model.parameters.len(), model.machine_states());
        let nodes: Vec<_> = measured
            .iter()
            .map(|m| match *m {
                Measured::State(i) => graph.variable(p + i),
                Measured::Input(j) => graph.variable(p + states + j),
                Measured::Expression(node) => node,
            })
            .collect();
        let program = Program::compile(&graph, p, &nodes);
        Self { program, measured: measured.to_vec(), states, inputs: model.inputs.len() }
    }

    /// Set the parameters.
    #[must_use]
    pub fn bind<T: Number>(&self, parameters: &[T]) -> Bound<T> {
        self.program.bind(parameters)
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
        // Most outputs are entries of the state; they need no program.
        let plain = |m: &Measured| !matches!(m, Measured::Expression(_));
        if self.measured.iter().all(plain) {
            for (out, m) in out.iter_mut().zip(&self.measured) {
                *out = match *m {
                    Measured::State(i) => state[i],
                    Measured::Input(j) => u[j],
                    Measured::Expression(_) => unreachable!("all are plain"),
                };
            }
            return;
        }
        let mut variables = Vec::with_capacity(self.states + self.inputs + 1);
        variables.extend_from_slice(&state[..self.states]);
        variables.extend_from_slice(u);
        variables.push(T::constant(t));
        self.program.evaluate(bound, &variables, out);
    }
}
