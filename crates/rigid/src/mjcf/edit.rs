//! An MJCF with other values in it. What elements say themselves counts more than what their classes do.

use super::bodies::named;
use super::defaults::{ACTUATOR, ClassId, Defaults, Part};
use super::settings::{FromGeoms, Settings, last};
use super::{actuators, frames};
use crate::edit::{Change, Edit, Unstated, positive, with_added};
use crate::robot::{Moves, RobotJoint};
use crate::xml::{Element, Patch, comment, computed, numbers};
use crate::{InertialParameters, JointKind, Robot};

/// The text with an edit.
pub(crate) fn edited(
    (text, root): (&str, Element),
    robot: &Robot,
    edit: &Edit,
) -> Result<String, Unstated> {
    let mut patch = Patch::new(text);
    let says = comment(&edit.says);
    match &edit.change {
        Change::Damping(joint, value) => {
            let value = value - of_motors(root, robot, joint)?.damping;
            set(&mut patch, &says, joint_element(root, joint)?, ("damping", positive(value)?));
        }
        Change::Friction(joint, value) => {
            let value = positive(*value)?;
            set(&mut patch, &says, joint_element(root, joint)?, ("frictionloss", value));
        }
        Change::Armature(joint, value) => {
            let value = value - of_motors(root, robot, joint)?.armature;
            set(&mut patch, &says, joint_element(root, joint)?, ("armature", positive(value)?));
        }
        Change::Spring(joint, stiffness, reference) => {
            spring(&mut patch, (root, robot), joint, (*stiffness, *reference))?;
            patch.before(joint_element(root, joint)?, &[says]);
        }
        Change::Inertia(link, added) => {
            if Settings::read(root)?.from_geoms == FromGeoms::Always {
                return Err(Unstated::FromGeoms);
            }
            let whole = with_added(robot, link, added)?;
            inertial(&mut patch, body_element(root, link)?, &whole, &says);
        }
        Change::Gravity(gravity) => self::gravity(&mut patch, root, *gravity, &says)?,
        Change::Gain(joint, factor) => gain(&mut patch, root, (joint, *factor), &says)?,
        Change::Servo(joint, gains, limit) => {
            servo(&mut patch, (root, robot), (joint, *gains, *limit), &says)?;
        }
    }
    Ok(patch.done())
}

fn set(patch: &mut Patch, says: &str, element: Element, (name, value): (&str, f64)) {
    patch.before(element, &[says.to_owned()]);
    patch.set(element, name, &numbers(&[value]));
}

fn joint_of<'r>(robot: &'r Robot, name: &str) -> Result<&'r RobotJoint, Unstated> {
    robot.joint(name).ok_or(Unstated::NoElement("joint"))
}

/// A joint with what its motors add to it, and nothing else.
fn of_motors(root: Element, robot: &Robot, joint: &str) -> Result<RobotJoint, Unstated> {
    let mut bare = joint_of(robot, joint)?.clone();
    (bare.damping, bare.armature) = (0.0, 0.0);
    let mut joints = robot.joints.clone();
    joints.iter_mut().filter(|j| j.name == joint).for_each(|j| *j = bare.clone());
    actuators::read(root, &mut joints, &Defaults::read(root)?)?;
    Ok(joints.into_iter().find(|j| j.name == joint).unwrap_or(bare))
}

/// The bodies with their names, in MuJoCo's order.
fn bodies(root: Element) -> impl Iterator<Item = (String, Element)> {
    let all = root.children("worldbody").flat_map(Element::descendants);
    let mut next = 1;
    all.filter(|e| e.tag() == "body").map(move |body| (named(body, "body", &mut next), body))
}

fn body_element<'a>(root: Element<'a>, name: &str) -> Result<Element<'a>, Unstated> {
    let mut all = bodies(root);
    all.find(|(n, _)| n == name).map(|(_, body)| body).ok_or(Unstated::NoElement("body"))
}

fn joint_element<'a>(root: Element<'a>, name: &str) -> Result<Element<'a>, Unstated> {
    let mut next = 0;
    let joints = bodies(root).flat_map(|(_, body)| frames::within(body));
    let joints = joints.filter(|e| ["joint", "freejoint"].contains(&e.tag()));
    let mut joints = joints.map(|joint| (named(joint, "joint", &mut next), joint));
    joints.find(|(n, _)| n == name).map(|(_, joint)| joint).ok_or(Unstated::NoElement("joint"))
}

