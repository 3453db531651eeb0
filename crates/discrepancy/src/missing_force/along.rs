//! The model linearised about a recording's smoothed motion.

use super::Belief;
use super::measured::MeasuredForce;
use crate::likelihood::Problem;
use crate::trajectories::SmoothedRecording;
use lacuna_effects::{AnyForceLaw, At, Channel, Law};
use lacuna_numbers::{Dual, LANES, Number};
use lacuna_plants::model::{Direction, ModelEffect, System};
use lacuna_plants::{Hold, Model};

/// What a recording's smoothed motion asks of the model, sample by sample: the residual
/// R = M q'' - F of every coordinate and h' - D of every first-order state, and its derivatives.
pub(super) struct Along<'p> {
    pub motion: &'p SmoothedRecording,
    /// Number of the recording.
    pub recording: usize,
    /// R, samples x channels.
    residual: Vec<f64>,
    /// By how much an input that jumps at the sample makes R jump, samples x channels.
    jump: Vec<f64>,
    /// M, samples x coordinates x coordinates.
    mass: Vec<f64>,
    /// dR/dx for every entry x of the machine's state, samples x channels x states.
    by_state: Vec<f64>,
    /// dR/dp for every uncertain parameter, samples x channels x parameters.
    by_parameter: Vec<f64>,
    /// The measured force on each channel that is imposed.
    measured: Vec<Option<MeasuredForce>>,
    coordinates: usize,
    channels: usize,
    states: usize,
    parameters: usize,
}

/// Entries of which the residual's derivatives are taken: states, then uncertain parameters.
struct Directions<'a> {
    states: usize,
    parameters: &'a [usize],
}

impl<'p> Along<'p> {
    /// Evaluate the model along recording `r`.
    pub(super) fn new(problem: &'p Problem, belief: &Belief, r: usize) -> Self {
        let model = problem.model;
        let motion = &problem.smoothed[r];
        let (samples, channels) = (motion.len(), model.channels());
        let (coordinates, states) = (model.coordinates.len(), model.machine_states());
        let parameters = belief.uncertain.len();
        let mut this = Self {
            motion,
            recording: r,
            residual: vec![0.0; samples * channels],
            jump: vec![0.0; samples * channels],
            mass: vec![0.0; samples * coordinates * coordinates],
            by_state: vec![0.0; samples * channels * states],
            by_parameter: vec![0.0; samples * channels * parameters],
            measured: (0..channels).map(|c| MeasuredForce::of(problem, r, c)).collect(),
            coordinates,
            channels,
            states,
            parameters,
        };
        let inputs = problem.effective_inputs(belief.effects, &problem.dataset.recordings[r]);
        let directions = Directions { states, parameters: &belief.uncertain };
        for first in (0..states + parameters).step_by(LANES) {
            this.differentiate(problem, belief, &inputs, &directions, first);
            this.compare_forces(problem, belief, &inputs, &directions, first);
        }
        if model.hold == Hold::ZeroOrder {
            this.follow_jumps(problem, belief, &inputs);
        }
        for effect in belief.effects {
            if let Law::Force(law) = effect.effect.law {
                this.add_effect(model, law, effect);
            }
        }
        this
    }

    /// The residual, and its derivatives in the [`LANES`] directions from `first` on.
    fn differentiate(
        &mut self,
        problem: &Problem,
        belief: &Belief,
        inputs: &[f64],
        directions: &Directions,
        first: usize,
    ) {
        let (n, m) = (self.coordinates, problem.model.inputs.len());
        let width = problem.model.input_width();
        let lane = |entry: usize| entry.checked_sub(first).filter(|l| *l < LANES);
        let mut parameters: Vec<Dual> =
            belief.parameters.iter().map(|&p| Dual::constant(p)).collect();
        for (k, &p) in directions.parameters.iter().enumerate() {
            if let Some(lane) = lane(directions.states + k) {
                parameters[p] = Dual::direction(belief.parameters[p], lane);
            }
        }
        let dynamics = problem.model.dynamics();
        let parameters = problem.model.with_structure_along(parameters, belief.effects, &[]);
        let bound = dynamics.bind_dual(&parameters);
        let mut room = bound.room();
        let mut outputs = vec![Dual::constant(0.0); dynamics.sizes().rates()];
        let mut variables = vec![Dual::constant(0.0); self.states + m + 1];
        for k in 0..self.motion.len() {
            for (i, &x) in self.motion.state(k).iter().enumerate() {
                variables[i] =
                    lane(i).map_or_else(|| Dual::constant(x), |lane| Dual::direction(x, lane));
            }
            let rest = inputs[k * width..k * width + m].iter().chain(&self.motion.times[k..=k]);
            for (to, &value) in variables[self.states..].iter_mut().zip(rest) {
                *to = Dual::constant(value);
            }
            bound.evaluate(&mut room, &variables, &mut outputs);
            let (mass, force) = outputs.split_at(n * n);
            for (to, from) in self.mass[k * n * n..].iter_mut().zip(mass) {
                *to = from.value;
            }
            for (c, force) in force.iter().enumerate() {
                let residual = if c < n {
                    (0..n).fold(Dual::constant(0.0), |sum, j| {
                        sum + mass[c * n + j] * Dual::constant(self.motion.rate(k, n + j))
                    })
                } else {
                    Dual::constant(self.motion.rate(k, c + n))
                };
                self.set((k, c), residual - *force, first);
            }
        }
    }

