//! Fleets' files, and the diagnoses that a fleet collects.

use super::file;
use lacuna::discrepancy::diagnosis::Diagnosis;
use lacuna::fleet::Plan;

/// Neither may panic, whatever the text is.
pub fn survive(text: &str) {
    let _ = Plan::read(&file("fleet.toml", text.as_bytes()));
    if let Ok(diagnosis) = serde_json::from_str::<Diagnosis>(text) {
        let _ = lacuna::report::summary(&diagnosis, false);
    }
}
