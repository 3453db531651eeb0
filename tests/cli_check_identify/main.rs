//! `lacuna check`, `lacuna compare`, `lacuna identify` and `lacuna simulate` of what was identified, as a user runs
//! them.

mod bench;
mod check;
mod compare;
mod identify;
mod refused;
mod simulate;
mod simulated;
