//! Rigid bodies that hang together by joints: a kinematic tree obeys
//!
//! ```text
//! M(q) q'' + h(q, q') = tau
//! ```
//!
//! | on paper | in code |
//! | --- | --- |
//! | body i, its parent p(i) | [`Body`] in [`Tree::bodies`], [`Body::parent`] |
//! | joint i: axis z_i, turned or slid along by q_i | [`Joint`] |
//! | a joint of several coordinates: as many joints, links of no mass between | [`Several`], `joints` |
//! | joint that follows coordinate c: at r q_c + o | [`Mimic`], [`Joint::ratio`], [`Joint::offset`] |
//! | pose of joint i in its parent's frame at q_i = 0, z_i being its z axis | [`Joint::pose`] |
//! | mass m, first moment m c, inertia I about the frame's origin | [`Inertia`] |
//! | mass matrix M | [`Dynamics::mass_matrix`] |
//! | derivatives of tau by q and q', q'' held | [`Dynamics::derivatives`] |
//! | tau = M q'' + h; h of Coriolis, centrifugal and gravity forces is that where q'' = 0 | [`Dynamics::inverse`] |
//!
//! All of it in any [`lacuna_numbers::Number`], so that derivatives by coordinates, velocities and
//! the parameters of bodies are exact. h is found by the recursive Newton-Euler equations, M by
//! composite bodies (Featherstone, *Rigid Body Dynamics Algorithms*, 2008, chapters 5 and 6); vectors are
//! those of three dimensions, in each body's own frame.
//!
//! Trees are those of robots' own files, [`urdf`] or [`mjcf`]: [`read`]. Such a file is written with other
//! values in it by [`edit`](mod@edit).
//!
//! SI units: metres, radians, kilograms, seconds.

mod algebra;
mod dynamics;
pub mod edit;
mod inertia;
mod joints;
pub mod mjcf;
mod motion;
mod robot;
mod size;
mod tree;
pub mod urdf;
mod xml;

pub use algebra::{Matrix, Pose, Vector};
pub use dynamics::{Dynamics, Room};
pub use inertia::{Inertia, InertialParameters};
pub use joints::{JointKind, Mimic, Several};
pub use motion::Motion;
pub use robot::{
    Coupling, Format, Link, Moves, PositionServo, Robot, RobotError, RobotJoint, ServoDamping,
};
pub use tree::{Body, Joint, Part, Tree};

/// Gravity where nothing else is said, m/s^2, in the frame of the root.
pub const GRAVITY: Vector<f64> = [0.0, 0.0, -9.81];

/// Read a robot from the text of its file, in the format that its first element says.
///
/// # Errors
/// [`RobotError`] with the line: what is wrong with a [`urdf`] or an [`mjcf`], or another format.
pub fn read(text: &str) -> Result<Robot, RobotError> {
    let source = xml::Source::parse(text)?;
    let root = source.root();
    match root.tag() {
        "robot" => urdf::robot(root),
        "mujoco" => mjcf::robot(root),
        other => Err(root.error(format!(
            "a robot's file holds a <robot> (URDF) or a <mujoco> (MJCF); found <{other}>"
        ))),
    }
}
