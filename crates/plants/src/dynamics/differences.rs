//! Simulators that compute in plain numbers: their derivatives by differences ([`Nearby`]).

use super::nearby::{Evaluate, Nearby, Slopes};
use super::{
    Bound, BoundDynamics, Dynamics, Implicit, ImplicitRoom, Mass, Point, Room, Sharing, Sizes,
    mass_and_force,
};
use lacuna_numbers::{Dual, Number};
use std::fmt::Debug;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

/// A simulator that computes in plain numbers and has no derivatives.
pub trait Simulator: Debug + Send + Sync + 'static {
    /// Whether it gives the mass matrix.
    fn mass(&self) -> Mass;

    /// Mass matrix (row-major `n x n`; the identity on entry), and generalised forces followed by
    /// the rates of the first-order states (`n + s`). It depends on nothing but `at`.
    fn evaluate(&self, at: &Point<'_>, mass: &mut [f64], force: &mut [f64]);

    /// The same at several points: parameters and variables of one in a row of `points`, its mass matrix
    /// and what follows it in a row of `rates` ([`Sizes::rates`]). To be given where many at once cost less than
    /// one after the other.
    fn evaluate_all(&self, sizes: Sizes, points: &[f64], rates: &mut [f64]) {
        let rows = points.chunks_exact(sizes.parameters + sizes.variables());
        for (point, rates) in rows.zip(rates.chunks_exact_mut(sizes.rates())) {
            let (parameters, variables) = point.split_at(sizes.parameters);
            let (mass, force) = mass_and_force(sizes, rates);
            self.evaluate(&Point::new(sizes, parameters, variables), mass, force);
        }
    }

    /// Whether it has the derivatives of its rates by an entry of a point itself: by a parameter, or
    /// by a variable after all parameters.
    fn has_derivative(&self, sizes: Sizes, entry: usize) -> bool {
        let _ = (sizes, entry);
        false
    }

    /// As [`Simulator::evaluate_all`], and derivatives at the first point by `entries`, which all are such
    /// that it has ([`Simulator::has_derivative`]): a row of `slopes` each.
    fn evaluate_along(
        &self,
        sizes: Sizes,
        points: &[f64],
        rates: &mut [f64],
        (entries, slopes): (&[usize], &mut [f64]),
    ) {
        let _ = (entries, slopes);
        self.evaluate_all(sizes, points, rates);
    }

    /// Number of outputs of its own, beside the state's entries and the inputs.
    fn outputs(&self) -> usize {
        0
    }

    /// These outputs at several points, as [`Simulator::evaluate_all`] does with rates.
    fn observe_all(&self, sizes: Sizes, points: &[f64], outputs: &mut [f64]) {
        let _ = (sizes, points);
        outputs.fill(f64::NAN);
    }

    /// What went wrong so far, in a sentence ([`Dynamics::trouble`]).
    fn trouble(&self) -> Option<String> {
        None
    }
}

/// The dynamics of a [`Simulator`], derivatives by differences where it has none.
#[derive(Debug)]
pub struct Differences<S>(Arc<Shared<S>>);

#[derive(Debug)]
struct Shared<S> {
    simulator: S,
    sizes: Sizes,
    /// Bits of the largest share of error. Those of numbers that are not negative are ordered as
    /// the numbers are, so that the largest does not depend on which thread comes first.
    worst: AtomicU64,
}

impl<S: Simulator> Differences<S> {
    /// The dynamics of a simulator of these sizes.
    #[must_use]
    pub fn new(simulator: S, sizes: Sizes) -> Self {
        Self(Arc::new(Shared { simulator, sizes, worst: AtomicU64::new(0) }))
    }
}

impl<S: Simulator> Dynamics for Differences<S> {
    fn sizes(&self) -> Sizes {
        self.0.sizes
    }

    fn mass(&self) -> Mass {
        self.0.simulator.mass()
    }

    fn outputs(&self) -> usize {
        self.0.simulator.outputs()
    }

