//! The tree of a robot's bodies that move.

use crate::algebra::{Pose, from_z};
use crate::robot::{JointKind, Link, Moves, Robot, RobotError, RobotJoint};
use crate::{Dynamics, Inertia, InertialParameters, Room};
use lacuna_numbers::Number;
use std::collections::{HashMap, HashSet};

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
    /// Stiffness of a spring in it, N m/rad or N/m.
    pub stiffness: f64,
    /// The coordinate where that spring is at rest.
    pub spring_reference: f64,
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
    /// The link's frame in the joint's.
    link_pose: Pose,
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
        let axes = self.link_pose.rotation.map(|row| row.map(T::constant));
        inertia.seen_from(&axes, self.link_pose.translation.map(T::constant))
    }
}

/// Bodies, parents before their children; coordinate i is that of body i's joint.
#[derive(Clone, Debug)]
pub struct Tree {
    /// The bodies.
    pub bodies: Vec<Body>,
}

/// A body in the making: its link and the inertia of all that is found to be fixed to it.
struct Making<'a> {
    link: &'a Link,
    merged: Vec<String>,
    parent: Option<usize>,
    joint: Joint,
    inertia: Inertia<f64>,
    link_pose: Pose,
}

impl Robot {
    /// The bodies that move when some joints are held still, each where it says: what hangs from a
    /// fixed joint or one that is held is part of its parent.
    ///
    /// # Errors
    /// [`RobotError`]: a joint that is held but does not exist, joints that are not simulated or
    /// tied to others, a robot of which nothing moves.
    pub fn tree(&self, held: &[(String, f64)]) -> Result<Tree, RobotError> {
        let all: HashSet<&str> = self.joints.iter().map(|j| &*j.name).collect();
        if let Some((name, _)) = held.iter().find(|(name, _)| !all.contains(&**name)) {
            let known = self.movable().join(", ");
            let message = format!("'{name}' is none of its joints: {known}");
            return Err(RobotError { line: None, message });
        }
        // The first counts where one is named twice.
        let held: HashMap<&str, f64> = held.iter().rev().map(|(name, at)| (&**name, *at)).collect();
        self.check_couplings(&held)?;
        let bodies = self.bodies(&held)?;
        if bodies.is_empty() {
            let message = "no joint moves: nothing can be simulated".to_owned();
            return Err(RobotError { line: None, message });
        }
        Ok(Tree { bodies: bodies.into_iter().map(Making::done).collect() })
    }

    /// What moves, from the ground outwards.
    fn bodies(&self, held: &HashMap<&str, f64>) -> Result<Vec<Making<'_>>, RobotError> {
        // Links whose joints are to come, with the body that they are a part of and where they stand in
        // it. Not by recursion: a file may be a chain of thousands.
        let mut bodies: Vec<Making> = vec![];
        let hanging = self.hanging();
        let root = |link| (link, None, Pose::SAME);
        let mut open: Vec<(usize, Option<usize>, Pose)> =
            self.roots().into_iter().map(root).collect();
        while let Some((link, body, pose)) = open.pop() {
            let mut below = vec![];
            for &joint in &hanging[link] {
                let place = pose.then(&joint.pose);
                let at = held.get(&*joint.name).copied();
                let at = if joint.moves == Moves::Fixed { Some(0.0) } else { at };
                let here = match (at, joint.moves) {
                    (Some(at), _) => (body, place.then(&joint.moved(at))),
                    (None, Moves::By(kind)) => {
                        let pose = match body {
                            Some(b) => bodies[b].link_pose.then(&place),
                            None => place,
                        };
                        bodies.push(self.begun((joint, kind), body, pose));
                        (Some(bodies.len() - 1), Pose::SAME)
                    }
                    (None, moves) => return Err(joint.not_simulated(moves)),
                };
                if let (Some(_), (Some(body), pose)) = (at, here) {
                    let part = &self.links[joint.child];
                    let making: &mut Making = &mut bodies[body];
                    making.inertia = making.inertia.plus(&part.inertia.seen_from_frame(&pose));
                    making.merged.push(part.name.clone());
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
    ) -> Making<'_> {
        let link = &self.links[joint.child];
        let name = joint.name.clone();
        let RobotJoint { damping, friction, armature, stiffness, spring_reference, .. } = *joint;
        let aligned = Pose { rotation: from_z(joint.axis), translation: joint.anchor };
        let pose = pose.then(&aligned);
        Making {
            link,
            merged: vec![],
            parent,
            joint: Joint {
                name,
                kind,
                pose,
                damping,
                friction,
                armature,
                stiffness,
                spring_reference,
            },
            inertia: link.inertia,
            link_pose: aligned.inverse(),
        }
    }
}

impl Making<'_> {
    fn done(self) -> Body {
        Body {
            name: self.link.name.clone(),
            merged: self.merged,
            parent: self.parent,
            joint: self.joint,
            inertia: self.inertia.parameters(),
            link_pose: self.link_pose,
        }
    }
}

impl Tree {
    /// Inertia of the bodies in their joints' frames.
    #[must_use]
    pub fn inertia(&self) -> Vec<Inertia<f64>> {
        self.bodies.iter().map(|b| b.in_joint_frame(&b.inertia)).collect()
    }

    /// The inertia that each joint moves where all coordinates are 0, its rotor's among it: where it is 0,
    /// accelerations would be without bound.
    #[must_use]
    pub fn moved(&self) -> Vec<f64> {
        let (n, inertia) = (self.bodies.len(), self.inertia());
        let dynamics = Dynamics::new(self, &inertia, [0.0; 3]);
        let (mut room, mut mass) = (Room::new(n), vec![0.0; n * n]);
        dynamics.place(&mut room, &vec![0.0; n]);
        dynamics.mass_matrix(&mut room, &mut mass);
        (0..n).map(|i| mass[i * n + i] + self.bodies[i].joint.armature).collect()
    }

    /// The bodies from one on to the ground, each before its parent.
    #[inline(always)]
    pub fn path(&self, body: usize) -> impl Iterator<Item = usize> + '_ {
        std::iter::successors(Some(body), |&b| self.bodies[b].parent)
    }
}
