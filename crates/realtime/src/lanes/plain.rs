//! Plain loops, for any processor.

use super::{Dispatch, Lanes, OnLanes};
use crate::LANES;

/// Arrays of eight numbers.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Plain;

#[cfg(not(feature = "std"))]
impl Plain {
    /// There is nothing to ask.
    pub const fn new() -> Self {
        Self
    }
}

impl Dispatch for Plain {
    #[inline(always)]
    fn dispatch(self, operation: impl OnLanes) {
        operation.run(self);
    }
}

#[inline(always)]
fn each(f: impl Fn(usize) -> f64) -> [f64; LANES] {
    core::array::from_fn(f)
}

impl Lanes for Plain {
    type V = [f64; LANES];

    #[inline(always)]
    fn splat(self, value: f64) -> Self::V {
        [value; LANES]
    }

    #[inline(always)]
    fn load(self, values: &[f64; LANES]) -> Self::V {
        *values
    }

    #[inline(always)]
    fn store(self, values: Self::V) -> [f64; LANES] {
        values
    }

    #[inline(always)]
    fn add(self, a: Self::V, b: Self::V) -> Self::V {
        each(|i| a[i] + b[i])
    }

    #[inline(always)]
    fn sub(self, a: Self::V, b: Self::V) -> Self::V {
        each(|i| a[i] - b[i])
    }

    #[inline(always)]
    fn mul(self, a: Self::V, b: Self::V) -> Self::V {
        each(|i| a[i] * b[i])
    }

    /// Rounded twice: a fused one is a slow call where the processor has none.
    #[inline(always)]
    fn mul_add(self, a: Self::V, b: Self::V, c: Self::V) -> Self::V {
        each(|i| a[i] * b[i] + c[i])
    }

    #[inline(always)]
    fn clamp(self, a: Self::V, lower: f64, upper: f64) -> Self::V {
        each(|i| a[i].clamp(lower, upper))
    }

    #[inline(always)]
    fn sqrt(self, a: Self::V) -> Self::V {
        #[cfg(feature = "std")]
        return each(|i| a[i].sqrt());
        #[cfg(not(feature = "std"))]
        return each(|i| libm::sqrt(a[i]));
    }

    #[inline(always)]
    fn times_power_of_two(self, a: Self::V, shifted: Self::V) -> Self::V {
        // The integer goes into the exponent bits.
        each(|i| f64::from_bits(a[i].to_bits().wrapping_add(shifted[i].to_bits() << 52)))
    }
}
