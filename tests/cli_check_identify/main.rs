//! `lacuna check`, `lacuna identify` and `lacuna simulate` of what was identified, as a user runs
//! them.

mod bench;
mod check;
mod identify;
mod refused;
mod simulate;
