//! A robot's dynamics: rigid bodies that hang together by joints, a motor at each.
//!
//! ```text
//! (M(q) + diag(J)) v' = u - h(q, v) - d v - f tanh(v / v_0) - k (q - q_0)
//! ```
//!
//! with M and h of [`lacuna_rigid`], and what the file states of each joint: damping d, friction f, rotor inertia
//! J, stiffness k of a spring that is at rest at q_0. What a joint that follows another states acts on the
//! coordinate of that, by its ratio once as a force and once more by how far and how fast the joint goes.
//! Parameters are, body by body, the ten of its inertia and d, f, J and k; then the ten of each part that is told
//! apart from the link that it is fixed to ([`lacuna_rigid::Tree::tell_apart`]); then those of the position servos
//! ([`Servo`]), whose input is a position: of it they make u. Behind them may stand what the model leaves out of
//! its structure ([`Dynamics::tree`]) and of its servos.

use super::servo::BoundServo;
use super::{
    Bound, BoundDynamics, Dynamics, Implicit, ImplicitRoom, Point, Room, Servo, Sharing, Sizes,
};
use lacuna_effects::law::{BODY, TILT};
use lacuna_numbers::{Dual, Number};
use lacuna_rigid::{Inertia, InertialParameters, Joint, Tree};
use std::sync::Arc;

/// Speed v_0 over which dry friction that a file states turns its sign, rad/s or m/s. A file means a force that holds
/// still whatever is weaker; a joint that creeps below this speed goes a milliradian a second astray, and were it ten
/// times as fast, simulators that do hold still would be told to have a peak of friction at low speed.
const STILL: f64 = 0.001;

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

/// How many of them, the first, are of inertia.
pub(crate) const INERTIAL: usize = 10;

/// A tree of bodies in a field of gravity.
#[derive(Debug)]
pub(crate) struct RobotDynamics {
    tree: Arc<Tree>,
    /// m/s^2, in the root's frame.
    gravity: [f64; 3],
    servos: Vec<Servo>,
}

impl RobotDynamics {
    pub fn new(tree: Arc<Tree>, gravity: [f64; 3]) -> Self {
        Self { tree, gravity, servos: vec![] }
    }

    /// The same with servos in the place of some inputs: of each coordinate it is the input of its number.
    pub fn with_servos(self, servos: Vec<Servo>) -> Self {
        Self { servos, ..self }
    }

    /// The values of [`PARTS`] of every body, and of inertia of every part that is told apart.
    pub fn values(tree: &Tree) -> Vec<f64> {
        let of_body = |b: &lacuna_rigid::Body| {
            let lacuna_rigid::Joint { damping, friction, armature, stiffness, .. } = b.joint;
            let joint = [damping, friction, armature, stiffness];
            b.inertia.entries().into_iter().chain(joint)
        };
        let of_parts = tree.apart().flat_map(|part| part.inertia().entries());
        tree.bodies.iter().flat_map(of_body).chain(of_parts).collect()
    }

    fn bound<T: Number>(&self, parameters: &[T]) -> Bound<T> {
        let (parameters, left_out) = parameters.split_at(self.sizes().parameters);
        let (of_bodies, rest) = parameters.split_at(PARTS.len() * self.tree.bodies.len());
        let (of_parts, of_servos) = rest.split_at(INERTIAL * self.tree.apart().count());
        let (structure, of_servos_left_out) =
            left_out.split_at(left_out.len().min(BODY * self.tree.bodies.len() + TILT));
        let mut servos = vec![None; self.tree.coordinates()];
        for servo in Servo::bound(&self.servos, of_servos, of_servos_left_out) {
            servos[servo.coordinate] = Some(servo);
        }
        let mut of_parts = of_parts.as_chunks::<INERTIAL>().0.iter();
        let bodies = self.tree.bodies.iter().zip(of_bodies.as_chunks::<{ PARTS.len() }>().0);
        let bodies = bodies.map(|(body, values)| {
            let [own @ .., damping, friction, armature, stiffness] = *values;
            let own = body.in_joint_frame(&InertialParameters::of_entries(&own));
            let parts = body.apart().zip(&mut of_parts);
            let inertia = parts.fold(own, |sum, (part, values)| {
                let part = part.in_link_frame(&InertialParameters::of_entries(values));
                sum.plus(&body.along_joint(&part))
            });
            let rest = body.joint.spring_reference;
            (inertia, Motor { damping, friction, armature, stiffness, rest })
        });
        let (inertia, joints) = bodies.unzip();
        let mut bound = BoundRobot {
            tree: self.tree.clone(),
            plain: vec![],
            changing: vec![],
            inertia,
            joints,
            servos,
            gravity: self.gravity.map(T::constant),
        };
        bound.change(structure);
        bound.note_values();
        Arc::new(bound)
    }
}

