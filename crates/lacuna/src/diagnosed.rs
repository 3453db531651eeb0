//! What `diagnose` does with recordings before a diagnosis, and with its outcome after it.

use crate::discrepancy::diagnose::{self, Outcome, Proof};
use crate::discrepancy::diagnosis::Diagnosis;
use crate::discrepancy::robot_file::{Augmented, augmented};
use crate::discrepancy::{Dataset, DiagnoseError, Observed, Output};
use crate::files::write_together;
use crate::plants::Model;
use crate::plants::model::{Measured, ModelError};
use crate::recordings::{
    Log, Recording, RecordingError, RecordingSource, arranged, read_log, without_shared,
};
use crate::report;
use std::error::Error;
use std::io;
use std::path::{Path, PathBuf};

/// What these files hold of what the model uses ([`Dataset::wanted`]).
///
/// # Errors
/// [`RecordingError`] with the file and place.
pub fn logs(model: &Model, sources: &[RecordingSource]) -> Result<Vec<Log>, RecordingError> {
    let wanted = Dataset::wanted(model);
    sources.iter().map(|source| read_log(source, &wanted)).collect()
}

/// The recordings of [`logs`].
///
/// # Errors
/// As [`logs`].
pub fn recordings(
    model: &Model,
    sources: &[RecordingSource],
) -> Result<Vec<Recording>, RecordingError> {
    Ok(logs(model, sources)?.into_iter().map(|log| log.recording).collect())
}

/// Training and held-out data, the noise of the training recordings in both. Without recordings that
/// are held out some are kept: one in four, or the last quarter of a single one. Recordings are arranged by what they
/// hold ([`arranged`]): their order and copies of them change nothing, and those that go on from another are one with it.
///
/// What is fitted proves nothing. Rows that both have ([`without_shared`]) are left out of the held-out ones; where
/// that leaves none of these, out of those to fit; and where nothing is left to fit either, as if none were held out.
///
/// # Errors
/// What does not fit the model, with the names of the recording and column.
pub fn datasets(
    model: &Model,
    recordings: &[Recording],
    held_out: &[Recording],
) -> Result<(Dataset, Dataset), DiagnoseError> {
    let (recordings, held_out) = (arranged(recordings), arranged(held_out));
    let without = |a: &[_], b: &[_]| without_shared(a, b, Dataset::FEWEST_SAMPLES);
    let Some(unseen) = without(&held_out, &recordings) else {
        return training_and_proof(model, &recordings, &held_out);
    };
    let (training, proof, note) = if !unseen.is_empty() {
        let note = "Held-out recordings have rows that are fitted as well: these prove nothing and are left out of the proof.";
        (recordings, unseen, note)
    } else if let Some(rest) = without(&recordings, &held_out).filter(|rest| !rest.is_empty()) {
        let note = "The held-out recordings are among those to fit: they are left out of these, for proof alone.";
        (rest, held_out, note)
    } else {
        let note = "All that is to be fitted is held out as well, which would prove nothing: a part is kept for proof, as where nothing is held out.";
        (recordings, vec![], note)
    };
    let (training, mut proof) = training_and_proof(model, &training, &proof)?;
    proof.notes.push(note.to_owned());
    Ok((training, proof))
}

/// Datasets of recordings that share nothing; without held-out ones some of the others are kept.
fn training_and_proof(
    model: &Model,
    recordings: &[Recording],
    held_out: &[Recording],
) -> Result<(Dataset, Dataset), DiagnoseError> {
    let all = Dataset::new(model, recordings)?;
    if held_out.is_empty() {
        return Ok(diagnose::split(&all));
    }
    let held = all.for_proof(Dataset::new(model, held_out)?)?;
    Ok((all, held))
}

/// A diagnosis with all that can be told, drawn and written of it.
pub struct Diagnosed {
    model: Model,
    outcome: Outcome,
    /// The series that the page draws.
    proofs: Vec<report::Proof>,
}

