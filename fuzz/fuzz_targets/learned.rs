//! Identified and compiled models.
#![no_main]

use lacuna::models::{AnyModel, LearnedModel};
use lacuna_fuzz::file;
use libfuzzer_sys::fuzz_target;

fuzz_target!(|data: &[u8]| {
    let path = file("model.json", data);
    let _ = AnyModel::read(&path);
    let _ = LearnedModel::read(&path);
});
