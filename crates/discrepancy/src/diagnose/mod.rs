//! The ladder: condition, differ at all?, calibrate, locate, screen, confirm, prove.

mod findings;
mod location;
mod outcome;
mod proof;
mod rungs;
mod separate;
mod split;

use crate::DiagnoseError;
use crate::dataset::{Dataset, Observed};
use crate::diagnosis::Diagnosis;
use crate::likelihood::Problem;
use crate::prediction::Prediction;
use crate::search::Search;
use crate::trajectories::unmeasured;
use lacuna_plants::Model;
use lacuna_plants::model::Augmentation;
use outcome::Ladder;
pub use split::split;

/// A diagnosis with what is needed to write and draw it.
pub struct Outcome {
    /// The result.
    pub diagnosis: Diagnosis,
    /// What to change in the model file.
    pub augmentation: Augmentation,
    /// Held-out recordings (or their stand-in) with free runs before and after.
    pub proofs: Vec<Proof>,
}

/// A held-out recording with what the model said before and says after, running free.
pub struct Proof {
    /// The recording.
    pub observed: Observed,
    /// The model as it was.
    pub before: Prediction,
    /// The augmented model.
    pub after: Prediction,
}

/// What a diagnosis may do beside naming.
#[derive(Clone, Copy, Debug, Default)]
pub struct Options {
    /// Keep what is left after the named effects as learned curves in the augmented model.
    pub learn_remainder: bool,
}

/// Diagnose a model on training recordings, with the proof on held-out ones.
///
/// `progress` is told what is being done.
///
/// # Errors
/// [`DiagnoseError`] naming the recording or channel that cannot be used.
pub fn diagnose(
    model: &Model,
    training: &Dataset,
    held_out: &Dataset,
    options: Options,
    progress: &(dyn Fn(&str) + Sync),
) -> Result<Outcome, DiagnoseError> {
    let coordinates = 0..model.coordinates.len();
    if let Some(state) = unmeasured(model, training).into_iter().find(|i| coordinates.contains(i)) {
        return Err(DiagnoseError::Unmeasured { channel: model.state_name(state).to_owned() });
    }
    if let Some(output) = training.constant_output() {
        return Err(DiagnoseError::Constant { channel: output.name.clone() });
    }
    progress("smoothing the recordings");
    let problem = Problem::new(model, training)?;
    let proof = Problem::new(model, held_out)?;
    let found = Search::new(&problem, &proof, progress).run(options.learn_remainder)?;
    progress("proving on held-out recordings");
    Ok(Ladder::new(&problem, &proof, found).outcome())
}

/// Seconds that the longest recording spans.
fn duration(dataset: &Dataset) -> f64 {
    let span = |o: &Observed| o.times[o.len() - 1] - o.times[0];
    dataset.recordings.iter().map(span).fold(0.0, f64::max)
}
