//! Computed-torque control of second-order plants by true or identified models, and the closed
//! loop it makes.
//!
//! ```text
//! q'' = f2(x) + g2(x) u                                        the model,  x = (q, q')
//! u   = g2(x)^+ (q_d'' + Kp (q_d - q) + Kv (q_d' - q') - f2(x))   the control law
//! e'' + Kv e' + Kp e = 0,   e = q_d - q                        what follows if the model is right
//! ```
//!
//! | on paper | in code | shape |
//! | --- | --- | --- |
//! | state x = (q, q') | `state: &[f64]` | 2p |
//! | f2, g2: acceleration rows of drift and control effectiveness | [`AccelerationModel::accelerations`] | p, p x m (row-major) |
//! | pseudo-inverse g2^+ | inside [`ComputedTorque::input`] | m x p |
//! | gains Kp, Kv (diagonal) | [`Gains`] | p each |
//! | reference q_d, q_d', q_d'' | [`Reference`] | p each |
//! | regulator q_d = 0 | [`Origin`] | |
//!
//! The law needs the model only through [`AccelerationModel`], which true plants
//! ([`PlantAccelerations`]) and identified models ([`VelocityRows`] for first-order ones) provide
//! alike. [`closed_loop()`] lets the law drive a true plant, evaluated at every stage of the
//! integration or sampled and held. Source of the law: Lewis, Dawson, Abdallah, *Robot
//! Manipulator Control* (2004), section 4.4.

pub mod closed_loop;
pub mod computed_torque;
pub mod error;
pub mod model;
pub mod reference;

pub use closed_loop::{ClosedLoop, Timing, closed_loop};
pub use computed_torque::{ComputedTorque, Gains};
pub use error::ControlError;
pub use model::{AccelerationModel, PlantAccelerations, VelocityRows};
pub use reference::{Origin, Reference, ReferenceFn};