    /// Set R of a channel at a sample with its derivatives in the directions from `first` on.
    fn set(&mut self, (k, c): (usize, usize), residual: Dual, first: usize) {
        let row = k * self.channels + c;
        self.residual[row] = residual.value;
        for (l, &slope) in residual.tangent.iter().enumerate() {
            let entry = first + l;
            if entry < self.states {
                self.by_state[row * self.states + entry] = slope;
            } else if entry < self.states + self.parameters {
                self.by_parameter[row * self.parameters + entry - self.states] = slope;
            }
        }
    }

    /// Of imposed coordinates, R is what the measured force shows; that of others stays.
    fn compare_forces(
        &mut self,
        problem: &Problem,
        belief: &Belief,
        inputs: &[f64],
        directions: &Directions,
        first: usize,
    ) {
        if self.measured.iter().all(Option::is_none) {
            return;
        }
        let lane = |entry: usize| entry.checked_sub(first).filter(|l| *l < LANES);
        let parameters = directions.parameters.iter().enumerate();
        let moved: Vec<(Direction, usize)> = parameters
            .filter_map(|(k, &p)| Some((Direction::Parameter(p), lane(directions.states + k)?)))
            .collect();
        let model = problem.model;
        let system = System::along(model, &belief.parameters, &[], &moved, problem.sample);
        let width = model.input_width();
        let mut y = vec![Dual::constant(0.0); problem.dataset.outputs.len()];
        for k in 0..self.motion.len() {
            let state = self.motion.state(k).iter().enumerate();
            let state: Vec<Dual> = state.map(|(i, &x)| Dual::among(x, i, first)).collect();
            let u = inputs[k * width..(k + 1) * width].iter().map(|&u| Dual::constant(u));
            let u: Vec<Dual> = u.collect();
            problem.observation.evaluate(&system, self.motion.times[k], &state, &u, &mut y);
            for c in 0..self.channels {
                let Some(force) = &self.measured[c] else { continue };
                let short = (-y[force.output] + force.values[k]) / force.slope;
                self.set((k, c), short, first);
            }
        }
    }

    /// Inputs are held: at a sample the force takes the mean of what it is before and after.
    fn follow_jumps(&mut self, problem: &Problem, belief: &Belief, inputs: &[f64]) {
        let (n, m) = (self.coordinates, problem.model.inputs.len());
        let width = problem.model.input_width();
        let dynamics = problem.model.dynamics();
        let parameters = problem.model.with_structure(&belief.parameters, belief.effects);
        let bound = dynamics.bind(&parameters);
        let mut room = bound.room();
        let mut outputs = vec![0.0; dynamics.sizes().rates()];
        let mut variables = vec![0.0; self.states + m + 1];
        let mut forces = |k: usize, u: &[f64], into: &mut Vec<f64>| {
            variables[..self.states].copy_from_slice(self.motion.state(k));
            variables[self.states..self.states + m].copy_from_slice(u);
            variables[self.states + m] = self.motion.times[k];
            bound.evaluate(&mut room, &variables, &mut outputs);
            into.clear();
            into.extend_from_slice(&outputs[n * n..]);
        };
        let (mut before, mut after) = (Vec::new(), Vec::new());
        for k in 1..self.motion.len() {
            let row = |k: usize| &inputs[k * width..k * width + m];
            let (u, next) = (row(k - 1), row(k));
            if u == next {
                continue;
            }
            forces(k, u, &mut before);
            forces(k, next, &mut after);
            // A force that is measured jumps with the inputs.
            for c in (0..self.channels).filter(|&c| self.measured[c].is_none()) {
                let jump = before[c] - after[c];
                self.jump[k * self.channels + c] = jump;
                self.residual[k * self.channels + c] -= 0.5 * jump;
            }
        }
    }

