//! What was seen: recordings of a real machine against time, and what can be said of them
//! without a model.
//!
//! A recording is a set of samples of a trajectory and its input,
//!
//! ```text
//! y_k = gamma(t_k) + sigma e_k,   u_k = u(t_k),   k = 0 ... N-1
//! ```
//!
//! | on paper | in code | unit |
//! | --- | --- | --- |
//! | times t_k | [`Recording::time`], strictly increasing; [`Sampling`] finds dropped rows | s |
//! | samples y_k | [`Recording::column`], NaN where missing | as in the file |
//! | input u(t) between samples | [`resample_input`] | as in the file |
//! | noise sigma | [`estimate_noise`], from sixth differences | as in the file |
//! | rows k that neither noise nor motion explains | [`find_outliers`] | |
//! | rows k on which a sensor is at the end of its range | [`find_saturated`] | |
//! | angles made continuous, outliers and samples of a sensor at its limit left out | [`condition`] | |
//! | which recordings there are, whatever their order and copies | [`arranged`] | |
//! | what recordings have that others have not | [`without_shared`] | |
//! | trajectory gamma, gamma', gamma'' | [`Smoother`], with standard deviations | ... per s, s^2 |
//!
//! Files are named by a [`RecordingSource`] (`run.csv#rows=100..40575`), read by
//! [`read`] with the one of the [`READERS`] whose file it is, and written by [`write_csv`]; columns in memory become
//! recordings by [`Recording::from_columns`]; of Parquet files with very many rows [`RowGroups`] reads a part at a time;
//! [`Unit`] and [`convert`] turn what a column
//! holds into the unit that a model expects.
//!
//! ```
//! use lacuna_recordings::{Smoother, Unit, convert, estimate_noise};
//! let time: Vec<f64> = (0..400).map(|k| 0.01 * k as f64).collect();
//! let degrees: Vec<f64> = time.iter().map(|t| (30.0 * t.sin()).round()).collect();
//! let angle = convert(&degrees, &Unit::parse("deg")?, &Unit::parse("rad")?)?;
//! let noise = estimate_noise(&time, &angle)?;
//! assert!((noise.quantum.unwrap() - 1f64.to_radians()).abs() < 1e-12);
//! let smooth = Smoother::fit(&time, &angle, noise.sd)?.at(&time);
//! assert!((smooth.first[200] - 30f64.to_radians() * 2f64.cos()).abs() < 0.02);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod arrangement;
mod conditioning;
mod contained;
mod csv;
mod error;
mod hold;
mod kinds;
mod log;
mod mat;
mod mcap;
mod memory;
mod noise;
mod outliers;
mod overlap;
mod parquet;
mod reader;
mod recording;
mod sampling;
mod saturation;
mod signal;
mod smoother;
mod source;
mod table;
mod unwrap;

pub use crate::csv::{Csv, write_csv, write_csv_with_time};
pub use crate::mat::Mat;
pub use crate::mcap::Mcap;
pub use crate::parquet::{Parquet, RowGroups};
pub use arrangement::arranged;
pub use conditioning::{Cleaned, condition, conditioning_notes, in_samples};
pub use error::RecordingError;
pub use hold::{InputHold, lost_input_variance, resample_input};
pub use log::{Clock, Log, Wanted};
pub use noise::{NoiseEstimate, estimate_noise, estimate_noise_pooled};
pub use outliers::{Outliers, find_outliers};
pub use overlap::without_shared;
pub use reader::{READERS, Reader, read, read_log};
pub use recording::{Column, Recording};
pub use sampling::{Gap, Sampling};
pub use saturation::find_saturated;
pub use signal::SignalError;
pub use smoother::{MeanPath, Prior, Samples, SharedSmoother, Smoothed, Smoother, Trajectory};
pub use source::{RecordingSource, Selection, SourceError};
pub use table::TableError;
pub use unwrap::unwrap_turns;

pub use lacuna_units::names::{did_you_mean, nearest};
pub use lacuna_units::{Dimension, Unit, UnitError, convert, convert_factor};
