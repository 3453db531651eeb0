//! The part of the guide's page that shows the pictures, by what effects say of themselves.

use lacuna_effects::{Acts, CATALOGUE, Effect, Kind, Law, Variable};
use std::fmt::Write;

use super::force::{self, Shows};
use super::typical::simplest;
use super::{COMMAND, FOLDER};

/// The heading of the part, which is the last of the page.
const HEADING: &str = "## Signatures\n";
/// Width of a picture on the page.
const WIDTH: u32 = 260;

/// What effects have in common that are shown together.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Group {
    DryFriction,
    Velocity,
    Position,
    Stops,
    Time,
    Memory,
    Resonances,
    Couplings,
    States,
    Structure,
    Actuators,
    Sensors,
}

/// In the order of the page.
const GROUPS: [Group; 12] = [
    Group::DryFriction,
    Group::Velocity,
    Group::Position,
    Group::Stops,
    Group::Time,
    Group::Memory,
    Group::Resonances,
    Group::Couplings,
    Group::States,
    Group::Structure,
    Group::Actuators,
    Group::Sensors,
];

impl Group {
    fn of(effect: &Effect) -> Self {
        let law = match effect.law {
            Law::Force(law) => law,
            Law::Structure(_) => return Self::Structure,
            Law::Input(_) => return Self::Actuators,
            Law::Sensor(_) => return Self::Sensors,
        };
        let is_curve = effect.parameters.iter().any(|p| p.kind == Kind::Variable);
        let in_time = effect.depends_on.iter().all(|v| *v == Variable::Time);
        let rubs = effect.depends_on.contains(&Variable::Velocity) && !is_curve;
        match force::shows(effect, law) {
            _ if effect.acts == Acts::States => Self::States,
            _ if effect.couples() => Self::Couplings,
            _ if effect.nature.edge => Self::Stops,
            Shows::Resonance => Self::Resonances,
            _ if rubs && effect.nature.kin.is_some() => Self::DryFriction,
            Shows::Trace => Self::Memory,
            Shows::Curve if in_time => Self::Time,
            Shows::Curve if rubs => Self::Velocity,
            Shows::Curve => Self::Position,
        }
    }

    fn title(self) -> &'static str {
        match self {
            Self::DryFriction => "Dry friction",
            Self::Velocity => "Other forces of the velocity",
            Self::Position => "Forces of the position and of the acceleration",
            Self::Stops => "Stops",
            Self::Time => "Forces in time",
            Self::Memory => "Forces that remember",
            Self::Resonances => "Resonances",
            Self::Couplings => "Between two coordinates",
            Self::States => "First-order states",
            Self::Structure => "Structure of a robot",
            Self::Actuators => "Actuators",
            Self::Sensors => "Sensors",
        }
    }

    /// How to read its pictures and tell them apart.
    fn reads(self) -> &'static str {
        match self {
            Self::DryFriction => {
                "A jump where the motion turns. Where there are three curves, they are for three values of what else matters; \
                 loops are those of the usual motion, of the same five times slower, and of a quarter of its stroke."
            }
            Self::Velocity => {
                "No jump where the motion turns: straight or bent, and the same or not at three values of what else matters."
            }
            Self::Position => "How the curve bends, and whether it repeats, tells these apart.",
            Self::Stops => {
                "Along a motion to and fro. One that damps pushes more on the way in than on the way out."
            }
            Self::Time => "Whatever the machine does.",
            Self::Memory => {
                "Loops of the usual motion, of the same five times slower, and of a quarter of its stroke. What changes with the \
                 speed relaxes in time; play and hysteresis do not."
            }
            Self::Resonances => {
                "Acceleration by a torque that swings with each frequency. A mass that hangs on the coordinate makes the machine \
                 heavier below the dip and leaves it as it is above the peak; an elastic drive does the reverse."
            }
            Self::Couplings => {
                "Against what the other coordinate does, for three values of what the channel's own does."
            }
            Self::States => "What a state loses, against itself.",
            Self::Structure => {
                "Torques along one motion, dashed without the effect. A payload shows more the faster the robot moves; a tilt does \
                 not, and loads even an axis that the model has upright."
            }
            Self::Actuators => {
                "What the machine gets of the command. Two are shown in time: they do less to a command that changes slowly."
            }
            Self::Sensors => {
                "What is recorded of a machine that moves as the model says. A delay shows where it moves fast, a bias and a scale \
                 where it rests, too."
            }
        }
    }
}

/// The page with the part about the pictures written anew.
#[must_use]
pub fn with_pictures(page: &str) -> String {
    let rest = page.split_once(HEADING).map_or(page, |(rest, _)| rest).trim_end();
    format!("{rest}\n\n{}", pictures())
}

fn pictures() -> String {
    let mut out = format!(
        "{HEADING}\nWhat each law does to a joint that turns by half a turn either way, with usual parameters, drawn from the laws \
         themselves by `{COMMAND}`. Where a law has a simpler relative, that one is dashed in its place.\n"
    );
    for group in GROUPS {
        let effects = || CATALOGUE.iter().copied().filter(|e| Group::of(e) == group);
        let _ = write!(out, "\n### {}\n\n{}\n\n", group.title(), group.reads());
        for effect in effects() {
            let Effect { class, words, .. } = effect;
            let _ = writeln!(
                out,
                "<img src=\"{FOLDER}/{class}.svg\" width=\"{WIDTH}\" alt=\"{class}: {words}\">"
            );
        }
        let known: String = effects().filter_map(beside).collect();
        if !known.is_empty() {
            let _ = write!(out, "\n{known}");
        }
    }
    out
}

/// How an effect differs from the simplest of its family, as an entry of a list.
fn beside(effect: &Effect) -> Option<String> {
    let simplest = simplest(effect)?;
    let further = effect.depends_on.iter().filter(|v| !simplest.depends_on.contains(v));
    let mut by: Vec<String> = further.map(|v| variable(*v).to_owned()).collect();
    if remembers(effect) && !remembers(simplest) {
        by.push("what it remembers".to_owned());
    }
    let named = simplest.parameters.iter().map(|p| p.name).collect::<Vec<_>>();
    // The first says how much of it there is.
    let own = effect.parameters.iter().skip(1);
    let own = own.filter(|p| p.physical && !named.contains(&p.name));
    let own: Vec<String> = own.map(|p| format!("`{}`", p.name)).collect();
    let by = if by.is_empty() { own.join(", ") } else { by.join(" and ") };
    Some(format!("- `{}` differs from `{}` by {by}\n", effect.class, simplest.class))
}

fn remembers(effect: &Effect) -> bool {
    matches!(effect.law, Law::Force(law) if law.memory() > 0)
}

fn variable(variable: Variable) -> &'static str {
    match variable {
        Variable::Coordinate => "the position",
        Variable::Velocity => "the velocity",
        Variable::Acceleration => "the acceleration",
        Variable::OtherCoordinate => "the position of another",
        Variable::OtherVelocity => "the velocity of another",
        Variable::Time => "the time",
        Variable::Input | Variable::OtherInput => "an input",
    }
}