impl Dynamics for RobotDynamics {
    fn sizes(&self) -> Sizes {
        let (n, bodies) = (self.tree.coordinates(), self.tree.bodies.len());
        let of_servos: usize = self.servos.iter().map(|s| s.parameters()).sum();
        let parameters = PARTS.len() * bodies + INERTIAL * self.tree.apart().count() + of_servos;
        Sizes { parameters, coordinates: n, states: 0, inputs: n }
    }

    fn sharing(&self) -> Sharing {
        Sharing::Some
    }

    fn tree(&self) -> Option<&Tree> {
        Some(&self.tree)
    }

    fn servos(&self) -> &[Servo] {
        &self.servos
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
    /// The values of it.
    plain: Vec<Inertia<f64>>,
    /// The bodies whose inertia carries derivatives.
    changing: Vec<usize>,
    joints: Vec<Motor<T>>,
    /// Of each coordinate that has one.
    servos: Vec<Option<BoundServo<T>>>,
    /// m/s^2, in the root's frame.
    gravity: [T; 3],
}

impl<T: Number> BoundRobot<T> {
    fn sizes(&self) -> Sizes {
        let n = self.tree.coordinates();
        Sizes { parameters: 0, coordinates: n, states: 0, inputs: n }
    }

    /// The bodies, their inertia in plain numbers.
    #[inline(always)]
    fn plain(&self) -> lacuna_rigid::Dynamics<'_, f64> {
        lacuna_rigid::Dynamics::new(&self.tree, &self.plain, self.gravity.map(T::value))
    }
}

/// What the file states of a joint beside what it carries.
#[derive(Clone, Copy, Debug)]
struct Motor<T> {
    damping: T,
    friction: T,
    /// Rotor inertia.
    armature: T,
    stiffness: T,
    /// Where the spring is at rest.
    rest: f64,
}

impl<T: Number> Motor<T> {
    /// The same in plain numbers.
    #[inline(always)]
    fn value(&self) -> Motor<f64> {
        Motor {
            damping: self.damping.value(),
            friction: self.friction.value(),
            armature: self.armature.value(),
            stiffness: self.stiffness.value(),
            rest: self.rest,
        }
    }

    /// The force that it makes in its joint at coordinates and velocities.
    #[inline(always)]
    fn force(&self, joint: &Joint, at: &Point<T>) -> T {
        let (q, v) = (joint.at(at.coordinates), joint.rate(at.velocities));
        let force = -(self.damping * v) - self.stiffness * (q - self.rest);
        // Most files state no friction: its sharp edge need not be evaluated.
        if self.friction.value() == 0.0 && !self.friction.moves() {
            return force;
        }
        force - self.friction * (v / STILL).tanh()
    }

    /// Its share of `M + diag(J)` and of what drives the bodies less h.
    #[inline(always)]
    fn act(&self, joint: &Joint, at: &Point<T>, (mass, force): (&mut [T], &mut [T])) {
        let c = joint.coordinate;
        let diagonal = c * (force.len() + 1);
        mass[diagonal] = mass[diagonal] + joint.felt(joint.felt(self.armature));
        force[c] = force[c] + joint.felt(self.force(joint, at));
    }
}

/// What drives coordinates less h, which stands in `force`.
#[inline(always)]
fn drive<T: Number>(
    servos: impl IntoIterator<Item = Option<BoundServo<T>>>,
    at: &Point<T>,
    force: &mut [T],
) {
    for ((force, input), servo) in force.iter_mut().zip(at.inputs).zip(servos) {
        T::by_itself();
        *force = driven(servo, *input, at) - *force;
    }
}

/// What drives a coordinate: its input, or what its servo makes of that.
#[inline(always)]
fn driven<T: Number>(servo: Option<BoundServo<T>>, input: T, at: &Point<T>) -> T {
    match servo {
        Some(servo) => servo.force(at),
        None => input,
    }
}

impl<T: Number> BoundRobot<T> {
    /// Note the values of inertia, and where it carries derivatives.
    fn note_values(&mut self) {
        let moves = |i: &Inertia<T>| i.entries().iter().any(|x| x.moves());
        self.plain = self.inertia.iter().map(|i| i.map(T::value)).collect();
        self.changing = (0..self.inertia.len()).filter(|&i| moves(&self.inertia[i])).collect();
    }

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
        let numbers = vec![T::constant(0.0); self.tree.coordinates()];
        Room { numbers, plain: vec![], bodies: lacuna_rigid::Room::new(self.tree.bodies.len()) }
    }

    #[inline(always)]
    fn evaluate(&self, room: &mut Room<T>, variables: &[T], rates: &mut [T]) {
        let n = self.tree.coordinates();
        let at = Point::new(self.sizes(), &[], variables);
        let (mass, force) = rates.split_at_mut(n * n);
        let dynamics = lacuna_rigid::Dynamics::new(&self.tree, &self.inertia, self.gravity);
        let (bodies, still) = (&mut room.bodies, &room.numbers);
        dynamics.place(bodies, at.coordinates);
        dynamics.mass_matrix(bodies, mass);
        dynamics.inverse(bodies, (at.velocities, still), force);
        drive(self.servos.iter().copied(), &at, force);
        for (body, motor) in self.tree.bodies.iter().zip(&self.joints) {
            motor.act(&body.joint, &at, (mass, force));
        }
    }

    fn implicit(&self) -> Option<&dyn Implicit<T>> {
        T::CARRIES.then_some(self)
    }
}

