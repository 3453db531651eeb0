//! Laws: what an effect does, written once for every kind of number.
//!
//! A law is a type with one of the traits [`ForceLaw`], [`SeriesLaw`] and [`StructureLaw`]; its
//! functions are generic over [`Number`], so that its derivatives by state, memory, shape,
//! amplitudes and inputs are exact. The catalogue holds laws behind [`Law`], whose traits name
//! the kinds of numbers that there are.

use crate::At;
use lacuna_numbers::{Dual, Number};
use std::fmt::Debug;

/// The law of an effect.
#[derive(Clone, Copy, Debug)]
pub enum Law {
    /// A generalised force.
    Force(&'static dyn AnyForceLaw),
    /// What the actuator makes of a command.
    Input(&'static dyn AnySeriesLaw),
    /// What the sensor makes of a coordinate.
    Sensor(&'static dyn AnySeriesLaw),
    /// What a robot is made of, or how it stands.
    Structure(&'static dyn AnyStructureLaw),
}

/// A generalised force `r = sum_k a_k (b_k - m_k q'')`, linear in its amplitudes a.
pub trait ForceLaw: Sync + Debug {
    /// Number of amplitudes: the first entries of the internal parameters.
    fn amplitudes(&self) -> usize {
        1
    }

    /// The force b per unit of each amplitude, that of its inertia apart.
    fn basis<T: Number>(&self, shape: &[T], at: &At<T>) -> impl AsRef<[T]>;

    /// The inertia m per unit of each amplitude, which adds to the channel's entry of the mass
    /// matrix; empty for a law that does not depend on the acceleration.
    fn inertia<T: Number>(&self, _shape: &[T], _at: &At<T>) -> impl AsRef<[T]> {
        [] as [T; 0]
    }

    /// Whether it is steep about rest, and smooth elsewhere: dry friction.
    fn is_dry(&self) -> bool {
        false
    }

    /// How steeply the force falls with the channel's velocity, `-dr/dv`, where steps of Runge-Kutta would have to be short
    /// for that alone: dry friction about rest. What varies slowly beside it may be left out; 0 of what is smooth.
    fn steepness<T: Number>(&self, _amplitudes: &[T], _shape: &[T], _at: &At<T>) -> f64 {
        0.0
    }

    /// The sum of amplitudes times basis.
    #[inline(always)]
    fn force<T: Number>(&self, amplitudes: &[T], shape: &[T], at: &At<T>) -> T {
        sum_of_products(amplitudes, self.basis(shape, at).as_ref())
    }

    /// Internal parameters (amplitudes, then shape) of physical ones.
    fn internal(&self, physical: &[f64]) -> Vec<f64> {
        physical.to_vec()
    }

    /// Physical parameters of internal ones.
    fn physical(&self, internal: &[f64]) -> Vec<f64> {
        internal.to_vec()
    }

    /// Number of memory states.
    fn memory(&self) -> usize {
        0
    }

    /// Memory at rest at `at`.
    fn memory_at_rest(&self, _at: &At, memory: &mut [f64]) {
        memory.fill(0.0);
    }

    /// Time derivative of the memory.
    fn memory_rate<T: Number>(&self, _shape: &[T], _at: &At<T>) -> impl AsRef<[T]> {
        [] as [T; 0]
    }

    /// Whether the opposite force acts on the other channels (actio and reactio).
    fn reacts(&self) -> bool {
        false
    }

    /// The share of the force whose opposite acts there: all of it, unless some is lost on the way.
    fn passed_on<T: Number>(&self, _shape: &[T]) -> T {
        T::constant(1.0)
    }
}

#[inline(always)]
fn sum_of_products<T: Number>(a: &[T], b: &[T]) -> T {
    a.iter().zip(b).fold(T::constant(0.0), |sum, (a, b)| sum + *a * *b)
}

/// A force law in one kind of number.
pub trait ForceLawIn<T: Number>: Sync + Debug {
    /// The sum of amplitudes times basis, inertia apart.
    fn force(&self, amplitudes: &[T], shape: &[T], at: &At<T>) -> T;

    /// See [`ForceLaw::is_dry`].
    fn is_dry(&self) -> bool;

    /// See [`ForceLaw::steepness`].
    fn steepness(&self, amplitudes: &[T], shape: &[T], at: &At<T>) -> f64;

    /// The sum of amplitudes times inertia: what adds to the mass matrix.
    fn inertia(&self, amplitudes: &[T], shape: &[T], at: &At<T>) -> T;

    /// The force per unit of each amplitude along a given motion, that of inertia included.
    fn along(&self, shape: &[T], at: &At<T>, basis: &mut [T]);

    /// The same at every sample of a motion, one series an amplitude. Memory starts as it is at the
    /// first sample and is integrated along the motion.
    fn series(&self, shape: &[T], motion: &[At<T>], series: &mut [Vec<T>]);

    /// Time derivative of the memory.
    fn memory_rate(&self, shape: &[T], at: &At<T>, rate: &mut [T]);

    /// See [`ForceLaw::passed_on`].
    fn passed_on(&self, shape: &[T]) -> T;
}

/// The force of a law at one point, to be compiled for every width of vectors: the lanes of dual
/// numbers fill the widest, and what is handed on in pieces as wide as the next operation reads it
/// is there at once.
struct ForceAt<'a, L, T> {
    law: &'a L,
    amplitudes: &'a [T],
    shape: &'a [T],
    at: &'a At<'a, T>,
}

impl<L: ForceLaw, T: Number> pulp::WithSimd for ForceAt<'_, L, T> {
    type Output = T;

    #[inline(always)]
    fn with_simd<S: pulp::Simd>(self, _simd: S) -> T {
        ForceLaw::force(self.law, self.amplitudes, self.shape, self.at)
    }
}

impl<L: ForceLaw, T: Number> ForceLawIn<T> for L {
    fn force(&self, amplitudes: &[T], shape: &[T], at: &At<T>) -> T {
        if T::CARRIES {
            return pulp::Arch::new().dispatch(ForceAt { law: self, amplitudes, shape, at });
        }
        ForceLaw::force(self, amplitudes, shape, at)
    }

    fn is_dry(&self) -> bool {
        ForceLaw::is_dry(self)
    }

    fn steepness(&self, amplitudes: &[T], shape: &[T], at: &At<T>) -> f64 {
        ForceLaw::steepness(self, amplitudes, shape, at)
    }

    fn inertia(&self, amplitudes: &[T], shape: &[T], at: &At<T>) -> T {
        sum_of_products(amplitudes, ForceLaw::inertia(self, shape, at).as_ref())
    }

    fn along(&self, shape: &[T], at: &At<T>, basis: &mut [T]) {
        basis.copy_from_slice(self.basis(shape, at).as_ref());
        let inertia = ForceLaw::inertia(self, shape, at);
        for (b, m) in basis.iter_mut().zip(inertia.as_ref()) {
            *b = *b - *m * at.acceleration;
        }
    }

    fn series(&self, shape: &[T], motion: &[At<T>], series: &mut [Vec<T>]) {
        let Some(first) = motion.first() else { return };
        let mut basis = vec![T::constant(0.0); series.len()];
        let mut memory = Memory::beginning(first);
        for (k, at) in motion.iter().enumerate() {
            let at = At { memory: &memory.now, ..*at };
            ForceLawIn::along(self, shape, &at, &mut basis);
            series.iter_mut().zip(&basis).for_each(|(series, value)| series.push(*value));
            if let Some(next) = motion.get(k + 1).filter(|_| !first.memory.is_empty()) {
                memory.advance(self, shape, (&motion[k], next));
            }
        }
    }

    fn memory_rate(&self, shape: &[T], at: &At<T>, rate: &mut [T]) {
        rate.copy_from_slice(ForceLaw::memory_rate(self, shape, at).as_ref());
    }

    fn passed_on(&self, shape: &[T]) -> T {
        ForceLaw::passed_on(self, shape)
    }
}

/// A law's memory on its way along a motion.
struct Memory<T> {
    now: Vec<T>,
    middle: Vec<T>,
    rate: Vec<T>,
    state: Vec<T>,
}

impl<T: Number> Memory<T> {
    fn beginning(at: &At<T>) -> Self {
        let room = || at.memory.to_vec();
        Self { now: room(), middle: room(), rate: room(), state: at.state.to_vec() }
    }

    /// From one sample to the next by the midpoint rule.
    #[inline(always)]
    fn advance<L: ForceLaw>(&mut self, law: &L, shape: &[T], way: (&At<T>, &At<T>)) {
        const STEPS: usize = 4;
        let h = (way.1.t - way.0.t) / STEPS as f64;
        for k in 0..STEPS {
            let begin = k as f64 / STEPS as f64;
            self.middle.copy_from_slice(&self.now);
            self.rate(law, shape, way, begin);
            for (z, r) in self.middle.iter_mut().zip(&self.rate) {
                *z = *z + *r * (0.5 * h);
            }
            self.rate(law, shape, way, begin + 0.5 / STEPS as f64);
            for (z, r) in self.now.iter_mut().zip(&self.rate) {
                *z = *z + *r * h;
            }
        }
    }

    /// The rate of what is in the middle after a share of the way between two samples, along a
    /// straight line.
    #[inline(always)]
    fn rate<L: ForceLaw>(
        &mut self,
        law: &L,
        shape: &[T],
        (from, to): (&At<T>, &At<T>),
        share: f64,
    ) {
        let Self { middle, rate, state, .. } = self;
        for (x, (a, b)) in state.iter_mut().zip(from.state.iter().zip(to.state)) {
            *x = *a + (*b - *a) * share;
        }
        let t = from.t + share * (to.t - from.t);
        let at = At { t, state, memory: middle, ..*from };
        rate.copy_from_slice(law.memory_rate(shape, &at).as_ref());
    }
}

/// A force law in every kind of number.
pub trait AnyForceLaw: ForceLawIn<f64> + ForceLawIn<Dual> {
    /// See [`ForceLaw::amplitudes`].
    fn amplitudes(&self) -> usize;
    /// See [`ForceLaw::internal`].
    fn internal(&self, physical: &[f64]) -> Vec<f64>;
    /// See [`ForceLaw::physical`].
    fn physical(&self, internal: &[f64]) -> Vec<f64>;
    /// See [`ForceLaw::memory`].
    fn memory(&self) -> usize;
    /// See [`ForceLaw::memory_at_rest`].
    fn memory_at_rest(&self, at: &At, memory: &mut [f64]);
    /// See [`ForceLaw::reacts`].
    fn reacts(&self) -> bool;
    /// The law in plain numbers.
    fn plain(&self) -> &dyn ForceLawIn<f64>;
    /// The law in dual numbers.
    fn dual(&self) -> &dyn ForceLawIn<Dual>;
}

impl<L: ForceLaw> AnyForceLaw for L {
    fn amplitudes(&self) -> usize {
        ForceLaw::amplitudes(self)
    }

    fn internal(&self, physical: &[f64]) -> Vec<f64> {
        ForceLaw::internal(self, physical)
    }

    fn physical(&self, internal: &[f64]) -> Vec<f64> {
        ForceLaw::physical(self, internal)
    }

    fn memory(&self) -> usize {
        ForceLaw::memory(self)
    }

    fn memory_at_rest(&self, at: &At, memory: &mut [f64]) {
        ForceLaw::memory_at_rest(self, at, memory);
    }

    fn reacts(&self) -> bool {
        ForceLaw::reacts(self)
    }

    fn plain(&self) -> &dyn ForceLawIn<f64> {
        self
    }

    fn dual(&self) -> &dyn ForceLawIn<Dual> {
        self
    }
}

/// What an actuator makes of the commanded series, or a sensor of the true one.
pub trait SeriesLaw: Sync + Debug {
    /// What becomes of a series at `times`, which increase. Inputs are held from each sample to
    /// the next: an actuator's effective value is the mean over each step.
    fn applied<T: Number>(&self, parameters: &[T], times: &[f64], series: &[T]) -> Vec<T>;
}

/// A law of a series in one kind of number.
pub trait SeriesLawIn<T: Number>: Sync + Debug {
    /// See [`SeriesLaw::applied`].
    fn applied(&self, parameters: &[T], times: &[f64], series: &[T]) -> Vec<T>;
}

impl<L: SeriesLaw, T: Number> SeriesLawIn<T> for L {
    fn applied(&self, parameters: &[T], times: &[f64], series: &[T]) -> Vec<T> {
        SeriesLaw::applied(self, parameters, times, series)
    }
}

/// A law of a series in every kind of number.
pub trait AnySeriesLaw: SeriesLawIn<f64> + SeriesLawIn<Dual> {
    /// The law in plain numbers.
    fn plain(&self) -> &dyn SeriesLawIn<f64>;
    /// The law in dual numbers.
    fn dual(&self) -> &dyn SeriesLawIn<Dual>;
}

impl<L: SeriesLaw> AnySeriesLaw for L {
    fn plain(&self) -> &dyn SeriesLawIn<f64> {
        self
    }

    fn dual(&self) -> &dyn SeriesLawIn<Dual> {
        self
    }
}

/// What a robot is made of, or how it stands: numbers that its dynamics do not have from the model, of
/// which all forces and the mass matrix follow.
///
/// | acts on | numbers |
/// | --- | --- |
/// | [`Acts::Links`](crate::Acts::Links) | [`BODY`] that add to the link's: mass m (kg), first moment m c (kg m), inertia about the origin of the link's frame (kg m^2): xx, xy, xz, yy, yz, zz |
/// | [`Acts::Base`](crate::Acts::Base) | [`TILT`]: roll and pitch of the base against how it stands in the model (rad) |
///
/// Their internal parameters are the physical ones, amplitudes first: in these the numbers are linear,
/// at least where they are small, and 0 where all of them are.
pub trait StructureLaw: Sync + Debug {
    /// Number of amplitudes: the first of the parameters.
    fn amplitudes(&self) -> usize;

    /// The numbers.
    fn numbers<T: Number>(&self, parameters: &[T]) -> impl AsRef<[T]>;
}

/// Numbers that a link's inertia is made of.
pub const BODY: usize = 10;
/// Numbers that say how a base stands.
pub const TILT: usize = 2;

/// A law of structure in one kind of number.
pub trait StructureLawIn<T: Number>: Sync + Debug {
    /// See [`StructureLaw::numbers`].
    fn numbers(&self, parameters: &[T]) -> Vec<T>;
}

impl<L: StructureLaw, T: Number> StructureLawIn<T> for L {
    fn numbers(&self, parameters: &[T]) -> Vec<T> {
        StructureLaw::numbers(self, parameters).as_ref().to_vec()
    }
}

/// A law of structure in every kind of number.
pub trait AnyStructureLaw: StructureLawIn<f64> + StructureLawIn<Dual> {
    /// See [`StructureLaw::amplitudes`].
    fn amplitudes(&self) -> usize;
    /// The law in plain numbers.
    fn plain(&self) -> &dyn StructureLawIn<f64>;
    /// The law in dual numbers.
    fn dual(&self) -> &dyn StructureLawIn<Dual>;
}

impl<L: StructureLaw> AnyStructureLaw for L {
    fn amplitudes(&self) -> usize {
        StructureLaw::amplitudes(self)
    }

    fn plain(&self) -> &dyn StructureLawIn<f64> {
        self
    }

    fn dual(&self) -> &dyn StructureLawIn<Dual> {
        self
    }
}
