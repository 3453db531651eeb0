//! Closures as simulators.

use super::{Mass, Point, Simulator};
use std::fmt;

/// A closure that gives accelerations, then the rates of the first-order states.
pub(crate) struct Rates<F>(pub F);

impl<F> fmt::Debug for Rates<F> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("a closure of rates")
    }
}

impl<F, R> Simulator for Rates<F>
where
    F: Fn(&Point<'_>) -> R + Send + Sync + 'static,
    R: AsRef<[f64]>,
{
    fn mass(&self) -> Mass {
        Mass::Unit
    }

    fn evaluate(&self, at: &Point<'_>, _mass: &mut [f64], force: &mut [f64]) {
        fill(force, (self.0)(at).as_ref());
    }
}

/// A closure for the mass matrix, and one for generalised forces and rates.
pub(crate) struct Mechanics<M, F> {
    pub mass: M,
    pub force: F,
}

impl<M, F> fmt::Debug for Mechanics<M, F> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("closures of a mass matrix and forces")
    }
}

impl<M, F, A, B> Simulator for Mechanics<M, F>
where
    M: Fn(&Point<'_>) -> A + Send + Sync + 'static,
    F: Fn(&Point<'_>) -> B + Send + Sync + 'static,
    A: AsRef<[f64]>,
    B: AsRef<[f64]>,
{
    fn mass(&self) -> Mass {
        Mass::Matrix
    }

    fn evaluate(&self, at: &Point<'_>, mass: &mut [f64], force: &mut [f64]) {
        fill(mass, (self.mass)(at).as_ref());
        fill(force, (self.force)(at).as_ref());
    }
}

/// What a closure gave; nothing that can be simulated where it is not of the length that it had
/// when the model was built.
fn fill(to: &mut [f64], from: &[f64]) {
    if to.len() == from.len() {
        to.copy_from_slice(from);
    } else {
        to.fill(f64::NAN);
    }
}
