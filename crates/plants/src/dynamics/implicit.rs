//! Derivatives of accelerations by way of `M a - F`, the accelerations a held.
//!
//! ```text
//! M a = F   =>   M a' = F' - M' a
//! ```
//!
//! What is on the right is linear in the directions of derivatives, and M is that of the values alone: what the
//! values and their derivatives by coordinates and velocities cost is paid once, however many directions
//! there are.

use lacuna_numbers::Number;
use lacuna_rigid::Motion;
use std::fmt::Debug;

/// Dynamics without first-order states whose derivatives are taken so.
pub trait Implicit<T: Number>: Debug + Send + Sync {
    /// Room to be asked in: made once, used for every sample of a simulation.
    fn room(&self) -> ImplicitRoom;

    /// Mass matrix and forces as [`super::BoundDynamics::evaluate`] has them, in plain numbers.
    fn values(&self, room: &mut ImplicitRoom, variables: &[f64], rates: &mut [f64]);

    /// Be told the accelerations at the variables of which the values were last asked.
    fn accelerate(&self, room: &mut ImplicitRoom, variables: &[f64], accelerations: &[f64]);

    /// Add the derivatives of `F - M a`, along those that the variables and this one's parameters carry, to
    /// what `forces` carry; their values come to mean nothing. The room may be that of dynamics of
    /// the same values that carry other directions, and keeps what is found on the way.
    fn derive(&self, room: &mut ImplicitRoom, variables: &[T], forces: &mut [T]);
}

/// Room for [`Implicit`]: made once, used for every sample of a simulation.
#[derive(Clone, Debug, Default)]
pub struct ImplicitRoom {
    /// How the bodies move.
    pub(super) motion: Motion,
    pub(super) accelerations: Vec<f64>,
    /// Derivatives of `M a - F` by coordinates and by velocities (row-major, `n x n`).
    pub(super) by_coordinates: Vec<f64>,
    pub(super) by_velocities: Vec<f64>,
    /// Where differences are taken.
    pub(super) plain: Vec<f64>,
}

impl ImplicitRoom {
    /// For `n` coordinates of so many bodies.
    #[must_use]
    pub fn new(n: usize, bodies: usize) -> Self {
        Self {
            motion: Motion::new(bodies),
            accelerations: vec![0.0; n],
            by_coordinates: vec![0.0; n * n],
            by_velocities: vec![0.0; n * n],
            plain: vec![],
        }
    }
}
