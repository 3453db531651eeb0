//! Robots from MJCF files, the XML of MuJoCo: bodies and their joints with all that `<default>` classes and
//! `<compiler>` say of them, and inertia from `<inertial>` or from the shapes of `<geom>`s. What is seen
//! and touched, sensors, and how actuators are controlled other than by position are passed over, and no other file is
//! opened.
//!
//! | in the file | in the [`Robot`] |
//! | --- | --- |
//! | `<worldbody>` | the root, `world` |
//! | a body without a joint | a link that is fixed to its parent's |
//! | a body of several joints | its link, carried by links of no mass, `body/joint`, one after the other |
//! | a joint's `ref` | its coordinate where bodies stand as the file places them, as in MuJoCo |
//! | a joint's `damping`, `frictionloss`, `armature`, `stiffness`, `springref` | the same, in radians or metres |
//! | a `<freejoint>` | a floating joint, whose coordinates are told in the world; held still, it stands as the file places it |
//! | an `<equality>` of two joints with no more than two numbers of `polycoef` | the first [follows](crate::Mimic) the second, rigidly |
//! | else `<equality>`, springs and dampers of `<tendon>`s | a [`Coupling`](crate::Coupling) |
//! | `<option gravity>` | [`Robot::gravity`], 0 0 -9.81 where nothing is said |
//! | an `<actuator>`'s `armature`, `damping` | the joint's, by the square of the `gear` |
//! | a `<position>` that alone drives a joint, or a `<general>` that is one | its [`PositionServo`](crate::PositionServo), for models whose input is the commanded position |
//! | else `<actuator>` | nothing: a joint's input is its torque or force, behind any gear or controller |
//!
//! Joints and bodies without names are `joint0`, `body1`, ... by MuJoCo's numbers. Stops (`range`) and
//! contacts are not simulated.
//!
//! The text is read by `roxmltree`, and not by `mjcf-rs`: mistakes must be told by their line, and `mjcf-rs`
//! does not keep where an element stood; it also opens the files that others `<include>`.

mod actuators;
mod bodies;
mod couplings;
mod defaults;
mod edit;
mod frames;
mod geoms;
mod inertia;
mod joints;
mod settings;

use crate::robot::{Format, Robot, RobotError};
use crate::xml::{Element, Source, check_twice};
use bodies::Bodies;
use defaults::Defaults;
pub(crate) use edit::edited;
use settings::Settings;

/// Read a robot from the text of an MJCF file.
///
/// # Errors
/// [`RobotError`] with the line: text that is no XML, elements that lack what they must have, classes that
/// there are not, masses below 0, axes of length 0, moving bodies whose inertia a mesh would say,
/// other files, and what would act on the robot and is not simulated (fluids, compensated gravity).
pub fn read(text: &str) -> Result<Robot, RobotError> {
    robot(Source::parse(text)?.root().expect("an MJCF", "mujoco")?)
}

pub(crate) fn robot(root: Element) -> Result<Robot, RobotError> {
    settings::check_alone(root)?;
    let settings = Settings::read(root)?;
    let defaults = Defaults::read(root)?;
    let mut bodies = Bodies::read(root, &settings, &defaults)?;
    check_twice("body", bodies.links.iter().map(|l| (&*l.name, l.line)))?;
    check_twice("joint", bodies.joints.iter().map(|j| (&*j.name, j.line)))?;
    actuators::read(root, &mut bodies.joints, &defaults)?;
    let couplings = couplings::read(root, &mut bodies, &defaults)?;
    let name = root.get("model").unwrap_or("robot").to_owned();
    let Bodies { links, joints, .. } = bodies;
    let (format, gravity) = (Format::Mjcf, Some(settings.gravity));
    Robot { format, name, links, joints, couplings, gravity }.checked()
}
