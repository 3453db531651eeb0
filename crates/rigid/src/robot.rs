//! A robot as its file describes it.

use crate::Inertia;
use crate::algebra::{Pose, Vector};
use crate::joints::{JointKind, Mimic, Several, check};
use std::collections::{HashMap, HashSet};
use thiserror::Error;

/// What is wrong with a robot's file, and where.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
#[error("{message}")]
pub struct RobotError {
    /// The line, counted from 1, of what is wrong.
    pub line: Option<u32>,
    /// What is wrong, and what to do.
    pub message: String,
}

impl RobotError {
    pub(crate) fn at(line: u32, message: impl Into<String>) -> Self {
        Self { line: Some(line), message: message.into() }
    }
}

/// The format of a robot's file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Format {
    /// URDF.
    Urdf,
    /// MJCF, MuJoCo's XML.
    Mjcf,
}

impl Format {
    /// As it is called.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Urdf => "URDF",
            Self::Mjcf => "MJCF",
        }
    }

    /// How names of such files end.
    #[must_use]
    pub fn extension(self) -> &'static str {
        match self {
            Self::Urdf => "urdf",
            Self::Mjcf => "xml",
        }
    }
}

/// A robot as its file describes it.
#[derive(Clone, Debug)]
pub struct Robot {
    /// The format of that.
    pub format: Format,
    /// Its name.
    pub name: String,
    /// Links, in the file's order.
    pub links: Vec<Link>,
    /// Joints, in the file's order.
    pub joints: Vec<RobotJoint>,
    /// What ties joints to others.
    pub couplings: Vec<Coupling>,
    /// Gravity that the file states, m/s^2, in the root's frame.
    pub gravity: Option<Vector<f64>>,
}

/// What ties the motion of joints to that of others. It is not simulated: the joints must be held still.
#[derive(Clone, Debug)]
pub struct Coupling {
    /// What it is.
    pub what: String,
    /// The joints, by their numbers.
    pub joints: Vec<usize>,
    /// Where it stands in the file.
    pub line: u32,
}

/// A link of a robot.
#[derive(Clone, Debug)]
pub struct Link {
    /// Its name.
    pub name: String,
    /// Its inertia about its frame's origin.
    pub inertia: Inertia<f64>,
    /// Where it stands in the file.
    pub line: u32,
}

/// How a joint lets its child move.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Moves {
    /// Not at all.
    Fixed,
    /// About or along its axis.
    By(JointKind),
    /// By several coordinates.
    Several(Several),
}

/// A joint of a robot.
#[derive(Clone, Debug)]
pub struct RobotJoint {
    /// Its name.
    pub name: String,
    /// How it moves.
    pub moves: Moves,
    /// The link it hangs from, by its number.
    pub parent: usize,
    /// The link it carries.
    pub child: usize,
    /// The child's frame in that of the parent where its coordinates are 0.
    pub pose: Pose,
    /// Where one of several coordinates is held still, unless these are: the child's frame in the one that
    /// it has where its coordinates are 0.
    pub rest: Pose,
    /// What moves it, if it is another joint.
    pub follows: Option<Mimic>,
    /// Its axis, a unit vector in the child's frame; of a planar joint, what stands on its plane.
    pub axis: Vector<f64>,
    /// A point of the axis in the child's frame, m.
    pub anchor: Vector<f64>,
    /// Viscous friction that the file states, N m s/rad or N s/m.
    pub damping: f64,
    /// Dry friction that the file states, N m or N.
    pub friction: f64,
    /// Rotor inertia that the file states, on the joint's side, kg m^2 or kg.
    pub armature: f64,
    /// Stiffness of a spring in it that the file states, N m/rad or N/m.
    pub stiffness: f64,
    /// The coordinate where that spring is at rest.
    pub spring_reference: f64,
    /// The position servo that the file has drive it.
    pub servo: Option<PositionServo>,
    /// Where it stands in the file.
    pub line: u32,
}

/// A position servo as a file states it, on the side of its joint.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PositionServo {
    /// Torque per error of the joint's coordinate, N m/rad or N/m.
    pub gain: f64,
    /// What holds it back from moving.
    pub damping: ServoDamping,
    /// The most torque that it has, N m or N.
    pub limit: Option<f64>,
}

/// How a file states the damping of a servo.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ServoDamping {
    /// By itself, N m s/rad or N s/m.
    Of(f64),
    /// As a share of that with which what the joint moves would not ring.
    Ratio(f64),
}

impl PositionServo {
    /// Its damping where the joint moves this inertia, kg m^2 or kg.
    #[must_use]
    pub fn damping(&self, inertia: f64) -> f64 {
        match self.damping {
            ServoDamping::Of(damping) => damping,
            ServoDamping::Ratio(ratio) => 2.0 * ratio * (self.gain * inertia).sqrt(),
        }
    }
}

/// What a joint holds together.
pub(crate) struct Ends {
    pub parent: usize,
    pub child: usize,
    /// The child's frame in the parent's.
    pub pose: Pose,
}

impl Robot {
    /// The joint of a name.
    #[must_use]
    pub fn joint(&self, name: &str) -> Option<&RobotJoint> {
        self.joints.iter().find(|j| j.name == name)
    }

    /// The names of the joints that are not fixed.
    #[must_use]
    pub fn movable(&self) -> Vec<&str> {
        let movable = self.joints.iter().filter(|j| j.moves != Moves::Fixed);
        movable.map(|j| j.name.as_str()).collect()
    }

