//! The model, and its columns, in other units.

use super::{Agreement, Posed, Subject, Transformation};
use crate::StudyError;
use std::collections::BTreeMap;
use std::f64::consts::PI;

pub(super) struct Units;

/// Another unit in place of one, and how many there are in it.
pub(super) fn other(unit: &str) -> Option<(&'static str, f64)> {
    match unit {
        "rad" => Some(("deg", 180.0 / PI)),
        "m" => Some(("mm", 1e3)),
        "rad/s" => Some(("rpm", 30.0 / PI)),
        "N" => Some(("mN", 1e3)),
        "N m" => Some(("mN m", 1e3)),
        "A" => Some(("mA", 1e3)),
        "V" => Some(("mV", 1e3)),
        _ => None,
    }
}

impl Transformation for Units {
    fn name(&self) -> &'static str {
        "units"
    }

    fn agreement(&self) -> Agreement {
        Agreement::Same
    }

    fn apply(&self, subject: &Subject) -> Result<Option<Posed>, StudyError> {
        let mut posed = subject.posed.clone();
        let (mut factors, mut units) = (BTreeMap::new(), BTreeMap::new());
        for channel in posed.channels() {
            if let Some((unit, factor)) = other(&channel.unit) {
                factors.insert(channel.name.clone(), factor);
                units.insert(channel.name, unit.to_owned());
            }
        }
        posed.rescale(&factors);
        posed.say_units(&units);
        Ok((!units.is_empty()).then_some(posed))
    }
}
