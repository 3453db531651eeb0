//! `<joint>` and `<freejoint>`.

use super::defaults::Part;
use super::settings::Settings;
use crate::algebra::{Pose, add, times, unit};
use crate::joints::{JointKind, Several};
use crate::robot::{Ends, Link, Moves, RobotError, RobotJoint};

/// Read a joint, whose place and axis are told in `frame`, which stands so in the body's. Its ends stand as
/// the file places them.
pub(super) fn read(
    part: &Part,
    (name, frame): (String, Pose),
    Ends { parent, child, pose }: Ends,
    settings: &Settings,
) -> Result<RobotJoint, RobotError> {
    let moves = moves(part)?;
    let angle = if moves == Moves::By(JointKind::Revolute) { settings.angle } else { 1.0 };
    let place = times(&frame.rotation, part.numbers_or("pos", [0.0; 3])?);
    let axis = part.numbers_or("axis", [0.0, 0.0, 1.0])?;
    let axis = unit(axis).ok_or_else(|| {
        let message = format!("the axis of {} has length 0", part.own.called());
        part.holder("axis").unwrap_or(part.own).error(message)
    })?;
    part.check_unset("springdamper", "state its stiffness and damping")?;
    part.check_unset("springyield", "a spring that yields is not simulated")?;
    let [stiffness] = part.numbers_or("stiffness", [0.0])?;
    let [spring_reference] = part.numbers_or("springref", [0.0])?;
    let reference = reference(part, settings)?;
    let mut joint = RobotJoint {
        name,
        moves,
        parent,
        child,
        pose,
        rest: Pose::SAME,
        follows: None,
        axis: times(&frame.rotation, axis),
        anchor: add(frame.translation, place),
        damping: part.positive("damping")?,
        friction: part.positive("frictionloss")?,
        armature: part.positive("armature")?,
        stiffness,
        spring_reference: spring_reference * angle,
        servo: None,
        line: part.own.line(),
    };
    match moves {
        // Its coordinates are told in the frame of the parent; the file says where it stands if it is held.
        Moves::Several(Several::Floating) => {
            (joint.pose, joint.rest, joint.anchor) = (Pose::SAME, pose, [0.0; 3]);
        }
        // The file places bodies where the coordinate is `ref`.
        _ => joint.pose = pose.then(&joint.moved(-reference)),
    }
    Ok(joint)
}

/// The coordinate where the file places bodies, rad or m.
pub(super) fn reference(part: &Part, settings: &Settings) -> Result<f64, RobotError> {
    let turns = moves(part)? == Moves::By(JointKind::Revolute);
    let [reference] = part.numbers_or("ref", [0.0])?;
    Ok(if turns { reference * settings.angle } else { reference })
}

/// What holds a link to its parent's where there is no joint.
pub(super) fn fixed(link: &Link, ends: Ends) -> RobotJoint {
    // A name that no joint of the file has: bodies and their joints are often called the same.
    RobotJoint::bare((format!("{} (fixed)", link.name), link.line), Moves::Fixed, ends)
}

fn moves(part: &Part) -> Result<Moves, RobotError> {
    let free = Moves::Several(Several::Floating);
    if part.own.tag() == "freejoint" {
        return Ok(free);
    }
    Ok(match part.get("type").unwrap_or("hinge") {
        "hinge" => Moves::By(JointKind::Revolute),
        "slide" => Moves::By(JointKind::Prismatic),
        "ball" => Moves::Several(Several::Ball),
        "free" => free,
        other => {
            let message = format!(
                "the type of {} is '{other}', which is none of hinge, slide, ball, free",
                part.own.called()
            );
            return Err(part.holder("type").unwrap_or(part.own).error(message));
        }
    })
}
