//! `<actuator>`: the rotor and damper of a motor, which its joint feels by the square of the gear, and the gains of
//! a position servo.
//!
//! A `<position>` on a joint with the gear g, and so a `<general>` that is written as one, makes of its control u
//!
//! ```text
//! tau = g clamp(k_p (u - g q) - k_v g v, -f, f)
//!     = clamp(g^2 k_p (u / g - q) - g^2 k_v v, -g f, g f)
//! ```
//!
//! with f of its `forcerange`: a [`PositionServo`] whose command is that of the joint, u / g. Where that is not all
//! that drives a joint, where it has an activation of its own or more force one way than the other, none is read.

use super::defaults::{ACTUATOR, ClassId, Defaults, Part};
use crate::robot::{Moves, PositionServo, RobotError, RobotJoint, ServoDamping};
use crate::xml::Element;
use std::collections::HashMap;

/// Add what motors have to their joints.
pub(super) fn read<'a>(
    root: Element<'a>,
    joints: &mut [RobotJoint],
    defaults: &Defaults<'a>,
) -> Result<(), RobotError> {
    let places: HashMap<String, usize> =
        joints.iter().enumerate().map(|(place, j)| (j.name.clone(), place)).collect();
    let mut drives = vec![0; joints.len()];
    for element in all(root) {
        let part = defaults.part(element, ACTUATOR, ClassId::MAIN)?;
        let (armature, damping) = (part.positive("armature")?, part.positive("damping")?);
        let place = driven(element).and_then(|name| places.get(name));
        if let Some(&place) = place {
            drives[place] += 1;
            joints[place].servo = servo(&part)?
                .filter(|_| drives[place] == 1 && matches!(joints[place].moves, Moves::By(_)));
        }
        if armature == 0.0 && damping == 0.0 {
            continue;
        }
        let squared = gear(&part)?.powi(2);
        let Some(place) = place else {
            let message = format!(
                "{} has a rotor or a damper and drives no joint, which is not simulated",
                element.called()
            );
            return Err(element.error(message));
        };
        joints[*place].armature += armature * squared;
        joints[*place].damping += damping * squared;
    }
    Ok(())
}

fn all(root: Element<'_>) -> impl Iterator<Item = Element<'_>> {
    root.children("actuator").flat_map(Element::elements)
}

/// The actuators that drive a joint.
pub(super) fn of_joint<'a>(root: Element<'a>, joint: &str) -> impl Iterator<Item = Element<'a>> {
    all(root).filter(move |element| driven(*element) == Some(joint))
}

/// The joint that an actuator drives.
fn driven(element: Element<'_>) -> Option<&str> {
    element.get("joint").or_else(|| element.get("jointinparent"))
}

/// The first number of the gear, which is that of a joint of one coordinate.
pub(super) fn gear(part: &Part) -> Result<f64, RobotError> {
    let gear = part.holder("gear").map_or(Ok(vec![]), |holder| holder.list("gear"))?;
    Ok(gear.first().copied().unwrap_or(1.0))
}

/// The servo that an actuator is, on the side of its joint.
fn servo(part: &Part) -> Result<Option<PositionServo>, RobotError> {
    let Some((gain, damping)) = gains(part)? else { return Ok(None) };
    let (gear, Some(limit)) = (gear(part)?, limit(part)?) else { return Ok(None) };
    let damping = match damping {
        ServoDamping::Of(damping) => ServoDamping::Of(gear * gear * damping),
        ratio @ ServoDamping::Ratio(_) => ratio,
    };
    let limit = limit.map(|force| gear.abs() * force);
    let servo = PositionServo { gain: gear * gear * gain, damping, limit };
    Ok((servo.gain > 0.0).then_some(servo))
}

/// k_p and k_v; none of an actuator that is no plain position servo.
fn gains(part: &Part) -> Result<Option<(f64, ServoDamping)>, RobotError> {
    match part.own.tag() {
        "position" => {
            let gain = part.positive_or("kp", 1.0)?;
            let ratio = part.positive("dampratio")?;
            let damping = match part.positive("kv")? {
                0.0 if ratio > 0.0 => ServoDamping::Ratio(ratio),
                damping => ServoDamping::Of(damping),
            };
            Ok((part.positive("timeconst")? == 0.0).then_some((gain, damping)))
        }
        "general" => {
            let numbers = |name| part.holder(name).map_or(Ok(vec![]), |holder| holder.list(name));
            let plain = |name, usual| part.get(name).is_none_or(|kind| kind == usual);
            let (gain, bias) = (numbers("gainprm")?, numbers("biasprm")?);
            let is_servo = part.get("biastype") == Some("affine")
                && plain("gaintype", "fixed")
                && plain("dyntype", "none");
            Ok(match (&gain[..], &bias[..]) {
                ([gain, ..], [none, stiffness, damping, ..])
                    if is_servo && *none == 0.0 && *stiffness == -gain && *damping <= 0.0 =>
                {
                    Some((*gain, ServoDamping::Of(-damping)))
                }
                _ => None,
            })
        }
        _ => Ok(None),
    }
}

/// The most force of an actuator, if it is limited; none where it is another one way than the other.
fn limit(part: &Part) -> Result<Option<Option<f64>>, RobotError> {
    if part.get("forcelimited") == Some("false") {
        return Ok(Some(None));
    }
    match part.holder("forcerange") {
        None => Ok(Some(None)),
        Some(holder) => {
            let [low, high] = holder.numbers("forcerange")?;
            Ok((low == -high && high > 0.0).then_some(Some(high)))
        }
    }
}
