//! The exponential function.
//!
//! x = n ln 2 + r with |r| <= ln 2 / 2; e^r = 1 + r + r^2 q(r) with q of degree 9 through the Chebyshev nodes (relative
//! error of the polynomial 2e-17); 2^n goes into the exponent bits.

use std::f64::consts::LOG2_E;

use pulp::{Simd, bytemuck};

/// Here the exponent bits are those of what is no number.
const OVERFLOWS: f64 = 710.0;
const SMALLEST: f64 = -707.0;
/// Adding 1.5 * 2^52 rounds to an integer and leaves it in the low bits.
const ROUND: f64 = 6_755_399_441_055_744.0;
/// ln 2 in two parts, the first with trailing zeros so that n times it is exact.
const LN_2_HIGH: f64 = 0.693_147_180_369_123_8;
const LN_2_LOW: f64 = 1.908_214_929_270_587_7e-10;
/// Coefficients of q, constant term first.
const COEFFICIENTS: [f64; 10] = [
    0.500_000_000_000_000_1,
    0.166_666_666_666_666_69,
    0.041_666_666_666_624_16,
    0.008_333_333_333_330_065,
    0.001_388_888_891_719_841_9,
    0.000_198_412_698_630_418_51,
    2.480_152_131_972_762e-5,
    2.755_726_847_827_900_4e-6,
    2.762_007_713_646_922e-7,
    2.510_037_679_881_25e-8,
];

/// e^x of every lane. Within 2 units in the last place; below e^-707 it stays at that, and what overflows is no number.
#[inline(always)]
pub(super) fn exponential<S: Simd>(simd: S, x: S::f64s) -> S::f64s {
    let above = simd.splat_f64s(OVERFLOWS);
    if S::IS_SCALAR {
        let overflows = simd.greater_than_f64s(x, above);
        return decay(simd, simd.select_f64s(overflows, above, x));
    }
    decay(simd, simd.min_f64s(above, x))
}

/// The same for x <= 0.
#[inline(always)]
pub(super) fn decay<S: Simd>(simd: S, x: S::f64s) -> S::f64s {
    let least = simd.splat_f64s(SMALLEST);
    if S::IS_SCALAR {
        let normal = simd.less_than_f64s(x, least);
        return reduced(simd, simd.select_f64s(normal, least, x));
    }
    // In this order a lane that is no number stays none, in one instruction.
    reduced(simd, simd.max_f64s(least, x))
}

#[inline(always)]
fn reduced<S: Simd>(simd: S, x: S::f64s) -> S::f64s {
    let shifted = simd.mul_add_e_f64s(x, simd.splat_f64s(LOG2_E), simd.splat_f64s(ROUND));
    let n = simd.sub_f64s(shifted, simd.splat_f64s(ROUND));
    let r = simd.mul_add_e_f64s(n, simd.splat_f64s(-LN_2_HIGH), x);
    let r = simd.mul_add_e_f64s(n, simd.splat_f64s(-LN_2_LOW), r);
    let power = power(simd, r);
    let bits = simd.transmute_u64s_f64s(power);
    let exponent = into_exponent(simd, simd.transmute_u64s_f64s(shifted));
    simd.transmute_f64s_u64s(simd.add_u64s(bits, exponent))
}

/// e^r = 1 + (r + r^2 q(r)) by Estrin's scheme: two operations more than Horner's, but a chain of half the length, and
/// processors have room for few of these chains at a time.
#[inline(always)]
fn power<S: Simd>(simd: S, r: S::f64s) -> S::f64s {
    let square = simd.mul_f64s(r, r);
    let fourth = simd.mul_f64s(square, square);
    let mut pairs = [r; 5];
    for (k, pair) in pairs.iter_mut().enumerate() {
        let (low, high) = (COEFFICIENTS[2 * k], COEFFICIENTS[2 * k + 1]);
        *pair = simd.mul_add_e_f64s(simd.splat_f64s(high), r, simd.splat_f64s(low));
    }
    let low = simd.mul_add_e_f64s(pairs[1], square, pairs[0]);
    let middle = simd.mul_add_e_f64s(pairs[3], square, pairs[2]);
    let high = simd.mul_add_e_f64s(pairs[4], fourth, middle);
    let q = simd.mul_add_e_f64s(high, fourth, low);
    simd.add_f64s(simd.splat_f64s(1.0), simd.mul_add_e_f64s(q, square, r))
}

/// Shifts the integer in the low bits into the exponent bits.
#[inline(always)]
fn into_exponent<S: Simd>(_: S, mut bits: S::u64s) -> S::u64s {
    let lanes: &mut [u64] = bytemuck::cast_slice_mut(std::slice::from_mut(&mut bits));
    for lane in lanes {
        *lane <<= 52;
    }
    bits
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;
    use pulp::WithSimd;

    use super::super::every;
    use super::*;

    /// e^x of all values, in vectors.
    struct Vectors<'a> {
        x: &'a [f64],
        decay: bool,
    }

    impl WithSimd for Vectors<'_> {
        type Output = Vec<f64>;

        fn with_simd<S: Simd>(self, simd: S) -> Vec<f64> {
            let of = |x| if self.decay { decay(simd, x) } else { exponential(simd, x) };
            let mut found = vec![0.0; self.x.len()];
            let chunks = self.x.chunks(S::F64_LANES).zip(found.chunks_mut(S::F64_LANES));
            chunks.for_each(|(x, y)| simd.partial_store_f64s(y, of(simd.partial_load_f64s(x))));
            found
        }
    }

    fn units_apart(a: f64, b: f64) -> u64 {
        a.to_bits().abs_diff(b.to_bits())
    }

    proptest! {
        #[test]
        fn exp_is_within_two_units_in_the_last_place(x in -707.0..709.78f64) {
            for arch in every() {
                let found = arch.dispatch(Vectors { x: &[x], decay: false })[0];
                prop_assert!(units_apart(found, x.exp()) <= 2, "exp({x}) is {found}");
                let x = -x.abs().min(707.0);
                let found = arch.dispatch(Vectors { x: &[x], decay: true })[0];
                prop_assert!(units_apart(found, x.exp()) <= 2, "exp({x}) is {found}");
            }
        }
    }

    #[test]
    fn exp_has_the_right_limits() {
        let x = [0.0, f64::NEG_INFINITY, -800.0, 709.78, 709.79, f64::INFINITY, f64::NAN];
        for arch in every() {
            let found = arch.dispatch(Vectors { x: &x, decay: false });
            assert!(found[0] == 1.0 && found[1] < 1e-306 && found[2] < 1e-306);
            assert!(found[3].is_finite() && found[4..].iter().all(|y| y.is_nan()), "{found:?}");
            let found = arch.dispatch(Vectors { x: &x, decay: true });
            assert!(found[0] == 1.0 && found[1] < 1e-306 && found[2] < 1e-306);
            assert!(found[6].is_nan());
        }
    }
}
