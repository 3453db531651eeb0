//! What a diagnosis was made of, so that it is made once.

use super::Settings;
use crate::models::read_equations;
use crate::plants::Model;
use crate::recordings::Recording;
use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};
use std::error::Error;
use std::fmt::Write;
use std::path::Path;

/// Its file in a machine's folder: it is written last, and stands for the others.
pub(super) const FILE: &str = "inputs.json";

/// What a machine's results were made of.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Inputs {
    /// The model's name.
    pub model: String,
    /// Recordings that it was asked to fit.
    pub recordings: Vec<String>,
    /// Recordings for proof alone; none where some of the others were kept.
    pub held_out: Vec<String>,
    /// The version of Lacuna.
    pub version: String,
    /// SHA-256 of the text of the model and of the robot's own file, the numbers of the recordings with the names
    /// of their columns, the options and the version.
    pub sha256: String,
}

/// A model with the text that it was read from.
pub(super) struct Source {
    pub model: Model,
    text: Vec<u8>,
}

impl Source {
    pub fn read(path: &Path) -> Result<Self, Box<dyn Error>> {
        let model = read_equations(path, None)?;
        let text = std::fs::read(path).map_err(|e| format!("{}: {e}", path.display()))?;
        Ok(Self { model, text })
    }
}

impl Inputs {
    pub(super) fn of(
        source: &Source,
        (recordings, held_out): (&[Recording], &[Recording]),
        settings: &Settings,
    ) -> Self {
        let version = env!("CARGO_PKG_VERSION").to_owned();
        let mut hash = Hash(Sha256::new());
        hash.add(version.as_bytes());
        hash.add(&source.text);
        hash.add(source.model.robot_file().map_or(&b""[..], |f| f.text.as_bytes()));
        hash.add(settings.text().as_bytes());
        for recordings in [recordings, held_out] {
            hash.add(&recordings.len().to_le_bytes());
            recordings.iter().for_each(|r| hash.recording(r));
        }
        let names = |all: &[Recording]| all.iter().map(|r| r.name.clone()).collect();
        Self {
            model: source.model.name.clone(),
            recordings: names(recordings),
            held_out: names(held_out),
            version,
            sha256: hash.text(),
        }
    }
}

struct Hash(Sha256);

impl Hash {
    /// Bytes with their number, so that what follows cannot be mistaken for them.
    fn add(&mut self, bytes: &[u8]) {
        self.0.update((bytes.len() as u64).to_le_bytes());
        self.0.update(bytes);
    }

    fn recording(&mut self, recording: &Recording) {
        self.add(recording.name.as_bytes());
        self.values(&recording.time);
        self.add(&recording.columns.len().to_le_bytes());
        for column in &recording.columns {
            self.add(column.name.as_bytes());
            self.values(&column.values);
        }
    }

    fn values(&mut self, values: &[f64]) {
        let bytes: Vec<u8> = values.iter().flat_map(|v| v.to_le_bytes()).collect();
        self.add(&bytes);
    }

    fn text(self) -> String {
        self.0.finalize().iter().fold(String::new(), |mut text, byte| {
            let _ = write!(text, "{byte:02x}");
            text
        })
    }
}
