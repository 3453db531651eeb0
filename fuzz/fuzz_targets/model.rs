//! Model files, and what is written of them.
#![no_main]

use lacuna::plants::Model;
use libfuzzer_sys::fuzz_target;

fuzz_target!(|text: &str| {
    match Model::from_text(text, "model.toml") {
        Ok(model) => {
            for channel in 0..model.channels() {
                assert!(!model.force_unit(channel).is_empty());
            }
        }
        Err(error) => assert!(error.to_string().starts_with("model.toml"), "{error}"),
    }
});
