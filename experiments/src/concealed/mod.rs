//! The proof: physics concealed in made-up recordings, and whether `lacuna diagnose` finds it.
//!
//! ```text
//! truth:     M(q; p*) q'' = F(q, q', u*; p*) + r(q, q', t, z)      p* near the model's p
//! files:     model (p, no r), samples y = sensor(q) + noise, commands u
//! ```
//!
//! Everything follows from a seed. For each case a machine is drawn ([`plants`]), physics concealed in
//! it ([`conceal`]: [`effects`] of the catalogue, [`off_formula`] laws beyond it, wrong actuators and sensors,
//! wrong parameters, or nothing), and its motion integrated finely in open or closed loop
//! ([`drive`], [`truth`]). Sensors add noise, quantise, lose rows ([`sensor`]). A draw is kept when it
//! is fair ([`fair`]): what is concealed moves the recordings over short windows by several noise
//! standard deviations that no parameter explains ([`gap`]); names that these data cannot tell apart
//! are all right ([`rivals`]).
//!
//! The case is written as files ([`files`]) with the truth in another directory. The command runs as a
//! process of its own on the files ([`tool`]); then the seal is broken and names, verdicts, places,
//! claimed probabilities and errors on sealed recordings are scored ([`score`], [`localise`],
//! [`summary`], [`reliability`], [`deviations`]), as is the peers' way on the same files ([`peer`]). From the files of
//! results the map from evidence to probability is fitted ([`calibration`]).
//!
//! | group | conceals | right is |
//! | --- | --- | --- |
//! | catalogue | one or two effects by the catalogue's formulas | class and channel |
//! | off-formula | laws the catalogue does not have; effects under coloured noise or clock jitter | nearest class, or an unknown function of the right variables; verdict unexplained, too |
//! | local | what acts in a region or from a time on | the same, and the samples where it acts (F1) |
//! | null | nothing, wrong parameters, coloured noise, clock jitter | no finding |
//! | robots | effects of joints, actuators, sensors and structure, friction on all joints, in drawn chains of two to five joints that a URDF describes | class and channel; nothing where there is nothing |
//! | machines | noisy inputs, random forces, a hidden coordinate, glitches, a slow log, with an effect or alone; laws of several variables; three effects | class and channel; nothing where there is nothing |

pub mod actuator;
pub mod beyond;
pub mod calibration;
pub mod case;
pub mod conceal;
pub mod deviations;
pub mod diagnosis;
pub mod disturbance;
pub mod draw;
pub mod drive;
pub mod effects;
pub mod error;
pub mod fair;
pub mod files;
pub mod gap;
pub mod localise;
pub mod machine;
pub mod off_formula;
pub mod peer;
pub mod places;
pub mod plants;
pub mod print;
pub mod proportion;
pub mod regression;
pub mod reliability;
pub mod rivals;
pub mod row;
pub mod scales;
pub mod score;
pub mod seal;
pub mod sealed;
pub mod sensor;
pub mod several;
pub mod study;
pub mod summary;
pub mod tool;
pub mod topic;
pub mod truth;
pub mod variants;
pub mod windows;

pub use error::ConcealedError;
pub use study::{NAME, Results, Settings, run};
