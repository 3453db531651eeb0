//! A model compiled to be simulated: a [`Plant`] of the machine and its effects' memory.

use super::{Model, ModelEffect};
use crate::Plant;
use crate::expression::{Bound, Program};
use lacuna_effects::{ForceLaw, Law, Local, MOST_AMPLITUDES};

/// The model's equations, compiled; parameters are free.
#[derive(Clone, Debug)]
pub struct Equations {
    program: Program,
    coordinates: usize,
    states: usize,
}

impl Equations {
    /// Compile the equations of a model.
    #[must_use]
    pub fn of(model: &Model) -> Self {
        let nodes = &model.equations;
        let outputs: Vec<_> = nodes.mass.iter().chain(&nodes.force).copied().collect();
        Self {
            program: Program::compile(&nodes.graph, model.parameters.len(), &outputs),
            coordinates: model.coordinates.len(),
            states: model.states.len(),
        }
    }

    /// Set the parameters.
    #[must_use]
    pub fn bind(&self, parameters: &[f64]) -> Bound {
        self.program.bind(parameters)
    }

    /// Mass matrix (row-major) followed by the generalised forces and first-order
    /// derivatives, at `variables` = coordinates, velocities, first-order states, inputs, time.
    pub fn evaluate(&self, bound: &Bound, variables: &[f64], mass_and_force: &mut [f64]) {
        self.program.evaluate(bound, variables, mass_and_force);
    }

    /// Length of what [`Equations::evaluate`] writes.
    #[must_use]
    pub fn outputs(&self) -> usize {
        self.program.outputs()
    }
}

/// Most variables and outputs that are evaluated without touching the heap.
const ON_STACK: usize = 20;

/// A model with its parameters and force effects set: a plant that can be simulated.
/// Input effects are applied to the input series beforehand
/// ([`Model::effective_inputs`]), sensor effects to the result.
#[derive(Clone, Debug)]
pub struct System {
    equations: Equations,
    bound: Bound,
    inputs: usize,
    forces: Vec<Force>,
    memory: usize,
}

/// A force effect, its parameters turned to amplitudes and shape.
#[derive(Clone, Debug)]
struct Force {
    law: &'static dyn ForceLaw,
    channel: usize,
    other: Option<usize>,
    amplitudes: Vec<f64>,
    shape: Vec<f64>,
    /// Where its memory begins in the memory of all.
    memory: usize,
}

impl System {
    /// The model with its own parameters and effects.
    #[must_use]
    pub fn new(model: &Model) -> Self {
        Self::with(model, &Equations::of(model), &model.values(), &model.effects)
    }

    /// Other parameters and effects on equations that are compiled already.
    #[must_use]
    pub fn with(
        model: &Model,
        equations: &Equations,
        parameters: &[f64],
        effects: &[ModelEffect],
    ) -> Self {
        let mut memory = 0;
        let mut forces = Vec::new();
        for e in effects {
            let Law::Force(law) = e.effect.law else { continue };
            let mut amplitudes = law.internal(&e.parameters);
            let shape = amplitudes.split_off(law.amplitudes());
            let ModelEffect { channel, other, .. } = *e;
            forces.push(Force { law, channel, other, amplitudes, shape, memory });
            memory += law.memory();
        }
        let bound = equations.bind(parameters);
        Self { equations: equations.clone(), bound, inputs: model.inputs.len(), forces, memory }
    }

    /// Length of the machine's state, memory apart.
    #[must_use]
    pub fn machine_states(&self) -> usize {
        2 * self.equations.coordinates + self.equations.states
    }

    /// The whole state for a state of the machine: the effects' memory is at rest there.
    #[must_use]
    pub fn at_rest(&self, machine: &[f64]) -> Vec<f64> {
        let mut state = machine.to_vec();
        state.resize(machine.len() + self.memory, 0.0);
        for force in &self.forces {
            let at = self.local(force, 0.0, machine);
            let begin = machine.len() + force.memory;
            let memory = &mut state[begin..begin + force.law.memory()];
            force.law.memory_at_rest(&at, memory);
        }
        state
    }

    /// What a force effect sees of a state.
    fn local(&self, force: &Force, t: f64, state: &[f64]) -> Local {
        let n = self.equations.coordinates;
        // Velocities of coordinates stand n after them; a first-order state stands n after
        // its channel's number and is its own velocity.
        let q = |c: usize| if c < n { state[c] } else { state[c + n] };
        let (other_q, other_v) = force.other.map_or((0.0, 0.0), |o| (q(o), state[o + n]));
        Local { t, q: q(force.channel), v: state[force.channel + n], other_q, other_v }
    }

