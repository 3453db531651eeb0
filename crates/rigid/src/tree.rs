//! A robot as its file describes it, and the tree of bodies that move.

use crate::algebra::{Matrix, Pose, Vector, from_z, rotation, transposed};
use crate::{Inertia, InertialParameters};
use lacuna_numbers::Number;
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

/// A robot as its file describes it.
#[derive(Clone, Debug)]
pub struct Robot {
    /// Its name.
    pub name: String,
    /// Links, in the file's order.
    pub links: Vec<Link>,
    /// Joints, in the file's order.
    pub joints: Vec<RobotJoint>,
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
    /// In a way that is not simulated: what it is called.
    Otherwise(&'static str),
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
    /// Its frame, which is the child's, in that of the parent.
    pub pose: Pose,
    /// Its axis, a unit vector in its own frame.
    pub axis: Vector<f64>,
    /// Viscous friction that the file states, N m s/rad or N s/m.
    pub damping: f64,
    /// Dry friction that the file states, N m or N.
    pub friction: f64,
    /// Rotor inertia that the file states, on the joint's side, kg m^2 or kg.
    pub armature: f64,
    /// Where it stands in the file.
    pub line: u32,
}

/// How a body moves relative to its parent.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum JointKind {
    /// It turns, rad.
    Revolute,
    /// It slides, m.
    Prismatic,
}

/// A joint of a tree.
#[derive(Clone, Debug)]
pub struct Joint {
    /// Its name.
    pub name: String,
    /// How it moves.
    pub kind: JointKind,
    /// Its frame in the parent's joint's where its coordinate is 0; its axis is the z axis of it.
    pub pose: Pose,
    /// Viscous friction, N m s/rad or N s/m.
    pub damping: f64,
    /// Dry friction, N m or N.
    pub friction: f64,
    /// Rotor inertia, kg m^2 or kg.
    pub armature: f64,
}

/// A body that moves: a link with all that is fixed to it.
#[derive(Clone, Debug)]
pub struct Body {
    /// The link's name.
    pub name: String,
    /// The links that are fixed to it.
    pub merged: Vec<String>,
    /// The body it hangs from; none: the ground.
    pub parent: Option<usize>,
    /// What moves it.
    pub joint: Joint,
    /// Inertia of all of it, in the link's frame.
    pub inertia: InertialParameters<f64>,
    /// The link's axes in the joint's frame, as columns; their origins are one.
    link_axes: Matrix<f64>,
}

impl Body {
    /// Inertia of a body of these parameters in its joint's frame.
    #[must_use]
    pub fn in_joint_frame<T: Number>(&self, parameters: &InertialParameters<T>) -> Inertia<T> {
        self.along_joint(&parameters.about_origin())
    }

    /// Inertia in the link's frame, in its joint's.
    #[must_use]
    pub fn along_joint<T: Number>(&self, inertia: &Inertia<T>) -> Inertia<T> {
        let axes = self.link_axes.map(|row| row.map(T::constant));
        inertia.seen_from(&axes, [T::constant(0.0); 3])
    }
}

/// Bodies, parents before their children; coordinate i is that of body i's joint.
#[derive(Clone, Debug)]
pub struct Tree {
    /// The bodies.
    pub bodies: Vec<Body>,
}

/// A body in the making: what moves it, and what it is made of.
struct Making {
    body: Body,
    inertia: Inertia<f64>,
}

impl Robot {
    /// The bodies that move when some joints are held still, each where it says: what hangs from a
    /// fixed joint or one that is held is part of its parent.
    ///
    /// # Errors
    /// [`RobotError`]: a joint that is held but does not exist, joints that are not simulated, a robot
    /// of which nothing moves.
    pub fn tree(&self, held: &[(String, f64)]) -> Result<Tree, RobotError> {
        if let Some((name, _)) = held.iter().find(|(name, _)| self.joint(name).is_none()) {
            let known: Vec<&str> = self.joints.iter().map(|j| j.name.as_str()).collect();
            let message = format!("'{name}' is none of its joints: {}", known.join(", "));
            return Err(RobotError { line: None, message });
        }
        let bodies = self.bodies(held)?;
        if bodies.is_empty() {
            let message = "no joint moves: nothing can be simulated".to_owned();
            return Err(RobotError { line: None, message });
        }
        Ok(Tree { bodies: bodies.iter().map(Making::done).collect() })
    }

    /// The joint of a name.
    #[must_use]
    pub fn joint(&self, name: &str) -> Option<&RobotJoint> {
        self.joints.iter().find(|j| j.name == name)
    }

    /// The one link that no joint carries.
    fn root(&self) -> usize {
        let mut carried = vec![false; self.links.len()];
        self.joints.iter().for_each(|j| carried[j.child] = true);
        carried.iter().position(|carried| !carried).unwrap_or(0)
    }

    /// The joints that hang from each link.
    fn hanging(&self) -> Vec<Vec<&RobotJoint>> {
        let mut hanging = vec![vec![]; self.links.len()];
        self.joints.iter().for_each(|j| hanging[j.parent].push(j));
        hanging
    }

