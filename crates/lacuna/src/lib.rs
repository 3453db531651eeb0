//! **Lacuna finds the physics that a simulator leaves out.**
//!
//! A model says `M(q) q'' = F(q, q', u; p)`; the machine obeys
//!
//! ```text
//! M(q) q'' = F(q, q', u; p) + r
//! ```
//!
//! and Lacuna finds r: where it acts, which physics it is, with numbers and units.
//!
//! | step | crate |
//! | --- | --- |
//! | what moves: models, integrators | [`plants`] |
//! | bodies that hang together by joints, from URDF or MJCF | [`rigid`] |
//! | simulators that are FMUs | [`fmu`] |
//! | numbers with exact derivatives | [`numbers`] |
//! | the catalogue of effects r can be made of | [`effects`] |
//! | what drives and disturbs it | [`excitation`] |
//! | what was seen | [`recordings`] |
//! | x^(s) = f + g u from whole trajectories | [`occupation`] |
//! | the same within microseconds, for control loops | [`realtime`] |
//! | from mismatch to findings | [`discrepancy`] |
//! | computed torque on true or identified models | [`control`] |
//! | charts | [`charts`] |
//! | pictures and words | [`report`] |
//!
//! What its commands do stands in [`models`], [`check`], [`simulation`], [`comparison`], [`diagnosed`],
//! [`identification`], [`difference`], [`fleet`] and [`trajectories`]: the
//! `lacuna` command and the Python package are thin layers on these. A model that is no text but
//! code, such as a closure, is built with [`plants::Model::builder`] and diagnosed with
//! [`discrepancy::diagnose::diagnose`]: `examples/closure.rs` goes all the way.

pub mod check;
pub mod comparison;
pub mod diagnosed;
pub mod difference;
pub mod files;
pub mod fleet;
pub mod identification;
pub mod models;
pub mod simulation;
pub mod table;
pub mod trajectories;

pub use lacuna_charts as charts;
pub use lacuna_control as control;
pub use lacuna_discrepancy as discrepancy;
pub use lacuna_effects as effects;
pub use lacuna_excitation as excitation;
pub use lacuna_fmu as fmu;
pub use lacuna_numbers as numbers;
pub use lacuna_occupation as occupation;
pub use lacuna_plants as plants;
pub use lacuna_realtime as realtime;
pub use lacuna_recordings as recordings;
pub use lacuna_report as report;
pub use lacuna_rigid as rigid;
