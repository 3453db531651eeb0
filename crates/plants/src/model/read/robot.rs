//! `[robot]`: a model whose equations of motion are those of a robot's own file.

use super::actuator::OfFile;
use super::{File, RawInput, Reader};
use crate::dynamics::{Dynamics, INERTIAL, PARTS, Part, RobotDynamics, felt};
use crate::model::{
    Coordinate, Measured, Measurement, Model, ModelError, Parameter, Place, RecordedInput,
    RobotFile, Source, Uncertainty, quoted,
};
use lacuna_effects::servo;
use lacuna_rigid::{GRAVITY, InertialParameters, Joint, JointKind, Robot, RobotError, Tree};
use serde::Deserialize;
use std::io;
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use toml::Spanned;

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RawRobot {
    /// Its own file, or the text of such a file.
    file: Option<Spanned<String>>,
    text: Option<Spanned<String>>,
    gravity: Option<Spanned<[f64; 3]>>,
    #[serde(default)]
    locked: Vec<Spanned<RawLocked>>,
    #[serde(default)]
    tolerance: RawTolerance,
}

/// A joint that is held still: its name, in which a final `*` stands for any end, or with where it is.
#[derive(Deserialize)]
#[serde(untagged, expecting = "the name of a joint, or { name = \"...\", at = its coordinate }")]
enum RawLocked {
    Name(String),
    At(LockedAt),
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct LockedAt {
    name: String,
    at: f64,
}

/// One standard deviation of what is believed: relative of mass and inertia, in metres of a centre of mass.
#[derive(Default, Deserialize)]
#[serde(deny_unknown_fields)]
struct RawTolerance {
    mass: Option<Spanned<f64>>,
    com: Option<Spanned<f64>>,
    inertia: Option<Spanned<f64>>,
}

/// The model file that says no more than a robot's own, by that one's path and text; none where it is none.
pub(super) fn about(path: &Path, text: &str) -> Option<String> {
    let kind = path.extension().and_then(|kind| kind.to_str()).unwrap_or_default();
    let named = ["urdf", "xml", "mjcf"].iter().any(|known| kind.eq_ignore_ascii_case(known));
    let (name, stem) = (path.file_name()?.to_str()?, path.file_stem()?.to_str()?);
    (named || text.trim_start().starts_with('<'))
        .then(|| format!("name = {}\n\n[robot]\nfile = {}\n", quoted(stem), quoted(name)))
}

impl Model {
    /// Whether a robot's own file was read that has position servos drive joints.
    #[must_use]
    pub fn has_servos_of_file(&self) -> bool {
        self.servos_of_file().next().is_some()
    }

    /// Joints, by their numbers and names, that the robot's own file has servos drive; none where a model file
    /// stands beside it, which says what is commanded.
    fn servos_of_file(&self) -> impl Iterator<Item = (usize, &str)> {
        let alone = self.source.as_ref().is_some_and(|source| source.alone);
        let tree = self.dynamics.tree().filter(|_| alone);
        let joints = tree.into_iter().flat_map(Tree::joints).enumerate();
        joints.filter(|(_, joint)| joint.servo.is_some()).map(|(c, joint)| (c, &*joint.name))
    }

