//! A robot's own file with other values in it: attributes are changed and elements put in where they must
//! be, each with a comment beside it; every other byte stays as it was.
//!
//! What a format knows of:
//!
//! | [`Change`] | URDF | MJCF |
//! | --- | --- | --- |
//! | damping, friction | `<dynamics>` of the joint | `damping`, `frictionloss` of the joint |
//! | rotor inertia, spring | - | `armature`; `stiffness`, `springref` |
//! | inertia of a link | its `<inertial>` | its `<inertial>`, which then counts in the place of its geoms |
//! | gravity | - | `<option gravity>` |
//! | gain of a motor | - | `gear` of the `<motor>`s of the joint |
//! | gains of a position servo | - | `kp`, `kv`, `forcerange` of the `<position>` of the joint |

use crate::xml::{Element, Source, comment};
use crate::{Format, Inertia, Robot, RobotError, mjcf, read, urdf};
use nalgebra::{Matrix3, SymmetricEigen};
use thiserror::Error;

/// What a file is to state, of a joint or link by its name.
#[derive(Clone, Debug, PartialEq)]
pub enum Change {
    /// Viscous friction of a joint, all of it, N m s/rad or N s/m.
    Damping(String, f64),
    /// Dry friction of a joint, all of it, N m or N.
    Friction(String, f64),
    /// Rotor inertia on a joint's side, all of it, kg m^2 or kg.
    Armature(String, f64),
    /// The spring in a joint: its stiffness (N m/rad or N/m), and the coordinate where it is at rest: an
    /// infinite one stands for a force without a spring.
    Spring(String, f64, f64),
    /// Inertia that a link has beside what the file states, in the link's frame.
    Inertia(String, Inertia<f64>),
    /// Gravity, m/s^2, in the root's frame.
    Gravity([f64; 3]),
    /// What the motors of a joint make of their commands is multiplied by this.
    Gain(String, f64),
    /// The position servo of a joint, on its side: its gain (N m/rad or N/m), its damping (N m s/rad or N s/m) and
    /// the most torque or force that it has, if that is limited.
    Servo(String, [f64; 2], Option<f64>),
}

/// A change and what the comment beside it says.
#[derive(Clone, Debug, PartialEq)]
pub struct Edit {
    /// The change.
    pub change: Change,
    /// The comment.
    pub says: String,
}

/// Why a file cannot state something.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum Unstated {
    /// There is no place for it.
    #[error("a {} has no place for it", .0.name())]
    NoPlace(Format),
    /// A quantity that is not negative would be.
    #[error("{0} is below 0")]
    Negative(f64),
    /// The file has no element of its own for it.
    #[error("the file has no <{0}> of its own for it")]
    NoElement(&'static str),
    /// The inertia would be one that no body can have.
    #[error("no body can have such a mass and inertia")]
    NoBody,
    /// A force that never changes can be that of a spring alone.
    #[error("it is none of a spring")]
    NoSpring,
    /// What the file says of its bodies' inertia does not count.
    #[error("<compiler inertiafromgeom=\"true\"> has inertia follow from shapes alone")]
    FromGeoms,
    /// Nothing pulls.
    #[error("gravity is disabled by a <flag>")]
    NoGravity,
    /// What drives the joint is more than a gain, or has a rotor or damper that the gain would change.
    #[error("no plain <motor> drives the joint")]
    NoMotor,
    /// The file has another servo, or none.
    #[error("no <position> alone drives the joint")]
    NoServo,
    /// What the file says cannot be read.
    #[error(transparent)]
    Unreadable(#[from] RobotError),
}

/// A file with other values in it.
#[derive(Clone, Debug, PartialEq)]
pub struct Edited {
    /// Its text.
    pub text: String,
    /// Whether it names other files, such as meshes, by where they are relative to it.
    pub names_files: bool,
    /// The edits, by their numbers, that are not in it, and why.
    pub left_out: Vec<(usize, Unstated)>,
}

/// The text of a robot's file with edits, each of another quantity.
///
/// # Errors
/// [`RobotError`] where the text is not that of a robot ([`read`]).
pub fn edit(text: &str, edits: &[Edit]) -> Result<Edited, RobotError> {
    let robot = read(text)?;
    let source = Source::parse(text)?;
    let named = |e: Element| e.get("file").or(e.get("filename")).is_some_and(is_relative);
    let names_files = source.root().descendants().any(named);
    let mut out = Edited { text: text.to_owned(), names_files, left_out: vec![] };
    for (number, edit) in edits.iter().enumerate() {
        match edited(&out.text, &robot, edit) {
            Ok(text) => out.text = text,
            Err(why) => out.left_out.push((number, why)),
        }
    }
    Ok(out)
}

/// The text with a comment in front of its first element.
///
/// # Errors
/// [`RobotError`] where the text is no XML.
pub fn headed(text: &str, says: &str) -> Result<String, RobotError> {
    let source = Source::parse(text)?;
    let start = source.root().start();
    let end = if text.contains("\r\n") { "\r\n" } else { "\n" };
    let says = comment(says).replace('\n', end);
    Ok(format!("{}{says}{end}{}", &text[..start], &text[start..]))
}

fn edited(text: &str, robot: &Robot, edit: &Edit) -> Result<String, Unstated> {
    let source = Source::parse(text)?;
    let whole = (text, source.root());
    match robot.format {
        Format::Urdf => urdf::edited(whole, robot, edit),
        Format::Mjcf => mjcf::edited(whole, robot, edit),
    }
}

/// Whether a file's name, or address, means another file from another folder.
fn is_relative(name: &str) -> bool {
    !name.contains("://") && !name.starts_with('/')
}

/// A quantity that is not negative.
pub(crate) fn positive(value: f64) -> Result<f64, Unstated> {
    if value >= 0.0 { Ok(value) } else { Err(Unstated::Negative(value)) }
}

/// The inertia of a link with what is added: such as a body can have, if it was.
pub(crate) fn with_added(
    robot: &Robot,
    link: &str,
    added: &Inertia<f64>,
) -> Result<crate::InertialParameters<f64>, Unstated> {
    let own = robot.links.iter().find(|l| l.name == link).ok_or(Unstated::NoElement("body"))?;
    let whole = own.inertia.plus(added);
    if is_possible(&own.inertia) && !is_possible(&whole) {
        return Err(Unstated::NoBody);
    }
    Ok(whole.parameters())
}

/// Whether some distribution of mass has this inertia: about its centre, the second moments of it are not
/// negative.
fn is_possible(inertia: &Inertia<f64>) -> bool {
    const ROUNDING: f64 = 1e-9;
    let [xx, xy, xz, yy, yz, zz] = inertia.parameters().inertia;
    let matrix = Matrix3::new(xx, xy, xz, xy, yy, yz, xz, yz, zz);
    let half_trace = 0.5 * matrix.trace();
    let moments = Matrix3::from_diagonal_element(half_trace) - matrix;
    let least = SymmetricEigen::new(moments).eigenvalues.min();
    inertia.mass >= 0.0 && half_trace.is_finite() && least >= -ROUNDING * half_trace
}
