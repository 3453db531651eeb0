//! What acts within the position servos of a model: of effects on their commands those that are felt behind the
//! comparison of command and position.
//!
//! A dead zone and a limit of an actuator whose input is a torque act on that. A servo's input is a position, and
//! they act on its error and on its force:
//!
//! ```text
//! tau = clamp(k_p e - k_d v, -limit, limit),    e = d - clamp(d, -half_width, half_width),    d = u - q
//! ```
//!
//! They are numbers behind the parameters of the dynamics ([`SERVO`]). Other effects on a command (a delay, a lag, a
//! gain) act on the command.

use super::{Model, ModelEffect};
use crate::dynamics::{BoundServo, Point, SERVO, Servo, Sizes};
use lacuna_effects::{Effect, InServo, Law};
use lacuna_numbers::Number;

/// The servos of a model with parameters and effects.
#[derive(Clone, Debug)]
pub struct Servos {
    bound: Vec<BoundServo<f64>>,
    sizes: Sizes,
}

impl Model {
    /// Where an effect on an input acts within servos; none where it acts on the input itself.
    #[must_use]
    pub fn in_servo(&self, effect: &Effect, channel: usize) -> Option<InServo> {
        let Law::Input(_) = effect.law else { return None };
        effect.nature.in_servo.filter(|_| self.servo_of(channel).is_some())
    }

    /// The servo that follows an input, and its number.
    #[must_use]
    pub fn servo_of(&self, input: usize) -> Option<(usize, &Servo)> {
        self.dynamics.servos().iter().enumerate().find(|(_, servo)| servo.input == input)
    }

    /// Whether the model says itself what an effect on an input does.
    #[must_use]
    pub fn states(&self, effect: &Effect, input: usize) -> bool {
        match self.in_servo(effect, input) {
            Some(InServo::Error) => self.servo_of(input).is_some_and(|(_, servo)| servo.plays),
            Some(InServo::Force) => self.servo_of(input).is_some_and(|(_, servo)| servo.saturates),
            None => false,
        }
    }

    /// The servos, given the model's parameters and effects.
    #[must_use]
    pub fn servos(&self, parameters: &[f64], effects: &[ModelEffect]) -> Servos {
        let (all, sizes) = (self.dynamics.servos(), self.dynamics.sizes());
        let parameters = self.with_structure(parameters, effects);
        let own: usize = all.iter().map(|servo| servo.parameters()).sum();
        let own = &parameters[sizes.parameters - own..sizes.parameters];
        let left_out = match parameters.len() == self.structure_end() {
            true => &parameters[parameters.len() - SERVO * all.len()..],
            false => &[],
        };
        Servos { bound: Servo::bound(all, own, left_out), sizes }
    }

    /// Add the numbers of an effect that acts within servos.
    pub(super) fn add_to_servos<T: Number>(
        &self,
        parameters: &mut Vec<T>,
        e: &ModelEffect,
        internal: impl Fn() -> Vec<T>,
    ) {
        let place = self.in_servo(e.effect, e.channel).zip(self.servo_of(e.channel));
        let Some((place, (servo, _))) = place else { return };
        parameters.resize(self.structure_end(), T::constant(0.0));
        let first = self.structure_end() - SERVO * self.dynamics.servos().len();
        let value = internal()[0];
        let at = first + SERVO * servo;
        match place {
            InServo::Error => parameters[at] = parameters[at] + value,
            InServo::Force => parameters[at + 1] = T::constant(1.0) / value,
        }
    }
}

impl Servos {
    /// The force of a servo at a state of the machine under some inputs.
    #[must_use]
    pub fn force(&self, servo: usize, state: &[f64], inputs: &[f64]) -> f64 {
        self.bound[servo].force(&self.point(state, inputs))
    }

    /// Its error, play and dead band apart.
    #[must_use]
    pub fn error(&self, servo: usize, state: &[f64], inputs: &[f64]) -> f64 {
        self.bound[servo].off(&self.point(state, inputs))
    }

    fn point<'a>(&self, state: &'a [f64], inputs: &'a [f64]) -> Point<'a> {
        let n = self.sizes.coordinates;
        Point {
            parameters: &[],
            coordinates: &state[..n],
            velocities: &state[n..2 * n],
            states: &state[2 * n..self.sizes.machine_states()],
            inputs: &inputs[..self.sizes.inputs],
            time: 0.0,
        }
    }
}
