//! One more recording, in which nothing moves.

use super::{Agreement, Posed, Subject, Transformation};
use crate::StudyError;
use crate::concealed::case::Case;

pub(super) struct Rest;

impl Transformation for Rest {
    fn name(&self) -> &'static str {
        "rest"
    }

    fn agreement(&self) -> Agreement {
        Agreement::Same
    }

    fn apply(&self, subject: &Subject) -> Result<Option<Posed>, StudyError> {
        let mut posed = subject.posed.clone();
        let Some(mut rest) = Case::rest(subject.seed, subject.plan)? else { return Ok(None) };
        rest.name = "rest.csv".to_owned();
        posed.recordings.push(rest);
        Ok(Some(posed))
    }
}
