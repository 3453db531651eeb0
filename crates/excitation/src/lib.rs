//! What drives and disturbs a plant: sums of sinusoids, initial states, measurement noise,
//! and the random streams they are drawn from.
//!
//! ```text
//! u_j(t) = sum_k a_jk sin(w_jk t + phi_jk)          each input channel j
//! x0_i   = c_i - L/2 + L h_i                        each initial state, h a Halton point
//! y      = x + sigma N(0, 1)                        each measured sample
//! ```
//!
//! | on paper | in code | unit |
//! | --- | --- | --- |
//! | amplitude a | [`Sinusoid::amplitude`] | of the input |
//! | angular frequency w | [`Sinusoid::angular_frequency`] | rad/s |
//! | phase phi | [`Sinusoid::phase`] | rad |
//! | centre c and side L of a cube | arguments of [`halton_cube`] | of the state |
//! | noise standard deviation sigma | argument of [`add_gaussian_noise`] | of the channel |
//! | random stream of a trial | [`rng`]`(seed, stream)` | - |
//!
//! Nothing here knows about plants: inputs are functions of time and states are rows of
//! numbers. Every random draw comes from a generator that the caller hands in, so that a study is
//! reproducible from one seed however many threads carry it out.

pub mod initial_states;
pub mod noise;
pub mod seed;
pub mod sinusoids;

pub use initial_states::{Axis, InitialStateError, grid, halton_cube};
pub use noise::{NoiseError, add_gaussian_noise};
pub use seed::rng;
pub use sinusoids::{Sinusoid, SinusoidError, SinusoidRanges, SumOfSinusoids};
