//! A URDF with other values in it.

use crate::edit::{Change, Edit, Unstated, positive, with_added};
use crate::xml::{Element, Patch, comment, computed, numbers};
use crate::{Format, InertialParameters, Robot};

/// The text with an edit.
pub(crate) fn edited(
    (text, root): (&str, Element),
    robot: &Robot,
    edit: &Edit,
) -> Result<String, Unstated> {
    let mut patch = Patch::new(text);
    match &edit.change {
        Change::Damping(joint, value) => {
            dynamics(&mut patch, named(root, "joint", joint)?, ("damping", *value), &edit.says)?;
        }
        Change::Friction(joint, value) => {
            dynamics(&mut patch, named(root, "joint", joint)?, ("friction", *value), &edit.says)?;
        }
        Change::Inertia(link, added) => {
            let whole = with_added(robot, link, added)?;
            inertial(&mut patch, named(root, "link", link)?, &whole, &edit.says);
        }
        Change::Armature(..)
        | Change::Spring(..)
        | Change::Gravity(_)
        | Change::Gain(..)
        | Change::Servo(..) => {
            return Err(Unstated::NoPlace(Format::Urdf));
        }
    }
    Ok(patch.done())
}

fn named<'a>(root: Element<'a>, tag: &'static str, name: &str) -> Result<Element<'a>, Unstated> {
    root.children(tag).find(|e| e.get("name") == Some(name)).ok_or(Unstated::NoElement(tag))
}

fn dynamics(
    patch: &mut Patch,
    joint: Element,
    (attribute, value): (&str, f64),
    says: &str,
) -> Result<(), Unstated> {
    let value = numbers(&[positive(value)?]);
    match joint.child("dynamics") {
        Some(dynamics) => {
            patch.before(dynamics, &[comment(says)]);
            patch.set(dynamics, attribute, &value);
        }
        None => {
            let dynamics = format!("<dynamics {attribute}=\"{value}\"/>");
            patch.last_in(joint, &[comment(says), dynamics]);
        }
    }
    Ok(())
}

/// The inertia along the axes of the link's frame.
fn inertial(patch: &mut Patch, link: Element, whole: &InertialParameters<f64>, says: &str) {
    let (place, mass) = (computed(&whole.centre), computed(&[whole.mass]));
    let entries = ["ixx", "ixy", "ixz", "iyy", "iyz", "izz"].into_iter().zip(whole.inertia);
    let entries = entries.map(|(name, entry)| (name, computed(&[entry])));
    let Some(inertial) = link.child("inertial") else {
        let inertia: String = entries.map(|(name, entry)| format!(" {name}=\"{entry}\"")).collect();
        let inertial = format!(
            "<inertial><origin xyz=\"{place}\"/><mass value=\"{mass}\"/><inertia{inertia}/></inertial>"
        );
        patch.first_in(link, &[comment(says), inertial]);
        return;
    };
    patch.before(inertial, &[comment(says)]);
    match inertial.child("origin") {
        Some(origin) => {
            patch.set(origin, "xyz", &place);
            patch.remove(origin, &["rpy"]);
        }
        None => patch.first_in(inertial, &[format!("<origin xyz=\"{place}\"/>")]),
    }
    if let Some(element) = inertial.child("mass") {
        patch.set(element, "value", &mass);
    }
    if let Some(tensor) = inertial.child("inertia") {
        entries.for_each(|(name, entry)| patch.set(tensor, name, &entry));
    }
}
