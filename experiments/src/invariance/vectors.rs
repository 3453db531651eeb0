//! Plain sums in place of the processor's vectors.

use super::{Agreement, Posed, Subject, Transformation};
use crate::StudyError;

pub(super) struct Vectors;

impl Transformation for Vectors {
    fn name(&self) -> &'static str {
        "plain vectors"
    }

    fn agreement(&self) -> Agreement {
        Agreement::Same
    }

    fn apply(&self, subject: &Subject) -> Result<Option<Posed>, StudyError> {
        let environment = vec![("LACUNA_VECTORS", "plain")];
        Ok(Some(Posed { environment, ..subject.posed.clone() }))
    }
}
