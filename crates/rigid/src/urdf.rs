//! Robots from URDF files: `<link>` with `<inertial>`, `<joint>` with `<origin>`, `<axis>`, `<limit>`,
//! `<mimic>` and `<dynamics>`. What is seen and touched (`<visual>`, `<collision>`, meshes) is passed over, and no
//! other file is opened.
//!
//! The text is read by `roxmltree`, and not by `urdf-rs`: mistakes must be told by their line, and
//! `urdf-rs` does not keep where an element stood.

mod edit;

pub(crate) use edit::edited;

use crate::Inertia;
use crate::algebra::{Pose, Vector, unit};
use crate::joints::{JointKind, Mimic, Several};
use crate::robot::{Ends, Format, Link, Moves, Robot, RobotError, RobotJoint};
use crate::xml::{Element, Source, check_diagonal, check_twice, numbers_or, positive_or};
use std::collections::HashMap;

/// Read a robot from the text of a URDF file.
///
/// # Errors
/// [`RobotError`] with the line: text that is no XML, elements that lack what they must have, masses
/// below 0, axes of length 0, joints that follow themselves, links that no joint reaches, that two carry or that hang in a circle.
pub fn read(text: &str) -> Result<Robot, RobotError> {
    robot(Source::parse(text)?.root().expect("a URDF", "robot")?)
}

pub(crate) fn robot(root: Element) -> Result<Robot, RobotError> {
    let name = root.get("name").unwrap_or("robot").to_owned();
    let links = root.children("link").map(link).collect::<Result<Vec<_>, _>>()?;
    check_twice("link", links.iter().map(|l| (&*l.name, l.line)))?;
    if links.is_empty() {
        let message = "there is no <link>: nothing can be simulated".to_owned();
        return Err(RobotError { line: None, message });
    }
    let places = links.iter().enumerate().map(|(place, l)| (l.name.as_str(), place)).collect();
    let joints = root.children("joint").map(|element| joint(element, &places));
    let mut joints = joints.collect::<Result<Vec<_>, _>>()?;
    check_twice("joint", joints.iter().map(|j| (&*j.name, j.line)))?;
    let places: HashMap<String, usize> =
        joints.iter().enumerate().map(|(place, j)| (j.name.clone(), place)).collect();
    for (joint, element) in joints.iter_mut().zip(root.children("joint")) {
        joint.follows = element.child("mimic").map(|mimic| follows(mimic, &places)).transpose()?;
    }
    let (format, couplings) = (Format::Urdf, vec![]);
    Robot { format, name, links, joints, couplings, gravity: None }.checked()
}

/// The `<origin>` of an element.
fn origin(element: Element) -> Result<Pose, RobotError> {
    let origin = element.child("origin");
    let place = numbers_or(origin, "xyz", [0.0; 3])?;
    Ok(Pose::of_roll_pitch_yaw(place, numbers_or(origin, "rpy", [0.0; 3])?))
}

fn link(element: Element) -> Result<Link, RobotError> {
    let name = element.attribute("name")?.to_owned();
    let inertia = match element.child("inertial") {
        Some(inertial) => inertia(inertial)?,
        None => Inertia::none(),
    };
    Ok(Link { name, inertia, line: element.line() })
}

fn inertia(element: Element) -> Result<Inertia<f64>, RobotError> {
    let (of_mass, tensor) = (element.required_child("mass")?, element.required_child("inertia")?);
    of_mass.attribute("value")?;
    let mass = positive_or(Some(of_mass), (of_mass, "value"), 0.0)?;
    let entry = |name: &str| tensor.numbers(name).map(|[entry]| entry);
    let inertia =
        [entry("ixx")?, entry("ixy")?, entry("ixz")?, entry("iyy")?, entry("iyz")?, entry("izz")?];
    let [xx, _, _, yy, _, zz] = inertia;
    check_diagonal(tensor, [xx, yy, zz])?;
    Ok(Inertia::of_centred(mass, inertia, &origin(element)?))
}

/// `links`: the place of each, by its name.
fn joint(element: Element, links: &HashMap<&str, usize>) -> Result<RobotJoint, RobotError> {
    let name = element.attribute("name")?.to_owned();
    let moves = moves(element)?;
    let end = |which: &'static str| {
        let of = element.required_child(which)?;
        let link = of.attribute("link")?;
        links.get(link).copied().ok_or_else(|| {
            of.error(format!("joint '{name}' names link '{link}', which there is not"))
        })
    };
    let (parent, child) = (end("parent")?, end("child")?);
    let dynamics = element.child("dynamics");
    let coefficient = |which| positive_or(dynamics, (element, which), 0.0);
    let (damping, friction) = (coefficient("damping")?, coefficient("friction")?);
    let ends = Ends { parent, child, pose: origin(element)? };
    let bare = RobotJoint::bare((name, element.line()), moves, ends);
    Ok(RobotJoint { axis: axis(element)?, damping, friction, ..bare })
}

/// The joint that a `<mimic>` names; `joints`: the place of each, by its name.
fn follows(element: Element, joints: &HashMap<String, usize>) -> Result<Mimic, RobotError> {
    let name = element.attribute("joint")?;
    let leader = joints.get(name).copied().ok_or_else(|| {
        element.error(format!("{} names joint '{name}', which there is not", element.called()))
    })?;
    let [multiplier] = numbers_or(Some(element), "multiplier", [1.0])?;
    let [offset] = numbers_or(Some(element), "offset", [0.0])?;
    Ok(Mimic { leader, multiplier, offset, line: element.line() })
}

/// How a joint moves; one that turns or slides between stops must say where they are, unless another moves it.
fn moves(element: Element) -> Result<Moves, RobotError> {
    let kind = element.attribute("type")?;
    let stated = ["limit", "mimic"].iter().any(|tag| element.child(tag).is_some());
    if matches!(kind, "revolute" | "prismatic") && !stated {
        return Err(element.error(format!("{} is {kind} and lacks its <limit>", element.called())));
    }
    Ok(match kind {
        "fixed" => Moves::Fixed,
        "revolute" | "continuous" => Moves::By(JointKind::Revolute),
        "prismatic" => Moves::By(JointKind::Prismatic),
        "planar" => Moves::Several(Several::Planar),
        "floating" => Moves::Several(Several::Floating),
        other => {
            return Err(element.error(format!(
                "the type of {} is '{other}', which is none of revolute, continuous, prismatic, fixed, \
                 planar, floating",
                element.called()
            )));
        }
    })
}

fn axis(element: Element) -> Result<Vector<f64>, RobotError> {
    let axis = element.child("axis");
    let xyz = numbers_or(axis, "xyz", [1.0, 0.0, 0.0])?;
    unit(xyz).ok_or_else(|| {
        let message = format!("the axis of {} has length 0", element.called());
        axis.unwrap_or(element).error(message)
    })
}
