//! The catalogue: every kind of physics that Lacuna can add to a model, each once, as a
//! law with named parameters and units. Simulation, diagnosis and reports read it here.
//!
//! A force law adds a generalised force to one channel of `M(q) q'' = F(q, q', u)`:
//!
//! ```text
//! r_i = sum_k a_k b_k(q, v, t, z; s)
//! ```
//!
//! It is linear in its amplitudes `a` and not in its shape `s`; `z` is its memory. That
//! split is what lets a whole family of laws be screened by linear regression.
//!
//! | on paper | in code |
//! | --- | --- |
//! | coordinate q, velocity v, time t | [`Local`] |
//! | amplitudes a, shape s | the *internal* parameters: amplitudes first ([`ForceLaw::amplitudes`]) |
//! | basis b | [`ForceLaw::basis`] |
//! | prior of a and s | [`ForceLaw::priors`] |
//! | memory z, its rate | [`ForceLaw::memory`], [`ForceLaw::memory_rate`] |
//! | magnitudes as an engineer states them | the *physical* parameters: [`Effect::parameters`], one value after the other: [`Effect::values`] |
//!
//! A new effect is one small file here, a line in [`CATALOGUE`], and a test.

mod actuator_lag;
mod asymmetric_friction;
mod backlash;
mod cogging;
mod constant_force;
mod coriolis_coupling;
mod coulomb_friction;
mod coupling_stiffness;
mod cubic_stiffness;
mod dead_zone;
mod end_stop;
mod gain_error;
mod gravity_torque;
mod hidden_resonance;
mod hysteresis;
mod input_delay;
pub mod law;
mod linear_loss;
mod linear_stiffness;
mod overflow;
pub mod parameter;
mod periodic_disturbance;
mod prior;
mod quadratic_drag;
mod quadratic_loss;
mod saturation;
mod sensor_bias;
mod sensor_delay;
mod sensor_scale;
mod step_change;
mod stribeck_friction;
pub mod unit;
mod unknown_function;
mod viscoelastic;
mod viscous_friction;

pub use law::{
    Acts, Effect, ForceLaw, InputLaw, Law, Local, MOST_AMPLITUDES, Scales, SensorLaw, Variable,
};
pub use parameter::{Kind, Parameter, Range};
pub use prior::Prior;
pub use unit::Dimension;

/// Every effect, in the order in which rivals of equal evidence are tried: simple ones first.
pub static CATALOGUE: &[&Effect] = &[
    &viscous_friction::EFFECT,
    &coulomb_friction::EFFECT,
    &stribeck_friction::EFFECT,
    &asymmetric_friction::EFFECT,
    &quadratic_drag::EFFECT,
    &constant_force::EFFECT,
    &linear_stiffness::EFFECT,
    &cubic_stiffness::EFFECT,
    &end_stop::EFFECT,
    &gravity_torque::EFFECT,
    &cogging::EFFECT,
    &coupling_stiffness::EFFECT,
    &coriolis_coupling::EFFECT,
    &hysteresis::EFFECT,
    &backlash::EFFECT,
    &viscoelastic::EFFECT,
    &hidden_resonance::EFFECT,
    &periodic_disturbance::EFFECT,
    &step_change::EFFECT,
    &linear_loss::EFFECT,
    &quadratic_loss::EFFECT,
    &overflow::EFFECT,
    &unknown_function::EFFECT,
    &gain_error::EFFECT,
    &dead_zone::EFFECT,
    &saturation::EFFECT,
    &input_delay::EFFECT,
    &actuator_lag::EFFECT,
    &sensor_scale::EFFECT,
    &sensor_bias::EFFECT,
    &sensor_delay::EFFECT,
];

/// The effect of that class name.
#[must_use]
pub fn find(class: &str) -> Option<&'static Effect> {
    CATALOGUE.iter().copied().find(|e| e.class == class)
}
