//! The model file of a case, and what is true of its parameters.

use lacuna_plants::Model;
use lacuna_plants::model::Parameter;
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use std::path::{Path, PathBuf};
use toml_edit::{DocumentMut, value};

use super::ConcealedError;
use super::effects::{sign, uniform};
use super::plants::{PlantSpec, draw_chain};
use super::topic::Topic;
use crate::StudyError;

/// Parameters are drawn within this factor of those in the plant's file.
const SPREAD: f64 = 1.25;
/// Probability that a parameter of a machine with missing physics is wrong as well.
const ALSO_WRONG: f64 = 0.5;

/// A model as files.
#[derive(Clone, Debug, PartialEq)]
pub struct Files {
    /// Text of the model file.
    pub model: String,
    /// Text of the robot's own file, if the model names one.
    pub robot: Option<String>,
}

/// Name of a robot's own file.
const ROBOT: &str = "robot.urdf";

impl Files {
    /// Write them into a folder; where the model file is then.
    ///
    /// # Errors
    /// [`StudyError::Write`].
    pub fn write(&self, folder: &Path) -> Result<PathBuf, StudyError> {
        let write = |name: &str, text: &str| {
            let path = folder.join(name);
            let written = std::fs::write(&path, text);
            written.map_err(|source| StudyError::Write { path: path.clone(), source })?;
            Ok::<_, StudyError>(path)
        };
        if let Some(text) = &self.robot {
            write(ROBOT, text)?;
        }
        write("model.toml", &self.model)
    }

    /// The model that they are.
    ///
    /// # Errors
    /// [`ConcealedError::Plant`] for files that are wrong, [`StudyError::Write`].
    pub fn read(&self) -> Result<Model, StudyError> {
        let folder = tempfile::tempdir()
            .map_err(|source| StudyError::Write { path: std::env::temp_dir(), source })?;
        let model = Model::read(&self.write(folder.path())?);
        Ok(model.map_err(|e| ConcealedError::Plant { reason: e.to_string() })?)
    }
}

/// The files of a model with parameters of its own, and the model.
///
/// # Errors
/// [`ConcealedError::Plant`] for a plant's file that is wrong.
pub fn draw(spec: &PlantSpec, rng: &mut ChaCha8Rng) -> Result<(Files, Model), StudyError> {
    if spec.joints > 0 {
        let robot = Some(draw_chain(spec.joints, rng));
        let files = Files { model: spec.model.to_owned(), robot };
        let model = files.read()?;
        return Ok((files, model));
    }
    let wrong = |reason: String| ConcealedError::Plant { reason };
    let mut document: DocumentMut =
        spec.model.parse().map_err(|e: toml_edit::TomlError| wrong(e.to_string()))?;
    let plain = Model::from_text(spec.model, "model.toml").map_err(|e| wrong(e.to_string()))?;
    for p in plain.parameters.iter().filter(|p| p.std() > 0.0) {
        let drawn = p.value * uniform(rng, -SPREAD.ln(), SPREAD.ln()).exp();
        document["parameters"][&p.name]["value"] = value(three_digits(drawn));
    }
    let text = document.to_string();
    let model = Model::from_text(&text, "model.toml").map_err(|e| wrong(e.to_string()))?;
    Ok((Files { model: text, robot: None }, model))
}

fn three_digits(value: f64) -> f64 {
    format!("{value:.2e}").parse().unwrap_or(value)
}

/// Whether a parameter may be drawn wrong: of a robot's links their masses, by which they stay possible.
fn may_be_wrong(model: &Model, k: usize) -> bool {
    let p = &model.parameters[k];
    p.std() > 0.0 && (model.dynamics().tree().is_none() || is_mass(p))
}

/// Whether a parameter of a robot is the mass of a link.
pub fn is_mass(parameter: &Parameter) -> bool {
    parameter.name.ends_with(".mass")
}

/// The model with the parameters that are true: some are off by about their tolerance.
pub fn miscalibrated(nominal: &Model, topic: Topic, rng: &mut ChaCha8Rng) -> Model {
    let mut model = nominal.clone();
    let uncertain: Vec<usize> =
        (0..model.parameters.len()).filter(|&k| may_be_wrong(&model, k)).collect();
    let wrong = match topic {
        Topic::Nothing(_) | Topic::Only(_) => 0,
        Topic::Parameter => rng.random_range(1..3),
        _ => usize::from(rng.random_range(0.0..1.0) < ALSO_WRONG),
    };
    for _ in 0..wrong {
        let p = &mut model.parameters[uncertain[rng.random_range(0..uncertain.len())]];
        p.value *= 1.0 + sign(rng) * uniform(rng, 0.4, 1.5) * p.tolerance();
    }
    model
}
