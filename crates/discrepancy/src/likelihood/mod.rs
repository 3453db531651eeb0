//! The likelihood of a model on recordings: the differential equation itself, fitted by
//! multiple shooting.
//!
//! Each recording is cut into windows with free initial states x_w; the model runs through each
//! window, and
//!
//! ```text
//! chi^2 = sum_w |(y_w - h(x(t; x_w, z, theta))) / sigma|^2
//! ```
//!
//! with theta the calibrated parameters and those of the effects; their evidence follows by
//! Laplace's method, the states of all windows eliminated ([`evidence`]). Memory z of
//! effects (hysteresis, a hidden mass) does not know of windows: it runs on from one to the
//! next, and only its value at the beginning of a recording is free.
//!
//! | on paper | in code |
//! | --- | --- |
//! | recordings, model, magnitudes | [`Problem`] |
//! | windows of level l: 2^l a recording | [`windows`] |
//! | theta, theta_0, S | [`Free`], [`Hypothesis`] |
//! | derivatives of the outputs | [`sweep`] (dual numbers through the Runge-Kutta steps) |
//! | normal equations without the states, a step within bounds | [`normal::Arrow`], `boxed` |
//! | x_w, theta at the optimum, H | [`Fit`] |
//! | what drives the machine, sigma_u, sigma_w | [`ProcessNoise`], [`intensity`] |
//! | innovations z, gains G, covariance P | [`Filter`] |
//! | A_k, B_k, C_k along a run | [`maps::Maps`] |
//! | log Z, temperature T | [`Fit::log_evidence`], [`Fit::temperature`] |
//! | how a fit ended, or why there is none | [`End`], [`FitError`] |

mod boxed;
mod chain;
pub mod coloured;
mod covariance;
mod end;
pub mod evidence;
mod filter;
mod fit;
mod hidden;
mod hypothesis;
pub mod intensity;
pub mod lanes;
mod leaving_out;
mod lines;
pub mod maps;
mod minimise;
pub mod normal;
mod paths;
mod problem;
mod process_noise;
mod shown;
pub mod sweep;
pub mod windows;
mod without;

pub use end::{Diverged, End, FitError};
pub use filter::Filter;
pub use fit::{FULL, Fit, LAST, QUICK, STILL, Windowed};
pub use hypothesis::{Free, Hypothesis, What};
pub use leaving_out::{LeavingOut, Said};
pub use minimise::Effort;
pub use problem::Problem;
pub use process_noise::ProcessNoise;
pub use windows::Window;
