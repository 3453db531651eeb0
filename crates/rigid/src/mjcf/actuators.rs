//! `<actuator>`: the rotor and damper of a motor, which its joint feels by the square of the gear.

use super::defaults::{ACTUATOR, ClassId, Defaults};
use crate::robot::{RobotError, RobotJoint};
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
    for element in root.children("actuator").flat_map(Element::elements) {
        let part = defaults.part(element, ACTUATOR, ClassId::MAIN)?;
        let (armature, damping) = (part.positive("armature")?, part.positive("damping")?);
        if armature == 0.0 && damping == 0.0 {
            continue;
        }
        let gear = part.holder("gear").map_or(Ok(vec![]), |holder| holder.list("gear"))?;
        let squared = gear.first().map_or(1.0, |ratio| ratio * ratio);
        let name = element.get("joint").or_else(|| element.get("jointinparent"));
        let Some(place) = name.and_then(|name| places.get(name)) else {
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
