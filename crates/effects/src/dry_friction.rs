//! What the laws of dry friction share: `-F tanh(v / smoothing_velocity)`, F being what each is about.

use crate::{At, Dimension, Family, ForceLaw, Number, Parameter, Prior, Range, Scales};
use std::fmt::Debug;

/// The laws of dry friction. Their shared numbers: [`shared`].
pub(crate) static FAMILY: Family = Family { words: "dry friction" };

/// The family's shared numbers: mean magnitude, half of what the backward one is larger than the
/// forward one, smoothing velocity.
pub(crate) fn shared(magnitude: f64, offset: f64, smoothing_velocity: f64) -> Vec<f64> {
    vec![magnitude, offset, smoothing_velocity]
}

/// A law of dry friction, linear in N amplitudes.
pub(crate) trait DryFriction<const N: usize>: Sync + Debug {
    /// Where the smoothing velocity stands in the shape.
    const SMOOTHING: usize;

    /// F per unit of each amplitude.
    fn magnitudes<T: Number>(&self, shape: &[T], at: &At<T>) -> [T; N];

    /// The velocity v of what rubs.
    #[inline(always)]
    fn sliding<T: Number>(&self, _shape: &[T], at: &At<T>) -> T {
        at.v()
    }

    /// See [`ForceLaw::internal`].
    fn internal(&self, physical: &[f64]) -> Vec<f64> {
        physical.to_vec()
    }

    /// See [`ForceLaw::physical`].
    fn physical(&self, internal: &[f64]) -> Vec<f64> {
        internal.to_vec()
    }

    /// See [`ForceLaw::reacts`].
    fn reacts(&self) -> bool {
        false
    }

    /// See [`ForceLaw::passed_on`].
    fn passed_on<T: Number>(&self, _shape: &[T]) -> T {
        T::constant(1.0)
    }
}

/// A force law that is one of dry friction.
#[derive(Debug)]
pub(crate) struct Dry<L, const N: usize>(pub L);

impl<const N: usize, L: DryFriction<N>> ForceLaw for Dry<L, N> {
    fn amplitudes(&self) -> usize {
        N
    }

    #[inline(always)]
    fn basis<T: Number>(&self, shape: &[T], at: &At<T>) -> impl AsRef<[T]> {
        let sign = (self.0.sliding(shape, at) / shape[L::SMOOTHING]).tanh();
        self.0.magnitudes(shape, at).map(|f| -(f * sign))
    }

    fn is_dry(&self) -> bool {
        true
    }

    #[inline(always)]
    fn steepness<T: Number>(&self, amplitudes: &[T], shape: &[T], at: &At<T>) -> f64 {
        /// Beyond so many smoothing velocities tanh is 1 as far as a double tells.
        const SATURATED: f64 = 20.0;
        let smoothing = shape[L::SMOOTHING].value();
        let share = self.0.sliding(shape, at).value() / smoothing;
        if share.abs() > SATURATED {
            return 0.0;
        }
        let magnitudes = amplitudes.iter().zip(self.0.magnitudes(shape, at));
        let magnitude: f64 = magnitudes.map(|(a, f)| a.value() * f.value()).sum();
        magnitude / (smoothing * share.cosh().powi(2))
    }

    fn internal(&self, physical: &[f64]) -> Vec<f64> {
        self.0.internal(physical)
    }

    fn physical(&self, internal: &[f64]) -> Vec<f64> {
        self.0.physical(internal)
    }

    fn reacts(&self) -> bool {
        self.0.reacts()
    }

    fn passed_on<T: Number>(&self, shape: &[T]) -> T {
        self.0.passed_on(shape)
    }
}

/// Default of `smoothing_velocity`: sharp for a machine that moves at about one unit a second.
pub(crate) const SMOOTHING_VELOCITY: Parameter =
    Parameter::new("smoothing_velocity", Dimension::VELOCITY, Range::Positive)
        .or(1e-3)
        .of_the_formula();

/// Smoothing velocities to begin from.
pub(crate) fn smoothing_velocities(scales: &Scales) -> [f64; 3] {
    [0.01, 0.04, 0.15].map(|share| share * scales.v)
}

/// Prior of a smoothing velocity.
pub(crate) fn smoothing_prior(scales: &Scales) -> Prior {
    Prior::order(0.03 * scales.v, 2.5, (1e-5 * scales.v, 0.4 * scales.v))
}