impl Diagnosed {
    /// What became of a model on training data.
    pub fn new(model: Model, training: &Dataset, outcome: Outcome) -> Self {
        let proofs = series(&model, &training.outputs, &outcome.proofs);
        Self { model, outcome, proofs }
    }

    /// The diagnosis.
    pub fn diagnosis(&self) -> &Diagnosis {
        &self.outcome.diagnosis
    }

    /// What diagnosis.json holds.
    ///
    /// # Errors
    /// None: these are numbers and names.
    pub fn json(&self) -> serde_json::Result<String> {
        serde_json::to_string_pretty(&self.outcome.diagnosis)
    }

    /// The model with what was found, as text.
    ///
    /// # Errors
    /// A text that has effects in another form than `[[effect]]`.
    pub fn augmented_text(&self) -> Result<String, ModelError> {
        self.model.augmented_text(&self.outcome.augmentation)
    }

    /// The robot's own file with what was found; none where the model is of no robot.
    ///
    /// # Errors
    /// A file that cannot be edited.
    pub fn robot(&self) -> Result<Option<Augmented>, Box<dyn Error>> {
        Ok(augmented(&self.model, &self.outcome.augmentation, &self.outcome.diagnosis.findings)?)
    }

    /// The page, with the command that repeats the diagnosis.
    ///
    /// # Errors
    /// As [`Diagnosed::augmented_text`].
    pub fn page(&self, command: &str) -> Result<String, ModelError> {
        Ok(report::page(&self.outcome.diagnosis, &self.augmented_text()?, &self.proofs, command))
    }

    /// Write diagnosis.json, augmented.toml, report.html and, of a robot, its own file to a folder. Returns
    /// the robot's file.
    ///
    /// # Errors
    /// Those of [`Diagnosed::augmented_text`] and [`Diagnosed::robot`], or the underlying error with the path.
    pub fn write(&self, folder: &Path, command: &str) -> Result<Option<Augmented>, Box<dyn Error>> {
        let robot = self.robot()?;
        let (json, text, page) = (self.json()?, self.augmented_text()?, self.page(command)?);
        let mut files =
            vec![("diagnosis.json", &*json), ("augmented.toml", &*text), ("report.html", &*page)];
        files.extend(robot.iter().map(|file| (&*file.name, &*file.text)));
        write_to(folder, &files)?;
        Ok(robot)
    }

    /// Write the page's pictures as SVG files to figures/ in a folder.
    ///
    /// # Errors
    /// The underlying error, with the path.
    pub fn write_figures(&self, folder: &Path) -> io::Result<()> {
        let files = report::files(&self.outcome.diagnosis, &self.proofs);
        let named: Vec<_> = files.iter().map(|f| (&*f.name, &*f.svg)).collect();
        write_to(&folder.join("figures"), &named)
    }
}

/// Write files of these names to a folder.
fn write_to(folder: &Path, files: &[(&str, &str)]) -> io::Result<()> {
    let paths: Vec<PathBuf> = files.iter().map(|(name, _)| folder.join(name)).collect();
    let texts = files.iter().map(|(_, text)| *text);
    write_together(&paths.iter().map(PathBuf::as_path).zip(texts).collect::<Vec<_>>())
}

/// The series that the report draws.
fn series(model: &Model, outputs: &[Output], proofs: &[Proof]) -> Vec<report::Proof> {
    let one = |p: &Proof, k: usize, output: &Output| report::Proof {
        recording: p.observed.name.clone(),
        channel: output.name.clone(),
        unit: output.unit.clone(),
        time: p.observed.times.clone(),
        measured: p.observed.outputs[k].clone(),
        before: p.before.outputs[k].clone(),
        after: p.after.outputs[k].clone(),
        imposed: imposed(model, output, &p.observed),
    };
    proofs.iter().flat_map(|p| outputs.iter().enumerate().map(move |(k, o)| one(p, k, o))).collect()
}