    /// Take the force of an effect out of the residual; memory is taken to run on unchanged.
    fn add_effect(&mut self, model: &Model, law: &dyn AnyForceLaw, effect: &ModelEffect) {
        let internal = law.internal(&effect.parameters);
        let (amplitudes, shape) = internal.split_at(law.amplitudes());
        let channels = model.places(effect.effect, effect.channel, effect.other);
        let series = self.motion.basis(law, shape, &channels);
        let passed_on = law.plain().passed_on(shape);
        let sides = [(effect.channel, 1.0)].into_iter();
        let sides: Vec<(usize, f64)> =
            sides.chain(effect.other.filter(|_| law.reacts()).map(|o| (o, -passed_on))).collect();
        // An input is no part of the state.
        let moving = if effect.effect.names_input() { 1 } else { channels.len() };
        let slopes = Slopes::of(self, law, (&channels, moving), (amplitudes, shape));
        for k in 0..self.motion.len() {
            let force: f64 = amplitudes.iter().zip(&series).map(|(a, b)| a * b[k]).sum();
            for &(c, sign) in &sides {
                let row = k * self.channels + c;
                self.residual[row] -= sign * force;
                for (state, slope) in slopes.at(k) {
                    self.by_state[row * self.states + state] -= sign * slope;
                }
            }
        }
    }

    /// Let the residual of a channel lose a force over entry `state` of the machine's state whose
    /// slope at sample k is `slope(k)`: the force itself is left to be learned, but the path's
    /// errors move it.
    pub(super) fn add_slope(&mut self, channel: usize, state: usize, slope: impl Fn(usize) -> f64) {
        for k in 0..self.motion.len() {
            let row = k * self.channels + channel;
            self.by_state[row * self.states + state] -= slope(k);
        }
    }

    /// R of a channel at sample `k`.
    pub(super) fn residual(&self, k: usize, channel: usize) -> f64 {
        self.residual[k * self.channels + channel]
    }

    /// By how much R of a channel jumps at sample `k`.
    pub(super) fn jump(&self, k: usize, channel: usize) -> f64 {
        self.jump[k * self.channels + channel]
    }

    /// M_cj at sample `k`; zero for a first-order state.
    pub(super) fn mass(&self, k: usize, channel: usize, j: usize) -> f64 {
        let n = self.coordinates;
        if channel < n { self.mass[(k * n + channel) * n + j] } else { 0.0 }
    }

    /// dR/dx of a channel at sample `k`, for an entry of the machine's state.
    pub(super) fn by_state(&self, k: usize, channel: usize, state: usize) -> f64 {
        self.by_state[(k * self.channels + channel) * self.states + state]
    }

    /// dR/dp of a channel at sample `k`, for all uncertain parameters.
    pub(super) fn by_parameters(&self, k: usize, channel: usize) -> &[f64] {
        let row = k * self.channels + channel;
        &self.by_parameter[row * self.parameters..(row + 1) * self.parameters]
    }

    /// The measured force on an imposed channel.
    pub(super) fn measured(&self, channel: usize) -> Option<&MeasuredForce> {
        self.measured[channel].as_ref()
    }

    /// The part of R that moves with the motion's highest derivative, M q'' or h'; of an imposed
    /// channel the force that is measured.
    pub(super) fn inertia(&self, k: usize, channel: usize) -> f64 {
        if let Some(force) = self.measured(channel) {
            return force.force(k);
        }
        let n = self.coordinates;
        if channel < n {
            (0..n).map(|j| self.mass(k, channel, j) * self.motion.rate(k, n + j)).sum()
        } else {
            self.motion.rate(k, channel + n)
        }
    }
}

/// Derivatives of an effect's force by the entries of the machine's state that it sees: those of
/// the first `moving` of its channels.
struct Slopes {
    states: Vec<usize>,
    /// Samples x states.
    values: Vec<f64>,
}

impl Slopes {
    fn of(
        along: &Along,
        law: &dyn AnyForceLaw,
        (channels, moving): (&[Channel], usize),
        (amplitudes, shape): (&[f64], &[f64]),
    ) -> Self {
        let motion = along.motion;
        let mut states: Vec<usize> = channels[..moving].iter().flat_map(|c| [c.q, c.v]).collect();
        states.sort_unstable();
        states.dedup();
        if law.memory() > 0 || states.len() > LANES {
            return Self { states: vec![], values: vec![] };
        }
        let constants =
            |values: &[f64]| -> Vec<Dual> { values.iter().map(|&v| Dual::constant(v)).collect() };
        let (amplitudes, shape) = (constants(amplitudes), constants(shape));
        let mut values = Vec::with_capacity(motion.len() * states.len());
        for k in 0..motion.len() {
            let here = motion.at(channels, k);
            let (mut state, inputs) = (constants(here.state), constants(here.inputs));
            for (lane, &i) in states.iter().enumerate() {
                state[i] = Dual::direction(here.state[i], lane);
            }
            let at = At {
                t: here.t,
                sample: here.sample,
                state: &state,
                channels,
                inputs: &inputs,
                memory: &[],
                acceleration: Dual::constant(here.acceleration),
            };
            let force = law.dual().force(&amplitudes, &shape, &at);
            values.extend_from_slice(&force.tangent[..states.len()]);
        }
        Self { states, values }
    }

    fn at(&self, k: usize) -> impl Iterator<Item = (usize, f64)> + '_ {
        let width = self.states.len();
        self.states.iter().copied().zip(self.values[k * width..].iter().copied())
    }
}
