//! `lacuna init`: the model file of a robot, to be edited, with what of it is in a recording.

use super::Outcome;
use crate::output::write_whole;
use crate::say::sayln;
use clap::Args;
use lacuna::recordings::{self, Recording, RecordingSource};
use lacuna::rigid::{self, JointKind, Robot, Tree};
use std::fmt::Write;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

#[derive(Args)]
pub struct Arguments {
    /// The robot's own file: URDF or MJCF
    robot: PathBuf,
    /// A recording of it, as a file, or a part of one: file.csv#t=0..20
    recording: RecordingSource,
    /// Write the model file here [default: the robot's name with .toml, in this folder]
    #[arg(long)]
    out: Option<PathBuf>,
}

/// Names that columns of time have, the usual one first.
const TIMES: [&str; 4] = ["t", "time", "timestamp", "stamp"];

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

pub fn run(a: &Arguments) -> Outcome {
    let (robot, tree) = read_robot(&a.robot)?;
    let (time, recording) = read_recording(&a.recording)?;
    let joints: Vec<Joint> =
        (0..tree.bodies.len()).map(|i| Joint::of(&tree, i, &recording)).collect();
    if joints.iter().all(Joint::is_absent) {
        let columns: Vec<&str> = recording.columns.iter().map(|c| c.name.as_str()).collect();
        let names: Vec<&str> = joints.iter().map(|j| j.name.as_str()).collect();
        let said = format!(
            "{}: no column is named after a joint of {} ({}); found {}",
            recording.name,
            a.robot.display(),
            names.join(", "),
            columns.join(", ")
        );
        return Err(said.into());
    }
    let out = a.out.clone().unwrap_or_else(|| {
        PathBuf::from(a.robot.file_stem().unwrap_or_default()).with_extension("toml")
    });
    if out.exists() {
        let said = "is there already: name another file with --out, or remove it";
        return Err(format!("{} {said}", out.display()).into());
    }
    write_whole(&out, &text(&a.robot, &out, (&robot, &time), &joints))?;
    tell(&out, &recording, &joints)?;
    Ok(ExitCode::SUCCESS)
}

fn read_robot(path: &Path) -> Result<(Robot, Tree), Box<dyn std::error::Error>> {
    let file = path.display();
    let text = std::fs::read_to_string(path).map_err(|e| format!("{file} cannot be read: {e}"))?;
    let told = |e: rigid::RobotError| match e.line {
        Some(line) => format!("{file}:{line}: {e}"),
        None => format!("{file}: {e}"),
    };
    let robot = rigid::read(&text).map_err(told)?;
    let held: Vec<(String, f64)> =
        not_simulated(&robot).map(|name| (name.to_owned(), 0.0)).collect();
    let tree = robot.tree(&held).map_err(told)?;
    Ok((robot, tree))
}

/// The joints that cannot be simulated: they are held still from the outset.
fn not_simulated(robot: &Robot) -> impl Iterator<Item = &str> {
    let coupled = |joint: usize| robot.couplings.iter().any(|c| c.joints.contains(&joint));
    let joints = robot.joints.iter().enumerate();
    let held = joints.filter(move |(number, joint)| {
        matches!(joint.moves, rigid::Moves::Otherwise(_)) || coupled(*number)
    });
    held.map(|(_, joint)| joint.name.as_str())
}

/// A recording and the name of its column of time.
fn read_recording(
    source: &RecordingSource,
) -> Result<(String, Recording), Box<dyn std::error::Error>> {
    let mut first = None;
    for name in TIMES {
        match recordings::read(source, name) {
            Ok(recording) => return Ok((name.to_owned(), recording)),
            Err(error) => first = first.or(Some(error)),
        }
    }
    Err(first.map_or_else(|| "no name of a column of time is known".into(), Into::into))
}

/// A column that is a channel.
struct Found {
    channel: String,
    column: Option<String>,
    unit: String,
}

/// A joint, and what a recording has of it.
struct Joint {
    name: String,
    position: Found,
    velocity: Found,
    drive: Found,
}

impl Joint {
    fn of(tree: &Tree, body: usize, recording: &Recording) -> Self {
        let joint = &tree.bodies[body].joint;
        let (units, drive) = match joint.kind {
            JointKind::Revolute => (["rad", "rad/s", "N m"], "torque"),
            JointKind::Prismatic => (["m", "m/s", "N"], "force"),
        };
        let name = joint.name.clone();
        let found = |channel: String, words: &[(&str, Option<&str>)], unit: &str| {
            Found::among(recording, (&name, channel), words, unit)
        };
        let position = found(name.clone(), &POSITION, units[0]);
        let velocity = found(format!("{name}_vel"), &VELOCITY, units[1]);
        let drive = found(format!("{name}_{drive}"), &DRIVE, units[2]);
        Self { name, position, velocity, drive }
    }