    fn sharing(&self) -> Sharing {
        // As long as they are taken by way of accelerations.
        if self.0.sizes.states == 0 { Sharing::All } else { Sharing::None }
    }

    fn derivative_error(&self) -> Option<f64> {
        let Sizes { parameters, .. } = self.0.sizes;
        let entries = parameters + self.0.sizes.variables() - 1;
        let known = |k: usize| self.0.simulator.has_derivative(self.0.sizes, k);
        let worst = f64::from_bits(self.0.worst.load(Ordering::Relaxed));
        // Those by parameters that are known exactly are never asked for.
        (worst > 0.0 || !(parameters..entries).all(known)).then_some(worst)
    }

    fn trouble(&self) -> Option<String> {
        self.0.simulator.trouble()
    }

    fn bind(&self, parameters: &[f64]) -> Bound {
        Arc::new(BoundSimulator { shared: self.0.clone(), parameters: parameters.to_vec() })
    }

    fn bind_dual(&self, parameters: &[Dual]) -> Bound<Dual> {
        Arc::new(BoundSimulator { shared: self.0.clone(), parameters: parameters.to_vec() })
    }
}

impl<S: Simulator> Shared<S> {
    fn rates(&self, parameters: &[f64], variables: &[f64], rates: &mut [f64]) {
        let at = Point::new(self.sizes, parameters, variables);
        let (mass, force) = mass_and_force(self.sizes, rates);
        self.simulator.evaluate(&at, mass, force);
    }
}

#[derive(Debug)]
struct BoundSimulator<S, T> {
    shared: Arc<Shared<S>>,
    parameters: Vec<T>,
}

impl<S: Simulator> BoundDynamics<f64> for BoundSimulator<S, f64> {
    fn evaluate(&self, _room: &mut Room<f64>, variables: &[f64], rates: &mut [f64]) {
        self.shared.rates(&self.parameters, variables, rates);
    }

    fn observe(&self, variables: &[f64], outputs: &mut [f64]) {
        let point = [&self.parameters, variables].concat();
        self.shared.simulator.observe_all(self.shared.sizes, &point, outputs);
    }
}

impl<S: Simulator> BoundSimulator<S, Dual> {
    /// What a point is made of.
    fn entries<'a>(&'a self, variables: &'a [Dual]) -> impl Iterator<Item = &'a Dual> {
        self.parameters.iter().chain(variables)
    }

    /// Room for values and derivatives at points, of so many values each.
    fn nearby(&self, width: usize) -> Vec<f64> {
        let Sizes { parameters, .. } = self.shared.sizes;
        vec![0.0; Nearby::length(parameters + self.shared.sizes.variables(), width)]
    }

    /// The rates of the simulator, to be differentiated in this room.
    fn rates_near<'r>(&self, room: &'r mut [f64]) -> Nearby<'r> {
        let sizes = self.shared.sizes;
        Nearby::of(room, sizes.parameters + sizes.variables(), sizes.rates())
    }

    /// Note how wrong derivatives by these entries are.
    fn note<'a>(&self, near: &Nearby<'_>, entries: impl Iterator<Item = &'a Dual>) {
        for (entry, _) in moving(entries) {
            self.shared.worst.fetch_max(near.error_by(entry).to_bits(), Ordering::Relaxed);
        }
    }
}

/// The entries that carry derivatives, with their numbers.
fn moving<'a>(entries: impl Iterator<Item = &'a Dual>) -> impl Iterator<Item = (usize, &'a Dual)> {
    entries.enumerate().filter(|(_, x)| x.moves())
}

/// The numbers of those entries.
fn asked<'a>(entries: impl Iterator<Item = &'a Dual>) -> impl Iterator<Item = usize> {
    moving(entries).map(|(entry, _)| entry)
}

/// Values at a point, with the derivatives that its entries carry.
fn write<'a>(near: &Nearby<'_>, entries: impl Iterator<Item = &'a Dual>, values: &mut [Dual]) {
    for (to, &value) in values.iter_mut().zip(near.values()) {
        *to = Dual::constant(value);
    }
    for (entry, x) in moving(entries) {
        for (to, &slope) in values.iter_mut().zip(near.slopes_by(entry)) {
            carry(to, slope, x);
        }
    }
}

