//! The tree of a robot's bodies that move.

mod making;

use crate::algebra::Pose;
use crate::{Dynamics, Inertia, InertialParameters, JointKind, PositionServo, Room};
use lacuna_numbers::Number;

/// A joint of a tree: it is at `ratio q + offset`, q being a coordinate of the tree.
#[derive(Clone, Debug)]
pub struct Joint {
    /// Its name; where it is one coordinate of a joint of several, the name of that.
    pub name: String,
    /// The joint of the file that it is, or is a coordinate of.
    pub of: String,
    /// The number of q.
    pub coordinate: usize,
    /// How far it goes where q goes by 1: 1 unless it follows another joint.
    pub ratio: f64,
    /// Where it is where q is 0: 0 unless it follows another joint.
    pub offset: f64,
    /// How it moves.
    pub kind: JointKind,
    /// Its frame in the parent's joint's where it is at 0; its axis is the z axis of it.
    pub pose: Pose,
    /// Viscous friction, N m s/rad or N s/m.
    pub damping: f64,
    /// Dry friction, N m or N.
    pub friction: f64,
    /// Rotor inertia, kg m^2 or kg.
    pub armature: f64,
    /// Stiffness of a spring in it, N m/rad or N/m.
    pub stiffness: f64,
    /// Where that spring is at rest.
    pub spring_reference: f64,
    /// The position servo that the file has drive it.
    pub servo: Option<PositionServo>,
    /// The line where the file says so.
    pub line: u32,
}

impl Joint {
    /// Where it is at the tree's coordinates.
    #[inline(always)]
    pub fn at<T: Number>(&self, coordinates: &[T]) -> T {
        let q = coordinates[self.coordinate];
        if self.ratio == 1.0 && self.offset == 0.0 { q } else { q * self.ratio + self.offset }
    }

    /// How fast it moves at the tree's velocities; likewise of accelerations.
    #[inline(always)]
    pub fn rate<T: Number>(&self, velocities: &[T]) -> T {
        self.felt(velocities[self.coordinate])
    }

    /// What its coordinate feels of a force in it.
    #[inline(always)]
    pub fn felt<T: Number>(&self, force: T) -> T {
        if self.ratio == 1.0 { force } else { force * self.ratio }
    }
}

/// A body that moves: a link with all that is fixed to it.
#[derive(Clone, Debug)]
pub struct Body {
    /// The link's name.
    pub name: String,
    /// The links that are fixed to it.
    pub fixed: Vec<Part>,
    /// The body it hangs from; none: the ground.
    pub parent: Option<usize>,
    /// What moves it.
    pub joint: Joint,
    /// Inertia of all of it but the parts that are told apart, in the link's frame.
    pub inertia: InertialParameters<f64>,
    /// That of the link alone.
    own: Inertia<f64>,
    /// The link's frame in the joint's.
    link_pose: Pose,
}

/// A link that is fixed to another.
#[derive(Clone, Debug)]
pub struct Part {
    /// Its name.
    pub name: String,
    /// Whether it is told apart from what it is fixed to: its inertia has numbers of its own.
    pub is_apart: bool,
    /// Its inertia, in its frame.
    inertia: Inertia<f64>,
    /// Its frame in that of the body's link.
    pose: Pose,
}

impl Part {
    /// Its inertia, in its frame.
    #[must_use]
    pub fn inertia(&self) -> InertialParameters<f64> {
        self.inertia.parameters()
    }

    /// Inertia of a part of these parameters in the frame of the link that it is fixed to.
    #[must_use]
    pub fn in_link_frame<T: Number>(&self, parameters: &InertialParameters<T>) -> Inertia<T> {
        let axes = self.pose.rotation.map(|row| row.map(T::constant));
        parameters.about_origin().seen_from(&axes, self.pose.translation.map(T::constant))
    }
}

impl Body {
    /// The parts that are told apart.
    pub fn apart(&self) -> impl Iterator<Item = &Part> {
        self.fixed.iter().filter(|part| part.is_apart)
    }

    /// Inertia of all of it, in the link's frame.
    #[must_use]
    pub fn whole(&self) -> InertialParameters<f64> {
        together(self.own, &self.fixed)
    }

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

/// Inertia of a link and of parts that are fixed to it, in the link's frame.
fn together<'p>(
    own: Inertia<f64>,
    parts: impl IntoIterator<Item = &'p Part>,
) -> InertialParameters<f64> {
    let add = |sum: Inertia<f64>, p: &Part| sum.plus(&p.inertia.seen_from_frame(&p.pose));
    parts.into_iter().fold(own, add).parameters()
}

/// Bodies, parents before their children.
#[derive(Clone, Debug)]
pub struct Tree {
    /// The bodies.
    pub bodies: Vec<Body>,
    /// The body whose joint each coordinate is that of, in their order: all bodies but those whose joints follow
    /// others.
    pub leading: Vec<usize>,
}

impl Tree {
    /// Inertia of the bodies, all that is fixed to them among it, in their joints' frames.
    #[must_use]
    pub fn inertia(&self) -> Vec<Inertia<f64>> {
        self.bodies.iter().map(|b| b.in_joint_frame(&b.whole())).collect()
    }

    /// The parts that are told apart.
    pub fn apart(&self) -> impl Iterator<Item = &Part> {
        self.bodies.iter().flat_map(Body::apart)
    }

    /// Tell a link apart from the one that it is fixed to, if it is to any: its inertia is none of the body's any more.
    pub fn tell_apart(&mut self, name: &str) {
        for body in &mut self.bodies {
            if let Some(part) = body.fixed.iter_mut().find(|part| part.name == name) {
                part.is_apart = true;
                body.inertia = together(body.own, body.fixed.iter().filter(|part| !part.is_apart));
            }
        }
    }

    /// The number of coordinates.
    #[must_use]
    pub fn coordinates(&self) -> usize {
        self.leading.len()
    }

    /// Whether joints follow others.
    #[must_use]
    pub fn has_followers(&self) -> bool {
        self.leading.len() < self.bodies.len()
    }

    /// The joint of each coordinate.
    pub fn joints(&self) -> impl ExactSizeIterator<Item = &Joint> + Clone {
        self.leading.iter().map(|&body| &self.bodies[body].joint)
    }

    /// The inertia that each coordinate moves where all coordinates are 0, its rotor's among it: where it is 0,
    /// accelerations would be without bound.
    #[must_use]
    pub fn moved(&self) -> Vec<f64> {
        let (n, inertia) = (self.coordinates(), self.inertia());
        let dynamics = Dynamics::new(self, &inertia, [0.0; 3]);
        let (mut room, mut mass) = (Room::new(self.bodies.len()), vec![0.0; n * n]);
        dynamics.place(&mut room, &vec![0.0; n]);
        dynamics.mass_matrix(&mut room, &mut mass);
        let mut moved: Vec<f64> = (0..n).map(|i| mass[i * n + i]).collect();
        for Body { joint, .. } in &self.bodies {
            moved[joint.coordinate] += joint.felt(joint.felt(joint.armature));
        }
        moved
    }

    /// The bodies from one on to the ground, each before its parent.
    #[inline(always)]
    pub fn path(&self, body: usize) -> impl Iterator<Item = usize> + '_ {
        std::iter::successors(Some(body), |&b| self.bodies[b].parent)
    }
}