    /// The model for recordings with these columns. Where a robot's own file was read, a joint that it has a
    /// position servo drive follows the command of that where the columns hold this (`elbow_command`) and no torque
    /// (`elbow_torque`).
    ///
    /// # Errors
    /// [`ModelError`] where two things would have one name.
    pub fn driven_by(self, columns: &[String]) -> Result<Self, ModelError> {
        let has = |name: &str| columns.iter().any(|column| column == name);
        let commanded = |(c, joint): &(usize, &str)| {
            has(&servo::command_of(joint)) && !has(&self.inputs[*c].name)
        };
        let joints: Vec<&str> =
            self.servos_of_file().filter(commanded).map(|(_, joint)| joint).collect();
        let (Some(source), false) = (&self.source, joints.is_empty()) else { return Ok(self) };
        let robot = source.robot.as_ref().map(|own| &*own.text);
        Reader { text: &source.text, file: &source.file, robot }.with_servos(&joints)
    }
}

impl Reader<'_> {
    pub(super) fn robot(&self, raw: &File, table: &Spanned<RawRobot>) -> Result<Model, ModelError> {
        self.check_alone(raw, table.span(), "[robot] says how all joints move")?;
        let robot = table.get_ref();
        let (mut tree, mut own) = self.tree(robot, self.own_file(table)?)?;
        // What a model file says of a link that is fixed to another, it says of that alone.
        let names = raw.parameters.keys().map(|name| name.get_ref().as_str());
        links(names).for_each(|link| tree.tell_apart(link));
        let tree = Arc::new(tree);
        let gravity = robot.gravity.as_ref().map_or(own.stated_gravity, |g| *g.get_ref());
        own.gravity = gravity;
        if let Some(g) = robot.gravity.as_ref().filter(|_| gravity.iter().any(|g| !g.is_finite())) {
            return Err(self.error(g.span(), "gravity must be finite".to_owned()));
        }
        let dynamics = Arc::new(RobotDynamics::new(tree.clone(), gravity));
        let parameters = self.robot_parameters(&tree, &robot.tolerance, &dynamics)?;
        let mut model = Model {
            name: raw.name.clone(),
            parameters,
            inputs: tree.joints().map(RecordedInput::of_joint).collect(),
            coordinates: tree.joints().map(Coordinate::of_joint).collect(),
            states: vec![],
            effects: vec![],
            measurements: vec![],
            time_column: raw.recordings.time.clone(),
            time_seconds: self.seconds(&raw.recordings.time_unit)?,
            hold: raw.recordings.input_hold,
            assumptions: vec![],
            dynamics,
            source: Some(Arc::new(Source {
                file: self.file.to_owned(),
                text: self.text.to_owned(),
                robot: Some(own),
                fmu: None,
                alone: self.robot.is_some(),
            })),
        };
        self.actuators(&raw.actuator, &mut model, Some(&servos(&tree)), |servos| {
            Arc::new(RobotDynamics::new(tree.clone(), gravity).with_servos(servos))
        })?;
        self.override_parameters(raw, &mut model)?;
        assume_rotors(&mut model, &tree);
        self.override_inputs(&raw.input, &mut model)?;
        for m in &raw.measurement {
            let measurement = self.measured_of_robot(m, &model)?;
            model.measurements.push(measurement);
        }
        self.check_measured_inputs(&raw.measurement, &model.measurements)?;
        for e in &raw.effect {
            let effect = self.effect(e, &model)?;
            model.effects.push(effect);
        }
        check_weight(&model, &tree, self.file)?;
        Ok(model)
    }

    /// A model file, or what stands for one, with servos of these joints.
    fn with_servos(&self, joints: &[&str]) -> Result<Model, ModelError> {
        let table = |joint: &&str| {
            let (template, channel) = (quoted(servo::TEMPLATE), quoted(joint));
            format!("\n[[actuator]]\ntemplate = {template}\nchannel = {channel}\n")
        };
        let tables: String = joints.iter().map(table).collect();
        let reader = Reader { text: &format!("{}{tables}", self.text), ..*self };
        reader.model(reader.file()?)
    }

    /// A robot's own file, or an FMU, is all that moves.
    pub(super) fn check_alone(
        &self,
        raw: &File,
        table: Range<usize>,
        says: &str,
    ) -> Result<(), ModelError> {
        let others = [
            ("[[coordinate]]", !raw.coordinate.is_empty()),
            ("[[state]]", !raw.state.is_empty()),
            ("[mechanics]", raw.mechanics.is_some()),
            ("[define]", !raw.define.is_empty()),
            ("[[actuator]]", !raw.actuator.is_empty() && raw.fmu.is_some()),
            ("[fmu]", raw.fmu.is_some() && raw.robot.is_some()),
        ];
        match others.iter().find(|(_, there)| *there) {
            Some((other, _)) => {
                Err(self.error(table, format!("{says}: {other} cannot stand beside it")))
            }
            None => Ok(()),
        }
    }

