//! Eight numbers at once: arithmetic that is written once and compiled for plain loops and for vector instructions.

mod plain;
#[cfg(feature = "std")]
mod vectors;

use core::f64::consts::{LN_2, LOG2_E};

use crate::LANES;

#[cfg(any(feature = "std", test))]
pub(crate) use plain::Plain;
#[cfg(feature = "std")]
pub(crate) use vectors::Detected;

/// What is computed on lanes, whichever they are.
pub(crate) trait OnLanes {
    /// With this arithmetic.
    fn run<L: Lanes>(self, lanes: L);
}

/// Chooses the lanes.
pub(crate) trait Dispatch: Copy {
    /// Runs the operation on the lanes that were chosen.
    fn dispatch(self, operation: impl OnLanes);
}

/// Without the choice at run time, plain loops.
#[cfg(not(feature = "std"))]
pub(crate) use plain::Plain as Detected;

/// Arithmetic on [`LANES`] numbers.
pub(crate) trait Lanes: Copy {
    /// The numbers, in vector registers where there are some.
    type V: Copy;

    fn splat(self, value: f64) -> Self::V;
    fn load(self, values: &[f64; LANES]) -> Self::V;
    fn store(self, values: Self::V) -> [f64; LANES];
    fn add(self, a: Self::V, b: Self::V) -> Self::V;
    fn sub(self, a: Self::V, b: Self::V) -> Self::V;
    fn mul(self, a: Self::V, b: Self::V) -> Self::V;
    /// a b + c, rounded once or twice.
    fn mul_add(self, a: Self::V, b: Self::V, c: Self::V) -> Self::V;
    fn clamp(self, a: Self::V, lower: f64, upper: f64) -> Self::V;
    fn sqrt(self, a: Self::V) -> Self::V;
    /// a 2^n for the integers n in the lowest bits of `shifted`.
    fn times_power_of_two(self, a: Self::V, shifted: Self::V) -> Self::V;

    /// The sum, in the same order everywhere.
    #[inline(always)]
    fn sum(self, a: Self::V) -> f64 {
        let [a, b, c, d, e, f, g, h] = self.store(a);
        ((a + e) + (c + g)) + ((b + f) + (d + h))
    }

    /// e^x by x = n ln 2 + r, |r| <= ln 2 / 2, and the Taylor polynomial of degree 13 in r (its remainder is below
    /// 5e-18). Arguments beyond -708 and 709 count as these.
    #[inline(always)]
    fn exp(self, x: Self::V) -> Self::V {
        // Adding 1.5 * 2^52 rounds to an integer and leaves it in the low bits.
        const ROUND: f64 = 6_755_399_441_055_744.0;
        // ln 2 in two parts, the first with trailing zeros so that n times it is exact.
        const LN_2_HIGH: f64 = 0.693_147_180_369_123_8;
        const LN_2_LOW: f64 = 1.908_214_929_270_587_7e-10;
        const { assert!(LN_2_HIGH + LN_2_LOW == LN_2) };

        let x = self.clamp(x, -708.0, 709.0);
        let shifted = self.mul_add(x, self.splat(LOG2_E), self.splat(ROUND));
        let n = self.sub(shifted, self.splat(ROUND));
        let r = self.mul_add(n, self.splat(-LN_2_HIGH), x);
        let r = self.mul_add(n, self.splat(-LN_2_LOW), r);
        let mut power = self.splat(INVERSE_FACTORIALS[13]);
        for coefficient in INVERSE_FACTORIALS.iter().rev().skip(1) {
            power = self.mul_add(power, r, self.splat(*coefficient));
        }
        self.times_power_of_two(power, shifted)
    }
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
    use super::*;
    use std::vec::Vec;

    /// e^x and square roots on whatever lanes run it.
    struct ExpAndRoot<'a>([f64; LANES], &'a mut [[f64; LANES]; 2]);

    impl OnLanes for ExpAndRoot<'_> {
        fn run<L: Lanes>(self, lanes: L) {
            let x = lanes.load(&self.0);
            let e = lanes.exp(x);
            *self.1 = [lanes.store(e), lanes.store(lanes.sqrt(e))];
        }
    }

    #[test]
    fn exp_and_roots_are_right_to_rounding_on_all_lanes() {
        for start in -100..100 {
            let x: Vec<f64> =
                (0..LANES).map(|k| 7.07 * f64::from(start) + 0.77 * k as f64).collect();
            let x: [f64; LANES] = x.try_into().unwrap();
            let (mut plain, mut dispatched) = ([[0.0; LANES]; 2], [[0.0; LANES]; 2]);
            Plain.dispatch(ExpAndRoot(x, &mut plain));
            Detected::new().dispatch(ExpAndRoot(x, &mut dispatched));
            for found in [plain, dispatched] {
                for (k, x) in x.iter().enumerate() {
                    let exact = x.exp();
                    assert!((found[0][k] / exact - 1.0).abs() < 1e-15, "exp({x})");
                    assert!((found[1][k] / exact.sqrt() - 1.0).abs() < 1e-15, "sqrt(exp({x}))");
                }
            }
        }
    }

    #[test]
    fn exp_keeps_what_is_no_number() {
        let mut found = [[0.0; LANES]; 2];
        Plain.dispatch(ExpAndRoot([f64::NAN; LANES], &mut found));
        assert!(found[0][0].is_nan());
        Detected::new().dispatch(ExpAndRoot([f64::NAN; LANES], &mut found));
        assert!(found[0][0].is_nan());
    }
}
