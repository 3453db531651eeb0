//! The ladder on recordings whose truth is known, because they are simulated here.

mod afresh;
mod beyond;
mod conventions;
mod driven;
mod errors;
mod evidence;
mod findings;
mod imposed;
mod inputs;
mod laws;
mod likelihood;
mod machines;
mod missing_force;
mod nothing_missing;
mod prediction;
mod screen;
mod together;
