//! Fleets' files, and the diagnoses that a fleet collects.
#![no_main]

use lacuna::discrepancy::diagnosis::Diagnosis;
use lacuna::fleet::Plan;
use lacuna_fuzz::file;
use libfuzzer_sys::fuzz_target;

fuzz_target!(|text: &str| {
    let _ = Plan::read(&file("fleet.toml", text.as_bytes()));
    if let Ok(diagnosis) = serde_json::from_str::<Diagnosis>(text) {
        let _ = lacuna::report::summary(&diagnosis, false);
    }
});
