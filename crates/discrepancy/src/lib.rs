//! From mismatch to findings: condition, locate, screen, confirm, prove.
//!
//! The machine obeys the model's equation with a missing generalised force r,
//!
//! ```text
//! M(q; p) q'' = F(q, q', u; p) + r,        r_i = sum_k a_k b_k(q, q', t; s) + remainder
//! ```
//!
//! and first-order states `h' = D(q, q', h, u; p) + r`. In force coordinates an effect on one
//! channel stands alone; in accelerations the mass matrix would smear it over all.
//!
//! | on paper | in code |
//! | --- | --- |
//! | measured channels, noise sigma | [`Dataset`], [`Observed`] |
//! | smoothed motion q, q' | [`trajectories::SmoothedRecording`] |
//! | missing force r(t) = f(x(t)) + remainder along the measured motion | [`missing_force::MissingForce`] |
//! | law b with shape s, priors of a and s | [`lacuna_effects::Effect`], [`candidates::Term`] |
//! | laws of a robot's joints together, in the weak form | [`missing_force::laws`] |
//! | likelihood of the differential equation, evidence Z | [`likelihood`] |
//! | occupation functionals with the Green's function as test function | [`screen::Screen`] |
//! | forward selection, rivals, what is missed, folds | [`search::Search`] |
//! | probability of a class, calibrated | [`probability::ProbabilityMap`] |
//! | prior odds and the other numbers that decide | [`Decision`] |
//! | prior odds of laws of one kind on many joints | `against` |
//! | free runs and windows | [`Predictor`], [`IdentifiedPredictor`] |
//! | the whole ladder | [`diagnose::diagnose`] |
//! | the result | [`Diagnosis`] |
//! | the same in a robot's own file | [`robot_file`] |
//!
//! The linearised likelihood screens: hundreds of candidates cost a second. The likelihood
//! itself, of the differential equation with free initial states, decides.

mod against;
pub mod candidates;
pub mod colour;
pub mod conventions;
pub mod dataset;
pub mod decision;
pub mod diagnose;
pub mod diagnosis;
mod error;
pub mod likelihood;
pub mod missing_force;
pub mod number;
pub mod prediction;
pub mod probability;
mod range;
pub mod robot_file;
pub mod scope;
pub mod screen;
pub mod search;
pub mod trajectories;
mod watch;
mod words;

pub use dataset::{Cleaned, Dataset, Observed, Output};
pub use decision::Decision;
pub use diagnosis::Diagnosis;
pub use error::DiagnoseError;
pub use prediction::{IdentifiedPredictor, Prediction, Predictor};
pub use scope::{Scope, Selector};
pub use watch::Watch;