fn spring(
    patch: &mut Patch,
    (root, robot): (Element, &Robot),
    name: &str,
    (stiffness, reference): (f64, f64),
) -> Result<(), Unstated> {
    if !reference.is_finite() {
        return Err(Unstated::NoSpring);
    }
    let (element, joint) = (joint_element(root, name)?, joint_of(robot, name)?);
    patch.set(element, "stiffness", &numbers(&[stiffness]));
    if reference != joint.spring_reference {
        let turns = joint.moves == Moves::By(JointKind::Revolute);
        let angle = if turns { Settings::read(root)?.angle } else { 1.0 };
        patch.set(element, "springref", &numbers(&[reference / angle]));
    }
    Ok(())
}

/// The inertia along the axes of the body's frame.
fn inertial(patch: &mut Patch, body: Element, whole: &InertialParameters<f64>, says: &str) {
    let [xx, xy, xz, yy, yz, zz] = whole.inertia;
    let tensor = match [xy, xz, yz].iter().all(|x| *x == 0.0) {
        true => ("diaginertia", computed(&[xx, yy, zz])),
        false => ("fullinertia", computed(&[xx, yy, zz, xy, xz, yz])),
    };
    let stated = [("pos", computed(&whole.centre)), ("mass", computed(&[whole.mass])), tensor];
    let Some(inertial) = body.child("inertial") else {
        let all: String = stated.map(|(name, value)| format!(" {name}=\"{value}\"")).concat();
        patch.first_in(body, &[says.to_owned(), format!("<inertial{all}/>")]);
        return;
    };
    patch.before(inertial, &[says.to_owned()]);
    let mut others = vec!["quat", "axisangle", "xyaxes", "zaxis", "euler"];
    others.extend(["diaginertia", "fullinertia"].iter().filter(|name| **name != stated[2].0));
    patch.remove(inertial, &others);
    stated.iter().for_each(|(name, value)| patch.set(inertial, name, value));
}

fn gravity(
    patch: &mut Patch,
    root: Element,
    gravity: [f64; 3],
    says: &str,
) -> Result<(), Unstated> {
    let mut flags = root.children("option").flat_map(|o| o.children("flag"));
    if flags.any(|flag| flag.get("gravity") == Some("disable")) {
        return Err(Unstated::NoGravity);
    }
    let value = numbers(&gravity);
    match last(root, "option", "gravity").or_else(|| root.child("option")) {
        Some(option) => {
            patch.before(option, &[says.to_owned()]);
            patch.set(option, "gravity", &value);
        }
        None => {
            let option = format!("<option gravity=\"{value}\"/>");
            patch.first_in(root, &[says.to_owned(), option]);
        }
    }
    Ok(())
}

/// A servo acts by way of its gear.
fn servo(
    patch: &mut Patch,
    (root, robot): (Element, &Robot),
    (joint, [gain, damping], limit): (&str, [f64; 2], Option<f64>),
    says: &str,
) -> Result<(), Unstated> {
    let own = joint_of(robot, joint)?.servo.ok_or(Unstated::NoServo)?;
    let first = actuators::of_joint(root, joint).next();
    let element = first.filter(|e| e.tag() == "position").ok_or(Unstated::NoServo)?;
    let defaults = Defaults::read(root)?;
    let part: Part = defaults.part(element, ACTUATOR, ClassId::MAIN)?;
    let gear = actuators::gear(&part)?;
    patch.before(element, &[says.to_owned()]);
    patch.remove(element, &["dampratio"]);
    patch.set(element, "kp", &numbers(&[positive(gain)? / (gear * gear)]));
    patch.set(element, "kv", &numbers(&[positive(damping)? / (gear * gear)]));
    if let Some(limit) = limit.filter(|_| limit != own.limit) {
        let force = limit / gear.abs();
        patch.set(element, "forcerange", &numbers(&[-force, force]));
    }
    Ok(())
}

/// A gain is a part of the gear where nothing else is: a rotor or damper would be felt by its square, and
/// a controller would follow another joint.
fn gain(
    patch: &mut Patch,
    root: Element,
    (joint, factor): (&str, f64),
    says: &str,
) -> Result<(), Unstated> {
    let defaults = Defaults::read(root)?;
    let all: Vec<Element> = actuators::of_joint(root, joint).collect();
    if all.is_empty() {
        return Err(Unstated::NoMotor);
    }
    for motor in all {
        let part: Part = defaults.part(motor, ACTUATOR, ClassId::MAIN)?;
        if motor.tag() != "motor" || part.positive("armature")? + part.positive("damping")? > 0.0 {
            return Err(Unstated::NoMotor);
        }
        let mut gear = part.holder("gear").map_or(Ok(vec![1.0]), |holder| holder.list("gear"))?;
        gear.iter_mut().take(1).for_each(|ratio| *ratio *= factor);
        patch.before(motor, &[says.to_owned()]);
        patch.set(motor, "gear", &numbers(&gear));
    }
    Ok(())
}
