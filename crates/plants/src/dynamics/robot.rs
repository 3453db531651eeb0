//! A robot's dynamics: rigid bodies that hang together by joints, a motor at each.
//!
//! ```text
//! (M(q) + diag(J)) v' = u - h(q, v) - d v - f tanh(v / v_0)
//! ```
//!
//! with M and h of [`lacuna_rigid`], and what the file states of each joint: damping d, friction f, rotor inertia
//! J. Parameters are, body by body, the ten of its inertia and these three; behind them may stand what
//! the model leaves out of its structure ([`Dynamics::tree`]).

use super::{Bound, BoundDynamics, Dynamics, Point, Room, Sizes};
use lacuna_effects::law::BODY;
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
}

/// The parameters of a body, in their order, as they are called.
pub(crate) const PARTS: [(&str, Part); 13] = [
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
            let joint = [b.joint.damping, b.joint.friction, b.joint.armature];
            [mass].into_iter().chain(centre).chain(inertia).chain(joint)
        };
        tree.bodies.iter().flat_map(of_body).collect()
    }

    fn bound<T: Number>(&self, parameters: &[T]) -> Bound<T> {
        let (parameters, structure) = parameters.split_at(self.sizes().parameters);
        let bodies = parameters.chunks_exact(PARTS.len());
        let inertia = self.tree.bodies.iter().zip(bodies.clone()).map(|(body, p)| {
            let (centre, inertia) = ([p[1], p[2], p[3]], [p[4], p[5], p[6], p[7], p[8], p[9]]);
            body.in_joint_frame(&InertialParameters { mass: p[0], centre, inertia })
        });
        let joints = bodies.map(|p| [p[10], p[11], p[12]]);
        let mut bound = BoundRobot {
            tree: self.tree.clone(),
            inertia: inertia.collect(),
            joints: joints.collect(),
            gravity: self.gravity.map(T::constant),
        };
        bound.change(structure);
        Arc::new(bound)
    }
}

impl Dynamics for RobotDynamics {
    fn sizes(&self) -> Sizes {
        let n = self.tree.bodies.len();
        Sizes { parameters: PARTS.len() * n, coordinates: n, states: 0, inputs: n }
    }

    fn tree(&self) -> Option<&Tree> {
        Some(&self.tree)
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
    /// Damping, friction, rotor inertia.
    joints: Vec<[T; 3]>,
    gravity: [T; 3],
}

impl<T: Number> BoundRobot<T> {
    /// Add what stands behind the parameters, if anything does.
    fn change(&mut self, structure: &[T]) {
        let (bodies, base) = structure.split_at(structure.len().min(BODY * self.inertia.len()));
        for ((inertia, body), added) in
            self.inertia.iter_mut().zip(&self.tree.bodies).zip(bodies.chunks_exact(BODY))
        {
            let [xx, xy, xz, yy, yz, zz] = std::array::from_fn(|k| added[4 + k]);
            let about_origin = [[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]];
            let moment = [added[1], added[2], added[3]];
            let added = Inertia { mass: added[0], moment, about_origin };
            *inertia = inertia.plus(&body.along_joint(&added));
        }
        if let [roll, pitch] = *base {
            self.gravity = as_seen_from(self.gravity, roll, pitch);
        }
    }
}

/// A vector as it is seen from a frame that is turned by roll about x, and then by pitch about y.
fn as_seen_from<T: Number>([x, y, z]: [T; 3], roll: T, pitch: T) -> [T; 3] {
    let ((s, c), (sr, cr)) = (pitch.sin_cos(), roll.sin_cos());
    let (x, z) = (c * x - s * z, s * x + c * z);
    [x, cr * y + sr * z, cr * z - sr * y]
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
        for (i, [damping, friction, armature]) in self.joints.iter().enumerate() {
            let v = at.velocities[i];
            mass[i * n + i] = mass[i * n + i] + *armature;
            force[i] = at.inputs[i] - force[i] - *damping * v - *friction * (v / STILL).tanh();
        }
    }
}
