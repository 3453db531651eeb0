//! The ladder on recordings whose truth is known, because they are simulated here.

mod errors;
mod findings;
mod machines;
mod nothing_missing;
mod prediction;
mod shooting;
mod weak;
