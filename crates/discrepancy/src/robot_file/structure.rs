//! What is new of what links are made of, and of how the base stands.

use super::Planned;
use super::acting::{Acting, Known};
use crate::number::{plain, with_std};
use crate::words::numbers;
use lacuna_effects::Acts;
use lacuna_plants::model::RobotFile;
use lacuna_rigid::edit::Change;
use lacuna_rigid::{Inertia, InertialParameters, Pose};

/// The inertia of a link with all that is fixed to it and not told apart is linear in that of the link: what it is
/// more is that one's.
pub(super) fn link(
    (name, own): (&str, &InertialParameters<f64>),
    known: &InertialParameters<Known>,
    acting: &[Acting],
) -> Option<Planned> {
    let (value, parameters) = (|k: Known| k.value, own.entries());
    let new = InertialParameters::of_entries(&known.entries().map(value));
    let moved = known.entries().into_iter().zip(parameters).filter(|(k, was)| k.value != *was);
    let mut says: Vec<String> = moved.map(|(k, was)| said(&k, was, name)).collect();
    let mut added = match says.is_empty() {
        true => Inertia::none(),
        false => new.about_origin().plus(&own.about_origin().map(|x| -x)),
    };
    for a in acting.iter().filter(|a| a.new.channel == name) {
        if let Some((Acts::Links, carried)) = a.structure() {
            added = added.plus(&inertia(&carried)?);
            says.push(format!("{} ({})", numbers(&a.new, &[]), a.by()));
        }
    }
    (!says.is_empty()).then(|| Planned {
        change: Change::Inertia(name.to_owned(), added),
        what: "inertia",
        of: format!("of link {name}"),
        says: format!("by {}", says.join(", ")),
    })
}

/// A calibrated parameter of a link, without the link's name.
fn said(k: &Known, was: f64, link: &str) -> String {
    let name = k.parameter.name.strip_prefix(link).unwrap_or(&k.parameter.name);
    let estimate = with_std(k.value, k.std, &k.parameter.unit).replace('±', "+-");
    format!("{} {estimate} (was {})", name.trim_start_matches('.'), plain(was, ""))
}

/// That of the numbers of an effect on a link's structure.
fn inertia(numbers: &[f64]) -> Option<Inertia<f64>> {
    let &[mass, x, y, z, xx, xy, xz, yy, yz, zz] = numbers else { return None };
    let about_origin = [[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]];
    Some(Inertia { mass, moment: [x, y, z], about_origin })
}

/// Gravity as a base sees it that does not stand as the file says.
pub(super) fn gravity(file: &RobotFile, acting: &[Acting]) -> Option<Planned> {
    let mut gravity = file.gravity;
    let mut says = vec![];
    for a in acting {
        let Some((Acts::Base, tilt)) = a.structure() else { continue };
        let &[roll, pitch] = &tilt[..] else { continue };
        let base = Pose::of_roll_pitch_yaw([0.0; 3], [roll, pitch, 0.0]);
        gravity = base.turned_back(gravity);
        says.push(format!(
            "{} of the base, {} ({})",
            a.new.effect.words,
            numbers(&a.new, &[]),
            a.by()
        ));
    }
    let was = file.stated_gravity;
    let [x, y, z] = was;
    says.insert(0, format!("in the base's frame, was {x} {y} {z}"));
    (gravity != was).then(|| Planned {
        change: Change::Gravity(gravity),
        what: "gravity",
        of: "on the base".to_owned(),
        says: says.join("; "),
    })
}
