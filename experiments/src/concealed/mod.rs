//! The proof: physics concealed in made-up recordings, and whether it is found.

pub mod actuator;
pub mod beyond;
pub mod case;
pub mod diagnosis;
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
pub mod plants;
pub mod print;
pub mod proportion;
pub mod row;
pub mod scales;
pub mod score;
pub mod sealed;
pub mod sensor;
pub mod study;
pub mod summary;
pub mod tool;
pub mod topic;
pub mod truth;

pub use error::ConcealedError;
pub use study::{NAME, Results, Settings, run};
