//! The numbers of a position servo, a template of actuators: what model files call them, and their units. Its law
//! is that of `lacuna_plants::dynamics::Servo`; a delay of its command is that of the catalogue.

use crate::{Dimension, Effect, Parameter, Range, input_delay};

/// The template's name.
pub const TEMPLATE: &str = "pd_servo";
/// Force per error of position.
pub const GAIN: Parameter = Parameter::new("kp", Dimension::new(1, -1, 0), Range::NonNegative);
/// Force against the velocity.
pub const DAMPING: Parameter = Parameter::new("kd", Dimension::new(1, -1, 1), Range::NonNegative);
/// The most force that it has.
pub const SATURATION: Parameter = Parameter::new("saturation", Dimension::FORCE, Range::Positive);
/// Play between it and what it drives, all of it.
pub const BACKLASH: Parameter =
    Parameter::new("backlash", Dimension::COORDINATE, Range::NonNegative);
/// How much later than the command it moves.
pub const DELAY: Parameter = Parameter::new("delay", Dimension::TIME, Range::NonNegative);

/// The input that a servo follows where nothing else is said.
#[must_use]
pub fn command_of(channel: &str) -> String {
    format!("{channel}_command")
}

/// The effect that a delay of the command is, with that number as its parameter.
#[must_use]
pub fn delay_of_command() -> &'static Effect {
    &input_delay::EFFECT
}
