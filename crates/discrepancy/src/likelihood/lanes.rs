//! Plain numbers side by side.

use lacuna_numbers::{LANES, Linear};
use pulp::Simd;
use std::ops::{Add, Mul, Sub};

/// [`LANES`] numbers to which the same is done: one vector of the widest machines.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(align(64))]
pub struct Lanes(pub [f64; LANES]);

impl Lanes {
    /// Add `factor` times another, lane by lane.
    #[inline(always)]
    pub fn add_scaled<S: Simd>(&mut self, simd: S, other: &Self, factor: f64) {
        let factor = simd.splat_f64s(factor);
        let (sums, _) = S::as_mut_simd_f64s(&mut self.0);
        for (sum, x) in sums.iter_mut().zip(S::as_simd_f64s(&other.0).0) {
            *sum = simd.mul_add_e_f64s(factor, *x, *sum);
        }
    }

    /// Add the products of two others, lane by lane.
    #[inline(always)]
    pub fn add_product<S: Simd>(&mut self, simd: S, a: &Self, b: &Self) {
        let factors = S::as_simd_f64s(&a.0).0.iter().zip(S::as_simd_f64s(&b.0).0);
        for (sum, (a, b)) in S::as_mut_simd_f64s(&mut self.0).0.iter_mut().zip(factors) {
            *sum = simd.mul_add_e_f64s(*a, *b, *sum);
        }
    }

    /// A function of each.
    #[inline(always)]
    pub fn map(self, f: impl Fn(f64) -> f64) -> Self {
        Self(self.0.map(f))
    }
}

impl Add for Lanes {
    type Output = Self;

    #[inline(always)]
    fn add(self, other: Self) -> Self {
        Self(std::array::from_fn(|l| self.0[l] + other.0[l]))
    }
}

impl Sub for Lanes {
    type Output = Self;

    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        Self(std::array::from_fn(|l| self.0[l] - other.0[l]))
    }
}

impl Mul for Lanes {
    type Output = Self;

    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        Self(std::array::from_fn(|l| self.0[l] * other.0[l]))
    }
}

impl Mul<f64> for Lanes {
    type Output = Self;

    #[inline(always)]
    fn mul(self, factor: f64) -> Self {
        self.map(|x| x * factor)
    }
}

impl Linear for Lanes {
    const ZERO: Self = Self([0.0; LANES]);

    #[inline(always)]
    fn by_itself() {
        std::hint::black_box(());
    }
}

#[cfg(test)]
mod tests {
    use super::Lanes;
    use lacuna_numbers::{LANES, Linear};
    use pulp::{Arch, Simd, WithSimd};

    struct Sums(Lanes, Lanes);

    impl WithSimd for Sums {
        type Output = Lanes;

        fn with_simd<S: Simd>(self, simd: S) -> Lanes {
            let mut sum = self.0;
            sum.add_scaled(simd, &self.1, 2.0);
            sum.add_product(simd, &self.0, &self.1);
            sum
        }
    }

    /// Small whole numbers: exact however wide the machine's vectors are.
    #[test]
    fn sums_are_those_of_plain_numbers() {
        let a = Lanes(std::array::from_fn(|l| l as f64));
        let b = Lanes(std::array::from_fn(|l| 3.0 - l as f64));
        let expected: [f64; LANES] =
            std::array::from_fn(|l| a.0[l] + 2.0 * b.0[l] + a.0[l] * b.0[l]);
        assert_eq!(Arch::new().dispatch(Sums(a, b)).0, expected);
        assert_eq!((a + b * 2.0 + Lanes::ZERO).0[5], 5.0 - 4.0);
    }
}
