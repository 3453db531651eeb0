//! What is simulated, whoever simulates it: the equations of motion behind one trait.
//!
//! With coordinates q in R^n, velocities v = q', first-order states x in R^s, inputs u in R^m,
//! parameters p and time t,
//!
//! ```text
//! M(q, v, x, u, t; p) v' = F(q, v, x, u, t; p)
//!                     x' = D(q, v, x, u, t; p)
//! ```
//!
//! | on paper | in code | shape |
//! | --- | --- | --- |
//! | n, s, m, length of p | [`Sizes`] | |
//! | (q, v, x, u, t) | the `variables` of [`BoundDynamics::evaluate`], in this order; [`Point`] | 2n + s + m + 1 |
//! | mass matrix M | the first of its `rates`, row-major | n^2 |
//! | generalised forces F, rates D | the rest of its `rates` | n + s |
//! | what else is measured, y | [`BoundDynamics::observe`] | [`Dynamics::outputs`] |
//! | derivatives by q, v, x, u, p | the lanes of [`Dual`] numbers | [`lacuna_numbers::LANES`] |
//!
//! Units are those of the model that the dynamics belong to ([`crate::Model`]): an entry of F
//! times a velocity is a power. A simulator that gives accelerations alone has M = 1
//! ([`Mass::Unit`]); F is then v', and so are the effects that are added to it.
//!
//! | what there is | becomes [`Dynamics`] by |
//! | --- | --- |
//! | expressions in a model file, or the robot or FMU that it names | [`crate::Model::read`] |
//! | a closure for v' and x', or two for M and for F and D | [`crate::model::Builder::rates`], [`crate::model::Builder::mechanics`] |
//! | a program that computes in `f64` | [`Simulator`] and [`Differences`] |
//! | Rust that computes in any [`Number`] | [`GenericSimulator`] and [`Exact`] |
//! | anything else | the trait itself |

mod closure;
mod differences;
mod equations;
mod exact;
mod fmu;
mod implicit;
mod nearby;
mod robot;
mod servo;

pub(crate) use closure::{Mechanics, Rates};
pub use differences::{Differences, Simulator};
pub(crate) use equations::{Equations, Nodes};
pub use exact::{Exact, GenericSimulator};
pub(crate) use fmu::Unit;
pub use implicit::{Implicit, ImplicitRoom};
pub(crate) use robot::{INERTIAL, PARTS, Part, RobotDynamics};
pub(crate) use servo::BoundServo;
pub use servo::{SERVO, Servo};

use crate::model::Step;
use lacuna_numbers::{Dual, LANES, Number};
use lacuna_rigid::Tree;
use std::fmt::Debug;
use std::ops::Range;
use std::sync::Arc;

/// How many there are of everything that dynamics depend on.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Sizes {
    /// Parameters p.
    pub parameters: usize,
    /// Second-order coordinates q.
    pub coordinates: usize,
    /// First-order states x.
    pub states: usize,
    /// Inputs u.
    pub inputs: usize,
}

impl Sizes {
    /// Length of the machine's state: coordinates, velocities, first-order states.
    #[must_use]
    pub fn machine_states(&self) -> usize {
        2 * self.coordinates + self.states
    }

    /// Number of force channels: coordinates, then first-order states.
    #[must_use]
    pub fn channels(&self) -> usize {
        self.coordinates + self.states
    }

    /// Length of the variables: the machine's state, inputs, time.
    #[must_use]
    pub fn variables(&self) -> usize {
        self.machine_states() + self.inputs + 1
    }

    /// Length of the rates: the mass matrix, then one entry a channel.
    #[must_use]
    pub fn rates(&self) -> usize {
        self.coordinates * self.coordinates + self.channels()
    }
}

/// What a simulator knows of inertia.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Mass {
    /// It gives the mass matrix; effects are generalised forces.
    #[default]
    Matrix,
    /// It gives accelerations alone: the mass matrix is 1, and effects are accelerations.
    Unit,
}

/// What derivatives in several directions have in common.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Sharing {
    /// Nothing.
    #[default]
    None,
    /// Some of what they cost: those that are taken by one thread had better be taken together.
    Some,
    /// Nearly all that they cost: all had better be taken together.
    All,
}

/// Equations of motion, their parameters free.
///
/// Nothing here fails: where a simulator cannot be evaluated it writes NaN, which ends a
/// simulation as one that diverges.
pub trait Dynamics: Debug + Send + Sync {
    /// What they depend on.
    fn sizes(&self) -> Sizes;

    /// Whether they give the mass matrix.
    fn mass(&self) -> Mass {
        Mass::Matrix
    }

    /// Number of outputs of their own, beside the state's entries and the inputs.
    fn outputs(&self) -> usize {
        0
    }

    /// What derivatives in several directions share ([`Implicit`]).
    fn sharing(&self) -> Sharing {
        Sharing::None
    }

    /// Largest error that derivatives taken so far were measured to have, as a share of
    /// `|dF/dx| + |F|/|x|`; `None` where derivatives are exact.
    fn derivative_error(&self) -> Option<f64> {
        None
    }

    /// What went wrong so far, in a sentence, where a simulator could not be evaluated; none where nothing did.
    fn trouble(&self) -> Option<String> {
        None
    }

    /// The bodies that move, where these are a robot's dynamics. Behind their parameters may then stand
    /// the numbers of what the model leaves out of its structure
    /// ([`StructureLaw`](lacuna_effects::StructureLaw)): those of each body, then those of the base.
    fn tree(&self) -> Option<&Tree> {
        None
    }

    /// The position servos that drive it. Their parameters are the last, and what the model leaves out of them
    /// ([`SERVO`]) may stand behind all else.
    fn servos(&self) -> &[Servo] {
        &[]
    }

