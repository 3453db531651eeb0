//! One side: recordings, identified.

use crate::identification::{Asked, Columns, Conditioning, Motion, input_hold};
use crate::occupation::Arguments::State;
use crate::occupation::{Identification, IdentifiedModel, InputPath};
use crate::recordings::Recording;
use std::error::Error;

/// Recordings of the simulator or of the machine, and f and g of them.
#[derive(Debug)]
pub struct Side {
    /// Names of the recordings.
    pub names: Vec<String>,
    /// f and g.
    pub model: IdentifiedModel,
    /// What was done to the recordings, in sentences.
    pub notes: Vec<String>,
    motion: Motion,
}

impl Side {
    /// Identify f and g.
    ///
    /// # Errors
    /// Recordings without the columns, or that cannot be identified.
    pub fn of(
        mut recordings: Vec<Recording>,
        columns: &Columns,
        asked: &Asked,
        path: InputPath,
    ) -> Result<Self, Box<dyn Error>> {
        let mut conditioning = Conditioning::default();
        let noise = conditioning.condition(columns, &asked.units, &mut recordings)?;
        let motion = Motion::of(columns, &noise, &recordings, input_hold(path))?;
        let motions: Vec<_> = motion.stretches.iter().map(|s| s.measured.clone()).collect();
        let found = Identification::new(columns.order, State, path).identify(&motions);
        let found = found.map_err(|e| format!("{}: {e}", motion.names.join(", ")))?;
        let notes = conditioning.notes();
        Ok(Self { names: motion.names.clone(), model: found.model, notes, motion })
    }

    /// At most about `count` of the states it visits, evenly spread over its samples.
    #[must_use]
    pub fn states(&self, count: usize) -> Vec<Vec<f64>> {
        let stretches = || self.motion.stretches.iter().map(|s| &s.data);
        let samples: usize = stretches().map(|d| d.samples()).sum();
        let rows = stretches().flat_map(|d| d.arguments().chunks_exact(d.argument_count()));
        rows.step_by(samples.div_ceil(count).max(1)).map(<[f64]>::to_vec).collect()
    }

    /// Root mean square of every input.
    #[must_use]
    pub fn input_sizes(&self, inputs: usize) -> Vec<f64> {
        let rows = || {
            self.motion.stretches.iter().flat_map(|s| s.data.inputs().chunks_exact(inputs.max(1)))
        };
        let mean = |j: usize| rows().map(|u| u[j] * u[j]).sum::<f64>() / rows().count() as f64;
        (0..inputs).map(|j| mean(j).sqrt()).collect()
    }
}
