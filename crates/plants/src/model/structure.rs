//! Effects on a robot's structure, as further parameters of its dynamics
//! ([`crate::dynamics::Dynamics::tree`]), behind which those within servos stand.

use super::{Direction, Model, ModelEffect};
use crate::dynamics::{SERVO, felt};
use lacuna_effects::law::{BODY, TILT};
use lacuna_effects::{Acts, AnyStructureLaw, BASE, Effect, Law, StructureLawIn};
use lacuna_numbers::{Dual, Number};
use std::collections::HashSet;
use std::ops::Range;

/// The law of an effect on structure.
fn law(e: &ModelEffect) -> Option<&'static dyn AnyStructureLaw> {
    if let Law::Structure(law) = e.effect.law { Some(law) } else { None }
}

impl Model {
    /// Parameters of the dynamics: those of the model, and behind them what these effects make of its
    /// structure, where any does.
    #[must_use]
    pub fn with_structure(&self, parameters: &[f64], effects: &[ModelEffect]) -> Vec<f64> {
        let plain = |law: &'static dyn AnyStructureLaw| law.plain();
        self.appended(parameters.to_vec(), effects, plain, |_, e| e.internal())
    }

    /// The same with derivatives by internal parameters of effects that are among the directions, each in
    /// its lane.
    #[must_use]
    pub fn with_structure_along(
        &self,
        parameters: Vec<Dual>,
        effects: &[ModelEffect],
        directions: &[(Direction, usize)],
    ) -> Vec<Dual> {
        let dual = |law: &'static dyn AnyStructureLaw| law.dual();
        self.appended(parameters, effects, dual, |index, e| {
            e.internal_along(Direction::of_effect(directions, index))
        })
    }

    fn appended<T: Number>(
        &self,
        mut parameters: Vec<T>,
        effects: &[ModelEffect],
        in_this_number: impl Fn(&'static dyn AnyStructureLaw) -> &'static dyn StructureLawIn<T>,
        internal: impl Fn(usize, &ModelEffect) -> Vec<T>,
    ) -> Vec<T> {
        for (index, e) in effects.iter().enumerate() {
            self.add_to_servos(&mut parameters, e, || internal(index, e));
            let Some(law) = law(e) else { continue };
            parameters.resize(self.structure_end(), T::constant(0.0));
            let numbers = in_this_number(law).numbers(&internal(index, e));
            let places = self.structure_of(e.effect.acts, e.channel);
            for (sum, number) in parameters[places].iter_mut().zip(numbers) {
                *sum = *sum + number;
            }
        }
        parameters
    }

    /// Where the numbers of an effect on structure stand among the parameters of the dynamics.
    #[must_use]
    pub fn structure_of(&self, acts: Acts, channel: usize) -> Range<usize> {
        let begin = self.dynamics.sizes().parameters;
        match acts {
            Acts::Base => self.base()..self.base() + TILT,
            _ => begin + BODY * channel..begin + BODY * (channel + 1),
        }
    }

    /// Where the numbers of the base stand.
    fn base(&self) -> usize {
        let bodies = self.dynamics.tree().map_or(0, |tree| tree.bodies.len());
        self.dynamics.sizes().parameters + BODY * bodies
    }

    /// Length of the dynamics' parameters with their structure, and with what is left out of their servos.
    #[must_use]
    pub fn structure_end(&self) -> usize {
        self.base() + TILT + SERVO * self.dynamics.servos().len()
    }

    /// Coordinates whose forces an effect on structure changes along a given motion: the joints between a link
    /// and the ground, or all that stand on the base.
    #[must_use]
    pub fn joints_under(&self, acts: Acts, channel: usize) -> Vec<usize> {
        let Some(tree) = self.dynamics.tree() else { return vec![] };
        if acts == Acts::Base {
            return (0..tree.coordinates()).collect();
        }
        let mut joints: Vec<usize> =
            tree.path(channel).map(|body| tree.bodies[body].joint.coordinate).collect();
        joints.reverse();
        let mut seen = HashSet::new();
        joints.retain(|joint| seen.insert(*joint));
        joints
    }

    /// Whether an effect on structure can do what the inertia of one joint's rotor cannot: it changes the
    /// forces of several joints, or those of gravity. On what turns about a vertical axis alone a payload
    /// is no more than inertia about it.
    #[must_use]
    pub fn tells_structure(&self, acts: Acts, channel: usize) -> bool {
        if self.joints_under(acts, channel).len() > 1 {
            return true;
        }
        let mut parameters = self.values();
        parameters.resize(self.structure_end(), 0.0);
        let (sizes, numbers) = (self.dynamics.sizes(), self.structure_of(acts, channel));
        // At rest, in a place like any other.
        let mut at: Vec<f64> = (1..=sizes.coordinates).map(|k| 0.618 * k as f64).collect();
        at.resize(sizes.variables(), 0.0);
        let forces = sizes.coordinates * sizes.coordinates;
        felt(&*self.dynamics, (&parameters, numbers), (&at, forces)).contains(&true)
    }

    /// Names of what an effect on structure can act on: the links that move, the base; nothing where the
    /// model is no robot's.
    #[must_use]
    pub fn structures(&self, effect: &Effect) -> Vec<&str> {
        match (self.dynamics.tree(), effect.acts) {
            (None, _) => vec![],
            (Some(_), Acts::Base) => vec![BASE],
            (Some(tree), _) => tree.bodies.iter().map(|b| &*b.name).collect(),
        }
    }
}
