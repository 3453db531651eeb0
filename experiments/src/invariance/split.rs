//! A recording cut in two files, as a logger does that begins a new one.

use super::{Agreement, Posed, Subject, Transformation};
use crate::StudyError;

pub(super) struct Split;

impl Transformation for Split {
    fn name(&self) -> &'static str {
        "split"
    }

    fn agreement(&self) -> Agreement {
        Agreement::Identical
    }

    fn apply(&self, subject: &Subject) -> Result<Option<Posed>, StudyError> {
        let mut posed = subject.posed.clone();
        let head = &mut posed.recordings[1];
        let usual = (head.time[head.len() - 1] - head.time[0]) / (head.len() - 1) as f64;
        // Between two rows of which none was lost.
        let whole = |k: &usize| head.time[*k] - head.time[k - 1] < 1.3 * usual;
        let Some(cut) = (head.len() * 2 / 5..head.len()).find(whole) else { return Ok(None) };
        let mut tail = head.clone();
        tail.name = format!("more of {}", tail.name);
        head.time.truncate(cut);
        tail.time.drain(..cut);
        for (head, tail) in head.columns.iter_mut().zip(&mut tail.columns) {
            head.values.truncate(cut);
            tail.values.drain(..cut);
        }
        posed.recordings.insert(0, tail);
        Ok(Some(posed))
    }
}