/// The imposed motion that an output is drawn against: all of it, where it may be a force on it.
fn imposed(model: &Model, output: &Output, observed: &Observed) -> Vec<report::Imposed> {
    let n = model.coordinates.len();
    let of = |c: usize| {
        let motion = model.motion_index(c)?;
        Some([(c, motion), (c + n, motion + 1)].map(|(state, column)| report::Imposed {
            name: model.state_name(state).to_owned(),
            unit: model.state_unit(state),
            values: observed.command(column),
        }))
    };
    let all = || model.imposed().filter_map(of).flatten().collect();
    match output.of {
        Measured::Force(c) => of(c).into_iter().flatten().collect(),
        Measured::Output(_) => all(),
        Measured::State(_) | Measured::Input(_) => vec![],
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::recordings::Column;
    use std::ops::Range;

    const MODEL: &str = r#"
name = "cart"
[parameters]
m = { value = 2.0, unit = "kg" }
[[input]]
name = "F"
unit = "N"
[[coordinate]]
name = "x"
velocity = "v"
unit = "m"
[mechanics]
mass = [["m"]]
force = ["F"]
[recordings]
time = "t"
input_hold = "linear"
"#;

    fn run(name: &str, rows: Range<usize>, phase: f64) -> Recording {
        let time: Vec<f64> = rows.map(|k| 0.01 * k as f64).collect();
        let wave = |rate: f64| time.iter().map(|t| (rate * t + phase).sin()).collect();
        let column = |name: &str, values| Column { name: name.into(), values };
        let columns = vec![column("x", wave(3.0)), column("F", wave(5.0))];
        Recording { name: name.into(), time, columns }
    }

    /// The names of what is fitted and of what is kept for proof, and what is said of it.
    fn chosen(recordings: &[&Recording], held_out: &[&Recording]) -> (String, String, String) {
        let model = Model::from_text(MODEL, "cart.toml").unwrap();
        let own = |all: &[&Recording]| all.iter().copied().cloned().collect::<Vec<_>>();
        let (training, proof) = datasets(&model, &own(recordings), &own(held_out)).unwrap();
        let names = |d: &Dataset| {
            let mut names: Vec<&str> = d.recordings.iter().map(|o| &*o.name).collect();
            names.sort_unstable();
            names.join(", ")
        };
        (names(&training), names(&proof), proof.notes.join(" "))
    }

    #[test]
    fn what_is_fitted_proves_nothing() {
        let [a, b, c] = ["a", "b", "c"].map(|name| run(name, 0..600, name.as_bytes()[0].into()));
        let apart = chosen(&[&a, &b], &[&c]);
        assert_eq!((&*apart.0, &*apart.1, &*apart.2), ("a, b", "c", ""));

        // An end of one that is fitted, and a copy beside a run of its own.
        let (fitted, proof, said) =
            chosen(&[&run("a", 0..400, 97.0)], &[&run("a", 300..600, 97.0)]);
        assert_eq!((&*fitted, &*proof), ("a", "a (4.000 to 5.990 s)"));
        assert!(said.contains("left out of the proof"), "{said}");
        let copy = Recording { name: "copy".into(), ..a.clone() };
        let (fitted, proof, said) = chosen(&[&a, &b], &[&copy, &c]);
        assert_eq!((&*fitted, &*proof), ("a, b", "c"));
        assert!(said.contains("left out of the proof"), "{said}");

        // One of those that are fitted, as `*.csv` names it too, and a part of the only one.
        let (fitted, proof, said) = chosen(&[&a, &b, &c], &[&c]);
        assert_eq!((&*fitted, &*proof), ("a, b", "c"));
        assert!(said.contains("for proof alone"), "{said}");
        let (fitted, proof, _) = chosen(&[&a], &[&run("part", 200..350, 97.0)]);
        assert_eq!((&*fitted, &*proof), ("a (0.000 to 1.990 s), a (3.500 to 5.990 s)", "part"));

        // The same altogether: as where none is held out.
        let (fitted, proof, said) = chosen(&[&a], &[&a]);
        let (alone, kept, nothing) = chosen(&[&a], &[]);
        assert_eq!((fitted, proof, nothing), (alone, kept, String::new()));
        assert!(said.contains("would prove nothing"), "{said}");
    }
}
