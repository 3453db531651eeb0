//! Dynamics written in Rust for any kind of number: derivatives are exact.

use super::{Bound, BoundDynamics, Dynamics, Mass, Point, Room, Sizes, mass_and_force};
use lacuna_numbers::{Dual, Number};
use std::fmt::Debug;
use std::sync::Arc;

/// A simulator that computes in any [`Number`].
pub trait GenericSimulator: Debug + Send + Sync + 'static {
    /// Whether it gives the mass matrix.
    fn mass(&self) -> Mass {
        Mass::Matrix
    }

    /// Mass matrix (row-major `n x n`; the identity on entry), and generalised forces followed by
    /// the rates of the first-order states (`n + s`).
    fn evaluate<T: Number>(&self, at: &Point<'_, T>, mass: &mut [T], force: &mut [T]);
}

/// The dynamics of a [`GenericSimulator`].
#[derive(Debug)]
pub struct Exact<S> {
    simulator: Arc<S>,
    sizes: Sizes,
}

impl<S: GenericSimulator> Exact<S> {
    /// The dynamics of a simulator of these sizes.
    #[must_use]
    pub fn new(simulator: S, sizes: Sizes) -> Self {
        Self { simulator: Arc::new(simulator), sizes }
    }

    fn bound<T: Number>(&self, parameters: &[T]) -> Bound<T> {
        let (simulator, sizes) = (self.simulator.clone(), self.sizes);
        Arc::new(BoundExact { simulator, sizes, parameters: parameters.to_vec() })
    }
}

impl<S: GenericSimulator> Dynamics for Exact<S> {
    fn sizes(&self) -> Sizes {
        self.sizes
    }

    fn mass(&self) -> Mass {
        self.simulator.mass()
    }

    fn bind(&self, parameters: &[f64]) -> Bound {
        self.bound(parameters)
    }

    fn bind_dual(&self, parameters: &[Dual]) -> Bound<Dual> {
        self.bound(parameters)
    }
}

#[derive(Debug)]
struct BoundExact<S, T> {
    simulator: Arc<S>,
    sizes: Sizes,
    parameters: Vec<T>,
}

impl<S: GenericSimulator, T: Number> BoundDynamics<T> for BoundExact<S, T> {
    #[inline(always)]
    fn evaluate(&self, _room: &mut Room<T>, variables: &[T], rates: &mut [T]) {
        let at = Point::new(self.sizes, &self.parameters, variables);
        let (mass, force) = mass_and_force(self.sizes, rates);
        self.simulator.evaluate(&at, mass, force);
    }
}
