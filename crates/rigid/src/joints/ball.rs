//! A joint that turns about a point: by yaw about z, then by pitch about y, then by roll about x, each axis
//! turned along by those before, `R = R_z(yaw) R_y(pitch) R_x(roll)` as in a URDF's `rpy`.

use super::{JointKind, Step};

pub(super) fn steps() -> [Step; 3] {
    [("yaw", [0.0, 0.0, 1.0]), ("pitch", [0.0, 1.0, 0.0]), ("roll", [1.0, 0.0, 0.0])]
        .map(|(name, axis)| Step { name, kind: JointKind::Revolute, axis })
}
