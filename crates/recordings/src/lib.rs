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
//! | times t_k | [`Recording::time`], strictly increasing | s |
//! | samples y_k, u_k | [`Recording::column`], NaN where missing | as in the file |

mod csv;
mod error;
mod hold;
mod noise;
mod recording;
mod sampling;
mod signal;
mod smoother;
mod source;
mod units;

pub use crate::csv::{read_csv, write_csv, write_csv_with_time};
pub use error::RecordingError;
pub use hold::{InputHold, resample_input};
pub use noise::{NoiseEstimate, estimate_noise, estimate_noise_pooled};
pub use recording::{Column, Recording};
pub use sampling::{Gap, Sampling};
pub use signal::SignalError;
pub use smoother::{Prior, Smoothed, Smoother, Trajectory};
pub use source::{RecordingSource, Selection, SourceError};
pub use units::{Dimension, Unit, UnitError, convert, convert_factor};
