//! From mismatch to findings: locate, screen, confirm, prove.

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
pub use prediction::{Prediction, Predictor};
