//! A robot's own file with what was found, for the simulators that read it: what the augmented model says of
//! each joint, each link and gravity, in the place of what the file does.
//!
//! The augmented model is `M q'' + h = u - d v - f sign v - k (q - q_0) + r` with the masses that it
//! calibrated. Of the effects in r, a file takes up those that are a quantity it knows
//! ([`lacuna_effects::Stated`]) and those on structure ([`lacuna_effects::Acts::Links`],
//! [`lacuna_effects::Acts::Base`]); what it cannot say is told.

mod acting;
mod joints;
mod structure;

use crate::diagnosis::Finding;
use crate::number::with_std;
use crate::words::numbers;
use acting::{Acting, Known};
use lacuna_effects::servo;
use lacuna_plants::Model;
use lacuna_plants::model::{Augmentation, RobotFile};
use lacuna_rigid::edit::{Change, Edit, Edited, Unstated, edit, headed};
use lacuna_rigid::{Format, Joint, RobotError, Tree};

/// A robot's own file with what was found.
#[derive(Clone, Debug)]
pub struct Augmented {
    /// Its name: `augmented.urdf`, `augmented.xml`.
    pub name: String,
    /// Its text: as it was, to the byte, where nothing was found.
    pub text: String,
    /// What of the augmented model it does not say.
    pub left_out: Vec<LeftOut>,
}

/// What a file does not say.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct LeftOut {
    /// What it is: `cogging on elbow`.
    pub what: String,
    /// Its numbers, and why it is not there.
    pub details: String,
}

/// A change of the file, and what it is told of.
struct Planned {
    change: Change,
    /// What it is: `rotor inertia`.
    what: &'static str,
    /// What it is of: `of joint elbow`.
    of: String,
    /// How much it is, what it was, and by what it changes.
    says: String,
}

/// The file of a model that is a robot's, with what a diagnosis adds to it and how sure its findings are;
/// none of another model.
///
/// # Errors
/// [`RobotError`] where the file's text is no robot's, which it was when the model was read.
pub fn augmented(
    model: &Model,
    augmentation: &Augmentation,
    findings: &[Finding],
) -> Result<Option<Augmented>, RobotError> {
    let Some(file) = model.robot_file() else { return Ok(None) };
    let acting = acting::effects(model, augmentation, findings);
    let known = acting::parameters(model, augmentation);
    let planned = planned(model, file, (&known, &acting));
    let edits = planned
        .iter()
        .map(|p| Edit { change: p.change.clone(), says: format!("lacuna: {} {}", p.what, p.says) });
    let edited = edit(&file.text, &edits.collect::<Vec<_>>())?;
    let mut left_out: Vec<LeftOut> = edited
        .left_out
        .iter()
        .map(|(number, why)| {
            let Planned { what, of, says, .. } = &planned[*number];
            LeftOut { what: format!("{what} {of}"), details: format!("{says}: {why}") }
        })
        .collect();
    left_out.extend(play(model, &known, file.format));
    left_out.extend(acting.iter().filter_map(|a| beyond(a, file.format)));
    let name = format!("augmented.{}", file.format.extension());
    let text = match edited.text == file.text && left_out.is_empty() {
        true => edited.text,
        false => headed(&edited.text, &head(file, &edited, &left_out))?,
    };
    Ok(Some(Augmented { name, text, left_out }))
}

/// What is to be another than the file says.
fn planned(model: &Model, file: &RobotFile, (all, acting): (&[Known], &[Acting])) -> Vec<Planned> {
    let bodies = model.dynamics().tree().map_or(&[][..], |tree| &tree.bodies);
    let mut planned = vec![];
    for (body, known) in bodies.iter().zip(model.by_body(all)) {
        planned.extend(joints::changes(&body.joint, (&known, all), acting, model));
        planned.extend(structure::link((&body.name, &body.inertia), &known.inertia, acting));
    }
    let parts = model.dynamics().tree().into_iter().flat_map(Tree::apart);
    for (part, known) in parts.zip(model.by_part(all)) {
        planned.extend(structure::link((&part.name, &part.inertia()), &known, &[]));
    }
    planned.extend(structure::gravity(file, acting));
    planned
}

/// Play of servos, of which no such file knows.
fn play(model: &Model, all: &[Known], format: Format) -> Vec<LeftOut> {
    let joints = model.dynamics().tree().into_iter().flat_map(Tree::joints);
    let of = |joint: &Joint| {
        let known = joints::of_servo(joint, all, &servo::BACKLASH).filter(|k| k.value > 0.0)?;
        let size = with_std(known.value, known.std, &known.parameter.unit).replace('±', "+-");
        Some(LeftOut {
            what: format!("{} of the servo of joint {}", servo::BACKLASH.name, joint.name),
            details: format!("{size}: {}", Unstated::NoPlace(format)),
        })
    };
    joints.filter_map(of).collect()
}

/// What of an effect is no quantity that any such file knows.
fn beyond(a: &Acting, format: Format) -> Option<LeftOut> {
    let numbers = numbers(&a.new, &[]);
    let what = match a.new.effect.nature.stated {
        Some(stated) => format!("{} ({})", stated.lost?, a.called()),
        None if a.structure().is_some() => return None,
        None => a.called(),
    };
    let why = Unstated::NoPlace(format);
    let details = if numbers.is_empty() { why.to_string() } else { format!("{numbers}: {why}") };
    Some(LeftOut { what, details })
}

/// What stands in front of the file.
fn head(file: &RobotFile, edited: &Edited, left_out: &[LeftOut]) -> String {
    let called = file.path.as_ref().map(|path| path.file_name().unwrap_or(path.as_os_str()));
    let name = called.map_or_else(|| file.format.name().into(), |name| name.to_string_lossy());
    let mut lines =
        vec![format!("lacuna: {name} with what was found; a comment stands beside what is new.")];
    if edited.names_files {
        lines.push(format!("Other files are named relative to the folder of {name}."));
    }
    if !left_out.is_empty() {
        lines.push(format!("Not in this {}:", file.format.name()));
        lines.extend(left_out.iter().map(|l| format!("  {}: {}", l.what, l.details)));
    }
    lines.join("\n     ")
}
