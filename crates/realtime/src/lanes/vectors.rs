//! Vector instructions, chosen at run time.

use pulp::{Arch, Simd, WithSimd};

use super::{Dispatch, Lanes, OnLanes, Plain};
use crate::LANES;

/// The widest vectors that the processor has. To find out takes as long as a small evaluation, so that it is kept.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Detected(Arch);

impl Detected {
    /// Asks the processor.
    pub fn new() -> Self {
        Self(Arch::new())
    }
}

impl Dispatch for Detected {
    #[inline(always)]
    fn dispatch(self, operation: impl OnLanes) {
        match self.0 {
            // Its fused multiply-and-add is a slow call.
            Arch::Scalar => operation.run(Plain),
            arch => arch.dispatch(Dispatched(operation)),
        }
    }
}

struct Dispatched<O>(O);

impl<O: OnLanes> WithSimd for Dispatched<O> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        match S::F64_LANES {
            8 => self.0.run(Vectors::<S, 1>(simd)),
            4 => self.0.run(Vectors::<S, 2>(simd)),
            2 => self.0.run(Vectors::<S, 4>(simd)),
            _ => self.0.run(Plain),
        }
    }
}

/// N vectors that hold eight numbers together.
#[derive(Clone, Copy)]
struct Vectors<S, const N: usize>(S);

impl<S: Simd, const N: usize> Lanes for Vectors<S, N> {
    type V = [S::f64s; N];

    #[inline(always)]
    fn splat(self, value: f64) -> Self::V {
        [self.0.splat_f64s(value); N]
    }

    #[inline(always)]
    fn load(self, values: &[f64; LANES]) -> Self::V {
        let (vectors, _) = S::as_simd_f64s(values);
        let mut loaded = self.splat(0.0);
        loaded.iter_mut().zip(vectors).for_each(|(to, from)| *to = *from);
        loaded
    }

    #[inline(always)]
    fn store(self, values: Self::V) -> [f64; LANES] {
        let mut stored = [0.0; LANES];
        let (vectors, _) = S::as_mut_simd_f64s(&mut stored);
        vectors.iter_mut().zip(values).for_each(|(to, from)| *to = from);
        stored
    }

    #[inline(always)]
    fn add(self, mut a: Self::V, b: Self::V) -> Self::V {
        a.iter_mut().zip(b).for_each(|(a, b)| *a = self.0.add_f64s(*a, b));
        a
    }

    #[inline(always)]
    fn sub(self, mut a: Self::V, b: Self::V) -> Self::V {
        a.iter_mut().zip(b).for_each(|(a, b)| *a = self.0.sub_f64s(*a, b));
        a
    }

    #[inline(always)]
    fn mul(self, mut a: Self::V, b: Self::V) -> Self::V {
        a.iter_mut().zip(b).for_each(|(a, b)| *a = self.0.mul_f64s(*a, b));
        a
    }

    #[inline(always)]
    fn mul_add(self, mut a: Self::V, b: Self::V, c: Self::V) -> Self::V {
        let entries = a.iter_mut().zip(b).zip(c);
        entries.for_each(|((a, b), c)| *a = self.0.mul_add_f64s(*a, b, c));
        a
    }

    #[inline(always)]
    fn clamp(self, mut a: Self::V, lower: f64, upper: f64) -> Self::V {
        let (lower, upper) = (self.0.splat_f64s(lower), self.0.splat_f64s(upper));
        for a in &mut a {
            // The bound first: what is no number stays so on x86, where the second operand wins.
            *a = self.0.min_f64s(upper, self.0.max_f64s(lower, *a));
        }
        a
    }

    #[inline(always)]
    fn sqrt(self, mut a: Self::V) -> Self::V {
        a.iter_mut().for_each(|a| *a = self.0.sqrt_f64s(*a));
        a
    }

    #[inline(always)]
    fn times_power_of_two(self, mut a: Self::V, shifted: Self::V) -> Self::V {
        // There is no shift of these vectors; the compiler makes one of the loop.
        let exponents = self.store(shifted).map(|s| f64::from_bits(s.to_bits() << 52));
        let simd = self.0;
        for (a, exponent) in a.iter_mut().zip(self.load(&exponents)) {
            let (power, exponent) =
                (simd.transmute_u64s_f64s(*a), simd.transmute_u64s_f64s(exponent));
            *a = simd.transmute_f64s_u64s(simd.add_u64s(power, exponent));
        }
        a
    }
}
