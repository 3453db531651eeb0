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
//! | test function phi, residual `int phi (M q'' - F) dt` | [`weak::WeakForm`] |
//! | noise covariance, white force tau | [`weak::Whitener`] |
//! | amplitudes a, parameters p, evidence | [`evidence::regress`] |
//! | law b with shape s | [`lacuna_effects::ForceLaw`], [`candidates::Term`] |
//! | forward selection | [`screen::Screen`] |
//! | multiple shooting | [`shooting::Shooting`] |
//! | free runs and windows | [`Predictor`], [`IdentifiedPredictor`] |
//! | the whole ladder | [`diagnose::diagnose`] |
//! | the result | [`Diagnosis`] |
//!
//! The weak form screens: it is linear, so hundreds of candidates cost a second. Multiple
//! shooting with the differential equation itself confirms: its errors-in-variables are none.

pub mod candidates;
pub mod dataset;
pub mod diagnose;
pub mod diagnosis;
mod error;
pub mod evidence;
pub mod prediction;
pub mod screen;
pub mod shooting;
pub mod trajectories;
pub mod weak;
mod words;

pub use dataset::{Dataset, Observed, Output};
pub use diagnosis::Diagnosis;
pub use error::DiagnoseError;
pub use prediction::{IdentifiedPredictor, Prediction, Predictor};