/// Add what an entry carries, times a slope.
fn carry(to: &mut Dual, slope: f64, x: &Dual) {
    for (to, from) in to.tangent.iter_mut().zip(&x.tangent) {
        *to += slope * from;
    }
}

impl<S: Simulator> BoundDynamics<Dual> for BoundSimulator<S, Dual> {
    fn room(&self) -> Room<Dual> {
        Room::new(vec![], self.nearby(self.shared.sizes.rates()))
    }

    fn evaluate(&self, room: &mut Room<Dual>, variables: &[Dual], rates: &mut [Dual]) {
        let mut near = self.rates_near(&mut room.plain);
        let entries = || self.entries(variables);
        near.begin(entries().map(|x| x.value), asked(entries()), &*self.shared);
        self.note(&near, entries());
        write(&near, entries(), rates);
    }

    fn observe(&self, variables: &[Dual], outputs: &mut [Dual]) {
        let mut room = self.nearby(outputs.len());
        let count = self.parameters.len() + variables.len();
        let mut near = Nearby::of(&mut room, count, outputs.len());
        let entries = || self.entries(variables);
        near.begin(entries().map(|x| x.value), asked(entries()), &Outputs(&self.shared));
        self.note(&near, entries());
        write(&near, entries(), outputs);
    }

    fn implicit(&self) -> Option<&dyn Implicit<Dual>> {
        (self.shared.sizes.states == 0).then_some(self)
    }
}

impl<S: Simulator> Implicit<Dual> for BoundSimulator<S, Dual> {
    fn room(&self) -> ImplicitRoom {
        let plain = self.nearby(self.shared.sizes.rates());
        ImplicitRoom { plain, ..ImplicitRoom::new(self.shared.sizes.coordinates, 0) }
    }

    fn values(&self, room: &mut ImplicitRoom, variables: &[f64], rates: &mut [f64]) {
        let mut near = self.rates_near(&mut room.plain);
        let point = self.parameters.iter().map(|p| p.value).chain(variables.iter().copied());
        // What was asked for at the points before will be asked for here.
        near.begin_as_usual(point, &*self.shared);
        rates.copy_from_slice(near.values());
    }

    fn accelerate(&self, room: &mut ImplicitRoom, _variables: &[f64], accelerations: &[f64]) {
        room.accelerations.copy_from_slice(accelerations);
    }

    fn derive(&self, room: &mut ImplicitRoom, variables: &[Dual], forces: &mut [Dual]) {
        let ImplicitRoom { plain, accelerations, .. } = room;
        let (n, entries) = (accelerations.len(), || self.entries(variables));
        let mut near = self.rates_near(plain);
        near.also(asked(entries()), &*self.shared);
        self.note(&near, entries());
        for (entry, x) in moving(entries()) {
            let (by_mass, by_force) = near.slopes_by(entry).split_at(n * n);
            for ((force, slope), row) in
                forces.iter_mut().zip(by_force).zip(by_mass.chunks_exact(n))
            {
                let held: f64 = row.iter().zip(&*accelerations).map(|(m, a)| m * a).sum();
                carry(force, slope - held, x);
            }
        }
    }
}

impl<S: Simulator> Evaluate for Shared<S> {
    fn evaluate(&self, points: &[f64], rates: &mut [f64], along: Slopes<'_>) {
        self.simulator.evaluate_along(self.sizes, points, rates, along);
    }

    fn is_known(&self, entry: usize) -> bool {
        self.simulator.has_derivative(self.sizes, entry)
    }
}

/// The outputs of a simulator's own.
struct Outputs<'a, S>(&'a Shared<S>);

impl<S: Simulator> Evaluate for Outputs<'_, S> {
    fn evaluate(&self, points: &[f64], outputs: &mut [f64], _along: Slopes<'_>) {
        self.0.simulator.observe_all(self.0.sizes, points, outputs);
    }

    fn is_known(&self, _entry: usize) -> bool {
        false
    }
}