    /// The links that no joint carries: one of a robot that is checked.
    pub(crate) fn roots(&self) -> Vec<usize> {
        let mut carried = vec![false; self.links.len()];
        self.joints.iter().for_each(|j| carried[j.child] = true);
        (0..carried.len()).filter(|&link| !carried[link]).collect()
    }

    /// The names of what can be held still: joints, and each coordinate of those that have several.
    #[must_use]
    pub fn holdable(&self) -> Vec<String> {
        let of = |j: &RobotJoint| {
            let coordinates =
                if let Moves::Several(_) = j.moves { j.coordinates() } else { vec![] };
            std::iter::once(j.name.clone()).chain(coordinates)
        };
        self.joints.iter().flat_map(of).collect()
    }

    /// The joints that hang from each link, by their numbers.
    pub(crate) fn hanging(&self) -> Vec<Vec<usize>> {
        let mut hanging = vec![vec![]; self.links.len()];
        self.joints.iter().enumerate().for_each(|(k, j)| hanging[j.parent].push(k));
        hanging
    }

    /// The same where all links hang from one, each by one joint, and no joint follows itself.
    pub(crate) fn checked(self) -> Result<Self, RobotError> {
        self.check_carriers()?;
        check(&self)?;
        let roots = self.roots();
        if let [first, second, ..] = roots[..] {
            let (first, second) = (&self.links[first], &self.links[second]);
            let message = format!(
                "links '{}' and '{}' hang from nothing, both: one link is the base, a joint must carry the other",
                first.name, second.name
            );
            return Err(RobotError::at(second.line, message));
        }
        self.check_no_loop(roots)?;
        Ok(self)
    }

    /// The names of the joints that must be held still: what ties them to others is not simulated.
    pub fn not_simulated(&self) -> impl Iterator<Item = &str> {
        let tied: HashSet<usize> = self.couplings.iter().flat_map(|c| &c.joints).copied().collect();
        let joints = self.joints.iter().enumerate();
        joints.filter(move |(number, _)| tied.contains(number)).map(|(_, joint)| &*joint.name)
    }

    /// Joints that are tied to others must be held still.
    pub(crate) fn check_couplings(&self, held: &HashMap<&str, f64>) -> Result<(), RobotError> {
        let still = |j: &RobotJoint| j.moves == Moves::Fixed || held.contains_key(&*j.name);
        for Coupling { what, joints, line } in &self.couplings {
            let joints = joints.iter().map(|&j| &self.joints[j]).filter(|j| !still(j));
            let names: Vec<&str> = joints.map(|j| j.name.as_str()).collect();
            if !names.is_empty() {
                let these = if names.len() > 1 { "them" } else { "it" };
                let quoted = names.join("\", \"");
                let message = format!(
                    "{what}, which is not simulated: hold {these} still with locked = [\"{quoted}\"]"
                );
                return Err(RobotError::at(*line, message));
            }
        }
        Ok(())
    }

    fn check_carriers(&self) -> Result<(), RobotError> {
        let mut carrier = vec![None; self.links.len()];
        for joint in &self.joints {
            if let Some(RobotJoint { name: first, .. }) = carrier[joint.child].replace(joint) {
                let message = format!(
                    "link '{}' is carried by joint '{first}' and by '{}': a tree is expected, without loops",
                    self.links[joint.child].name, joint.name
                );
                return Err(RobotError::at(joint.line, message));
            }
        }
        Ok(())
    }

    /// With one carrier a link, what does not come from the root hangs in a circle.
    fn check_no_loop(&self, mut open: Vec<usize>) -> Result<(), RobotError> {
        let hanging = self.hanging();
        let mut reached = vec![false; self.links.len()];
        while let Some(link) = open.pop() {
            reached[link] = true;
            open.extend(hanging[link].iter().map(|&j| self.joints[j].child));
        }
        match self.joints.iter().find(|j| !reached[j.child]) {
            Some(joint) => {
                let message = format!(
                    "link '{}' hangs from itself by way of joint '{}': a tree is expected, without loops",
                    self.links[joint.child].name, joint.name
                );
                Err(RobotError::at(joint.line, message))
            }
            None => Ok(()),
        }
    }
}

impl RobotJoint {
    /// One of whose axis, friction, rotor and spring nothing is said.
    pub(crate) fn bare((name, line): (String, u32), moves: Moves, ends: Ends) -> Self {
        let Ends { parent, child, pose } = ends;
        Self {
            name,
            moves,
            parent,
            child,
            pose,
            rest: Pose::SAME,
            follows: None,
            axis: [0.0, 0.0, 1.0],
            anchor: [0.0; 3],
            damping: 0.0,
            friction: 0.0,
            armature: 0.0,
            stiffness: 0.0,
            spring_reference: 0.0,
            servo: None,
            line,
        }
    }

    /// The child's frame where its coordinate is `at`, in what it is where that is 0; where it is held, if
    /// it has several.
    pub(crate) fn moved(&self, at: f64) -> Pose {
        match self.moves {
            Moves::By(kind) => kind.moved(self.axis, self.anchor, at),
            Moves::Several(_) => self.rest,
            Moves::Fixed => Pose::SAME,
        }
    }

    /// The names of its coordinates.
    #[must_use]
    pub fn coordinates(&self) -> Vec<String> {
        match self.moves {
            Moves::Fixed => vec![],
            Moves::By(_) => vec![self.name.clone()],
            Moves::Several(several) => {
                let steps = several.steps(self.axis).into_iter();
                steps.map(|step| format!("{}_{}", self.name, step.name)).collect()
            }
        }
    }
}
