//! Models from text, and what is wrong with them.
#![allow(dead_code)]

use lacuna_plants::Model;

pub fn read(text: &str) -> Model {
    Model::from_text(text, "model.toml").unwrap_or_else(|e| panic!("{e}"))
}

pub fn error(text: &str) -> String {
    match Model::from_text(text, "model.toml") {
        Ok(_) => panic!("no error in\n{text}"),
        Err(e) => e.to_string(),
    }
}
