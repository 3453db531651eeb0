//! Robots from URDF files: `<link>` with `<inertial>`, `<joint>` with `<origin>`, `<axis>`, `<limit>`
//! and `<dynamics>`. What is seen and touched (`<visual>`, `<collision>`, meshes) is passed over, and no
//! other file is opened.
//!
//! The text is read by `roxmltree`, and not by `urdf-rs`: mistakes must be told by their line, and
//! `urdf-rs` does not keep where an element stood.

use crate::algebra::{Pose, Vector, product, transposed};
use crate::tree::{Link, Moves, Robot, RobotError, RobotJoint};
use crate::{Inertia, InertialParameters, JointKind};
use roxmltree::{Document, Node};
use std::collections::HashMap;

/// Read a robot from the text of a URDF file.
///
/// # Errors
/// [`RobotError`] with the line: text that is no XML, elements that lack what they must have, masses
/// below 0, axes of length 0, links that no joint reaches, that two carry or that hang in a circle.
pub fn read(text: &str) -> Result<Robot, RobotError> {
    let document = Document::parse(text).map_err(|e| {
        RobotError::at(e.pos().row, format!("this is no XML that can be read: {e}"))
    })?;
    let root = document.root_element();
    if root.tag_name().name() != "robot" {
        let found = root.tag_name().name();
        let message = format!("a URDF file holds a <robot>; found <{found}>");
        return Err(RobotError::at(line(root), message));
    }
    let name = root.attribute("name").unwrap_or("robot").to_owned();
    let rows = Rows::of(text);
    let links = children(root, "link").map(|node| link(node, rows.of_node(node)));
    let links = links.collect::<Result<Vec<_>, _>>()?;
    check_twice("link", links.iter().map(|l| (&*l.name, l.line)))?;
    let places = links.iter().enumerate().map(|(place, l)| (l.name.as_str(), place)).collect();
    let joints = children(root, "joint").map(|node| joint(node, rows.of_node(node), &places));
    let joints = joints.collect::<Result<Vec<_>, _>>()?;
    check_twice("joint", joints.iter().map(|j| (&*j.name, j.line)))?;
    let robot = Robot { name, links, joints };
    check_hangs_together(&robot)?;
    Ok(robot)
}

/// Where lines begin: an element's own is found by counting from the text's beginning, which is too slow
/// for all of them.
struct Rows(Vec<usize>);

impl Rows {
    fn of(text: &str) -> Self {
        Self(text.match_indices('\n').map(|(at, _)| at).collect())
    }

    fn of_node(&self, node: Node) -> u32 {
        let before = self.0.partition_point(|at| *at < node.range().start);
        u32::try_from(before + 1).unwrap_or(u32::MAX)
    }
}

fn line(node: Node) -> u32 {
    node.document().text_pos_at(node.range().start).row
}

fn children<'a, 'i>(
    node: Node<'a, 'i>,
    name: &'static str,
) -> impl Iterator<Item = Node<'a, 'i>> + 'a
where
    'i: 'a,
{
    node.children().filter(move |c| c.is_element() && c.tag_name().name() == name)
}

fn child<'a, 'i>(node: Node<'a, 'i>, name: &'static str) -> Option<Node<'a, 'i>> {
    children(node, name).next()
}

/// `<joint> 'elbow'`.
fn called(node: Node) -> String {
    let tag = node.tag_name().name();
    let mut named = node.ancestors().filter_map(|n| Some((n.tag_name(), n.attribute("name")?)));
    match (node.attribute("name"), named.next()) {
        (Some(name), _) => format!("<{tag}> '{name}'"),
        (None, Some((of, name))) => format!("<{tag}> of {} '{name}'", of.name()),
        (None, None) => format!("<{tag}>"),
    }
}

fn attribute<'a>(node: Node<'a, '_>, name: &str) -> Result<&'a str, RobotError> {
    node.attribute(name).ok_or_else(|| {
        RobotError::at(line(node), format!("{} lacks its attribute '{name}'", called(node)))
    })
}

