//! A model compiled to be simulated: a [`Plant`] of the machine and its effects' memory.

use super::force::Force;
use super::mass::{impose, solve_mass};
use super::steep::Steep;
use super::together::{Shared, Strand, advance_together};
use super::{Model, ModelEffect};
use crate::Plant;
use crate::dynamics::{Bound, BoundDynamics, Implicit, Room, Sizes};
use crate::input::{MOTION, StepInput};
use crate::substeps::{JUMP, JUMP_OF_DERIVATIVES, Part, Place, Plan, Stepped, Substeps, jumps};
use lacuna_effects::{AnyForceLaw, ForceLawIn, Law};
use lacuna_numbers::{Dual, LANES, Number, copy};

/// Most variables and rates that are evaluated without touching the heap.
const ON_STACK: usize = 20;

/// What a derivative is taken with respect to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Direction {
    /// A parameter of the model.
    Parameter(usize),
    /// An internal parameter (amplitudes, then shape) of one of the effects: effect, parameter.
    Effect(usize, usize),
    /// A constant force on a channel.
    Force(usize),
    /// A constant change of an input.
    Input(usize),
}

impl Direction {
    /// Those of the internal parameters of one effect among some directions: parameter, lane.
    pub(super) fn of_effect(
        directions: &[(Self, usize)],
        effect: usize,
    ) -> impl Iterator<Item = (usize, usize)> + '_ {
        directions.iter().filter_map(move |&(d, lane)| match d {
            Self::Effect(e, j) if e == effect => Some((j, lane)),
            _ => None,
        })
    }
}

/// A model with its parameters and force effects set: a plant that can be simulated, in plain
/// numbers or, with derivatives, in [`Dual`] ones. Its inputs are rows of
/// [`Model::input_width`] numbers: the motion of imposed coordinates stands in them, and what their
/// entries of the state are is taken from there.
/// Input effects are applied to the input series beforehand
/// ([`Model::effective_inputs`]), sensor effects to the result.
#[derive(Clone, Debug)]
pub struct System<T: Number = f64> {
    bound: Bound<T>,
    sizes: Sizes,
    forces: Vec<Force<T>>,
    /// Whether any force is dry friction.
    dry: bool,
    /// Constant forces, one a channel.
    push: Vec<T>,
    /// Changes of inputs, which carry derivatives alone.
    change: Vec<(usize, T)>,
    memory: usize,
    /// Coordinates whose motion is imposed.
    imposed: Vec<usize>,
}

impl System {
    /// The model with its own parameters and effects.
    #[must_use]
    pub fn new(model: &Model) -> Self {
        Self::with(model, &model.values(), &model.effects)
    }

    /// The model with other parameters and effects.
    #[must_use]
    pub fn with(model: &Model, parameters: &[f64], effects: &[ModelEffect]) -> Self {
        let push = vec![0.0; model.channels()];
        let bound = model.dynamics.bind(&model.with_structure(parameters, effects));
        let law = |law: &'static dyn AnyForceLaw| law.plain();
        Self::built(model, bound, effects, (push, 0.0), law, |_, e| e.internal())
    }

    /// Determinant of the mass matrix of the coordinates that are free, at a state under some inputs;
    /// 1 without any.
    #[must_use]
    pub fn mass_determinant(&self, state: &[f64], inputs: &[f64]) -> f64 {
        let n = self.sizes.coordinates;
        let mut variables = state[..self.machine_states()].to_vec();
        variables.extend_from_slice(inputs);
        variables.resize(self.sizes.variables(), 0.0);
        let mut outputs = vec![0.0; self.sizes.rates()];
        self.bound.evaluate_once(&variables, &mut outputs);
        let (mass, force) = outputs.split_at_mut(n * n);
        impose(&self.imposed, |_| 0.0, mass, &mut force[..n]);
        nalgebra::DMatrix::from_row_slice(n, n, mass).determinant()
    }
}

