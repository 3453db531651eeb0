//! Models from text, and what is wrong with them.
#![allow(dead_code)]

use lacuna_numbers::{Dual, Number};
use lacuna_plants::model::Direction;
use lacuna_plants::{Hold, Model, Substeps, System};
use std::path::PathBuf;

/// A folder of a model and of what stands beside it.
pub struct Folder(tempfile::TempDir);

impl Folder {
    pub fn new() -> Self {
        Self(tempfile::tempdir().expect("a folder"))
    }

    pub fn file(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    pub fn write(&self, name: &str, text: impl AsRef<str>) {
        std::fs::write(self.file(name), text.as_ref()).expect("a file");
    }

    pub fn model(&self, text: &str) -> Result<Model, String> {
        let file = self.file("model.toml").display().to_string();
        Model::from_text(text, &file).map_err(|e| e.to_string())
    }
}

pub fn read(text: &str) -> Model {
    Model::from_text(text, "model.toml").unwrap_or_else(|e| panic!("{e}"))
}

pub fn error(text: &str) -> String {
    match Model::from_text(text, "model.toml") {
        Ok(_) => panic!("no error in\n{text}"),
        Err(e) => e.to_string(),
    }
}

/// The states of a model of one input at the samples behind the first, with derivatives in a direction, and how many steps
/// they took: the input is given at each sample, so many seconds apart.
pub fn states(
    model: &Model,
    direction: Direction,
    (step, inputs, hold): (f64, &[f64], Hold),
    start: &[f64],
    substeps: Substeps,
) -> (Vec<Dual>, usize) {
    let along = [(direction, 0)];
    let system = System::<Dual>::along(model, &model.values(), &model.effects, &along, step);
    let times: Vec<f64> = (0..inputs.len()).map(|k| step * k as f64).collect();
    let path = hold.along((&times, inputs), 0..inputs.len(), 1, substeps.count);
    let mut x: Vec<Dual> = start.iter().copied().map(Dual::constant).collect();
    let (mut room, mut states) = (system.workspace(), vec![]);
    for (k, pair) in times.windows(2).enumerate() {
        system.advance(&mut room, (pair[0], pair[1]), path.step_in(k), substeps, &mut x);
        states.extend_from_slice(&x);
    }
    (states, room.steps())
}
