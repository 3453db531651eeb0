//! A joint that slides in a plane and turns about what stands on it.
//!
//! x in the plane is the x axis of the joint's frame as the plane has it, or the y axis where the plane stands
//! across x; y is across both.

use super::{JointKind, Step};
use crate::algebra::{Vector, cross, dot, scaled, sub, unit};

/// How far along x a normal may be for x to say a direction of the plane: as far as half a right angle.
const ALONG: f64 = std::f64::consts::FRAC_1_SQRT_2;

pub(super) fn steps(normal: Vector<f64>) -> Vec<Step> {
    let along = if normal[0].abs() <= ALONG { [1.0, 0.0, 0.0] } else { [0.0, 1.0, 0.0] };
    let in_plane = sub(along, scaled(normal, dot(along, normal)));
    let x = unit(in_plane).unwrap_or(along);
    [
        ("x", JointKind::Prismatic, x),
        ("y", JointKind::Prismatic, cross(normal, x)),
        ("yaw", JointKind::Revolute, normal),
    ]
    .map(|(name, kind, axis)| Step { name, kind, axis })
    .to_vec()
}