impl System<Dual> {
    /// The same with derivatives in up to [`LANES`] directions, each in the lane that stands
    /// beside it; states and inputs bring their own. `sample` is the time from sample to sample,
    /// to which the time of an event can be told ([`lacuna_effects::At::sample`]).
    #[must_use]
    pub fn along(
        model: &Model,
        parameters: &[f64],
        effects: &[ModelEffect],
        directions: &[(Direction, usize)],
        sample: f64,
    ) -> Self {
        debug_assert!(directions.iter().all(|d| d.1 < LANES));
        let mut numbers: Vec<Dual> = parameters.iter().map(|&p| Dual::constant(p)).collect();
        let mut push = vec![Dual::constant(0.0); model.channels()];
        let mut change = vec![];
        for &(direction, lane) in directions {
            match direction {
                Direction::Parameter(k) => numbers[k] = Dual::direction(parameters[k], lane),
                Direction::Force(c) => push[c] = Dual::direction(0.0, lane),
                // What -0 is added to stays as it is, were it -0 itself.
                Direction::Input(j) => change.push((j, Dual::direction(-0.0, lane))),
                Direction::Effect(..) => {}
            }
        }
        let numbers = model.with_structure_along(numbers, effects, directions);
        let bound = model.dynamics.bind_dual(&numbers);
        let law = |law: &'static dyn AnyForceLaw| law.dual();
        let system = Self::built(model, bound, effects, (push, sample), law, |index, e| {
            e.internal_along(Direction::of_effect(directions, index))
        });
        Self { change, ..system }
    }
}

