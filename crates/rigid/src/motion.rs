//! Inverse dynamics and its derivatives by coordinates and velocities, in the ground's frame.
//!
//! A motion is (w; v): how fast a body turns, and the velocity of what of it passes the ground's
//! origin; a wrench is (n; f): torque about that origin, and force. With s_i the motion of joint i at unit speed, p
//! the parent of i, outwards
//!
//! ```text
//! v_i = v_p + s_i q'     s'_i = v_p x s_i     a_i = a_p + s_i q'' + s'_i q'     s''_i = a_p x s_i + v_p x s'_i
//! f_i = I_i a_i + v_i x* I_i v_i
//! ```
//!
//! with a = -g of the ground. Where F_i, I_i, B_i are sums over body i and all that hangs from it, and j is i or
//! a body between it and the ground,
//!
//! ```text
//! M_ij = s_j . I_i s_i           tau_i = s_i . F_i
//! d tau_i/d q_j  = s_i . (B_i s'_j + I_i s''_j)       d tau_i/d q'_j = s_i . (B_i s_j + 2 I_i s'_j)
//! d tau_j/d q_i  = s_j . (B_i s'_i + I_i s''_i + s_i x* F_i)
//! d tau_j/d q'_i = s_j . (B_i s_i + 2 I_i s'_i)
//! ```
//!
//! (Singh, Russell and Wensing, *Efficient analytical derivatives of rigid-body dynamics using spatial vector
//! algebra*, 2022). There B = (v x*) I - I (v x) + (I v) x-bar*; of its blocks only those by the
//! angular velocity are not 0: `B (w; v) = (D w; -2 f x w)`, f being the momentum.

use crate::algebra::{Matrix, Pose, Vector, add, cross, dot, scaled, sub, times, transposed_times};
use crate::{Body, Dynamics, Inertia, JointKind};
use lacuna_numbers::Number;

/// A motion or a wrench.
#[derive(Clone, Copy, Debug, Default)]
struct Six {
    /// Angular velocity, or torque.
    turn: Vector<f64>,
    /// Velocity, or force.
    slide: Vector<f64>,
}

impl Six {
    #[inline(always)]
    fn plus(self, other: Self) -> Self {
        Self { turn: add(self.turn, other.turn), slide: add(self.slide, other.slide) }
    }

    #[inline(always)]
    fn times(self, factor: f64) -> Self {
        Self { turn: scaled(self.turn, factor), slide: scaled(self.slide, factor) }
    }

    /// The power of a wrench along a motion.
    #[inline(always)]
    fn dot(&self, other: &Self) -> f64 {
        dot(self.turn, other.turn) + dot(self.slide, other.slide)
    }

    /// Rate of a motion that is carried along by this one.
    #[inline(always)]
    fn carries(&self, motion: &Self) -> Self {
        let slide = add(cross(self.turn, motion.slide), cross(self.slide, motion.turn));
        Self { turn: cross(self.turn, motion.turn), slide }
    }

    /// Rate of a wrench that is carried along by this motion.
    #[inline(always)]
    fn carries_wrench(&self, wrench: &Self) -> Self {
        let turn = add(cross(self.turn, wrench.turn), cross(self.slide, wrench.slide));
        Self { turn, slide: cross(self.turn, wrench.slide) }
    }
}

impl Inertia<f64> {
    /// The momentum of a motion.
    #[inline(always)]
    fn of(&self, motion: &Six) -> Six {
        let Six { turn, slide } = motion;
        Six {
            turn: add(times(&self.about_origin, *turn), cross(self.moment, *slide)),
            slide: sub(scaled(*slide, self.mass), cross(self.moment, *turn)),
        }
    }
}

/// B of a body or of several: `B (w; v) = (D w; -2 f x w)`.
#[derive(Clone, Copy, Debug, Default)]
struct Coriolis {
    d: Matrix<f64>,
    momentum: Vector<f64>,
}

