//! A force effect inside the equations of motion, in any kind of number.

use super::ModelEffect;
use lacuna_effects::{ForceLaw, Local, MOST_AMPLITUDES};
use lacuna_numbers::{Dual, LANES, Number};

/// A force effect, its parameters turned to amplitudes and shape.
#[derive(Clone, Debug)]
pub(super) struct Force<T> {
    law: &'static dyn ForceLaw,
    channel: usize,
    other: Option<usize>,
    amplitudes: Vec<T>,
    shape: Vec<T>,
    /// Values of the shape, as laws take them.
    plain: Vec<f64>,
    /// Steps of differences with respect to the shape.
    steps: Vec<f64>,
    /// Where its memory begins in the memory of all.
    memory: usize,
}

/// Most memory states, and most shape parameters, of a law.
const MOST_MEMORY: usize = 4;
const MOST_SHAPES: usize = 4;
/// Variables of a law beside its memory and shape.
const VARIABLES: usize = 4;

impl<T: Number> Force<T> {
    pub(super) fn new(
        law: &'static dyn ForceLaw,
        effect: &ModelEffect,
        mut internal: Vec<T>,
        memory: usize,
    ) -> Self {
        let shape = internal.split_off(law.amplitudes());
        let plain: Vec<f64> = shape.iter().map(|s| s.value()).collect();
        let steps = plain.iter().map(|s| 1e-6 * s.abs() + 1e-12).collect();
        let ModelEffect { channel, other, .. } = *effect;
        Self { law, channel, other, amplitudes: internal, shape, plain, steps, memory }
    }

    /// Differences with respect to the shape that samples so far apart can see.
    pub(super) fn resolve(&mut self, sample: f64) {
        for (k, step) in self.steps.iter_mut().enumerate() {
            *step = step.max(self.law.resolution(k, sample));
        }
    }

    /// Write the memory at rest into a state; it begins at `machine`.
    pub(super) fn rest(&self, coordinates: usize, state: &mut [f64], machine: usize) {
        let at = local(&self.variables(coordinates, state), 0.0);
        let begin = machine + self.memory;
        self.law.memory_at_rest(&at, &mut state[begin..begin + self.law.memory()]);
    }

    /// The law's variables: coordinate and velocity of the channel, then of the other one.
    /// Velocities of coordinates stand `coordinates` after them; a first-order state stands so
    /// far after its channel's number and is its own velocity.
    fn variables<N: Number>(&self, coordinates: usize, state: &[N]) -> [N; VARIABLES] {
        let n = coordinates;
        let q = |c: usize| if c < n { state[c] } else { state[c + n] };
        let zero = N::constant(0.0);
        let (other_q, other_v) = self.other.map_or((zero, zero), |o| (q(o), state[o + n]));
        [q(self.channel), state[self.channel + n], other_q, other_v]
    }

    /// Add the force to the generalised forces and write the memory's rate. `sizes` are the
    /// numbers of coordinates and of machine states.
    #[inline(always)]
    pub(super) fn add(
        &self,
        sizes: (usize, usize),
        t: f64,
        state: &[T],
        force: &mut [T],
        derivative: &mut [T],
    ) {
        let variables = self.variables(sizes.0, state);
        let range = sizes.1 + self.memory..sizes.1 + self.memory + self.law.memory();
        let memory = &state[range.clone()];
        let sum = self.force(t, &variables, memory);
        force[self.channel] = force[self.channel] + sum;
        if let (true, Some(other)) = (self.law.reacts(), self.other) {
            force[other] = force[other] - sum;
        }
        if !range.is_empty() {
            self.rate(t, &variables, memory, &mut derivative[range]);
        }
    }

    /// Sum of amplitudes times basis.
    #[inline(always)]
    fn force(&self, t: f64, variables: &[T; VARIABLES], memory: &[T]) -> T {
        let count = self.amplitudes.len();
        let mut basis = [0.0; MOST_AMPLITUDES];
        let basis = &mut basis[..count];
        let point = Point::of(variables, memory, &self.plain);
        self.law.basis(point.shape(), &local(&point.variables, t), point.memory(), basis);
        let mut sum = T::constant(0.0);
        for (a, &b) in self.amplitudes.iter().zip(&*basis) {
            sum = sum + *a * b;
        }
        if sum.tangent().is_empty() {
            return sum;
        }
        let total = |p: &Point| {
            let mut basis = [0.0; MOST_AMPLITUDES];
            let basis = &mut basis[..count];
            self.law.basis(p.shape(), &local(&p.variables, t), p.memory(), basis);
            self.amplitudes.iter().zip(&*basis).map(|(a, b)| a.value() * b).sum::<f64>()
        };
        let here = sum.value();
        sum + self.chain(variables, memory, point, |p| total(p) - here)
    }

