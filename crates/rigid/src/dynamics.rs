//! Mass matrix and forces of a tree.
//!
//! Along the tree, with R_i(q_i) and p_i(q_i) the pose of body i in its parent, outwards
//!
//! ```text
//! w_i = R^T w_p + z q'
//! w'_i = R^T w'_p + z q'' + w_i x z q'
//! a_i = R^T (a_p + w'_p x p + w_p x (w_p x p)) [+ z q'' + 2 w_i x z q']
//! f_i = m a + w' x mc + w x (w x mc),   n_i = I w' + w x I w + mc x a
//! ```
//!
//! (the terms with z in w for a joint that turns, those in brackets for one that slides), and inwards
//! f_p += R f_i, n_p += R n_i + p x R f_i; tau_i is the share of n_i or of f_i along z. Gravity is an
//! acceleration of the root.
//!
//! Where joints follow others, q_b = G q + g being where all of them are, these are the forces and the mass matrix
//! of q_b; those of q are G^T tau_b and G^T M_b G.

use crate::algebra::{Matrix, Vector, add, cross, cross_z, scaled, times, transposed_times};
use crate::{Inertia, JointKind, Tree};
use lacuna_numbers::Number;

/// A tree whose bodies have inertia in some number.
#[derive(Clone, Debug)]
pub struct Dynamics<'a, T> {
    pub(crate) tree: &'a Tree,
    pub(crate) inertia: &'a [Inertia<T>],
    pub(crate) gravity: Vector<T>,
}

/// Where bodies are and how they move: made once, used for every evaluation.
#[derive(Clone, Debug)]
pub struct Room<T> {
    rotation: Vec<Matrix<T>>,
    place: Vec<Vector<T>>,
    angular: Vec<Vector<T>>,
    angular_rate: Vec<Vector<T>>,
    linear: Vec<Vector<T>>,
    force: Vec<Vector<T>>,
    torque: Vec<Vector<T>>,
    composite: Vec<Inertia<T>>,
}

impl<T: Number> Room<T> {
    /// For a tree of so many bodies.
    #[must_use]
    pub fn new(bodies: usize) -> Self {
        let zero = T::constant(0.0);
        let vectors = || vec![[zero; 3]; bodies];
        Self {
            rotation: vec![[[zero; 3]; 3]; bodies],
            place: vectors(),
            angular: vectors(),
            angular_rate: vectors(),
            linear: vectors(),
            force: vectors(),
            torque: vectors(),
            composite: vec![Inertia::none(); bodies],
        }
    }
}

impl<'a, T: Number> Dynamics<'a, T> {
    /// Of a tree whose bodies have this inertia, in this field of gravity (m/s^2, in the root's
    /// frame).
    #[must_use]
    pub fn new(tree: &'a Tree, inertia: &'a [Inertia<T>], gravity: Vector<T>) -> Self {
        debug_assert_eq!(tree.bodies.len(), inertia.len());
        Self { tree, inertia, gravity }
    }

    /// Set the poses of all bodies in their parents: to be called before the others.
    #[inline(always)]
    pub fn place(&self, room: &mut Room<T>, q: &[T]) {
        for (i, body) in self.tree.bodies.iter().enumerate() {
            let joint = &body.joint;
            (room.rotation[i], room.place[i]) = joint.kind.frame(&joint.pose, joint.at(q));
        }
    }

    /// The forces tau that accelerations take at velocities: `M q'' + h`, at the poses of
    /// [`Dynamics::place`].
    #[inline(always)]
    pub fn inverse(&self, room: &mut Room<T>, (v, a): (&[T], &[T]), tau: &mut [T]) {
        let zero = T::constant(0.0);
        for (i, body) in self.tree.bodies.iter().enumerate() {
            let (w, rate, linear) = match body.parent {
                Some(p) => (room.angular[p], room.angular_rate[p], room.linear[p]),
                None => ([zero; 3], [zero; 3], self.gravity.map(|g| -g)),
            };
            let (r, p) = (&room.rotation[i], room.place[i]);
            let carried = add(linear, add(cross(rate, p), cross(w, cross(w, p))));
            let mut w = transposed_times(r, w);
            let mut rate = transposed_times(r, rate);
            let mut linear = transposed_times(r, carried);
            let (v, a) = (body.joint.rate(v), body.joint.rate(a));
            let [x, y] = cross_z(w, v);
            match body.joint.kind {
                JointKind::Revolute => {
                    w[2] = w[2] + v;
                    rate = [rate[0] + x, rate[1] + y, rate[2] + a];
                }
                JointKind::Prismatic => {
                    linear = [linear[0] + x * 2.0, linear[1] + y * 2.0, linear[2] + a];
                }
            }
            let body = &self.inertia[i];
            let (mc, about) = (body.moment, &body.about_origin);
            let force = add(cross(rate, mc), cross(w, cross(w, mc)));
            room.force[i] = add(scaled(linear, body.mass), force);
            let torque = add(times(about, rate), cross(w, times(about, w)));
            room.torque[i] = add(torque, cross(mc, linear));
            (room.angular[i], room.angular_rate[i], room.linear[i]) = (w, rate, linear);
        }
        tau.fill(zero);
        for (i, body) in self.tree.bodies.iter().enumerate().rev() {
            let (force, torque, joint) = (room.force[i], room.torque[i], &body.joint);
            let share = joint.felt(joint.kind.share(force, torque));
            tau[joint.coordinate] = tau[joint.coordinate] + share;
            if let Some(p) = body.parent {
                let (force, torque) = carried(&room.rotation[i], room.place[i], force, torque);
                room.force[p] = add(room.force[p], force);
                room.torque[p] = add(room.torque[p], torque);
            }
        }
    }

    /// The mass matrix (row-major, `n x n`) at the poses of [`Dynamics::place`].
    #[inline(always)]
    pub fn mass_matrix(&self, room: &mut Room<T>, mass: &mut [T]) {
        let (n, zero) = (self.tree.coordinates(), T::constant(0.0));
        mass.fill(zero);
        room.composite.copy_from_slice(self.inertia);
        for (i, body) in self.tree.bodies.iter().enumerate().rev() {
            let whole = room.composite[i];
            if let Some(p) = body.parent {
                let seen = whole.seen_from(&room.rotation[i], room.place[i]);
                room.composite[p] = room.composite[p].plus(&seen);
            }
            let [x, y, _] = whole.moment;
            let (mut force, mut torque) = match body.joint.kind {
                JointKind::Revolute => ([-y, x, zero], whole.about_origin[2]),
                JointKind::Prismatic => ([zero, zero, whole.mass], [y, -x, zero]),
            };
            let mut at = i;
            loop {
                let other = &self.tree.bodies[at].joint;
                let entry = other.felt(body.joint.felt(other.kind.share(force, torque)));
                let (row, column) = (body.joint.coordinate, other.coordinate);
                mass[row * n + column] = mass[row * n + column] + entry;
                if at != i {
                    mass[column * n + row] = mass[column * n + row] + entry;
                }
                let Some(parent) = self.tree.bodies[at].parent else { break };
                (force, torque) = carried(&room.rotation[at], room.place[at], force, torque);
                at = parent;
            }
        }
    }
}

/// A force and its torque about a body's origin, as its parent feels them.
#[inline(always)]
fn carried<T: Number>(
    rotation: &Matrix<T>,
    place: Vector<T>,
    force: Vector<T>,
    torque: Vector<T>,
) -> (Vector<T>, Vector<T>) {
    let force = times(rotation, force);
    (force, add(times(rotation, torque), cross(place, force)))
}
