//! A robot's dynamics: rigid bodies that hang together by joints, a motor at each.
//!
//! ```text
//! (M(q) + diag(J)) v' = u - h(q, v) - d v - f tanh(v / v_0) - k (q - q_0)
//! ```
//!
//! with M and h of [`lacuna_rigid`], and what the file states of each joint: damping d, friction f, rotor inertia
//! J, stiffness k of a spring that is at rest at q_0. Parameters are, body by body, the ten of its inertia
//! and d, f, J and k.

use super::{Bound, BoundDynamics, Dynamics, Point, Room, Sizes};
use lacuna_numbers::{Dual, Number};
use lacuna_rigid::{Inertia, InertialParameters, Tree};
use std::sync::Arc;

/// Speed v_0 over which dry friction that a file states turns its sign, rad/s or m/s.
const STILL: f64 = 0.01;

/// A quantity of a body or its joint that is a parameter.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Part {
    Mass,
    /// Of the centre of mass, by axis.
    Centre,
    /// Of the inertia about the centre of mass.
    Inertia,
    Damping,
    Friction,
    Armature,
    Stiffness,
}

/// The parameters of a body, in their order, as they are called.
pub(crate) const PARTS: [(&str, Part); 14] = [
    ("mass", Part::Mass),
    ("com_x", Part::Centre),
    ("com_y", Part::Centre),
    ("com_z", Part::Centre),
    ("inertia_xx", Part::Inertia),
    ("inertia_xy", Part::Inertia),
    ("inertia_xz", Part::Inertia),
    ("inertia_yy", Part::Inertia),
    ("inertia_yz", Part::Inertia),
    ("inertia_zz", Part::Inertia),
    ("damping", Part::Damping),
    ("friction", Part::Friction),
    ("armature", Part::Armature),
    ("stiffness", Part::Stiffness),
];

/// A tree of bodies in a field of gravity.
#[derive(Debug)]
pub(crate) struct RobotDynamics {
    tree: Arc<Tree>,
    /// m/s^2, in the root's frame.
    gravity: [f64; 3],
}

impl RobotDynamics {
    pub fn new(tree: Arc<Tree>, gravity: [f64; 3]) -> Self {
        Self { tree, gravity }
    }

    /// The values of [`PARTS`] of every body.
    pub fn values(tree: &Tree) -> Vec<f64> {
        let of_body = |b: &lacuna_rigid::Body| {
            let InertialParameters { mass, centre, inertia } = b.inertia;
            let lacuna_rigid::Joint { damping, friction, armature, stiffness, .. } = b.joint;
            let joint = [damping, friction, armature, stiffness];
            [mass].into_iter().chain(centre).chain(inertia).chain(joint)
        };
        tree.bodies.iter().flat_map(of_body).collect()
    }

    fn bound<T: Number>(&self, parameters: &[T]) -> Bound<T> {
        let bodies = parameters.chunks_exact(PARTS.len());
        let inertia = self.tree.bodies.iter().zip(bodies.clone()).map(|(body, p)| {
            let (centre, inertia) = ([p[1], p[2], p[3]], [p[4], p[5], p[6], p[7], p[8], p[9]]);
            body.in_joint_frame(&InertialParameters { mass: p[0], centre, inertia })
        });
        let joints = bodies.map(|p| [p[10], p[11], p[12], p[13]]);
        Arc::new(BoundRobot {
            tree: self.tree.clone(),
            inertia: inertia.collect(),
            joints: joints.collect(),
            gravity: self.gravity.map(T::constant),
        })
    }
}

impl Dynamics for RobotDynamics {
    fn sizes(&self) -> Sizes {
        let n = self.tree.bodies.len();
        Sizes { parameters: PARTS.len() * n, coordinates: n, states: 0, inputs: n }
    }

    fn bind(&self, parameters: &[f64]) -> Bound {
        self.bound(parameters)
    }

    fn bind_dual(&self, parameters: &[Dual]) -> Bound<Dual> {
        self.bound(parameters)
    }
}

#[derive(Debug)]
struct BoundRobot<T> {
    tree: Arc<Tree>,
    inertia: Vec<Inertia<T>>,
    /// Damping, friction, rotor inertia, stiffness.
    joints: Vec<[T; 4]>,
    gravity: [T; 3],
}

impl<T: Number> BoundDynamics<T> for BoundRobot<T> {
    fn room(&self) -> Room<T> {
        let n = self.tree.bodies.len();
        let numbers = vec![T::constant(0.0); n];
        Room { numbers, plain: vec![], bodies: lacuna_rigid::Room::new(n) }
    }

    #[inline(always)]
    fn evaluate(&self, room: &mut Room<T>, variables: &[T], rates: &mut [T]) {
        let n = self.tree.bodies.len();
        let sizes = Sizes { parameters: 0, coordinates: n, states: 0, inputs: n };
        let at = Point::new(sizes, &[], variables);
        let (mass, force) = rates.split_at_mut(n * n);
        let dynamics = lacuna_rigid::Dynamics::new(&self.tree, &self.inertia, self.gravity);
        let (bodies, still) = (&mut room.bodies, &room.numbers);
        dynamics.place(bodies, at.coordinates);
        dynamics.mass_matrix(bodies, mass);
        dynamics.inverse(bodies, (at.velocities, still), force);
        for (i, [damping, friction, armature, stiffness]) in self.joints.iter().enumerate() {
            let v = at.velocities[i];
            let strain = at.coordinates[i] - self.tree.bodies[i].joint.spring_reference;
            mass[i * n + i] = mass[i * n + i] + *armature;
            let friction = *damping * v + *friction * (v / STILL).tanh();
            force[i] = at.inputs[i] - force[i] - friction - *stiffness * strain;
        }
    }
}
