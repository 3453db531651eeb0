//! Kernel sums over many points at once, vectorised.
//!
//! The loops are plain Rust that the compiler vectorises; `pulp` compiles them a second time for processors with
//! AVX2 and chooses at run time. Each value is the result of the same additions and multiplications in the same order on
//! every processor (no fused multiply-add), so results are the same to the last bit.

use std::f64::consts::{LN_2, LOG2_E};

use pulp::{Simd, WithSimd};

/// values\[k\] = profile(sum_i x_i p_ik)
pub(crate) fn map_dot_products(
    x: &[f64],
    points: &[f64],
    values: &mut [f64],
    profile: impl Fn(f64) -> f64,
) {
    pulp::Arch::new().dispatch(MapDotProducts { x, points, values, profile });
}

/// values\[k\] = profile(sum_i ((x_i - p_ik) / w_i)^2), with one width for all dimensions or one per dimension.
pub(crate) fn map_squared_distances(
    x: &[f64],
    points: &[f64],
    widths: &[f64],
    values: &mut [f64],
    profile: impl Fn(f64) -> f64,
) {
    pulp::Arch::new().dispatch(MapSquaredDistances { x, points, widths, values, profile });
}

/// Adds sum_k b_ok v_k to sums\[o\], for coefficients stored output by output: `coefficients[o * values.len() + k]`.
pub(crate) fn add_weighted_sums(values: &[f64], coefficients: &[f64], sums: &mut [f64]) {
    pulp::Arch::new().dispatch(AddWeightedSums { values, coefficients, sums });
}

// Structs instead of closures, because only a method can be marked for inlining, and what is not inlined into the
// dispatching function is not compiled for its processor.

struct MapDotProducts<'a, F> {
    x: &'a [f64],
    points: &'a [f64],
    values: &'a mut [f64],
    profile: F,
}

impl<F: Fn(f64) -> f64> WithSimd for MapDotProducts<'_, F> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let Self { x, points, values, profile } = self;
        values.fill(0.0);
        for (&own, coordinates) in x.iter().zip(points.chunks_exact(values.len().max(1))) {
            for (value, other) in values.iter_mut().zip(coordinates) {
                *value += own * other;
            }
        }
        values.iter_mut().for_each(|value| *value = profile(*value));
    }
}

struct MapSquaredDistances<'a, F> {
    x: &'a [f64],
    points: &'a [f64],
    widths: &'a [f64],
    values: &'a mut [f64],
    profile: F,
}

impl<F: Fn(f64) -> f64> WithSimd for MapSquaredDistances<'_, F> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let Self { x, points, widths, values, profile } = self;
        values.fill(0.0);
        let coordinates = points.chunks_exact(values.len().max(1));
        for ((&own, coordinates), width) in x.iter().zip(coordinates).zip(widths.iter().cycle()) {
            let inverse = 1.0 / width;
            for (value, other) in values.iter_mut().zip(coordinates) {
                let difference = (own - other) * inverse;
                *value += difference * difference;
            }
        }
        values.iter_mut().for_each(|value| *value = profile(*value));
    }
}

struct AddWeightedSums<'a> {
    values: &'a [f64],
    coefficients: &'a [f64],
    sums: &'a mut [f64],
}

impl WithSimd for AddWeightedSums<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let coefficients = self.coefficients.chunks_exact(self.values.len().max(1));
        for (sum, coefficients) in self.sums.iter_mut().zip(coefficients) {
            *sum += dot_in_lanes(self.values, coefficients);
        }
    }
}

/// Partial sums of a dot product: a fixed number, so that the order of the additions is the same everywhere.
const LANES: usize = 8;

#[inline(always)]
fn dot_in_lanes(x: &[f64], y: &[f64]) -> f64 {
    let mut lanes = [0.0; LANES];
    let (x_blocks, x_rest) = x.as_chunks::<LANES>();
    let (y_blocks, y_rest) = y.as_chunks::<LANES>();
    for (a, b) in x_blocks.iter().zip(y_blocks) {
        for i in 0..LANES {
            lanes[i] += a[i] * b[i];
        }
    }
    let rest: f64 = x_rest.iter().zip(y_rest).map(|(a, b)| a * b).sum();
    lanes.iter().sum::<f64>() + rest
}

/// e^x by x = n ln 2 + r, |r| <= ln 2 / 2, and the Taylor polynomial of degree 13 in r (its remainder is below
/// 5e-18). Within 2 units in the last place; results below 1e-307 are zero.
#[inline(always)]
pub(crate) fn exp(x: f64) -> f64 {
    const LARGEST: f64 = 709.782_712_893_384;
    const SMALLEST: f64 = -707.0;
    // Adding 1.5 * 2^52 rounds to an integer and leaves it in the low bits.
    const ROUND: f64 = 6_755_399_441_055_744.0;
    // ln 2 in two parts, the first with trailing zeros so that n times it is exact.
    const LN_2_HIGH: f64 = 0.693_147_180_369_123_8;
    const LN_2_LOW: f64 = 1.908_214_929_270_587_7e-10;
    const { assert!(LN_2_HIGH + LN_2_LOW == LN_2) };

    let shifted = x * LOG2_E + ROUND;
    let n = shifted - ROUND;
    let r = (x - n * LN_2_HIGH) - n * LN_2_LOW;
    let power = INVERSE_FACTORIALS.iter().rev().fold(0.0, |sum, coefficient| sum * r + coefficient);
    // 2^n: the integer goes into the exponent bits.
    let result = f64::from_bits(power.to_bits().wrapping_add(shifted.to_bits() << 52));
    let result = if x < SMALLEST { 0.0 } else { result };
    let result = if x > LARGEST { f64::INFINITY } else { result };
    if x.is_nan() { x } else { result }
}

/// 1 / k! for k = 0, ..., 13.
const INVERSE_FACTORIALS: [f64; 14] = {
    let mut inverse = [1.0; 14];
    let (mut k, mut factorial) = (1, 1.0);
    while k < 14 {
        factorial *= k as f64;
        inverse[k] = 1.0 / factorial;
        k += 1;
    }
    inverse
};

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::exp;

    proptest! {
        #[test]
        fn exp_is_within_two_units_in_the_last_place(x in -707.0..709.78f64) {
            let difference = exp(x).to_bits().abs_diff(x.exp().to_bits());
            prop_assert!(difference <= 2, "exp({x}) is {difference} units off");
        }
    }

    #[test]
    fn exp_has_the_right_limits() {
        assert_eq!(exp(0.0), 1.0);
        assert_eq!(exp(f64::NEG_INFINITY), 0.0);
        assert_eq!(exp(-800.0), 0.0);
        assert_eq!(exp(f64::INFINITY), f64::INFINITY);
        assert_eq!(exp(710.0), f64::INFINITY);
        assert!(exp(709.78).is_finite());
        assert!(exp(f64::NAN).is_nan());
    }
}
