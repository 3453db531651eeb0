//! What `diagnose --simulated` does: two sets of recordings, one of a simulator and one of the machine, and no model.
//!
//! Both are identified ([`crate::occupation::Identification`]),
//!
//! ```text
//! q^(s) = f(x) + g(x) u
//! ```
//!
//! and f and g compared where both are known, with the standard deviations of both. Where g has an inverse that is a
//! mass matrix,
//!
//! ```text
//! M = g^-1,   F = M f:   M q'' = F(x) + u
//! ```
//!
//! and M and F are compared in the place of g and f: a force F is in the units of the inputs, and does not differ
//! where but the inertia does.
//!
//! | on paper | in code |
//! | --- | --- |
//! | f, g or F, M of both at common states | [`Entry`] |
//! | whether they differ, over which variables | [`Place`] |
//! | laws of the catalogue that the difference of F or f is | [`Law`] |
//!
//! No model says what is known of the machine. A law that is missing and one that the simulator has with another size
//! look the same here, and so do another inertia and another gain: the verdict says so.

mod functions;
mod laws;
mod place;
mod results;
mod side;

pub use functions::{Entry, Of};
pub use laws::{Law, Rival};
pub use place::{Place, Share};
pub use results::Difference;
pub use side::Side;

use crate::identification::{Asked, Columns};
use crate::occupation::InputPath;
use crate::recordings::{Recording, RecordingSource};
use std::error::Error;

/// Two sets of recordings, and which of their columns are what.
#[derive(Clone, Debug)]
pub struct Runs {
    /// Of the simulator.
    pub simulated: Vec<Recording>,
    /// Of the machine.
    pub recorded: Vec<Recording>,
    /// The same of both.
    pub columns: Columns,
}

impl Runs {
    /// Read the recordings of both sides, and tell which columns are what by the first.
    ///
    /// # Errors
    /// What is wrong with a file.
    pub fn read(
        simulated: &[RecordingSource],
        recorded: &[RecordingSource],
        asked: &Asked,
    ) -> Result<Self, Box<dyn Error>> {
        let first = simulated.first().ok_or("no recording of the simulator")?;
        let (time, notes) = asked.time_of(first)?;
        let all = |of: &[RecordingSource]| {
            of.iter().map(|s| crate::recordings::read(s, &time)).collect::<Result<Vec<_>, _>>()
        };
        let (simulated, recorded) = (all(simulated)?, all(recorded)?);
        let columns = Columns::choose(asked, &simulated[0], time.clone(), notes)?;
        Ok(Self { simulated, recorded, columns })
    }
}

/// Identify both sides and compare them.
///
/// # Errors
/// Recordings without the columns, that cannot be identified, or that visit other states.
pub fn compare_runs(
    runs: Runs,
    (asked, path): (&Asked, InputPath),
    progress: &dyn Fn(&str),
) -> Result<Difference, Box<dyn Error>> {
    let columns = &runs.columns;
    progress("identifying what was simulated");
    let simulated = Side::of(runs.simulated, columns, asked, path)?;
    progress("identifying what was recorded");
    let recorded = Side::of(runs.recorded, columns, asked, path)?;
    progress("comparing the two");
    Difference::of(&simulated, &recorded, columns)
}
