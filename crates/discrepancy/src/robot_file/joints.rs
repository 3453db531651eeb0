//! What is new of a joint and of what drives it.

use super::Planned;
use super::acting::{Acting, Known, Sum};
use lacuna_effects::{Parameter, Quantity, servo};
use lacuna_plants::Model;
use lacuna_plants::model::BodyParameters;
use lacuna_rigid::edit::Change;
use lacuna_rigid::{Joint, ServoDamping};

pub(super) fn changes(
    joint: &Joint,
    (known, all): (&BodyParameters<Known>, &[Known]),
    acting: &[Acting],
    model: &Model,
) -> Vec<Planned> {
    let plain = |quantity, what, known: &Known, was, change: fn(String, f64) -> Change| {
        let sum = Sum::new(known.value, known.std).with(acting, (quantity, &joint.name));
        (sum.value != was).then(|| Planned {
            change: change(joint.name.clone(), sum.value),
            what,
            of: of(joint),
            says: sum.says(was, &known.parameter.unit),
        })
    };
    let (damping, friction) = (&known.damping, &known.friction);
    let rotor = &known.armature;
    [
        plain(Quantity::Damping, "damping", damping, joint.damping, Change::Damping),
        plain(Quantity::Friction, "friction", friction, joint.friction, Change::Friction),
        plain(Quantity::RotorInertia, "rotor inertia", rotor, joint.armature, Change::Armature),
        spring(joint, &known.stiffness, acting),
        gain(joint, acting, model),
        servo(joint, all),
    ]
    .into_iter()
    .flatten()
    .collect()
}

fn of(joint: &Joint) -> String {
    format!("of joint {}", joint.name)
}

/// A spring k_0 that is at rest at q_0, one that is at rest at 0, and a force f are one spring that is at rest at
/// `(k_0 q_0 + f) / k`.
fn spring(joint: &Joint, own: &Known, acting: &[Acting]) -> Option<Planned> {
    let name = joint.name.as_str();
    let stiffness = Sum::new(own.value, own.std).with(acting, (Quantity::Stiffness, name));
    let force = Sum::new(0.0, 0.0).with(acting, (Quantity::Force, name));
    let (k, rest, unit) = (stiffness.value, joint.spring_reference, &own.parameter.unit);
    let (of_force, of_angle) = unit.split_once('/').unwrap_or((unit, ""));
    let planned = |reference, what, says| Planned {
        change: Change::Spring(joint.name.clone(), k, reference),
        what,
        of: of(joint),
        says,
    };
    if force.value == 0.0 && k == own.value {
        let says = || stiffness.says(joint.stiffness, unit);
        return (k != joint.stiffness).then(|| planned(rest, "stiffness", says()));
    }
    let reference = (own.value * rest + force.value) / k;
    if k == 0.0 {
        return Some(planned(reference, "constant force", force.says(0.0, of_force)));
    }
    let mut says = stiffness.says(joint.stiffness, unit);
    if force.value != 0.0 {
        says += &format!(", and a constant force of {}", force.says(0.0, of_force));
    }
    says += &format!("; at rest at {reference:.4} {of_angle}");
    Some(planned(reference, "stiffness", says))
}

/// A number of the servo of a joint.
pub(super) fn of_servo<'k, 'm>(
    joint: &Joint,
    all: &'k [Known<'m>],
    number: &Parameter,
) -> Option<&'k Known<'m>> {
    let name = format!("{}.{}", joint.name, number.name);
    all.iter().find(|known| known.parameter.name == name)
}

/// A servo whose numbers are others than the file's; a file that states its damping as a share of another number
/// states none.
fn servo(joint: &Joint, all: &[Known]) -> Option<Planned> {
    let number = |number: &Parameter| of_servo(joint, all, number);
    let (gain, damping) = (number(&servo::GAIN)?, number(&servo::DAMPING)?);
    let limit = number(&servo::SATURATION);
    let stated = joint.servo.map(|s| match s.damping {
        ServoDamping::Of(damping) => (s.gain, damping, s.limit),
        ServoDamping::Ratio(_) => (s.gain, damping.parameter.value, s.limit),
    });
    let own = |known: &Known| known.parameter.value;
    let (was_gain, was_damping, was_limit) =
        stated.unwrap_or((own(gain), own(damping), limit.map(own)));
    let mut says = vec![];
    let mut compare = |known: &Known, was: Option<f64>| {
        if Some(known.value) != was {
            let sum = Sum::new(known.value, known.std);
            let key = known.parameter.name.rsplit('.').next().unwrap_or_default();
            says.push(format!("{key} {}", sum.says_of(was, &known.parameter.unit)));
        }
    };
    compare(gain, Some(was_gain));
    compare(damping, Some(was_damping));
    if let Some(limit) = limit {
        compare(limit, was_limit);
    }
    let change =
        Change::Servo(joint.name.clone(), [gain.value, damping.value], limit.map(|l| l.value));
    (!says.is_empty()).then(|| Planned {
        change,
        what: "servo",
        of: of(joint),
        says: says.join(", "),
    })
}

/// Motors drive joints in their order.
fn gain(joint: &Joint, acting: &[Acting], model: &Model) -> Option<Planned> {
    let driven = model.coordinates.iter().position(|c| c.name == joint.name)?;
    let input = &model.inputs.get(driven)?.name;
    let gains = || acting.iter().filter_map(|a| Some((a, a.part(Quantity::Gain, input)?)));
    let factor: f64 = gains().map(|(_, (gain, _))| gain).product();
    let says: Vec<String> = gains()
        .map(|(a, (gain, std))| {
            format!("{} ({})", crate::number::with_std(gain, std, "").replace('±', "+-"), a.by())
        })
        .collect();
    (factor != 1.0).then(|| Planned {
        change: Change::Gain(joint.name.clone(), factor),
        what: "gain",
        of: of(joint),
        says: says.join(" times "),
    })
}