    /// Add the effects' forces to `force` and write their memories' rates.
    fn add_effects(&self, t: f64, state: &[f64], force: &mut [f64], derivative: &mut [f64]) {
        let machine = self.machine_states();
        let mut basis = [0.0; MOST_AMPLITUDES];
        for f in &self.forces {
            let at = self.local(f, t, state);
            let range = machine + f.memory..machine + f.memory + f.law.memory();
            let memory = &state[range.clone()];
            let basis = &mut basis[..f.amplitudes.len()];
            f.law.basis(&f.shape, &at, memory, basis);
            let sum: f64 = f.amplitudes.iter().zip(&*basis).map(|(a, b)| a * b).sum();
            force[f.channel] += sum;
            if let (true, Some(other)) = (f.law.reacts(), f.other) {
                force[other] -= sum;
            }
            if !range.is_empty() {
                f.law.memory_rate(&f.shape, &at, memory, &mut derivative[range]);
            }
        }
    }

    /// Determinant of the mass matrix at a state; 1 without coordinates.
    #[must_use]
    pub fn mass_determinant(&self, state: &[f64]) -> f64 {
        let n = self.equations.coordinates;
        let mut variables = state[..self.machine_states()].to_vec();
        variables.resize(self.machine_states() + self.inputs + 1, 0.0);
        let mut outputs = vec![0.0; self.equations.outputs()];
        self.equations.evaluate(&self.bound, &variables, &mut outputs);
        nalgebra::DMatrix::from_row_slice(n, n, &outputs[..n * n]).determinant()
    }
}

impl Plant for System {
    fn order(&self) -> usize {
        if self.equations.states == 0 { 2 } else { 1 }
    }

    fn dimension(&self) -> usize {
        let Equations { coordinates, states, .. } = self.equations;
        if states == 0 { coordinates } else { 2 * coordinates + states }
    }

    fn inputs(&self) -> usize {
        self.inputs
    }

    fn states(&self) -> usize {
        self.machine_states() + self.memory
    }

    fn derivative(&self, t: f64, state: &[f64], u: &[f64], derivative: &mut [f64]) {
        let variables = self.machine_states() + self.inputs + 1;
        let outputs = self.equations.outputs();
        if variables <= ON_STACK && outputs <= ON_STACK {
            let (mut v, mut o) = ([0.0; ON_STACK], [0.0; ON_STACK]);
            self.rates(t, state, u, derivative, &mut v[..variables], &mut o[..outputs]);
        } else {
            let (mut v, mut o) = (vec![0.0; variables], vec![0.0; outputs]);
            self.rates(t, state, u, derivative, &mut v, &mut o);
        }
    }
}

impl System {
    fn rates(
        &self,
        t: f64,
        state: &[f64],
        u: &[f64],
        derivative: &mut [f64],
        variables: &mut [f64],
        outputs: &mut [f64],
    ) {
        let machine = self.machine_states();
        variables[..machine].copy_from_slice(&state[..machine]);
        variables[machine..machine + u.len()].copy_from_slice(u);
        variables[machine + u.len()] = t;
        self.equations.evaluate(&self.bound, variables, outputs);
        let n = self.equations.coordinates;
        let (mass, force) = outputs.split_at_mut(n * n);
        self.add_effects(t, state, force, derivative);
        solve_mass(mass, &mut force[..n]);
        derivative[..n].copy_from_slice(&state[n..2 * n]);
        derivative[n..machine].copy_from_slice(force);
    }
}

/// `force <- mass^-1 force`; not finite where the mass matrix is singular. Both are
/// overwritten. Gaussian elimination with pivoting; one and two coordinates, the usual
/// sizes in a hot loop, by formula.
fn solve_mass(mass: &mut [f64], force: &mut [f64]) {
    match force {
        [] => {}
        [f] => *f /= mass[0],
        [f, g] => {
            let (a, b, c, d) = (mass[0], mass[1], mass[2], mass[3]);
            let determinant = a * d - b * c;
            (*f, *g) = ((d * *f - b * *g) / determinant, (a * *g - c * *f) / determinant);
        }
        _ => eliminate(mass, force),
    }
}

fn eliminate(mass: &mut [f64], force: &mut [f64]) {
    let n = force.len();
    for k in 0..n {
        let size = |i: &usize| mass[i * n + k].abs();
        let pivot = (k..n).max_by(|a, b| size(a).total_cmp(&size(b))).unwrap_or(k);
        if pivot != k {
            for j in 0..n {
                mass.swap(k * n + j, pivot * n + j);
            }
            force.swap(k, pivot);
        }
        for i in k + 1..n {
            let share = mass[i * n + k] / mass[k * n + k];
            for j in k..n {
                mass[i * n + j] -= share * mass[k * n + j];
            }
            force[i] -= share * force[k];
        }
    }
    for k in (0..n).rev() {
        let known: f64 = (k + 1..n).map(|j| mass[k * n + j] * force[j]).sum();
        force[k] = (force[k] - known) / mass[k * n + k];
    }
}