/// The numbers of an attribute.
fn numbers<const N: usize>(node: Node, name: &str) -> Result<[f64; N], RobotError> {
    let text = attribute(node, name)?;
    let parsed: Option<Vec<f64>> = text.split_whitespace().map(|n| n.parse().ok()).collect();
    let parsed = parsed.filter(|all| all.iter().all(|n: &f64| n.is_finite()));
    parsed.and_then(|all| all.try_into().ok()).ok_or_else(|| {
        let many = if N == 1 { "a number".to_owned() } else { format!("{N} numbers") };
        let what = format!("'{name}' of {} must be {many}; found \"{text}\"", called(node));
        RobotError::at(line(node), what)
    })
}

/// The same where it may be absent.
fn numbers_or<const N: usize>(
    node: Option<Node>,
    name: &str,
    otherwise: [f64; N],
) -> Result<[f64; N], RobotError> {
    match node.filter(|n| n.has_attribute(name)) {
        Some(node) => numbers(node, name),
        None => Ok(otherwise),
    }
}

fn number(node: Node, name: &str) -> Result<f64, RobotError> {
    numbers::<1>(node, name).map(|[n]| n)
}

/// The `<origin>` of an element.
fn origin(node: Node) -> Result<Pose, RobotError> {
    let origin = child(node, "origin");
    let place = numbers_or(origin, "xyz", [0.0; 3])?;
    Ok(Pose::of_roll_pitch_yaw(place, numbers_or(origin, "rpy", [0.0; 3])?))
}

fn link(node: Node, line: u32) -> Result<Link, RobotError> {
    let name = attribute(node, "name")?.to_owned();
    let inertia = match child(node, "inertial") {
        Some(inertial) => inertia(inertial)?,
        None => Inertia::none(),
    };
    Ok(Link { name, inertia, line })
}

fn inertia(node: Node) -> Result<Inertia<f64>, RobotError> {
    let required = |name: &'static str| {
        child(node, name).ok_or_else(|| {
            RobotError::at(line(node), format!("{} lacks its <{name}>", called(node)))
        })
    };
    let (mass_node, tensor) = (required("mass")?, required("inertia")?);
    let mass = number(mass_node, "value")?;
    if mass < 0.0 {
        let message = format!("{} must be 0 or more; found {mass}", called(mass_node));
        return Err(RobotError::at(line(mass_node), message));
    }
    let entry = |name: &str| number(tensor, name);
    let (xx, xy, xz) = (entry("ixx")?, entry("ixy")?, entry("ixz")?);
    let (yy, yz, zz) = (entry("iyy")?, entry("iyz")?, entry("izz")?);
    if xx.min(yy).min(zz) < 0.0 {
        let message = format!("{} must be 0 or more: ixx {xx}, iyy {yy}, izz {zz}", called(tensor));
        return Err(RobotError::at(line(tensor), message));
    }
    let pose = origin(node)?;
    let (r, turned) = (pose.rotation, [[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]);
    let [[xx, xy, xz], [_, yy, yz], [_, _, zz]] = product(&product(&r, &turned), &transposed(&r));
    let inertia = [xx, xy, xz, yy, yz, zz];
    Ok(InertialParameters { mass, centre: pose.translation, inertia }.about_origin())
}

/// `links`: the place of each, by its name.
fn joint(node: Node, row: u32, links: &HashMap<&str, usize>) -> Result<RobotJoint, RobotError> {
    let name = attribute(node, "name")?.to_owned();
    let moves = moves(node)?;
    let end = |which: &'static str| {
        let of = child(node, which).ok_or_else(|| {
            RobotError::at(line(node), format!("joint '{name}' lacks its <{which}>"))
        })?;
        let link = attribute(of, "link")?;
        links.get(link).copied().ok_or_else(|| {
            let message = format!("joint '{name}' names link '{link}', which there is not");
            RobotError::at(line(of), message)
        })
    };
    let (parent, child_link) = (end("parent")?, end("child")?);
    let dynamics = child(node, "dynamics");
    let coefficient = |which: &str| -> Result<f64, RobotError> {
        let [value] = numbers_or(dynamics, which, [0.0])?;
        if value >= 0.0 {
            return Ok(value);
        }
        let message = format!("{which} of joint '{name}' must be 0 or more; found {value}");
        Err(RobotError::at(dynamics.map_or(line(node), line), message))
    };
    let (damping, friction) = (coefficient("damping")?, coefficient("friction")?);
    let pose = origin(node)?;
    let axis = axis(node)?;
    Ok(RobotJoint {
        name,
        moves,
        parent,
        child: child_link,
        pose,
        axis,
        damping,
        friction,
        armature: 0.0,
        line: row,
    })
}