    fn channels(&self) -> [&Found; 3] {
        [&self.position, &self.velocity, &self.drive]
    }

    /// Whether nothing is recorded of it.
    fn is_absent(&self) -> bool {
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

/// The model file.
fn text(robot_file: &Path, out: &Path, (robot, time): (&Robot, &str), joints: &[Joint]) -> String {
    let gravity = robot.gravity.unwrap_or([0.0, 0.0, -9.81]);
    let mut text = format!("name = {}\n\n[robot]\n", quoted(&robot.name));
    let mut line = |said: String| writeln!(text, "{said}").unwrap_or_default();
    line(format!("file = {}", quoted(&relative(robot_file, out))));
    line(format!("gravity = {gravity:?}   # m/s^2, in the frame of the robot's root"));
    let absent = joints.iter().filter(|j| j.is_absent()).map(|j| j.name.as_str());
    let locked: Vec<String> = not_simulated(robot).chain(absent).map(quoted).collect();
    if !locked.is_empty() {
        line("# Not in the recording, or not simulated: held still, at 0 unless { name = ..., at = ... }.".into());
        line(format!("locked = [{}]", locked.join(", ")));
    }
    line("# One standard deviation of what the file says; what is left out is taken as known exactly.".into());
    line(
        "# tolerance = { mass = 0.05, com = 0.01, inertia = 0.1 }   # relative, m, relative".into(),
    );
    line("\n# Other values than the file's, or how sure they are:".into());
    line("# [parameters]".into());
    if let Some(joint) = joints.iter().find(|j| !j.is_absent()) {
        line(format!("# \"{}.armature\" = {{ value = 0.01, std = 0.01 }}", joint.name));
    }
    line(format!("\n[recordings]\ntime = {}", quoted(time)));
    line("input_hold = \"zero-order\"   # or \"linear\", \"band-limited\"".into());
    let channels = || joints.iter().flat_map(Joint::channels);
    let renamed = |c: &Found| c.column.as_ref().is_some_and(|column| *column != c.channel);
    if channels().any(renamed) {
        for Found { channel, column, unit } in channels() {
            let Some(column) = column else { continue };
            let (column, of) = (quoted(column), quoted(channel));
            line(format!(
                "\n[[measurement]]\ncolumn = {column}\nof = {of}\nunit = {}",
                quoted(unit)
            ));
        }
    }
    text
}

fn quoted(text: &str) -> String {
    // JSON's strings are TOML's.
    serde_json::Value::from(text).to_string()
}

/// The robot's file as it is found from the model's folder; whole where that is another.
fn relative(robot: &Path, out: &Path) -> String {
    let folder = |p: &Path| p.parent().map(Path::to_owned).unwrap_or_default();
    let path = match (robot.file_name(), folder(robot) == folder(out)) {
        (Some(name), true) => PathBuf::from(name),
        _ => std::path::absolute(robot).unwrap_or_else(|_| robot.to_owned()),
    };
    path.display().to_string()
}

/// What was matched and what was not.
fn tell(out: &Path, recording: &Recording, joints: &[Joint]) -> std::io::Result<()> {
    sayln!("{}: to be edited; then lacuna check {} ...", out.display(), out.display())?;
    for joint in joints {
        if joint.is_absent() {
            sayln!("  {}: not in {}, held still", joint.name, recording.name)?;
            continue;
        }
        let told = |c: &Found| c.column.as_ref().map(|column| format!("{} = {column}", c.channel));
        let said: Vec<String> = joint.channels().into_iter().filter_map(told).collect();
        sayln!("  {}: {}", joint.name, said.join(", "))?;
        if joint.drive.column.is_none() {
            sayln!(
                "    no column of {}: without a motor add one of zeros, or lock the joint",
                joint.drive.channel
            )?;
        }
    }
    let used: Vec<&String> =
        joints.iter().flat_map(Joint::channels).filter_map(|c| c.column.as_ref()).collect();
    let unused = recording.columns.iter().map(|c| &c.name).filter(|name| !used.contains(name));
    let unused: Vec<&str> = unused.map(String::as_str).collect();
    if !unused.is_empty() {
        sayln!("  columns that no joint explains: {}", unused.join(", "))?;
    }
    Ok(())
}
