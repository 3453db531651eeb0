//! What moves: the [`Plant`] trait, the paper's two plants, an integrator that respects
//! how the input was held, and models: what is believed of a machine, simulated by any
//! [`Dynamics`], those that are expressions in a text file among them.
//!
//! A plant of order `s` obeys
//!
//! ```text
//! x^(s)(t) = f(x, ..., x^(s-1)) + g(x, ..., x^(s-1)) u(t)
//! ```
//!
//! | on paper | in code | shape |
//! | --- | --- | --- |
//! | order s | [`Plant::order`] | 1 or 2 |
//! | coordinates x in R^n | [`Plant::dimension`] | n |
//! | state (x, x', ..., x^(s-1)) | `state: &[f64]`, blocks one after the other, then memory | `Plant::states()` |
//! | input u in R^m | `input: &[f64]` | m |
//! | drift f | [`Plant::drift`] | n |
//! | control effectiveness g | [`Plant::control_effectiveness`] | n x m, row-major |

pub mod duffing;
pub mod dynamics;
pub mod expression;
pub mod input;
pub mod integrate;
pub mod model;
pub mod plant;
mod substeps;
pub mod two_link;

pub use duffing::Duffing;
pub use dynamics::Dynamics;
pub use input::{Hold, Input, InputFn, InputPath, SampledInput, SmoothInput};
pub use integrate::{SimulationError, Trajectory, rk4, rk4_sampled};
pub use model::{Model, ModelError, System};
pub use plant::Plant;
pub use substeps::Substeps;
pub use two_link::TwoLinkArm;