    /// Set the parameters, of [`Sizes::parameters`] values, and the numbers of its structure, if there are
    /// any ([`Dynamics::tree`]).
    fn bind(&self, parameters: &[f64]) -> Bound;

    /// The same with derivatives: those by parameters that are [`Dual::direction`]s among them.
    fn bind_dual(&self, parameters: &[Dual]) -> Bound<Dual>;

    /// The same with derivatives by the parameters from the `first` on, one a lane.
    fn bind_along(&self, parameters: &[f64], first: usize) -> Bound<Dual> {
        let along = parameters.iter().enumerate().map(|(k, p)| Dual::among(*p, k, first));
        self.bind_dual(&along.collect::<Vec<_>>())
    }
}

/// Which of some parameters change rates, those from `begin` on, at some variables.
pub(crate) fn felt(
    dynamics: &dyn Dynamics,
    (parameters, some): (&[f64], Range<usize>),
    (variables, begin): (&[f64], usize),
) -> Vec<bool> {
    /// More than what rounding leaves of 0.
    const FELT: f64 = 1e-12;
    let at: Vec<Dual> = variables.iter().map(|x| Dual::constant(*x)).collect();
    let mut rates = vec![Dual::constant(0.0); dynamics.sizes().rates()];
    let mut felt = vec![];
    for first in some.clone().step_by(LANES) {
        dynamics.bind_along(parameters, first).evaluate_once(&at, &mut rates);
        let is_felt = |lane: usize| rates[begin..].iter().any(|r| r.tangent[lane].abs() > FELT);
        felt.extend((0..LANES.min(some.end - first)).map(is_felt));
    }
    felt
}

/// Dynamics with their parameters set, shared between threads.
pub type Bound<T = f64> = Arc<dyn BoundDynamics<T>>;

/// Equations of motion with their parameters set, in one kind of number.
pub trait BoundDynamics<T: Number>: Debug + Send + Sync {
    /// Room to evaluate in: made once, used for every sample of a simulation.
    fn room(&self) -> Room<T> {
        Room::new(vec![], vec![])
    }

    /// Mass matrix (row-major; the identity for [`Mass::Unit`]), generalised forces and rates of
    /// the first-order states, into `rates` ([`Sizes::rates`] entries), at `variables` = (q, v, x,
    /// u, t) ([`Sizes::variables`] entries). Numbers that carry derivatives carry those of the
    /// parameters and variables along.
    fn evaluate(&self, room: &mut Room<T>, variables: &[T], rates: &mut [T]);

    /// The same for one point, in room of its own.
    fn evaluate_once(&self, variables: &[T], rates: &mut [T]) {
        self.evaluate(&mut self.room(), variables, rates);
    }

    /// The outputs of its own ([`Dynamics::outputs`] entries) at `variables`, after which the
    /// forces stand that impose motion ([`crate::Model::imposed`]), one an imposed coordinate.
    fn observe(&self, variables: &[T], outputs: &mut [T]) {
        let _ = variables;
        outputs.fill(T::constant(f64::NAN));
    }

    /// Derivatives by way of known accelerations, where they are cheaper than those that
    /// [`BoundDynamics::evaluate`] carries along.
    fn implicit(&self) -> Option<&dyn Implicit<T>> {
        None
    }

    /// Take a step of a simulation. To be left as it is: here the loop over stages is compiled
    /// together with [`BoundDynamics::evaluate`], so that a sample costs one virtual call.
    fn advance(&self, step: Step<'_, T>) {
        step.along(self);
    }
}

/// Room for [`BoundDynamics::evaluate`]: what it holds is the business of who made it.
#[derive(Clone, Debug)]
pub struct Room<T> {
    /// Numbers of the kind that is evaluated in.
    pub numbers: Vec<T>,
    /// Plain numbers.
    pub plain: Vec<f64>,
    /// Bodies that hang together.
    pub bodies: lacuna_rigid::Room<T>,
}

impl<T: Number> Room<T> {
    /// Without bodies.
    #[must_use]
    pub fn new(numbers: Vec<T>, plain: Vec<f64>) -> Self {
        Self { numbers, plain, bodies: lacuna_rigid::Room::new(0) }
    }
}

/// Where equations of motion are evaluated.
#[derive(Clone, Copy, Debug)]
pub struct Point<'a, T = f64> {
    /// Parameters p, in the model's order, as all that follows.
    pub parameters: &'a [T],
    /// Coordinates q.
    pub coordinates: &'a [T],
    /// Velocities v.
    pub velocities: &'a [T],
    /// First-order states x.
    pub states: &'a [T],
    /// Inputs u.
    pub inputs: &'a [T],
    /// Time t (s).
    pub time: T,
}

impl<'a, T: Number> Point<'a, T> {
    /// The point of `variables` = (q, v, x, u, t).
    #[must_use]
    pub fn new(sizes: Sizes, parameters: &'a [T], variables: &'a [T]) -> Self {
        let (coordinates, rest) = variables.split_at(sizes.coordinates);
        let (velocities, rest) = rest.split_at(sizes.coordinates);
        let (states, rest) = rest.split_at(sizes.states);
        let (inputs, time) = rest.split_at(sizes.inputs);
        Self { parameters, coordinates, velocities, states, inputs, time: time[0] }
    }
}

/// `rates` as the mass matrix, set to the identity, and what follows it.
fn mass_and_force<T: Number>(sizes: Sizes, rates: &mut [T]) -> (&mut [T], &mut [T]) {
    let n = sizes.coordinates;
    let (mass, force) = rates.split_at_mut(n * n);
    for (k, entry) in mass.iter_mut().enumerate() {
        *entry = T::constant(if k % (n + 1) == 0 { 1.0 } else { 0.0 });
    }
    (mass, force)
}
