//! A force effect inside the equations of motion, in any kind of number.

use super::{Model, ModelEffect};
use lacuna_effects::{AnyForceLaw, At, Channel, ForceLawIn, Law, Variable};
use lacuna_numbers::{Dual, LANES, Number};
use std::ops::Range;

/// A force effect, its parameters turned to amplitudes and shape.
#[derive(Clone, Debug)]
pub(super) struct Force<T: Number> {
    any: &'static dyn AnyForceLaw,
    law: &'static dyn ForceLawIn<T>,
    channel: usize,
    /// The channel on which its reaction acts.
    reaction: Option<usize>,
    /// Where the channel and the other one stand in the state.
    places: Vec<Channel>,
    amplitudes: Vec<T>,
    shape: Vec<T>,
    /// Whether it adds to the mass matrix.
    inertial: bool,
    /// Its memory in the whole state.
    memory: Range<usize>,
    /// Time from sample to sample, by which derivatives by the time of an event are told.
    sample: f64,
}

impl<T: Number> Force<T> {
    /// The effect with these internal parameters; its memory begins at `memory` in the state.
    pub(super) fn new(
        model: &Model,
        e: &ModelEffect,
        (any, law): (&'static dyn AnyForceLaw, &'static dyn ForceLawIn<T>),
        mut internal: Vec<T>,
        memory: usize,
        sample: f64,
    ) -> Self {
        let shape = internal.split_off(any.amplitudes());
        Self {
            any,
            law,
            channel: e.channel,
            reaction: e.other.filter(|_| any.reacts()),
            places: model.places(e.effect, e.channel, e.other),
            amplitudes: internal,
            shape,
            inertial: e.effect.depends_on.contains(&Variable::Acceleration),
            memory: memory..memory + any.memory(),
            sample,
        }
    }

    /// Whether it adds to the mass matrix.
    pub(super) fn is_inertial(&self) -> bool {
        self.inertial
    }

    /// Whether it is dry friction.
    pub(super) fn is_dry(&self) -> bool {
        self.law.is_dry()
    }

    /// Write the memory at rest into a state that begins with `machine`.
    pub(super) fn rest(&self, machine: &[f64], state: &mut [f64]) {
        let at = At::new(0.0, machine, &self.places);
        self.any.memory_at_rest(&at, &mut state[self.memory.clone()]);
    }

    /// What its law sees at a time, of the whole state and the inputs.
    #[inline(always)]
    fn at<'a>(&'a self, (t, state, inputs): (f64, &'a [T], &'a [T])) -> At<'a, T> {
        let memory = &state[self.memory.clone()];
        At { sample: self.sample, inputs, memory, ..At::new(t, state, &self.places) }
    }

    /// Add how steeply the force falls with the velocity to what its channels have of that; whether it falls.
    #[inline(always)]
    pub(super) fn damp(&self, at: (f64, &[T], &[T]), steepness: &mut [f64]) -> bool {
        let falls = self.law.steepness(&self.amplitudes, &self.shape, &self.at(at));
        // What drives has no rest.
        if falls.is_nan() || falls <= 0.0 {
            return false;
        }
        steepness[self.channel] += falls;
        if let Some(other) = self.reaction {
            steepness[other] += falls * self.law.passed_on(&self.shape).value().powi(2);
        }
        true
    }

    /// Add the force to the generalised forces and its inertia to the mass matrix (row-major, of
    /// so many coordinates), and write the memory's rate.
    #[inline(always)]
    pub(super) fn add(
        &self,
        at: (f64, &[T], &[T]),
        (coordinates, mass): (usize, &mut [T]),
        force: &mut [T],
        derivative: &mut [T],
    ) {
        let at = self.at(at);
        let sum = self.law.force(&self.amplitudes, &self.shape, &at);
        force[self.channel] = force[self.channel] + sum;
        if let Some(other) = self.reaction {
            force[other] = force[other] - sum * self.law.passed_on(&self.shape);
        }
        if self.inertial {
            let own = self.channel * coordinates + self.channel;
            mass[own] = mass[own] + self.law.inertia(&self.amplitudes, &self.shape, &at);
        }
        if !self.memory.is_empty() {
            self.law.memory_rate(&self.shape, &at, &mut derivative[self.memory.clone()]);
        }
    }
}

impl ModelEffect {
    /// The internal parameters: amplitudes and shape of a force effect; the parameters
    /// themselves of any other.
    #[must_use]
    pub fn internal(&self) -> Vec<f64> {
        match self.effect.law {
            Law::Force(law) => law.internal(&self.parameters),
            Law::Input(_) | Law::Sensor(_) | Law::Structure(_) => self.parameters.clone(),
        }
    }

    /// Set the internal parameters.
    pub fn set_internal(&mut self, internal: &[f64]) {
        self.parameters = match self.effect.law {
            Law::Force(law) => law.physical(internal),
            Law::Input(_) | Law::Sensor(_) | Law::Structure(_) => internal.to_vec(),
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
