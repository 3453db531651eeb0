//! `lacuna init`: the model file of a robot, to be edited, with what of it is in a recording.

mod columns;

use super::Outcome;
use crate::say::sayln;
use clap::Args;
use columns::{Found, Gains, Joint};
use lacuna::effects::{Dimension, Parameter, servo};
use lacuna::files::write_whole;
use lacuna::plants::model::quoted;
use lacuna::recordings::{self, Recording, RecordingSource};
use lacuna::rigid::{self, GRAVITY, Robot, Tree};
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

pub fn run(a: &Arguments) -> Outcome {
    let (robot, tree) = read_robot(&a.robot)?;
    let (time, recording) = read_recording(&a.recording)?;
    let joints: Vec<Joint> = tree.joints().map(|joint| Joint::of(joint, &recording)).collect();
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
    // What cannot be simulated is held still from the outset.
    let held: Vec<_> = robot.not_simulated().map(|name| (name.to_owned(), 0.0)).collect();
    let tree = robot.tree(&held).map_err(told)?;
    Ok((robot, tree))
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

/// The model file.
fn text(robot_file: &Path, out: &Path, (robot, time): (&Robot, &str), joints: &[Joint]) -> String {
    let (name, file) = (quoted(&robot.name), quoted(&relative(robot_file, out)));
    let gravity = robot.gravity.unwrap_or(GRAVITY);
    let mut text = format!(
        "name = {name}\n\n[robot]\nfile = {file}\n\
         gravity = {gravity:?}   # m/s^2, in the frame of the robot's root\n"
    );
    let mut locked: Vec<String> = robot.not_simulated().chain(absent(joints)).map(quoted).collect();
    locked.dedup();
    if !locked.is_empty() {
        text += "# Not in the recording, or not simulated: held still, at 0 unless { name = ..., at = ... }.\n";
        text += &format!("locked = [{}]\n", locked.join(", "));
    }
    text += "# One standard deviation of what the file says; what is left out is taken as known exactly.\n\
        # tolerance = { mass = 0.05, com = 0.01, inertia = 0.1 }   # relative, m, relative\n\n\
        # Other values than the file's, or how sure they are:\n# [parameters]\n";
    if let Some(joint) = joints.iter().find(|j| !j.is_absent()) {
        text += &format!("# \"{}.armature\" = {{ value = 0.01, std = 0.01 }}\n", joint.name);
    }
    text += &format!("\n[recordings]\ntime = {}\n", quoted(time));
    text += "input_hold = \"zero-order\"   # or \"linear\", \"band-limited\"\n";
    text + &joints.iter().map(actuator).collect::<String>() + &measurements(joints)
}

/// The servo of a joint that is told where to be.
fn actuator(joint: &Joint) -> String {
    let Some(gains) = joint.servo else { return String::new() };
    let unit = |of: Dimension| quoted(&of.text(&joint.units.0, &joint.units.1, ""));
    let number = |p: Parameter, how_sure: &str| {
        format!("# {} = {{ value = ..., unit = {}{how_sure} }}\n", p.name, unit(p.unit))
    };
    let (template, channel) = (quoted(servo::TEMPLATE), quoted(&joint.name));
    let mut text = format!("\n[[actuator]]\ntemplate = {template}\nchannel = {channel}\n");
    text += match gains {
        Gains::OfFile => {
            "# Its gains are those of the robot's file, known exactly unless they are said here:\n"
        }
        Gains::Unknown => "# The robot's file has no gains: say them.\n",
    };
    text += &number(servo::GAIN, ", tolerance = 0.2");
    text += &number(servo::DAMPING, ", tolerance = 0.5");
    text += &number(servo::SATURATION, "");
    text + &number(servo::BACKLASH, "")
}

/// What is held still: joints that are not in the recording, and single coordinates of one of several that is.
fn absent(joints: &[Joint]) -> impl Iterator<Item = &str> {
    let whole = |of: &str| joints.iter().filter(|j| j.of == of).all(Joint::is_absent);
    let absent = joints.iter().filter(|j| j.is_absent());
    absent.map(move |j| if whole(&j.of) { j.of.as_str() } else { j.name.as_str() })
}

/// What columns measure, where any has another name than its channel.
fn measurements(joints: &[Joint]) -> String {
    let channels = joints.iter().flat_map(Joint::channels);
    let found: Vec<_> = channels.filter_map(|c| Some((c, c.column.as_ref()?))).collect();
    if found.iter().all(|(c, column)| **column == c.channel) {
        return String::new();
    }
    let table = |(Found { channel, unit, .. }, column): &(&Found, &String)| {
        let [column, of, unit] = [*column, channel, unit].map(|text| quoted(text));
        format!("\n[[measurement]]\ncolumn = {column}\nof = {of}\nunit = {unit}\n")
    };
    found.iter().map(table).collect()
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
        match joint.servo {
            Some(Gains::OfFile) => sayln!("    a servo, with the gains of the robot's file")?,
            Some(Gains::Unknown) => {
                sayln!("    a servo, of whose gains the robot's file says nothing: say kp and kd")?;
            }
            None => {}
        }
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
