//! A joint that holds nothing: the body's origin is at x, y and z along the axes of the joint's frame, and the
//! body is turned there as by a ball joint.

use super::{JointKind, Step, ball};

pub(super) fn steps() -> Vec<Step> {
    let slides = [("x", [1.0, 0.0, 0.0]), ("y", [0.0, 1.0, 0.0]), ("z", [0.0, 0.0, 1.0])]
        .map(|(name, axis)| Step { name, kind: JointKind::Prismatic, axis });
    [slides, ball::steps()].concat()
}
