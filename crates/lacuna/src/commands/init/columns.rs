//! Which columns of a recording are a robot's channels.

use lacuna::effects::servo;
use lacuna::plants::model::{Coordinate, RecordedInput};
use lacuna::recordings::Recording;
use lacuna::rigid;

/// What stands before or after a joint's name in that of a column, and the unit that it tells.
const POSITION: [(&str, Option<&str>); 6] = [
    ("", None),
    ("pos", None),
    ("position", None),
    ("q", None),
    ("angle", None),
    ("deg", Some("deg")),
];
const VELOCITY: [(&str, Option<&str>); 5] =
    [("vel", None), ("velocity", None), ("speed", None), ("dq", None), ("qd", None)];
const DRIVE: [(&str, Option<&str>); 5] =
    [("torque", None), ("force", None), ("effort", None), ("tau", None), ("trq", None)];

const COMMAND: [(&str, Option<&str>); 12] = [
    ("command", None),
    ("cmd", None),
    ("qcmd", None),
    ("commanded", None),
    ("goal", None),
    ("target", None),
    ("desired", None),
    ("setpoint", None),
    ("reference", None),
    ("commanddeg", Some("deg")),
    ("cmddeg", Some("deg")),
    ("goaldeg", Some("deg")),
];

/// A column that is a channel.
pub(super) struct Found {
    pub channel: String,
    pub column: Option<String>,
    pub unit: String,
}

/// A joint, and what a recording has of it.
pub(super) struct Joint {
    pub name: String,
    /// The joint of the robot that it is, or is a coordinate of.
    pub of: String,
    position: Found,
    velocity: Found,
    pub drive: Found,
    /// What its servo is, where it is told where to be and no torque is recorded.
    pub servo: Option<Gains>,
    /// Units of its force and its coordinate.
    pub units: (String, String),
}

/// Where the gains of a joint's servo stand.
#[derive(Clone, Copy)]
pub(super) enum Gains {
    /// In the robot's file.
    OfFile,
    /// Nowhere.
    Unknown,
}

impl Joint {
    pub fn of(joint: &rigid::Joint, recording: &Recording) -> Self {
        let (coordinate, input) = (Coordinate::of_joint(joint), RecordedInput::of_joint(joint));
        let found = |channel: String, words: &[(&str, Option<&str>)], unit: &str| {
            Found::among(recording, (&joint.name, channel), words, unit)
        };
        let position = found(coordinate.name, &POSITION, &coordinate.unit);
        let velocity = found(coordinate.velocity, &VELOCITY, &format!("{}/s", coordinate.unit));
        let torque = found(input.name, &DRIVE, &input.unit);
        let command = found(servo::command_of(&joint.name), &COMMAND, &coordinate.unit);
        let is_commanded = torque.column.is_none() && command.column.is_some();
        let gains = if joint.servo.is_some() { Gains::OfFile } else { Gains::Unknown };
        Self {
            name: joint.name.clone(),
            of: joint.of.clone(),
            position,
            velocity,
            drive: if is_commanded { command } else { torque },
            servo: is_commanded.then_some(gains),
            units: (coordinate.force_unit.unwrap_or_default(), coordinate.unit),
        }
    }

    pub fn channels(&self) -> [&Found; 3] {
        [&self.position, &self.velocity, &self.drive]
    }

    /// Whether nothing is recorded of it.
    pub fn is_absent(&self) -> bool {
        self.channels().iter().all(|c| c.column.is_none())
    }
}

impl Found {
    /// The column of a recording that is a channel of a joint: of the channel's own name, or of the joint's with
    /// a word before or after it.
    fn among(
        recording: &Recording,
        (joint, channel): (&str, String),
        words: &[(&str, Option<&str>)],
        unit: &str,
    ) -> Self {
        let columns = || recording.columns.iter().map(|c| &c.name);
        if let Some(exact) = columns().find(|c| **c == channel) {
            return Self { column: Some(exact.clone()), channel, unit: unit.to_owned() };
        }
        let joint = letters(joint);
        for (word, told) in words {
            let meant = [format!("{joint}{word}"), format!("{word}{joint}")];
            if let Some(column) = columns().find(|c| meant.contains(&letters(c))) {
                let unit = told.unwrap_or(unit).to_owned();
                return Self { column: Some(column.clone()), channel, unit };
            }
        }
        Self { column: None, channel, unit: unit.to_owned() }
    }
}

/// A name without what separates its words.
fn letters(name: &str) -> String {
    name.chars().filter(char::is_ascii_alphanumeric).map(|c| c.to_ascii_lowercase()).collect()
}
