//! Recordings, and the columns of each, in another order.

use super::{Agreement, Posed, Subject, Transformation};
use crate::StudyError;

pub(super) struct Order;

impl Transformation for Order {
    fn name(&self) -> &'static str {
        "order"
    }

    fn agreement(&self) -> Agreement {
        Agreement::Identical
    }

    fn apply(&self, subject: &Subject) -> Result<Option<Posed>, StudyError> {
        let mut posed = subject.posed.clone();
        posed.recordings.rotate_left(2);
        posed.recordings.swap(0, 1);
        posed.recordings.iter_mut().for_each(|r| r.columns.reverse());
        Ok(Some(posed))
    }
}
