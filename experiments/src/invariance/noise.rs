//! The same motion with other noise.

use super::{Agreement, Posed, Subject, Transformation};
use crate::StudyError;
use crate::concealed::case::Case;

pub(super) struct Noise;

impl Transformation for Noise {
    fn name(&self) -> &'static str {
        "noise"
    }

    fn agreement(&self) -> Agreement {
        Agreement::Same
    }

    fn apply(&self, subject: &Subject) -> Result<Option<Posed>, StudyError> {
        Ok(Some(Posed::of(&Case::draw_with_noise(subject.seed, subject.plan, 1)?)?))
    }
}