impl<T: Number> System<T> {
    fn built(
        model: &Model,
        bound: Bound<T>,
        effects: &[ModelEffect],
        (push, sample): (Vec<T>, f64),
        in_this_number: impl Fn(&'static dyn AnyForceLaw) -> &'static dyn ForceLawIn<T>,
        internal: impl Fn(usize, &ModelEffect) -> Vec<T>,
    ) -> Self {
        let mut memory = 0;
        let mut forces = Vec::new();
        for (index, e) in effects.iter().enumerate() {
            let Law::Force(law) = e.effect.law else { continue };
            let laws = (law, in_this_number(law));
            let begin = model.machine_states() + memory;
            forces.push(Force::new(model, e, laws, internal(index, e), begin, sample));
            memory += law.memory();
        }
        let (sizes, imposed) = (model.dynamics.sizes(), model.imposed().collect());
        let dry = forces.iter().any(Force::is_dry);
        Self { bound, sizes, forces, dry, push, change: vec![], memory, imposed }
    }

    /// The dynamics, their parameters set.
    #[inline(always)]
    pub(super) fn bound(&self) -> &Bound<T> {
        &self.bound
    }

    /// Length of a row of inputs, imposed motion among them.
    #[must_use]
    pub fn input_width(&self) -> usize {
        self.sizes.inputs + MOTION * self.imposed.len()
    }

    /// Set position and velocity of the imposed coordinates in a state to those of a row of inputs.
    #[inline(always)]
    pub fn impose(&self, u: &[T], state: &mut [T]) {
        for (k, &c) in self.imposed.iter().enumerate() {
            let motion = self.sizes.inputs + MOTION * k;
            state[c] = u[motion];
            state[c + self.sizes.coordinates] = u[motion + 1];
        }
    }

    /// The forces that impose motion, one an imposed coordinate ([`Model::imposed`]), at a whole
    /// state whose imposed entries are those of the row of inputs.
    #[must_use]
    pub fn imposing(&self, at: (f64, &[T], &[T])) -> Vec<T> {
        let zero = T::constant(0.0);
        let mut variables = vec![zero; self.sizes.variables()];
        let mut outputs = vec![zero; self.sizes.rates()];
        let mut derivative = vec![zero; self.width()];
        self.variables(at, &mut variables);
        self.bound.evaluate_once(&variables, &mut outputs);
        self.push(at, &mut outputs, &mut derivative);
        let n = self.sizes.coordinates;
        let pushed = outputs.clone();
        self.solve(at, &mut outputs, &mut derivative);
        let (mass, force) = pushed.split_at(n * n);
        let accelerations = &derivative[n..2 * n];
        let on = |&c: &usize| {
            let row = mass[c * n..(c + 1) * n].iter().zip(accelerations);
            row.fold(-force[c], |sum, (m, a)| sum + *m * *a)
        };
        self.imposed.iter().map(on).collect()
    }

    /// Length of the machine's state, memory apart.
    #[must_use]
    pub fn machine_states(&self) -> usize {
        self.sizes.machine_states()
    }

    /// Length of the whole state.
    #[must_use]
    pub fn width(&self) -> usize {
        self.machine_states() + self.memory
    }

    /// The whole state for a state of the machine: the effects' memory is at rest there.
    #[must_use]
    pub fn at_rest(&self, machine: &[f64]) -> Vec<f64> {
        let mut state = machine.to_vec();
        state.resize(machine.len() + self.memory, 0.0);
        for force in &self.forces {
            force.rest(machine, &mut state);
        }
        state
    }

    /// Room to evaluate this system in.
    #[must_use]
    pub fn workspace(&self) -> Workspace<T> {
        let zero = T::constant(0.0);
        let width = self.width();
        Workspace {
            room: self.bound.room(),
            variables: vec![zero; self.sizes.variables()],
            outputs: vec![zero; self.sizes.rates()],
            slope: std::array::from_fn(|_| vec![zero; width]),
            stage: vec![zero; width],
            input: vec![zero; self.input_width()],
            shared: match self.implicit() {
                Some(implicit) => {
                    let Sizes { coordinates, .. } = self.sizes;
                    let lengths = (coordinates, self.sizes.variables(), self.sizes.rates());
                    Shared::new(implicit.room(), lengths)
                }
                None => Shared::default(),
            },
            steep: {
                let Sizes { coordinates, states, .. } = self.sizes;
                Steep::new(coordinates, states)
            },
            plan: Plan::default(),
            begin: vec![],
            steps: 0,
        }
    }

    /// Its dynamics where derivatives are taken by way of known accelerations.
    #[inline(always)]
    pub(super) fn implicit(&self) -> Option<&dyn Implicit<T>> {
        if self.imposed.is_empty() { self.bound.implicit() } else { None }
    }

    /// Whether an effect adds to the mass matrix.
    #[inline(always)]
    pub(super) fn is_inertial(&self) -> bool {
        self.forces.iter().any(Force::is_inertial)
    }

    /// Advance the state from `times.0` to `times.1` by RK4 steps.
    pub fn advance(
        &self,
        w: &mut Workspace<T>,
        times: (f64, f64),
        inputs: StepInput<T>,
        substeps: Substeps,
        state: &mut [T],
    ) {
        let alone = Strand { system: self, workspace: w, inputs, state };
        advance_together(&mut [alone], times, substeps);
    }

    /// Whether anything but a position, whose slope never jumps, has slopes that jump within the step, or derivatives
    /// whose slopes do: what rests in stiff friction has slopes of 0 whatever the step, and its derivatives must not
    /// run away there.
    #[inline(always)]
    pub(super) fn jumps(&self, w: &Workspace<T>, state: &[T]) -> bool {
        let entries = self.sizes.coordinates..self.width();
        (0..T::PARTS).any(|part| {
            let share = if part == 0 { JUMP } else { JUMP_OF_DERIVATIVES };
            // What holds a velocity and what pushes it cancel where it rests.
            let held = |i: usize| w.steep.rate(i) * state[i].part(part).abs();
            jumps(share, entries.clone(), |i, k| w.slope[k][i].part(part), held)
        })
    }

    /// The slope of one RK4 stage: at `state` moved by a step along the slope before it.
    #[inline(always)]
    fn stage<B: BoundDynamics<T> + ?Sized>(
        &self,
        bound: &B,
        w: &mut Workspace<T>,
        k: usize,
        (t, place): (f64, Place),
        inputs: StepInput<T>,
        (state, step): (&[T], f64),
    ) {
        self.begin_stage(w, k, (t, place), inputs, (state, step));
        let Workspace { room, variables, outputs, slope, stage, input, steep, .. } = w;
        // No closure stands between: it would be compiled apart, for the narrowest vectors.
        bound.evaluate(room, variables, outputs);
        let at = (t, &stage[..], &input[..]);
        self.push(at, outputs, &mut slope[k]);
        if k == 0 && self.damp(at, steep) {
            steep.over_mass(&outputs[..self.sizes.coordinates.pow(2)], &self.imposed);
        }
        self.solve(at, outputs, &mut slope[k]);
        steep.relative(k, step, state, stage, &mut slope[k]);
    }

    /// Find how steeply forces fall with the velocities; whether any does.
    #[inline(always)]
    pub(super) fn damp(&self, at: (f64, &[T], &[T]), steep: &mut Steep) -> bool {
        self.dry
            && steep.find(|steepness| {
                let mut falls = false;
                for force in &self.forces {
                    falls |= force.damp(at, steepness);
                }
                falls
            })
    }

    /// Whether velocities are steep about rest.
    #[inline(always)]
    pub(super) fn is_dry(&self) -> bool {
        self.dry
    }

    /// What a stage is evaluated at: the state moved along the slope before it, and the inputs.
    #[inline(always)]
    pub(super) fn begin_stage(
        &self,
        w: &mut Workspace<T>,
        k: usize,
        (t, place): (f64, Place),
        inputs: StepInput<T>,
        (state, step): (&[T], f64),
    ) {
        inputs.at(place, &mut w.input);
        for (j, change) in &self.change {
            w.input[*j] = w.input[*j] + *change;
        }
        if k > 0 {
            let slopes = &w.slope[k - 1];
            for ((moved, x), slope) in w.stage.iter_mut().zip(state).zip(slopes) {
                T::by_itself();
                *moved = *x + *slope * step;
            }
            w.steep.moved(k, step, state, &w.slope, &mut w.stage);
        } else {
            copy(state, &mut w.stage);
        }
        self.impose(&w.input, &mut w.stage);
        self.variables((t, &w.stage, &w.input), &mut w.variables);
    }

    /// What the dynamics are evaluated at.
    #[inline(always)]
    pub(super) fn variables(&self, (t, state, u): (f64, &[T], &[T]), variables: &mut [T]) {
        let (machine, m) = (self.machine_states(), self.sizes.inputs);
        copy(&state[..machine], &mut variables[..machine]);
        copy(&u[..m], &mut variables[machine..machine + m]);
        variables[machine + m] = T::constant(t);
    }

    /// Add forces and effects to what the dynamics evaluate to, and write the memory's rates.
    #[inline(always)]
    pub(super) fn push(
        &self,
        (t, state, u): (f64, &[T], &[T]),
        outputs: &mut [T],
        derivative: &mut [T],
    ) {
        let n = self.sizes.coordinates;
        let (mass, force) = outputs.split_at_mut(n * n);
        for (f, p) in force.iter_mut().zip(&self.push) {
            T::by_itself();
            *f = *f + *p;
        }
        for f in &self.forces {
            f.add((t, state, u), (n, mass), force, derivative);
        }
    }

    /// Rates of the machine's state.
    #[inline(always)]
    fn solve(&self, (_, state, u): (f64, &[T], &[T]), outputs: &mut [T], derivative: &mut [T]) {
        let machine = self.machine_states();
        let n = self.sizes.coordinates;
        let (mass, force) = outputs.split_at_mut(n * n);
        let acceleration = |k: usize| u[self.sizes.inputs + MOTION * k + 2];
        impose(&self.imposed, acceleration, mass, &mut force[..n]);
        solve_mass(mass, &mut force[..n]);
        copy(&state[n..2 * n], &mut derivative[..n]);
        copy(force, &mut derivative[n..machine]);
    }
}

/// Steps of one system, on their way through the dynamics.
pub struct Step<'a, T: Number> {
    pub(super) strand: Strand<'a, T>,
    /// Where those beside it cut their steps.
    pub(super) plan: Option<&'a mut Plan>,
    pub(super) times: (f64, f64),
    pub(super) substeps: Substeps,
}

