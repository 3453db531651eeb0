//! Times since another second.

use super::{Agreement, Posed, Subject, Transformation};
use crate::StudyError;

/// As times since 1970 are written (s).
const LATER: f64 = 1e9;

pub(super) struct Times;

impl Transformation for Times {
    fn name(&self) -> &'static str {
        "times"
    }

    fn agreement(&self) -> Agreement {
        Agreement::Same
    }

    fn apply(&self, subject: &Subject) -> Result<Option<Posed>, StudyError> {
        let mut posed = subject.posed.clone();
        let times = posed.recordings.iter_mut().flat_map(|r| &mut r.time);
        times.for_each(|t| *t += LATER);
        Ok(Some(posed))
    }
}