    /// A path relative to this file.
    pub(super) fn beside(&self, name: &str) -> PathBuf {
        Path::new(self.file).parent().unwrap_or(Path::new("")).join(name)
    }

    /// The robot's own file: where it is, unless its text stands in the model's, and its text.
    fn own_file(&self, table: &Spanned<RawRobot>) -> Result<(Option<PathBuf>, String), ModelError> {
        let raw = table.get_ref();
        let file = match (&raw.file, &raw.text) {
            (Some(file), None) => file,
            (None, Some(text)) => return Ok((None, text.get_ref().clone())),
            (file, _) => {
                let found = if file.is_some() { "both" } else { "neither" };
                let message = format!(
                    "[robot] names the robot's own file (file = \"arm.urdf\"), or holds its text (text = \"...\"); \
                     found {found}"
                );
                return Err(self.error(table.span(), message));
            }
        };
        let path = self.beside(file.get_ref());
        let text = match self.robot {
            Some(text) => text.to_owned(),
            None => text_of(&path).map_err(|e| {
                let message = format!("the robot's file {} cannot be read: {e}", path.display());
                self.error(file.span(), message)
            })?,
        };
        Ok((Some(path), text))
    }

    /// What moves, and the robot's file.
    fn tree(
        &self,
        raw: &RawRobot,
        (path, text): (Option<PathBuf>, String),
    ) -> Result<(Tree, RobotFile), ModelError> {
        let in_file = |e: RobotError| in_robot_file((path.as_deref(), &text, self.file), e);
        let robot = lacuna_rigid::read(&text).map_err(in_file)?;
        let held = self.held(&raw.locked, &robot)?;
        let tree = robot.tree(&held).map_err(in_file)?;
        let stated_gravity = robot.gravity.unwrap_or(GRAVITY);
        let format = robot.format;
        Ok((tree, RobotFile { path, text, format, stated_gravity, gravity: stated_gravity }))
    }

    /// The joints that are held still, each where.
    fn held(
        &self,
        locked: &[Spanned<RawLocked>],
        robot: &Robot,
    ) -> Result<Vec<(String, f64)>, ModelError> {
        let mut held = vec![];
        for entry in locked {
            let (pattern, at) = match entry.get_ref() {
                RawLocked::Name(name) => (name, 0.0),
                RawLocked::At(LockedAt { name, at }) => (name, *at),
            };
            if !at.is_finite() {
                return Err(
                    self.error(entry.span(), "a joint is held at a finite place".to_owned())
                );
            }
            let meant = |name: &str| match pattern.strip_suffix('*') {
                Some(begin) => name.starts_with(begin),
                None => name == pattern,
            };
            let names: Vec<_> = robot.holdable().into_iter().filter(|n| meant(n)).collect();
            if names.is_empty() {
                let known = robot.movable().join(", ");
                let message = format!("'{pattern}' is none of the robot's joints: {known}");
                return Err(self.error(entry.span(), message));
            }
            held.extend(names.into_iter().map(|name| (name, at)));
        }
        Ok(held)
    }