impl<T: Number> Step<'_, T> {
    /// Take it along dynamics of a known type.
    pub(crate) fn along<B: BoundDynamics<T> + ?Sized>(self, bound: &B) {
        // One copy of what follows for every width of vectors: the lanes of dual numbers fill
        // the widest.
        pulp::Arch::new().dispatch(Along { step: self, bound });
    }
}

/// A step with the dynamics that it is taken along, to be dispatched.
struct Along<'a, T: Number, B: ?Sized> {
    step: Step<'a, T>,
    bound: &'a B,
}

impl<T: Number, B: BoundDynamics<T> + ?Sized> pulp::WithSimd for Along<'_, T, B> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: pulp::Simd>(self, _simd: S) {
        let Self { step: Step { mut strand, plan, times, substeps }, bound } = self;
        let made = substeps.take(times, &mut Alone { strand: &mut strand, plan, bound });
        strand.workspace.steps += made;
    }
}

/// A system that goes on by itself.
struct Alone<'s, 'a, T: Number, B: ?Sized> {
    strand: &'s mut Strand<'a, T>,
    plan: Option<&'a mut Plan>,
    bound: &'s B,
}

impl<T: Number, B: BoundDynamics<T> + ?Sized> Stepped for Alone<'_, '_, T, B> {
    #[inline(always)]
    fn stage(&mut self, k: usize, at: (f64, Place), step: f64) {
        let Strand { system, workspace: w, inputs, state } = &mut *self.strand;
        system.stage(self.bound, w, k, at, *inputs, (state, step));
    }

