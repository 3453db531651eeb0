//! `<joint>` and `<freejoint>`.

use super::defaults::Part;
use super::settings::Settings;
use crate::JointKind;
use crate::algebra::{Pose, add, times, unit};
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
    let [reference] = part.numbers_or("ref", [0.0])?;
    let mut joint = RobotJoint {
        name,
        moves,
        parent,
        child,
        pose,
        axis: times(&frame.rotation, axis),
        anchor: add(frame.translation, place),
        damping: part.positive("damping")?,
        friction: part.positive("frictionloss")?,
        armature: part.positive("armature")?,
        stiffness,
        spring_reference: spring_reference * angle,
        line: part.own.line(),
    };
    // The file places bodies where the coordinate is `ref`.
    joint.pose = pose.then(&joint.moved(-reference * angle));
    Ok(joint)
}

/// What holds a link to its parent's where there is no joint.
pub(super) fn fixed(link: &Link, ends: Ends) -> RobotJoint {
    // A name that no joint of the file has: bodies and their joints are often called the same.
    RobotJoint::bare((format!("{} (fixed)", link.name), link.line), Moves::Fixed, ends)
}

fn moves(part: &Part) -> Result<Moves, RobotError> {
    let free = Moves::Otherwise("free to float");
    if part.own.tag() == "freejoint" {
        return Ok(free);
    }
    Ok(match part.get("type").unwrap_or("hinge") {
        "hinge" => Moves::By(JointKind::Revolute),
        "slide" => Moves::By(JointKind::Prismatic),
        "ball" => Moves::Otherwise("a ball joint"),
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