    /// The parameters of all bodies. Those that change nothing, wherever the robot is, are known.
    fn robot_parameters(
        &self,
        tree: &Tree,
        tolerance: &RawTolerance,
        dynamics: &RobotDynamics,
    ) -> Result<Vec<Parameter>, ModelError> {
        let share = |of: &Option<Spanned<f64>>| match of {
            None => Ok(0.0),
            Some(t) if *t.get_ref() >= 0.0 && t.get_ref().is_finite() => Ok(*t.get_ref()),
            Some(t) => {
                let message = format!(
                    "a tolerance is a standard deviation, 0 or more; found {}",
                    t.get_ref()
                );
                Err(self.error(t.span(), message))
            }
        };
        let (mass, com) = (share(&tolerance.mass)?, share(&tolerance.com)?);
        let inertia = share(&tolerance.inertia)?;
        let values = RobotDynamics::values(tree);
        let matters = matters(dynamics, &values);
        let std = |of: &Described, value: f64| match of.part {
            Part::Mass => mass * value,
            Part::Centre if of.inertia.mass > 0.0 => com,
            Part::Inertia => inertia * radius(&of.inertia.inertia, of.suffix),
            Part::Centre | Part::Damping | Part::Friction | Part::Armature | Part::Stiffness => 0.0,
        };
        let one = |((of, &value), matters): ((Described, &f64), bool)| Parameter {
            name: format!("{}.{}", of.name, of.suffix),
            value,
            unit: of.unit().to_owned(),
            uncertainty: Uncertainty::Absolute(if matters { std(&of, value) } else { 0.0 }),
        };
        Ok(described(tree).zip(&values).zip(matters).map(one).collect())
    }

    /// `[parameters]` beside a robot: other values of what its file says, or how sure they are.
    fn override_parameters(&self, raw: &File, model: &mut Model) -> Result<(), ModelError> {
        for (new, raw_new) in self.parameters(raw)?.into_iter().zip(raw.parameters.values()) {
            let Some(own) = model.parameters.iter_mut().find(|p| p.name == new.name) else {
                return Err(self.unknown_parameter(raw, &new.name, model));
            };
            own.value = new.value;
            if raw_new.tolerance.is_some() || raw_new.std.is_some() {
                own.uncertainty = new.uncertainty;
            }
        }
        Ok(())
    }

    /// `[[input]]` beside a robot or an FMU: what is known of the signals that drive it.
    pub(super) fn override_inputs(
        &self,
        raw: &[RawInput],
        model: &mut Model,
    ) -> Result<(), ModelError> {
        for (new, raw) in self.inputs(raw)?.into_iter().zip(raw) {
            let known: Vec<_> = model.inputs.iter().map(|i| i.name.clone()).collect();
            let Some(own) = model.inputs.iter_mut().find(|i| i.name == new.name) else {
                let message = format!("'{}' is none of the inputs: {}", new.name, known.join(", "));
                return Err(self.error(raw.name.span(), message));
            };
            (own.actuator, own.noise) = (new.actuator, new.noise);
        }
        Ok(())
    }

    fn measured_of_robot(
        &self,
        raw: &super::RawMeasurement,
        model: &Model,
    ) -> Result<Measurement, ModelError> {
        let text = raw.of.get_ref();
        let state = (0..model.machine_states()).find(|&s| model.state_name(s) == text);
        let input = || model.inputs.iter().position(|i| i.name == *text).map(Measured::Input);
        let Some(of) = state.map(Measured::State).or_else(input) else {
            let states = (0..model.machine_states()).map(|s| model.state_name(s));
            let inputs = model.inputs.iter().map(|i| i.name.as_str());
            let known: Vec<&str> = states.chain(inputs).collect();
            let message = format!(
                "of a robot '{text}' is not measured; expected one of {}",
                known.join(", ")
            );
            return Err(self.error(raw.of.span(), message));
        };
        Ok(Measurement {
            column: raw.column.clone(),
            unit: raw.unit.clone(),
            of,
            text: text.clone(),
        })
    }
}

/// What a parameter of a robot's dynamics is.
struct Described<'t> {
    /// What it is of: a link or a joint.
    name: &'t str,
    suffix: &'static str,
    part: Part,
    /// Of its link.
    inertia: InertialParameters<f64>,
    /// Of its joint.
    kind: JointKind,
}