impl Coriolis {
    /// D = \[w\] I - I \[w\] - \[v\]\[h\] - \[h\]\[v\] - \[n\], h being the first moment and n the angular momentum.
    #[inline(always)]
    fn of(inertia: &Inertia<f64>, velocity: &Six, momentum: &Six) -> Self {
        let (i, h) = (&inertia.about_origin, inertia.moment);
        let Six { turn: w, slide: v } = *velocity;
        let n = momentum.turn;
        // Columns of [w] I; I being symmetric, I [w] is -([w] I)^T.
        let c: [Vector<f64>; 3] = std::array::from_fn(|k| cross(w, i[k]));
        let round = 2.0 * dot(v, h);
        let d = [
            [2.0 * c[0][0], c[1][0] + c[0][1] + n[2], c[2][0] + c[0][2] - n[1]],
            [c[0][1] + c[1][0] - n[2], 2.0 * c[1][1], c[2][1] + c[1][2] + n[0]],
            [c[0][2] + c[2][0] + n[1], c[1][2] + c[2][1] - n[0], 2.0 * c[2][2]],
        ];
        // [v][h] + [h][v] = h v^T + v h^T - 2 (v . h) 1.
        let d = std::array::from_fn(|a| {
            std::array::from_fn(|b| {
                let own = if a == b { round } else { 0.0 };
                d[a][b] + own - h[a] * v[b] - v[a] * h[b]
            })
        });
        Self { d, momentum: momentum.slide }
    }

    #[inline(always)]
    fn plus(&self, other: &Self) -> Self {
        let d = std::array::from_fn(|k| add(self.d[k], other.d[k]));
        Self { d, momentum: add(self.momentum, other.momentum) }
    }

    /// B s, of which the angular part of s is all that matters.
    #[inline(always)]
    fn times(&self, w: Vector<f64>) -> Six {
        Six { turn: times(&self.d, w), slide: scaled(cross(w, self.momentum), 2.0) }
    }

    /// s^T B as what the angular part of a motion is multiplied with.
    #[inline(always)]
    fn row(&self, s: &Six) -> Vector<f64> {
        add(transposed_times(&self.d, s.turn), scaled(cross(self.momentum, s.slide), 2.0))
    }
}

/// What one body does, in the ground's frame.
#[derive(Clone, Copy, Debug)]
struct Moving {
    pose: Pose,
    /// The motion of the joint at unit speed of its coordinate s, and what carries it does to it: s', s''.
    axis: Six,
    axis_rate: Six,
    axis_acceleration: Six,
    velocity: Six,
    acceleration: Six,
    /// Of the body alone.
    inertia: Inertia<f64>,
    momentum: Six,
    /// With all that hangs from it.
    composite: Inertia<f64>,
    coriolis: Coriolis,
    wrench: Six,
}

/// How the bodies of a tree move: room for [`Dynamics::mass_and_bias`] and what follows it.
#[derive(Clone, Debug, Default)]
pub struct Motion {
    bodies: Vec<Moving>,
}

impl Motion {
    /// For a tree of so many bodies.
    #[must_use]
    pub fn new(bodies: usize) -> Self {
        let nothing = Moving {
            pose: Pose::SAME,
            axis: Six::default(),
            axis_rate: Six::default(),
            axis_acceleration: Six::default(),
            velocity: Six::default(),
            acceleration: Six::default(),
            inertia: Inertia::none(),
            momentum: Six::default(),
            composite: Inertia::none(),
            coriolis: Coriolis::default(),
            wrench: Six::default(),
        };
        Self { bodies: vec![nothing; bodies] }
    }
}

