//! Recordings given twice.

use super::{Agreement, Posed, Subject, Transformation};
use crate::StudyError;

pub(super) struct Twice;

impl Transformation for Twice {
    fn name(&self) -> &'static str {
        "twice"
    }

    fn agreement(&self) -> Agreement {
        Agreement::Identical
    }

    fn apply(&self, subject: &Subject) -> Result<Option<Posed>, StudyError> {
        let mut posed = subject.posed.clone();
        for k in [0, 3] {
            let mut copy = posed.recordings[k].clone();
            copy.name = format!("copy of {}", copy.name);
            posed.recordings.push(copy);
        }
        Ok(Some(posed))
    }
}