impl Described<'_> {
    fn unit(&self) -> &'static str {
        let of_turning = |turning, sliding| match self.kind {
            JointKind::Revolute => turning,
            JointKind::Prismatic => sliding,
        };
        match self.part {
            Part::Mass => "kg",
            Part::Centre => "m",
            Part::Inertia => "kg m^2",
            Part::Damping => of_turning("N m s/rad", "N s/m"),
            Part::Friction => of_turning("N m", "N"),
            Part::Armature => of_turning("kg m^2", "kg"),
            Part::Stiffness => of_turning("N m/rad", "N/m"),
        }
    }
}

/// The parameters of a robot's dynamics, in their order ([`RobotDynamics::values`]).
fn described(tree: &Tree) -> impl Iterator<Item = Described<'_>> {
    let of_bodies = tree.bodies.iter().flat_map(|body| {
        let (inertia, kind) = (body.inertia, body.joint.kind);
        PARTS.iter().enumerate().map(move |(k, &(suffix, part))| {
            let name = if k < INERTIAL { &body.name } else { &body.joint.name };
            Described { name, suffix, part, inertia, kind }
        })
    });
    let of_parts = tree.bodies.iter().flat_map(|body| {
        body.apart().flat_map(|link| {
            let (name, inertia, kind) = (&link.name, link.inertia(), body.joint.kind);
            let inertial = PARTS[..INERTIAL].iter();
            inertial.map(move |&(suffix, part)| Described { name, suffix, part, inertia, kind })
        })
    });
    of_bodies.chain(of_parts)
}

/// The links of which parameters by these names tell the inertia.
fn links<'n>(names: impl Iterator<Item = &'n str>) -> impl Iterator<Item = &'n str> {
    let inertial = |of: &str| PARTS[..INERTIAL].iter().any(|(suffix, _)| *suffix == of);
    names.filter_map(move |name| {
        let (link, of) = name.rsplit_once('.')?;
        inertial(of).then_some(link)
    })
}

/// What its file states of the servo of each coordinate.
fn servos(tree: &Tree) -> Vec<Option<OfFile>> {
    let stated = |(joint, inertia): (&Joint, f64)| {
        let servo = joint.servo?;
        Some(OfFile { gain: servo.gain, damping: servo.damping(inertia), limit: servo.limit })
    };
    tree.joints().zip(tree.moved()).map(stated).collect()
}

/// What is wrong with a robot's own file, as that of a model; where its text stands in a model file, that is the
/// last of these.
fn in_robot_file((path, text, model): (Option<&Path>, &str, &str), e: RobotError) -> ModelError {
    let RobotError { line, message } = e;
    match (path, line) {
        (Some(path), _) => ModelError {
            file: path.display().to_string(),
            place: line.map(|line| Place::of_line(text, line as usize)),
            message,
        },
        (None, line) => {
            let at = line.map_or_else(String::new, |line| format!("line {line} of "));
            let message = format!("{at}the robot's text: {message}");
            ModelError { file: model.to_owned(), place: None, message }
        }
    }
}

/// What moves must have inertia.
fn check_weight(model: &Model, tree: &Tree, file: &str) -> Result<(), ModelError> {
    let Some(own) = model.robot_file().filter(|_| model.is_singular_at_rest()) else {
        return Ok(());
    };
    let whole = (own.path.as_deref(), &*own.text, file);
    let error = |line, message| Err(in_robot_file(whole, RobotError { line, message }));
    let moved = tree.moved().into_iter().position(|moved| moved.is_nan() || moved <= 0.0);
    let Some(body) = moved.map(|i| &tree.bodies[tree.leading[i]]) else {
        let message = "the mass matrix is singular where all joints are at 0".to_owned();
        return error(None, message);
    };
    let (link, joint) = (&body.name, &body.joint.name);
    let message = format!(
        "joint '{joint}' moves what has no inertia: link '{link}' and all that hangs from it. Say how \
         large its rotor's inertia may be, \"{joint}.armature\" = {{ value = ..., std = ... }} in \
         [parameters] of a model file, or hold it still, locked = [\"{joint}\"] in [robot] there"
    );
    error(Some(body.joint.line), message)
}