impl<T: Number> Implicit<T> for BoundRobot<T> {
    fn room(&self) -> ImplicitRoom {
        ImplicitRoom::new(self.tree.coordinates(), self.tree.bodies.len())
    }

    fn values(&self, room: &mut ImplicitRoom, variables: &[f64], rates: &mut [f64]) {
        pulp::Arch::new().dispatch(Values { robot: self, room, variables, rates });
    }

    fn accelerate(&self, room: &mut ImplicitRoom, variables: &[f64], accelerations: &[f64]) {
        pulp::Arch::new().dispatch(Accelerate { robot: self, room, variables, accelerations });
    }

    fn derive(&self, room: &mut ImplicitRoom, variables: &[T], forces: &mut [T]) {
        pulp::Arch::new().dispatch(Derive { robot: self, room, variables, forces });
    }
}

/// A call of [`Implicit::values`], to be compiled for every width of vectors, as those that follow. Closures
/// would be compiled apart, for the narrowest.
struct Values<'a, T> {
    robot: &'a BoundRobot<T>,
    room: &'a mut ImplicitRoom,
    variables: &'a [f64],
    rates: &'a mut [f64],
}

impl<T: Number> pulp::WithSimd for Values<'_, T> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: pulp::Simd>(self, _simd: S) {
        let Self { robot, room, variables, rates } = self;
        let n = robot.tree.coordinates();
        let at = Point::new(robot.sizes(), &[], variables);
        let (mass, force) = rates.split_at_mut(n * n);
        let moving = (at.coordinates, at.velocities);
        robot.plain().mass_and_bias(&mut room.motion, moving, mass, force);
        drive(robot.servos.iter().map(|s| s.map(|s| s.value())), &at, force);
        for (body, motor) in robot.tree.bodies.iter().zip(&robot.joints) {
            motor.value().act(&body.joint, &at, (mass, force));
        }
    }
}

struct Accelerate<'a, T> {
    robot: &'a BoundRobot<T>,
    room: &'a mut ImplicitRoom,
    variables: &'a [f64],
    accelerations: &'a [f64],
}

impl<T: Number> pulp::WithSimd for Accelerate<'_, T> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: pulp::Simd>(self, _simd: S) {
        let Self { robot, room, variables, accelerations } = self;
        let at = Point::new(robot.sizes(), &[], variables);
        let ImplicitRoom { motion, by_coordinates, by_velocities, .. } = room;
        let moving = (at.velocities, accelerations);
        robot.plain().derivatives(motion, moving, by_coordinates, by_velocities);
        room.accelerations.copy_from_slice(accelerations);
    }
}

struct Derive<'a, T> {
    robot: &'a BoundRobot<T>,
    room: &'a ImplicitRoom,
    variables: &'a [T],
    forces: &'a mut [T],
}

impl<T: Number> pulp::WithSimd for Derive<'_, T> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: pulp::Simd>(self, _simd: S) {
        let Self { robot, room, variables, forces } = self;
        let n = robot.tree.coordinates();
        let at = Point::new(robot.sizes(), &[], variables);
        let dynamics = robot.plain();
        // What it takes to move the bodies enters with the other sign.
        for force in forces.iter_mut() {
            T::by_itself();
            *force = -*force;
        }
        for &i in &robot.changing {
            dynamics.carry(&room.motion, i, &robot.inertia[i], forces);
        }
        if robot.gravity.iter().any(|g| g.moves()) {
            dynamics.hold_up(&room.motion, robot.gravity, forces);
        }
        let (by_q, by_v) = (room.by_coordinates.chunks(n), room.by_velocities.chunks(n));
        let inputs = at.inputs.iter().zip(&robot.servos);
        for ((force, (input, servo)), (by_q, by_v)) in
            forces.iter_mut().zip(inputs).zip(by_q.zip(by_v))
        {
            let mut taken = *force;
            for (q, slope) in at.coordinates.iter().zip(by_q) {
                taken = taken + *q * *slope;
            }
            for (v, slope) in at.velocities.iter().zip(by_v) {
                taken = taken + *v * *slope;
            }
            *force = driven(*servo, *input, &at) - taken;
        }
        for (body, motor) in robot.tree.bodies.iter().zip(&robot.joints) {
            let (joint, c) = (&body.joint, body.joint.coordinate);
            let turned = motor.armature * joint.rate(&room.accelerations);
            forces[c] = forces[c] + joint.felt(motor.force(joint, &at) - turned);
        }
    }
}