/// How a joint moves; one that turns or slides between stops must say where they are.
fn moves(node: Node) -> Result<Moves, RobotError> {
    let kind = attribute(node, "type")?;
    if child(node, "mimic").is_some() {
        return Ok(Moves::Otherwise("moved by another joint (<mimic>)"));
    }
    if matches!(kind, "revolute" | "prismatic") && child(node, "limit").is_none() {
        let message = format!("{} is {kind} and lacks its <limit>", called(node));
        return Err(RobotError::at(line(node), message));
    }
    Ok(match kind {
        "fixed" => Moves::Fixed,
        "revolute" | "continuous" => Moves::By(JointKind::Revolute),
        "prismatic" => Moves::By(JointKind::Prismatic),
        "planar" => Moves::Otherwise("planar"),
        "floating" => Moves::Otherwise("floating"),
        other => {
            let message = format!(
                "the type of {} is '{other}', which is none of revolute, continuous, prismatic, fixed, \
                 planar, floating",
                called(node)
            );
            return Err(RobotError::at(line(node), message));
        }
    })
}

fn axis(node: Node) -> Result<Vector<f64>, RobotError> {
    let axis = child(node, "axis");
    let xyz: Vector<f64> = numbers_or(axis, "xyz", [1.0, 0.0, 0.0])?;
    let length = xyz.iter().map(|x| x * x).sum::<f64>().sqrt();
    if length > 0.0 {
        return Ok(xyz.map(|x| x / length));
    }
    let message = format!("the axis of {} has length 0", called(node));
    Err(RobotError::at(axis.map_or(line(node), line), message))
}

fn check_twice<'a>(
    what: &str,
    all: impl Iterator<Item = (&'a str, u32)>,
) -> Result<(), RobotError> {
    let mut seen = HashMap::new();
    for (name, line) in all {
        if let Some(first) = seen.insert(name, line) {
            let message = format!("{what} '{name}' is there twice: the first is in line {first}");
            return Err(RobotError::at(line, message));
        }
    }
    Ok(())
}

/// All links must hang from one, each by one joint.
fn check_hangs_together(robot: &Robot) -> Result<(), RobotError> {
    if robot.links.is_empty() {
        let message = "there is no <link>: nothing can be simulated".to_owned();
        return Err(RobotError { line: None, message });
    }
    let mut carrier = vec![None; robot.links.len()];
    for joint in &robot.joints {
        if let Some(first) = carrier[joint.child].replace(joint) {
            let message = format!(
                "link '{}' is carried by joint '{}' and by '{}': a tree is expected, without loops",
                robot.links[joint.child].name, first.name, joint.name
            );
            return Err(RobotError::at(joint.line, message));
        }
    }
    let roots: Vec<usize> = (0..carrier.len()).filter(|l| carrier[*l].is_none()).collect();
    if let [first, second, ..] = roots[..] {
        let (first, second) = (&robot.links[first], &robot.links[second]);
        let message = format!(
            "links '{}' and '{}' hang from nothing, both: one link is the base, a joint must carry the other",
            first.name, second.name
        );
        return Err(RobotError::at(second.line, message));
    }
    check_no_loop(robot, &carrier)
}

/// With one carrier a link, what does not come from the root hangs in a circle.
fn check_no_loop(robot: &Robot, carrier: &[Option<&RobotJoint>]) -> Result<(), RobotError> {
    let mut below: Vec<Vec<usize>> = vec![vec![]; carrier.len()];
    let mut reached = vec![false; carrier.len()];
    for joint in carrier.iter().flatten() {
        below[joint.parent].push(joint.child);
    }
    let mut open: Vec<usize> = (0..carrier.len()).filter(|l| carrier[*l].is_none()).collect();
    while let Some(link) = open.pop() {
        reached[link] = true;
        open.extend(&below[link]);
    }
    match reached.iter().zip(carrier).find(|(reached, _)| !**reached) {
        Some((_, Some(joint))) => {
            let message = format!(
                "link '{}' hangs from itself by way of joint '{}': a tree is expected, without loops",
                robot.links[joint.child].name, joint.name
            );
            Err(RobotError::at(joint.line, message))
        }
        _ => Ok(()),
    }
}
