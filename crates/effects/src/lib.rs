//! The catalogue: every kind of physics that Lacuna can add to a model, each once, as a
//! law with named parameters and units. Simulation, diagnosis and reports read it here.
//!
//! A force law adds a generalised force to one channel of `M(q) q'' = F(q, q', u)`:
//!
//! ```text
//! r_i = sum_k a_k (b_k(q, q', u, t, z; s) - m_k(q, q', u, t, z; s) q_i'')
//! ```
//!
//! It is linear in its amplitudes `a` and not in its shape `s`; `z` is its memory. That
//! split is what lets a whole family of laws be screened by linear regression. Laws are generic
//! over the number type ([`lacuna_numbers::Number`]): all their derivatives are exact.
//!
//! | on paper | in code |
//! | --- | --- |
//! | coordinate q_i, velocity v, other channels, inputs u, time t, memory z | [`At`] |
//! | amplitudes a, shape s | the *internal* parameters: amplitudes first ([`ForceLaw::amplitudes`]) |
//! | basis b, inertia m | [`ForceLaw::basis`], [`ForceLaw::inertia`] |
//! | memory z, its rate | [`ForceLaw::memory`], [`ForceLaw::memory_rate`] |
//! | what an actuator or sensor makes of a series | [`SeriesLaw::applied`] |
//! | what a link is made of beside, how the base stands | [`StructureLaw::numbers`] |
//! | prior of a and s | [`Effect::priors`] |
//! | shapes s to begin from | [`Effect::shapes`] |
//! | what it is beside a constant force | [`Nature::biased`] |
//! | what a robot's own file can say of it | [`Nature::stated`] |
//! | magnitudes as an engineer states them | the *physical* parameters: [`Effect::parameters`], one value after the other: [`Effect::values`] |
//!
//! What an effect is stands in its file, in an [`Effect`]; how it is looked for is another
//! crate, which asks these data and knows no effect by name. A new effect is one small file
//! here, its line in [`CATALOGUE`], and a test.

mod actuator_lag;
mod added_inertia;
mod asymmetric_friction;
mod at;
mod backlash;
mod base_tilt;
mod cogging;
mod constant_force;
mod coriolis_coupling;
mod coulomb_friction;
mod coupling_friction;
mod coupling_stiffness;
mod cross_damping;
mod cubic_stiffness;
mod damped_stop;
mod dead_zone;
mod dry_friction;
mod effect;
mod elastic_drive;
mod end_stop;
mod family;
mod gain_error;
mod gravity_torque;
mod held;
mod hidden_resonance;
mod hysteresis;
mod input_damping;
mod input_delay;
pub mod law;
mod linear_loss;
mod linear_stiffness;
mod load_friction;
mod lugre_friction;
mod maxwell_slip;
mod overflow;
pub mod parameter;
mod payload;
mod periodic_disturbance;
mod position_damping;
mod position_friction;
mod prior;
mod quadratic_drag;
mod quadratic_loss;
mod quadratic_stiffness;
mod saturating_stiffness;
mod saturation;
mod scales;
mod sensor_bias;
mod sensor_dead_zone;
mod sensor_delay;
mod sensor_scale;
pub mod servo;
mod sine;
mod size;
mod spill;
mod stated;
mod step_change;
mod stribeck_friction;
mod time_friction;
mod transmission_backlash;
pub mod unit;
mod unknown_function;
mod viscoelastic;
mod viscous_friction;

pub use at::{At, Channel};
pub use effect::{Acts, BASE, Biased, Effect, InServo, Nature, Variable, one_shape};
pub use family::{Family, Kin};
use lacuna_numbers::Number;
pub use law::{
    AnyForceLaw, AnySeriesLaw, AnyStructureLaw, ForceLaw, ForceLawIn, Law, SeriesLaw, SeriesLawIn,
    StructureLaw, StructureLawIn,
};
pub use parameter::{Kind, Parameter, Range};
pub use prior::Prior;
pub use scales::{GRID, LINES, PITCHES, Scales};
pub use stated::{Quantity, Stated};
pub use unit::Dimension;

/// Every effect, in the order in which rivals of equal evidence are tried: simple ones first.
pub static CATALOGUE: &[&Effect] = &[
    &viscous_friction::EFFECT,
    &coulomb_friction::EFFECT,
    &stribeck_friction::EFFECT,
    &asymmetric_friction::EFFECT,
    &position_friction::EFFECT,
    &time_friction::EFFECT,
    &load_friction::EFFECT,
    &quadratic_drag::EFFECT,
    &position_damping::EFFECT,
    &input_damping::EFFECT,
    &constant_force::EFFECT,
    &linear_stiffness::EFFECT,
    &quadratic_stiffness::EFFECT,
    &cubic_stiffness::EFFECT,
    &saturating_stiffness::EFFECT,
    &added_inertia::EFFECT,
    &payload::EFFECT,
    &base_tilt::EFFECT,
    &end_stop::EFFECT,
    &damped_stop::EFFECT,
    &gravity_torque::EFFECT,
    &cogging::EFFECT,
    &coupling_stiffness::EFFECT,
    &coupling_friction::EFFECT,
    &transmission_backlash::EFFECT,
    &coriolis_coupling::EFFECT,
    &cross_damping::EFFECT,
    &lugre_friction::EFFECT,
    &maxwell_slip::EFFECT,
    &hysteresis::EFFECT,
    &backlash::EFFECT,
    &viscoelastic::EFFECT,
    &hidden_resonance::EFFECT,
    &elastic_drive::EFFECT,
    &periodic_disturbance::EFFECT,
    &step_change::EFFECT,
    &linear_loss::EFFECT,
    &quadratic_loss::EFFECT,
    &overflow::EFFECT,
    &spill::EFFECT,
    &unknown_function::EFFECT,
    &gain_error::EFFECT,
    &dead_zone::EFFECT,
    &saturation::EFFECT,
    &input_delay::EFFECT,
    &actuator_lag::EFFECT,
    &sensor_scale::EFFECT,
    &sensor_bias::EFFECT,
    &sensor_dead_zone::EFFECT,
    &sensor_delay::EFFECT,
];

/// The effect of that class name.
#[must_use]
pub fn find(class: &str) -> Option<&'static Effect> {
    CATALOGUE.iter().copied().find(|e| e.class == class)
}

/// The effect that is a learned curve over a variable of its choice, not a formula.
#[must_use]
pub fn curve() -> &'static Effect {
    &unknown_function::EFFECT
}
