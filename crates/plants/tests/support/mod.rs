//! Models from text, and what is wrong with them.
#![allow(dead_code)]

use lacuna_plants::Model;
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