/// Files round small inertia to 0. Where a link has mass, but none of its inertia is about its joint, that of
/// a rotor stands for it: as large as what the joint before it moves, and as unsure, for the motors of a robot
/// are chosen to match what they move.
fn assume_rotors(model: &mut Model, tree: &Tree) {
    let moved = tree.moved();
    let of = |body: usize| moved[tree.bodies[body].joint.coordinate];
    for &i in &tree.leading {
        let (body, kind) = (&tree.bodies[i], tree.bodies[i].joint.kind);
        let alike = |&p: &usize| tree.bodies[p].joint.kind == kind && of(p) > 0.0;
        let before = tree.path(i).skip(1).find(alike);
        let (0.0, true, Some(before)) = (of(i), body.whole().mass > 0.0, before) else {
            continue;
        };
        let name = format!("{}.armature", body.joint.name);
        let mut rotors = model.parameters.iter_mut();
        let Some(rotor) = rotors.find(|p| p.name == name && p.value == 0.0) else { continue };
        (rotor.value, rotor.uncertainty) = (of(before), Uncertainty::Absolute(of(before)));
        model.assumptions.push(format!(
            "By its file link '{}' has no inertia about joint '{}': {name} is estimated instead, beginning with \
             what joint '{}' moves, {:.2e} {} and as unsure as that.",
            body.name, body.joint.name, tree.bodies[before].joint.name, of(before), rotor.unit
        ));
    }
}

/// How large an entry of an inertia is as one of its kind: itself on the diagonal, and the mean of the two
/// it stands between off it.
fn radius(&[xx, _, _, yy, _, zz]: &[f64; 6], entry: &str) -> f64 {
    match entry {
        "inertia_xx" => xx,
        "inertia_yy" => yy,
        "inertia_zz" => zz,
        "inertia_xy" => (xx * yy).sqrt(),
        "inertia_xz" => (xx * zz).sqrt(),
        _ => (yy * zz).sqrt(),
    }
}

/// Which parameters change anything anywhere: the inertia of a body that only turns about one axis is known
/// about that axis alone.
fn matters(dynamics: &RobotDynamics, values: &[f64]) -> Vec<bool> {
    // Coordinates and velocities in no relation to each other.
    let place = |k: usize| ((k + 1) as f64 * 0.754_877_666).fract() * 4.0 - 2.0;
    let variables: Vec<f64> = (0..dynamics.sizes().variables()).map(place).collect();
    felt(dynamics, (values, 0..values.len()), (&variables, 0))
}

impl RecordedInput {
    /// What drives a robot's joint.
    #[must_use]
    pub fn of_joint(joint: &Joint) -> Self {
        let (what, unit) = match joint.kind {
            JointKind::Revolute => ("torque", "N m"),
            JointKind::Prismatic => ("force", "N"),
        };
        Self::new(&format!("{}_{what}", joint.name), unit)
    }
}

impl Coordinate {
    /// That of a robot's joint.
    #[must_use]
    pub fn of_joint(joint: &Joint) -> Self {
        let (unit, force_unit) = match joint.kind {
            JointKind::Revolute => ("rad", "N m"),
            JointKind::Prismatic => ("m", "N"),
        };
        Self {
            name: joint.name.clone(),
            velocity: format!("{}_vel", joint.name),
            unit: unit.to_owned(),
            force_unit: Some(force_unit.to_owned()),
            imposed: false,
        }
    }
}

/// The text of a file that another names: a device or a pipe in its place may have no end.
fn text_of(path: &Path) -> io::Result<String> {
    if !std::fs::metadata(path)?.is_file() {
        return Err(io::Error::new(io::ErrorKind::InvalidInput, "it is no regular file"));
    }
    std::fs::read_to_string(path)
}
