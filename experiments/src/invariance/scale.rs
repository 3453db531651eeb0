//! Coordinates in units a million times as large, or as small.

use super::{Agreement, Posed, Subject, Transformation};
use crate::StudyError;
use std::collections::BTreeMap;

pub(super) struct Scale(pub f64);

impl Transformation for Scale {
    fn name(&self) -> &'static str {
        if self.0 < 1.0 { "scaled down" } else { "scaled up" }
    }

    fn agreement(&self) -> Agreement {
        Agreement::Same
    }

    fn apply(&self, subject: &Subject) -> Result<Option<Posed>, StudyError> {
        let mut posed = subject.posed.clone();
        let prefix = if self.0 < 1.0 { "M" } else { "u" };
        let scaled = |unit: &str| matches!(unit, "rad" | "m" | "A" | "rad/s");
        let channels = posed.channels().into_iter();
        let units: BTreeMap<String, String> = channels
            .filter(|c| c.section != "input" && scaled(&c.unit))
            .map(|c| (c.name, format!("{prefix}{}", c.unit)))
            .collect();
        posed.rescale(&units.keys().map(|name| (name.clone(), self.0)).collect());
        posed.say_units(&units);
        Ok((!units.is_empty()).then_some(posed))
    }
}
