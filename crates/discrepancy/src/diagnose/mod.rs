//! The ladder: condition, differ at all?, calibrate, locate, screen, confirm, prove.

mod confirm;
mod ladder;

use crate::DiagnoseError;
use crate::dataset::{Dataset, Observed};
use crate::diagnosis::Diagnosis;
use crate::prediction::Prediction;
use crate::screen::Screen;
use crate::trajectories::unmeasured;
use crate::weak::WeakForm;
use confirm::Confirmation;
use lacuna_plants::Model;
use lacuna_plants::model::Augmentation;
use ladder::Ladder;

/// Nats that decide: an effect, or a moved parameter, must gain this much.
const THRESHOLD: f64 = 10.0;

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

/// Split recordings into those that are fitted and those kept for proof: one in four, or the
/// last quarter of a single one.
#[must_use]
pub fn split(dataset: &Dataset) -> (Dataset, Dataset) {
    let all = &dataset.recordings;
    if let [only] = &all[..] {
        let cut = only.len() * 3 / 4;
        let (head, tail) = (only.part(0..cut), only.part(cut..only.len()));
        return (dataset.with_recordings(vec![head]), dataset.with_recordings(vec![tail]));
    }
    let kept = all.len().div_ceil(4);
    let (train, held) = all.split_at(all.len() - kept);
    (dataset.with_recordings(train.to_vec()), dataset.with_recordings(held.to_vec()))
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
    progress: &(dyn Fn(&str) + Sync),
) -> Result<Outcome, DiagnoseError> {
    let hidden = unmeasured(model, training);
    if let Some(&state) = hidden.first() {
        return Err(DiagnoseError::Unmeasured { channel: model.state_name(state).to_owned() });
    }
    if let Some(output) = training.constant_output() {
        return Err(DiagnoseError::Constant { channel: output.name.clone() });
    }
    progress("smoothing the recordings");
    let weak = WeakForm::new(model, training)?;
    let screen = Screen::new(&weak, model.values());
    let screening = screen.search(progress)?;
    progress("fitting the findings with the equations of motion");
    let confirmed = Confirmation::new(model, training, &screen, &screening).run(progress);
    progress("proving on held-out recordings");
    Ladder { model, training, held_out, screen, screening, confirmed }.outcome()
}

/// Seconds that the longest recording spans.
fn duration(dataset: &Dataset) -> f64 {
    let span = |o: &Observed| o.times[o.len() - 1] - o.times[0];
    dataset.recordings.iter().map(span).fold(0.0, f64::max)
}
