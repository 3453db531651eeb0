//! How joints let bodies move, one way a file.
//!
//! | joint | its coordinates |
//! | --- | --- |
//! | [`JointKind::Revolute`] | an angle about its axis |
//! | [`JointKind::Prismatic`] | a way along its axis |
//! | [`Several::Planar`] | `_x` and `_y` in a plane, then `_yaw` about what stands on it |
//! | [`Several::Floating`] | `_x`, `_y`, `_z`, then as [`Several::Ball`] |
//! | [`Several::Ball`] | `_yaw`, `_pitch`, `_roll`: about z, then the y and then the x that are turned along |
//! | [`Mimic`] | none of its own: that of another joint, scaled and shifted |
//!
//! A joint of several coordinates is a chain of joints of one each, with links of no mass between them; their
//! coordinates are called after the joint, `base_yaw`. Pitch at a right angle is singular: there yaw and roll
//! turn about one axis, and the mass matrix has no inverse.

mod ball;
mod floating;
mod mimic;
mod planar;
mod prismatic;
mod revolute;

pub use mimic::Mimic;
pub(crate) use mimic::{Role, check, roles};

use crate::algebra::{Matrix, Pose, Vector};
use lacuna_numbers::Number;

/// How a body moves relative to its parent.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum JointKind {
    /// It turns, rad.
    Revolute,
    /// It slides, m.
    Prismatic,
}

/// How a body moves relative to its parent by more than one coordinate.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Several {
    /// In a plane.
    Planar,
    /// Freely.
    Floating,
    /// About a point.
    Ball,
}

/// One coordinate of several.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Step {
    /// How its name ends.
    pub name: &'static str,
    pub kind: JointKind,
    /// A unit vector in the frame that the steps before have moved.
    pub axis: Vector<f64>,
}

impl Several {
    /// What such a joint is.
    #[must_use]
    pub fn called(self) -> &'static str {
        match self {
            Self::Planar => "planar",
            Self::Floating => "floating",
            Self::Ball => "a ball joint",
        }
    }

    /// Its coordinates, the parent's first.
    pub(crate) fn steps(self, axis: Vector<f64>) -> Vec<Step> {
        match self {
            Self::Planar => planar::steps(axis),
            Self::Floating => floating::steps(),
            Self::Ball => ball::steps().to_vec(),
        }
    }
}

impl JointKind {
    /// Axes, as columns, and origin of a joint's frame in the parent's joint's: at coordinate 0 it stands so.
    #[inline(always)]
    pub(crate) fn frame<T: Number>(self, at_zero: &Pose, q: T) -> (Matrix<T>, Vector<T>) {
        match self {
            Self::Revolute => revolute::frame(at_zero, q),
            Self::Prismatic => prismatic::frame(at_zero, q),
        }
    }

    /// What a coordinate does to a body that moves about or along an axis through a point.
    pub(crate) fn moved(self, axis: Vector<f64>, anchor: Vector<f64>, at: f64) -> Pose {
        match self {
            Self::Revolute => revolute::moved(axis, anchor, at),
            Self::Prismatic => prismatic::moved(axis, at),
        }
    }

    /// The share of a force and its torque that a joint feels along its axis, z.
    #[inline(always)]
    pub(crate) fn share<T: Number>(self, force: Vector<T>, torque: Vector<T>) -> T {
        match self {
            Self::Revolute => torque[2],
            Self::Prismatic => force[2],
        }
    }
}
