//! The ladder: condition, differ at all?, calibrate, locate, screen, confirm, prove.

mod driving;
mod findings;
mod location;
mod outcome;
mod proof;
mod rungs;
mod separate;
mod split;
mod stretches;

use crate::DiagnoseError;
use crate::conventions::otherwise;
use crate::dataset::{Dataset, Observed};
use crate::decision::Decision;
use crate::diagnosis::Diagnosis;
use crate::likelihood::Problem;
use crate::prediction::Prediction;
use crate::scope::{Scope, known};
use crate::search::Search;
use crate::watch::Watch;
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
#[derive(Clone, Debug, Default)]
pub struct Options {
    /// The numbers that decide.
    pub decision: Decision,
    /// Keep what is left after the named effects as learned curves in the augmented model.
    pub learn_remainder: bool,
    /// What may be named.
    pub scope: Scope,
    /// Recorded inputs, by name, that are exactly what the machine got, whatever the model says: no
    /// noise on them is estimated.
    pub exact: Vec<String>,
}

impl Options {
    /// The model with what is asked of its inputs.
    fn asked_of(&self, model: &Model) -> Result<Model, DiagnoseError> {
        self.scope.check(model)?;
        let names: Vec<&str> = model.inputs.iter().map(|i| &*i.name).collect();
        self.exact.iter().try_for_each(|name| known("input", name, &names))?;
        let mut model = model.clone();
        let asked = model.inputs.iter_mut().filter(|i| self.exact.contains(&i.name));
        asked.for_each(|input| input.noise = Some(0.0));
        Ok(model)
    }

    /// What a reader of the diagnosis must know of what was asked for.
    fn notes(&self) -> Vec<String> {
        let mut notes = self.scope.notes();
        if !self.exact.is_empty() {
            notes.push(format!(
                "As was asked, the recorded {} was taken for exactly what the machine got.",
                self.exact.join(", ")
            ));
        }
        notes
    }
}

/// Diagnose a model on training recordings, with the proof on held-out ones.
///
/// Parameters are fitted and effects are chosen on the training recordings alone; the held-out ones
/// are opened once, when everything is decided, and can only refuse what was decided.
///
/// # Errors
/// [`DiagnoseError`] naming the recording or channel that cannot be used, [`DiagnoseError::Unknown`]
/// names in the options, and [`DiagnoseError::Cancelled`].
pub fn diagnose(
    model: &Model,
    training: &Dataset,
    held_out: &Dataset,
    options: Options,
    watch: &Watch,
) -> Result<Outcome, DiagnoseError> {
    if let Some(output) = training.constant_output() {
        return Err(DiagnoseError::Constant { channel: output.name.clone() });
    }
    let model = &options.asked_of(model)?;
    watch.tell("smoothing the recordings");
    let problem = Problem::new(model, training)?.watched_by(watch);
    let (decision, scope) = (options.decision, &options.scope);
    let search = Search::new(&problem, decision, scope, watch);
    let part = stretches::stretches(training);
    let part = part.as_ref().map(|part| Problem::new(model, part)).transpose()?;
    let part = part.map(|part| part.watched_by(watch));
    let found = match &part {
        None => search.run(options.learn_remainder)?,
        Some(part) => {
            search.run_in(&Search::new(part, decision, scope, watch), options.learn_remainder)?
        }
    };
    let otherwise = otherwise(part.as_ref().unwrap_or(&problem), &found.chosen, decision, watch);
    let found = if otherwise.is_some() { found.withheld() } else { found };
    watch.tell("proving on held-out recordings");
    let mut outcome = Ladder::new(&problem, held_out, decision, found, otherwise).outcome();
    outcome.diagnosis.notes.extend(options.notes().into_iter().chain(watch.note()));
    if watch.is_cancelled() {
        return Err(DiagnoseError::Cancelled);
    }
    Ok(outcome)
}

/// Seconds that the longest recording spans.
fn duration(dataset: &Dataset) -> f64 {
    let span = |o: &Observed| o.times[o.len() - 1] - o.times[0];
    dataset.recordings.iter().map(span).fold(0.0, f64::max)
}