    /// What moves, from the ground outwards.
    fn bodies(&self, held: &[(String, f64)]) -> Result<Vec<Making>, RobotError> {
        // Links whose joints are to come, with the body that they are a part of and where they stand in
        // it. Not by recursion: a file may be a chain of thousands.
        let mut bodies: Vec<Making> = vec![];
        let hanging = self.hanging();
        let mut open = vec![(self.root(), None, Pose::SAME)];
        while let Some((link, body, pose)) = open.pop() {
            let mut below = vec![];
            for &joint in &hanging[link] {
                let place = pose.then(&joint.pose);
                let at = held.iter().find(|(name, _)| *name == joint.name).map(|(_, at)| *at);
                let at = if joint.moves == Moves::Fixed { Some(0.0) } else { at };
                let here = match (at, joint.moves) {
                    (Some(at), _) => (body, place.then(&joint.moved(at))),
                    (None, Moves::By(kind)) => {
                        let from = body.map(|b: usize| bodies[b].body.link_axes);
                        let pose = in_joint_frame(from, place);
                        bodies.push(self.begun((joint, kind), body, pose));
                        (Some(bodies.len() - 1), Pose::SAME)
                    }
                    (None, moves) => return Err(joint.not_simulated(moves)),
                };
                if let (Some(_), (Some(body), pose)) = (at, here) {
                    let part = &self.links[joint.child];
                    let making: &mut Making = &mut bodies[body];
                    making.inertia = making.inertia.plus(&part.inertia.seen_from_frame(&pose));
                    making.body.merged.push(part.name.clone());
                }
                below.push((joint.child, here.0, here.1));
            }
            open.extend(below.into_iter().rev());
        }
        Ok(bodies)
    }

    /// A body that a joint moves, of its own link alone.
    fn begun(
        &self,
        (joint, kind): (&RobotJoint, JointKind),
        parent: Option<usize>,
        pose: Pose,
    ) -> Making {
        let link = &self.links[joint.child];
        let name = joint.name.clone();
        let RobotJoint { damping, friction, armature, .. } = *joint;
        let aligned = Pose { rotation: from_z(joint.axis), ..Pose::SAME };
        let pose = pose.then(&aligned);
        let moving = Joint { name, kind, pose, damping, friction, armature };
        let body = Body {
            name: link.name.clone(),
            merged: vec![],
            parent,
            joint: moving,
            inertia: link.inertia.parameters(),
            link_axes: transposed(&aligned.rotation),
        };
        Making { body, inertia: link.inertia }
    }
}

/// A pose in a link's frame, in the frame of its joint, where the link has these axes; as it is of the
/// ground.
fn in_joint_frame(link_axes: Option<Matrix<f64>>, pose: Pose) -> Pose {
    link_axes.map_or(pose, |rotation| Pose { rotation, ..Pose::SAME }.then(&pose))
}

impl RobotJoint {
    fn not_simulated(&self, moves: Moves) -> RobotError {
        let what = if let Moves::Otherwise(what) = moves { what } else { "of no known kind" };
        let name = &self.name;
        let message = format!(
            "joint '{name}' is {what}, which is not simulated: hold it still with locked = [\"{name}\"]"
        );
        RobotError::at(self.line, message)
    }

    /// The child's frame in the joint's where its coordinate is `at`.
    fn moved(&self, at: f64) -> Pose {
        match self.moves {
            Moves::By(JointKind::Revolute) => {
                Pose { rotation: rotation(self.axis, at), ..Pose::SAME }
            }
            Moves::By(JointKind::Prismatic) => {
                Pose { translation: self.axis.map(|z| z * at), ..Pose::SAME }
            }
            Moves::Fixed | Moves::Otherwise(_) => Pose::SAME,
        }
    }
}

impl Making {
    fn done(&self) -> Body {
        Body { inertia: self.inertia.parameters(), ..self.body.clone() }
    }
}

impl Tree {
    /// Inertia of the bodies in their joints' frames.
    #[must_use]
    pub fn inertia(&self) -> Vec<Inertia<f64>> {
        self.bodies.iter().map(|b| b.in_joint_frame(&b.inertia)).collect()
    }

    /// The body that weighs nothing where all coordinates are 0, with all that hangs from it and the rotor
    /// inertia of its joint: its acceleration would be without bound.
    #[must_use]
    pub fn weightless(&self) -> Option<&Body> {
        let n = self.bodies.len();
        let inertia = self.inertia();
        let dynamics = crate::Dynamics::new(self, &inertia, [0.0; 3]);
        let (mut room, mut mass) = (crate::Room::new(n), vec![0.0; n * n]);
        dynamics.place(&mut room, &vec![0.0; n]);
        dynamics.mass_matrix(&mut room, &mut mass);
        let own = |i: usize| mass[i * n + i] + self.bodies[i].joint.armature;
        (0..n).find(|&i| own(i).is_nan() || own(i) <= 0.0).map(|i| &self.bodies[i])
    }
}
