//! The studies of Lacuna: those of the paper *Control Occupation Kernel Regression* (Abudia,
//! Channagiri, Rosenfeld, Kamalapurkar; IEEE Transactions on Automatic Control 71(7), 2026).
//!
//! ```text
//! x'' = (x - x^3) + (2 + sin x) u                       Duffing oscillator, order 2
//! M(q) q'' + V(q, q') q' + Fd q' + Fs tanh(q') = tau    two-link manipulator, as order 1
//! ```
//!
//! | study | module | what it measures |
//! | --- | --- | --- |
//! | one Duffing trial | [`duffing`] | errors of f and g on 61 points |
//! | Duffing Monte-Carlo | [`duffing_montecarlo`] | the same over trials |
//! | choice of lambda | [`lambda_ablation`] | the same for the paper's recipe with other lambdas |
//! | Duffing with more noise | [`noise_sweep`] | the same against the noise |
//! | manipulator | [`manipulator`] | relative errors of f, g1, g2 on 100 points |
//! | manipulator under computed torque | [`manipulator_ctc`] | joint angles after 5 s and 10 s |
//! | the same at 10 kHz | [`manipulator_realtime`] | how long the control law takes |
//! | concealed physics | [`concealed`] | what `lacuna diagnose` finds of physics that was hidden from it |
//! | invariance | [`invariance`] | whether what says nothing of a machine changes its diagnosis |
//! | fleets | [`fleet`] | whether `lacuna fleet` finds the machines that are unlike the others |
//! | numbers that decide | [`ablation`] | the same with each halved and doubled |
//! | signatures | [`signatures`] | nothing: the guide's pictures of the catalogue |
//!
//! Each study draws its data ([`duffing_data`], [`manipulator_data`]), identifies a model by each
//! of the [`recipes`] (the paper's, and [`sindy`] in two forms), and writes statistics to `results/NAME.json` and figures to
//! `results/figures`. Everything follows from one seed, whatever the number of threads. Run them
//! with `cargo run -p experiments -- NAME`.

pub mod ablation;
pub mod cli;
pub mod concealed;
pub mod duffing;
pub mod duffing_data;
pub mod duffing_montecarlo;
pub mod error;
pub mod figures;
pub mod fleet;
pub mod identified;
pub mod invariance;
pub mod lambda_ablation;
pub mod manipulator;
pub mod manipulator_ctc;
pub mod manipulator_data;
pub mod manipulator_large;
pub mod manipulator_realtime;
pub mod noise_sweep;
pub mod output;
pub mod progress;
pub mod published;
pub mod recipes;
pub mod signatures;
pub mod sindy;
pub mod speed;
pub mod statistics;

pub use error::StudyError;
