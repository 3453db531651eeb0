//! Model files, and what is written of them.

use lacuna::plants::Model;

/// What is wrong in one is told with the file's name.
pub fn survive(text: &str) {
    match Model::from_text(text, "model.toml") {
        Ok(model) => {
            for channel in 0..model.channels() {
                assert!(!model.force_unit(channel).is_empty());
            }
        }
        Err(error) => assert!(error.to_string().starts_with("model.toml"), "{error}"),
    }
}