impl Dynamics<'_, f64> {
    /// The mass matrix (row-major, `n x n`) and the forces h, at coordinates and velocities.
    #[inline(always)]
    pub fn mass_and_bias(
        &self,
        motion: &mut Motion,
        (q, v): (&[f64], &[f64]),
        mass: &mut [f64],
        bias: &mut [f64],
    ) {
        let n = q.len();
        self.follow(motion, (q, v));
        mass.fill(0.0);
        bias.fill(0.0);
        for i in (0..self.tree.bodies.len()).rev() {
            let Moving { axis, composite, wrench, .. } = motion.bodies[i];
            let c = self.tree.bodies[i].joint.coordinate;
            bias[c] += axis.dot(&wrench);
            let momentum = composite.of(&axis);
            for at in self.tree.path(i) {
                let entry = motion.bodies[at].axis.dot(&momentum);
                let other = self.tree.bodies[at].joint.coordinate;
                mass[c * n + other] += entry;
                if at != i {
                    mass[other * n + c] += entry;
                }
            }
            if let Some(p) = self.tree.bodies[i].parent {
                let parent = &mut motion.bodies[p];
                parent.composite = parent.composite.plus(&composite);
                parent.wrench = parent.wrench.plus(wrench);
            }
        }
    }

    /// Poses, velocities, and the wrenches where nothing but gravity and velocities accelerates.
    #[inline(always)]
    fn follow(&self, motion: &mut Motion, (q, v): (&[f64], &[f64])) {
        for (i, body) in self.tree.bodies.iter().enumerate() {
            let from = body.parent.map_or(Pose::SAME, |p| motion.bodies[p].pose);
            let joint = &body.joint;
            let (rotation, translation) = joint.kind.frame(&joint.pose, joint.at(q));
            let pose = from.then(&Pose { rotation, translation });
            let z = [pose.rotation[0][2], pose.rotation[1][2], pose.rotation[2][2]];
            let axis = match body.joint.kind {
                JointKind::Revolute => Six { turn: z, slide: cross(pose.translation, z) },
                JointKind::Prismatic => Six { turn: [0.0; 3], slide: z },
            };
            // The motion at unit speed of the coordinate, which that of a joint that follows may differ from.
            let axis = if joint.ratio == 1.0 { axis } else { axis.times(joint.ratio) };
            let (velocity, acceleration) = self.carrier(motion, body);
            let (axis_rate, v) = (velocity.carries(&axis), v[joint.coordinate]);
            let acceleration = acceleration.plus(axis_rate.times(v));
            let velocity = velocity.plus(axis.times(v));
            let inertia = self.inertia[i].seen_from(&pose.rotation, pose.translation);
            let momentum = inertia.of(&velocity);
            let wrench = inertia.of(&acceleration).plus(velocity.carries_wrench(&momentum));
            motion.bodies[i] = Moving {
                pose,
                axis,
                axis_rate,
                axis_acceleration: Six::default(),
                velocity,
                acceleration,
                inertia,
                momentum,
                composite: inertia,
                coriolis: Coriolis::default(),
                wrench,
            };
        }
    }

    /// Velocity and acceleration of what a body hangs from. Gravity amounts to an acceleration of the ground.
    #[inline(always)]
    fn carrier(&self, motion: &Motion, body: &Body) -> (Six, Six) {
        match body.parent {
            Some(p) => (motion.bodies[p].velocity, motion.bodies[p].acceleration),
            None => (Six::default(), Six { turn: [0.0; 3], slide: self.gravity.map(|g| -g) }),
        }
    }

    /// Derivatives of the forces `M q'' + h` by coordinates and by velocities (row-major, `n x n` each), the
    /// accelerations held, where [`Dynamics::mass_and_bias`] was last asked.
    #[inline(always)]
    pub fn derivatives(
        &self,
        motion: &mut Motion,
        (v, a): (&[f64], &[f64]),
        by_coordinates: &mut [f64],
        by_velocities: &mut [f64],
    ) {
        let n = v.len();
        self.accelerate(motion, (v, a));
        by_coordinates.fill(0.0);
        by_velocities.fill(0.0);
        for i in (0..self.tree.bodies.len()).rev() {
            let c = self.tree.bodies[i].joint.coordinate;
            let Moving { axis, axis_rate, axis_acceleration, composite, coriolis, wrench, .. } =
                motion.bodies[i];
            let (row, momentum) = (coriolis.row(&axis), composite.of(&axis));
            let turned = coriolis.times(axis_rate.turn).plus(composite.of(&axis_acceleration));
            let turned = turned.plus(axis.carries_wrench(&wrench));
            let faster = coriolis.times(axis.turn).plus(composite.of(&axis_rate).times(2.0));
            for at in self.tree.path(i) {
                let j = &motion.bodies[at];
                let other = self.tree.bodies[at].joint.coordinate;
                let (here, there) = (c * n + other, other * n + c);
                by_coordinates[there] += j.axis.dot(&turned);
                by_velocities[there] += j.axis.dot(&faster);
                if at != i {
                    by_coordinates[here] +=
                        dot(row, j.axis_rate.turn) + momentum.dot(&j.axis_acceleration);
                    by_velocities[here] += dot(row, j.axis.turn) + 2.0 * momentum.dot(&j.axis_rate);
                }
            }
            if let Some(p) = self.tree.bodies[i].parent {
                let parent = &mut motion.bodies[p];
                parent.coriolis = parent.coriolis.plus(&coriolis);
                parent.wrench = parent.wrench.plus(wrench);
            }
        }
    }

    /// What follows from the accelerations of the joints.
    #[inline(always)]
    fn accelerate(&self, motion: &mut Motion, (v, a): (&[f64], &[f64])) {
        for (i, body) in self.tree.bodies.iter().enumerate() {
            let (velocity, acceleration) = self.carrier(motion, body);
            let own = &mut motion.bodies[i];
            own.axis_acceleration =
                acceleration.carries(&own.axis).plus(velocity.carries(&own.axis_rate));
            let c = body.joint.coordinate;
            own.acceleration =
                acceleration.plus(own.axis.times(a[c])).plus(own.axis_rate.times(v[c]));
            let carried = own.velocity.carries_wrench(&own.momentum);
            own.wrench = own.inertia.of(&own.acceleration).plus(carried);
            own.coriolis = Coriolis::of(&own.inertia, &own.velocity, &own.momentum);
        }
    }

    /// Add to `tau` the forces that hold the bodies up in some field of gravity, where
    /// [`Dynamics::mass_and_bias`] was last asked: linear in that field.
    #[inline(always)]
    pub fn hold_up<T: Number>(&self, motion: &Motion, gravity: Vector<T>, tau: &mut [T]) {
        for (body, Moving { axis, composite, .. }) in self.tree.bodies.iter().zip(&motion.bodies) {
            let c = body.joint.coordinate;
            tau[c] = tau[c] - weighted(gravity, composite.of(axis).slide);
        }
    }

    /// Add to `tau` the forces that it takes to move a body of some inertia, in its joint's frame, along with
    /// body `i` as [`Dynamics::derivatives`] was last told: linear in that inertia.
    #[inline(always)]
    pub fn carry<T: Number>(&self, motion: &Motion, i: usize, inertia: &Inertia<T>, tau: &mut [T]) {
        let Moving { pose, velocity, acceleration, .. } = &motion.bodies[i];
        let (r, p) = (&pose.rotation, pose.translation);
        // Of the origin of the joint's frame, and in that frame.
        let passing = add(velocity.slide, cross(velocity.turn, p));
        let linear = add(acceleration.slide, cross(acceleration.turn, p));
        let linear = transposed_times(r, add(linear, cross(velocity.turn, passing)));
        let (w, rate) =
            (transposed_times(r, velocity.turn), transposed_times(r, acceleration.turn));
        let (mass, mc, about) = (inertia.mass, inertia.moment, &inertia.about_origin);
        let pushed = [mass * linear[0], mass * linear[1], mass * linear[2]];
        let force = add(pushed, add(across(rate, mc), across(w, across(w, mc))));
        let torque = add(turned(about, rate), across(w, turned(about, w)));
        let torque = add(torque, across([-linear[0], -linear[1], -linear[2]], mc));
        let force = turned_by(r, force);
        let torque = add(turned_by(r, torque), across(p, force));
        for j in self.tree.path(i) {
            let Six { turn, slide } = motion.bodies[j].axis;
            let c = self.tree.bodies[j].joint.coordinate;
            tau[c] = tau[c] + weighted(torque, turn) + weighted(force, slide);
        }
    }
}

/// `a . b` with plain weights.
#[inline(always)]
fn weighted<T: Number>(a: Vector<T>, b: Vector<f64>) -> T {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// `m a` of a plain vector. Written out, as what follows: arrays of dual numbers are too large for
/// `map` to be compiled into what calls it.
#[inline(always)]
fn turned<T: Number>(m: &Matrix<T>, a: Vector<f64>) -> Vector<T> {
    [weighted(m[0], a), weighted(m[1], a), weighted(m[2], a)]
}

/// `m a` of a plain matrix.
#[inline(always)]
fn turned_by<T: Number>(m: &Matrix<f64>, a: Vector<T>) -> Vector<T> {
    [weighted(a, m[0]), weighted(a, m[1]), weighted(a, m[2])]
}

/// `a x b` of a plain vector.
#[inline(always)]
fn across<T: Number>(a: Vector<f64>, b: Vector<T>) -> Vector<T> {
    [b[2] * a[1] - b[1] * a[2], b[0] * a[2] - b[2] * a[0], b[1] * a[0] - b[0] * a[1]]
}
