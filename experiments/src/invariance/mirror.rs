//! Coordinates that count the other way.

use super::{Agreement, Posed, Subject, Transformation};
use crate::StudyError;

pub(super) struct Mirror;

impl Transformation for Mirror {
    fn name(&self) -> &'static str {
        "mirrored"
    }

    fn agreement(&self) -> Agreement {
        Agreement::Same
    }

    fn apply(&self, subject: &Subject) -> Result<Option<Posed>, StudyError> {
        let mut posed = subject.posed.clone();
        let coordinates = posed.channels().into_iter().filter(|c| c.section == "coordinate");
        let factors: std::collections::BTreeMap<_, _> =
            coordinates.map(|c| (c.name, -1.0)).collect();
        posed.rescale(&factors);
        Ok((!factors.is_empty()).then_some(posed))
    }
}