    fn rate(&self, t: f64, variables: &[T; VARIABLES], memory: &[T], rate: &mut [T]) {
        let count = memory.len();
        let point = Point::of(variables, memory, &self.plain);
        let values = |p: &Point| {
            let mut rate = [0.0; MOST_MEMORY];
            let at = local(&p.variables, t);
            self.law.memory_rate(p.shape(), &at, p.memory(), &mut rate[..count]);
            rate
        };
        let here = values(&point);
        for (k, rate) in rate.iter_mut().enumerate() {
            *rate = T::constant(here[k]);
            if !rate.tangent().is_empty() {
                *rate = *rate
                    + self.chain(variables, memory, point.clone(), |p| values(p)[k] - here[k]);
            }
        }
    }

    /// The derivatives of a function of the point that is 0 there, by differences with respect
    /// to whatever moves.
    fn chain(
        &self,
        variables: &[T; VARIABLES],
        memory: &[T],
        mut point: Point,
        change: impl Fn(&Point) -> f64,
    ) -> T {
        let mut sum = T::constant(0.0);
        let mut add = |x: &T, step: f64, entry: Entry| {
            if x.tangent().iter().all(|&t| t == 0.0) {
                return;
            }
            let before = point.get(entry);
            point.set(entry, before + step);
            let slope = change(&point) / step;
            point.set(entry, before);
            sum = sum + x.mapped(0.0, slope);
        };
        for (i, x) in variables.iter().enumerate() {
            add(x, state_step(x.value()), Entry::Variable(i));
        }
        for (i, x) in memory.iter().enumerate() {
            add(x, state_step(x.value()), Entry::Memory(i));
        }
        for (i, x) in self.shape.iter().enumerate() {
            add(x, self.steps[i], Entry::Shape(i));
        }
        sum
    }
}

/// Small beside the widths of any law, large beside rounding.
fn state_step(x: f64) -> f64 {
    1e-7 * x.abs() + 1e-9
}

fn local<N: Number>(variables: &[N; VARIABLES], t: f64) -> Local {
    let [q, v, other_q, other_v] = variables.map(Number::value);
    Local { t, q, v, other_q, other_v }
}

/// One entry of what a law sees.
#[derive(Clone, Copy)]
enum Entry {
    Variable(usize),
    Memory(usize),
    Shape(usize),
}

/// What a law sees, as values.
#[derive(Clone)]
struct Point {
    variables: [f64; VARIABLES],
    memory: [f64; MOST_MEMORY],
    memories: usize,
    shape: [f64; MOST_SHAPES],
    shapes: usize,
}

impl Point {
    fn of<T: Number>(variables: &[T; VARIABLES], memory: &[T], shape: &[f64]) -> Self {
        let mut this = Self {
            variables: variables.map(Number::value),
            memory: [0.0; MOST_MEMORY],
            memories: memory.len(),
            shape: [0.0; MOST_SHAPES],
            shapes: shape.len(),
        };
        for (to, from) in this.memory.iter_mut().zip(memory) {
            *to = from.value();
        }
        this.shape[..shape.len()].copy_from_slice(shape);
        this
    }

    fn memory(&self) -> &[f64] {
        &self.memory[..self.memories]
    }

    fn shape(&self) -> &[f64] {
        &self.shape[..self.shapes]
    }

    fn get(&self, entry: Entry) -> f64 {
        match entry {
            Entry::Variable(i) => self.variables[i],
            Entry::Memory(i) => self.memory[i],
            Entry::Shape(i) => self.shape[i],
        }
    }

    fn set(&mut self, entry: Entry, value: f64) {
        match entry {
            Entry::Variable(i) => self.variables[i] = value,
            Entry::Memory(i) => self.memory[i] = value,
            Entry::Shape(i) => self.shape[i] = value,
        }
    }
}

impl ModelEffect {
    /// The internal parameters: amplitudes and shape of a force effect; the parameters
    /// themselves of any other.
    #[must_use]
    pub fn internal(&self) -> Vec<f64> {
        match self.effect.law {
            lacuna_effects::Law::Force(law) => law.internal(&self.parameters),
            _ => self.parameters.clone(),
        }
    }

    /// Set the internal parameters.
    pub fn set_internal(&mut self, internal: &[f64]) {
        self.parameters = match self.effect.law {
            lacuna_effects::Law::Force(law) => law.physical(internal),
            _ => internal.to_vec(),
        };
    }

    /// The same with derivatives with respect to them, each in its lane.
    pub(super) fn internal_along(&self, lanes: impl Iterator<Item = (usize, usize)>) -> Vec<Dual> {
        let mut out: Vec<Dual> = self.internal().into_iter().map(Dual::constant).collect();
        for (j, lane) in lanes {
            debug_assert!(lane < LANES);
            out[j].tangent[lane] = 1.0;
        }
        out
    }
}