    #[inline(always)]
    fn jumps(&self) -> bool {
        let Strand { system, workspace, state, .. } = &*self.strand;
        system.jumps(workspace, state)
    }

    #[inline(always)]
    fn turns(&self) -> bool {
        self.strand.system.is_dry()
    }

    #[inline(always)]
    fn complete(&mut self, h: f64) {
        let Strand { system, workspace: w, state, .. } = &mut *self.strand;
        w.complete(h, state);
        system.impose(&w.input, state);
    }

    #[inline(always)]
    fn is_planned(&self, part: Part) -> bool {
        self.plan.as_ref().is_some_and(|plan| plan.holds(part))
    }

    #[inline(always)]
    fn plan(&mut self, part: Part) {
        if let Some(plan) = &mut self.plan {
            plan.add(part);
        }
    }
}

/// Room for [`System::advance`].
#[derive(Clone, Debug)]
pub struct Workspace<T> {
    room: Room<T>,
    pub(super) variables: Vec<T>,
    pub(super) outputs: Vec<T>,
    pub(super) slope: [Vec<T>; 4],
    pub(super) stage: Vec<T>,
    pub(super) input: Vec<T>,
    pub(super) shared: Shared,
    pub(super) steep: Steep,
    /// Where those beside it cut their steps.
    pub(super) plan: Plan,
    /// The state with which the way to the next sample began.
    pub(super) begin: Vec<T>,
    pub(super) steps: usize,
}

impl<T: Number> Workspace<T> {
    /// How many Runge-Kutta steps were made in it, those that were cut among them.
    #[must_use]
    pub fn steps(&self) -> usize {
        self.steps
    }

    /// Complete a step of Runge-Kutta from its four slopes.
    #[inline(always)]
    pub(super) fn complete(&mut self, h: f64, state: &mut [T]) {
        let Self { slope, stage, steep, .. } = self;
        steep.ended(h, state, slope, stage);
        let [k1, k2, k3, k4] = slope;
        for (i, x) in state.iter_mut().enumerate() {
            let sum = k1[i] + (k2[i] + k3[i]) * 2.0 + k4[i];
            *x = *x + sum * (h / 6.0);
        }
        steep.set(h, stage, state);
    }
}

impl Plant for System {
    fn order(&self) -> usize {
        if self.sizes.states == 0 { 2 } else { 1 }
    }

    fn dimension(&self) -> usize {
        let sizes = self.sizes;
        if sizes.states == 0 { sizes.coordinates } else { sizes.machine_states() }
    }

    fn inputs(&self) -> usize {
        self.input_width()
    }

    fn states(&self) -> usize {
        self.width()
    }

    fn derivative(&self, t: f64, state: &[f64], u: &[f64], derivative: &mut [f64]) {
        if !self.imposed.is_empty() {
            let mut imposed = state.to_vec();
            self.impose(u, &mut imposed);
            return self.derivative_at((t, &imposed, u), derivative);
        }
        self.derivative_at((t, state, u), derivative);
    }
}

impl System {
    /// Rates of a state whose imposed entries are those of the inputs.
    fn derivative_at(&self, (t, state, u): (f64, &[f64], &[f64]), derivative: &mut [f64]) {
        let (variables, outputs) = (self.sizes.variables(), self.sizes.rates());
        let mut rates = |v: &mut [f64], o: &mut [f64]| {
            self.variables((t, state, u), v);
            self.bound.evaluate_once(v, o);
            self.push((t, state, u), o, derivative);
            self.solve((t, state, u), o, derivative);
        };
        if variables <= ON_STACK && outputs <= ON_STACK {
            let (mut v, mut o) = ([0.0; ON_STACK], [0.0; ON_STACK]);
            rates(&mut v[..variables], &mut o[..outputs]);
        } else {
            rates(&mut vec![0.0; variables], &mut vec![0.0; outputs]);
        }
    }
}
