//! One machine: diagnosed, its results written whole, and not done twice.

use super::inputs::{self, Inputs, Source};
use super::plan::Machine;
use crate::diagnosed::{Diagnosed, datasets, recordings};
use crate::discrepancy::diagnose::{self, Options};
use crate::discrepancy::{Scope, Selector, Watch};
use crate::files::write_whole;
use crate::plants::Model;
use crate::recordings::{Recording, RecordingSource};
use serde_json::json;
use std::error::Error;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};
use std::time::Duration;

/// The file that says why a machine has no diagnosis.
pub(super) const FAILED: &str = "failed.json";

/// How each machine is diagnosed: the options of `lacuna diagnose`.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Settings {
    /// Keep what is left after the named effects as learned curves.
    pub learn_remainder: bool,
    /// Look for nothing but these.
    pub only: Vec<Selector>,
    /// Do not look for these.
    pub exclude: Vec<Selector>,
    /// Recorded inputs that are exactly what the machines got.
    pub exact: Vec<String>,
    /// Time after which the search of one machine ends with the best found by then.
    pub time_budget: Option<Duration>,
}

impl Settings {
    fn options(&self) -> Options {
        Options {
            learn_remainder: self.learn_remainder,
            scope: Scope { only: self.only.clone(), exclude: self.exclude.clone() },
            exact: self.exact.clone(),
            ..Options::default()
        }
    }

    /// All of it as text, for [`Inputs::sha256`].
    pub(super) fn text(&self) -> String {
        let texts = |all: &[Selector]| all.iter().map(ToString::to_string).collect::<Vec<_>>();
        let seconds = self.time_budget.map(|b| b.as_secs_f64());
        json!([self.learn_remainder, texts(&self.only), texts(&self.exclude), self.exact, seconds])
            .to_string()
    }
}

/// What became of a machine.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum State {
    /// It was diagnosed.
    Diagnosed,
    /// Its results were there, and are of the same inputs.
    There,
    /// It could not be diagnosed: why.
    Failed(String),
}

/// The work at the machines of a fleet: one model, one way of diagnosing, one folder.
pub struct Work {
    source: Source,
    settings: Settings,
    folder: PathBuf,
    /// What repeats it, for pages.
    command: String,
}

impl Work {
    /// With a model's file, results in `folder`; `command` is what pages say repeats them.
    ///
    /// # Errors
    /// What is wrong with the model's file, or with the options for this model.
    pub fn new(
        model: &Path,
        settings: Settings,
        folder: &Path,
        command: &str,
    ) -> Result<Self, Box<dyn Error>> {
        let source = Source::read(model)?;
        settings.options().scope.check(&source.model)?;
        Ok(Self { source, settings, folder: folder.to_owned(), command: command.to_owned() })
    }

    /// The model of all machines.
    pub fn model(&self) -> &Model {
        &self.source.model
    }

    /// The recordings of a machine that are files.
    ///
    /// # Errors
    /// None to fit, or what is wrong with one.
    pub fn read(
        &self,
        machine: &Machine,
    ) -> Result<(Vec<Recording>, Vec<Recording>), Box<dyn Error>> {
        let all = |sources: &[RecordingSource]| recordings(&self.source.model, sources);
        if machine.recordings.is_empty() {
            return Err(format!("no recordings to fit; looked for in {}", machine.sought).into());
        }
        Ok((all(&machine.recordings)?, all(&machine.held_out)?))
    }

    /// Diagnose the machine `name`, or find that this was done. Recordings are what `read` gives, to fit and for
    /// proof alone. What cannot be diagnosed is written to failed.json, and tried again the next time.
    ///
    /// # Errors
    /// Results that cannot be written. What is wrong with a machine is none: see [`State::Failed`].
    pub fn diagnose(
        &self,
        name: &str,
        recordings: impl FnOnce() -> Result<(Vec<Recording>, Vec<Recording>), Box<dyn Error>>,
        watch: Watch,
    ) -> Result<State, Box<dyn Error>> {
        let folder = self.folder.join(name);
        let watch = &match self.settings.time_budget {
            Some(budget) => watch.within(budget),
            None => watch,
        };
        let found = match recordings() {
            Ok((recordings, held_out)) => {
                let inputs = Inputs::of(&self.source, (&recordings, &held_out), &self.settings);
                if is_done(&folder, &inputs) {
                    return Ok(State::There);
                }
                self.found(&recordings, &held_out, watch).map(|found| (found, inputs))
            }
            Err(error) => Err(error),
        };
        // What stands for results that are being replaced must not outlive them.
        remove(&folder.join(inputs::FILE))?;
        match found {
            Ok((found, inputs)) => {
                found.write(&folder, &self.command)?;
                remove(&folder.join(FAILED))?;
                write_whole(&folder.join(inputs::FILE), &serde_json::to_string_pretty(&inputs)?)?;
                Ok(State::Diagnosed)
            }
            Err(_) if watch.is_cancelled() => Err("called off".into()),
            Err(error) => {
                let error = error.to_string();
                let text = serde_json::to_string_pretty(&json!({ "error": error }))?;
                write_whole(&folder.join(FAILED), &text)?;
                Ok(State::Failed(error))
            }
        }
    }

    fn found(
        &self,
        recordings: &[Recording],
        held_out: &[Recording],
        watch: &Watch,
    ) -> Result<Diagnosed, Box<dyn Error>> {
        let model = &self.source.model;
        let (training, held_out) = datasets(model, recordings, held_out)?;
        let outcome =
            diagnose::diagnose(model, &training, &held_out, self.settings.options(), watch)?;
        Ok(Diagnosed::new(model.clone(), &training, outcome))
    }

    /// Whether a machine is done: its results are of these very inputs, or it failed.
    pub fn is_settled(&self, machine: &Machine) -> bool {
        let folder = self.folder.join(&machine.name);
        if folder.join(FAILED).exists() {
            return true;
        }
        // Recordings are read only where there is something to compare them with.
        folder.join(inputs::FILE).exists()
            && self.read(machine).is_ok_and(|(recordings, held_out)| {
                is_done(
                    &folder,
                    &Inputs::of(&self.source, (&recordings, &held_out), &self.settings),
                )
            })
    }
}

/// Whether a folder has the results of these inputs.
fn is_done(folder: &Path, inputs: &Inputs) -> bool {
    let text = std::fs::read_to_string(folder.join(inputs::FILE)).unwrap_or_default();
    serde_json::from_str::<Inputs>(&text).is_ok_and(|there| there == *inputs)
}

fn remove(path: &Path) -> Result<(), Box<dyn Error>> {
    match std::fs::remove_file(path) {
        Err(e) if e.kind() != ErrorKind::NotFound => Err(format!("{}: {e}", path.display()).into()),
        _ => Ok(()),
    }
}
