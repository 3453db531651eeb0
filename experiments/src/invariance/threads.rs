//! Sixteen threads in place of one.

use super::{Agreement, Posed, Subject, Transformation};
use crate::StudyError;

pub(super) struct Threads;

impl Transformation for Threads {
    fn name(&self) -> &'static str {
        "threads"
    }

    fn agreement(&self) -> Agreement {
        Agreement::Identical
    }

    fn apply(&self, subject: &Subject) -> Result<Option<Posed>, StudyError> {
        let environment = vec![("RAYON_NUM_THREADS", "16")];
        Ok(Some(Posed { environment, ..subject.posed.clone() }))
    }
}
