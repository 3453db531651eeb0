//! Numbers that a model can be evaluated in: plain ones, and [`Dual`] numbers that carry
//! derivatives along.
//!
//! A dual number is `a + sum_l a_l e_l` with `e_l e_m = 0`: evaluating a function on it gives
//! the function's value and, lane by lane, its exact derivatives in [`LANES`] directions, for
//! about the price of two evaluations.
//!
//! | on paper | in code |
//! | --- | --- |
//! | a | [`Dual::value`] |
//! | a_l = da/de_l | [`Dual::tangent`] |

use crate::expression::{Binary, Unary};
use std::fmt::Debug;
use std::ops::{Add, Div, Mul, Neg, Sub};

/// Directions that one evaluation carries along.
pub const LANES: usize = 8;

/// What expressions and equations of motion are evaluated in.
pub trait Number:
    Copy
    + Debug
    + Send
    + Sync
    + 'static
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
{
    /// A number that does not depend on anything.
    fn constant(value: f64) -> Self;

    /// Its value.
    fn value(self) -> f64;

    /// Times a constant.
    fn scaled(self, factor: f64) -> Self;

    /// The derivatives that it carries; none for a plain number.
    fn tangent(&self) -> &[f64];

    /// A number of this value whose derivative in each lane is given.
    fn with_tangent(value: f64, tangent: impl Fn(usize) -> f64) -> Self;

    /// A number of this value, and of derivatives `sum_i slopes_i of_i`.
    fn chained(value: f64, slopes: &[f64], of: &[Self]) -> Self;

    /// An operation on one value.
    fn unary(self, op: Unary) -> Self;

    /// An operation on two values.
    fn binary(self, op: Binary, other: Self) -> Self;
}

impl Number for f64 {
    #[inline(always)]
    fn constant(value: f64) -> Self {
        value
    }

    #[inline(always)]
    fn value(self) -> f64 {
        self
    }

    #[inline(always)]
    fn scaled(self, factor: f64) -> Self {
        factor * self
    }

    #[inline(always)]
    fn tangent(&self) -> &[f64] {
        &[]
    }

    #[inline(always)]
    fn with_tangent(value: f64, _tangent: impl Fn(usize) -> f64) -> Self {
        value
    }

    #[inline(always)]
    fn chained(value: f64, _slopes: &[f64], _of: &[Self]) -> Self {
        value
    }

    #[inline(always)]
    fn unary(self, op: Unary) -> Self {
        op.apply(self)
    }

    #[inline(always)]
    fn binary(self, op: Binary, other: Self) -> Self {
        op.apply(self, other)
    }
}

/// A value and its derivatives in [`LANES`] directions.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Dual {
    /// The value.
    pub value: f64,
    /// Its derivatives.
    pub tangent: [f64; LANES],
}

impl Dual {
    /// A value that is itself direction `lane`.
    #[must_use]
    pub fn direction(value: f64, lane: usize) -> Self {
        let mut tangent = [0.0; LANES];
        tangent[lane] = 1.0;
        Self { value, tangent }
    }

    /// `value` with the tangent `a self' + b other'`.
    #[inline(always)]
    fn blend(self, value: f64, a: f64, other: Self, b: f64) -> Self {
        let tangent = std::array::from_fn(|l| a * self.tangent[l] + b * other.tangent[l]);
        Self { value, tangent }
    }

    /// `value` with the tangent `slope self'`.
    #[inline(always)]
    fn along(self, value: f64, slope: f64) -> Self {
        Self { value, tangent: self.tangent.map(|t| slope * t) }
    }
}

impl Add for Dual {
    type Output = Self;

    #[inline(always)]
    fn add(self, other: Self) -> Self {
        self.blend(self.value + other.value, 1.0, other, 1.0)
    }
}

impl Sub for Dual {
    type Output = Self;

    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        self.blend(self.value - other.value, 1.0, other, -1.0)
    }
}

impl Mul for Dual {
    type Output = Self;

    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        self.blend(self.value * other.value, other.value, other, self.value)
    }
}

impl Div for Dual {
    type Output = Self;

    #[inline(always)]
    fn div(self, other: Self) -> Self {
        let inverse = 1.0 / other.value;
        let value = self.value / other.value;
        self.blend(value, inverse, other, -value * inverse)
    }
}

impl Neg for Dual {
    type Output = Self;

    #[inline(always)]
    fn neg(self) -> Self {
        self.along(-self.value, -1.0)
    }
}

impl Number for Dual {
    #[inline(always)]
    fn constant(value: f64) -> Self {
        Self { value, tangent: [0.0; LANES] }
    }

    #[inline(always)]
    fn value(self) -> f64 {
        self.value
    }

    #[inline(always)]
    fn scaled(self, factor: f64) -> Self {
        self.along(factor * self.value, factor)
    }

    #[inline(always)]
    fn tangent(&self) -> &[f64] {
        &self.tangent
    }

    #[inline(always)]
    fn with_tangent(value: f64, tangent: impl Fn(usize) -> f64) -> Self {
        Self { value, tangent: std::array::from_fn(tangent) }
    }

    fn chained(value: f64, slopes: &[f64], of: &[Self]) -> Self {
        let mut out = Self::constant(value);
        for (slope, x) in slopes.iter().zip(of) {
            for (t, s) in out.tangent.iter_mut().zip(&x.tangent) {
                *t += slope * s;
            }
        }
        out
    }

    #[inline(always)]
    fn unary(self, op: Unary) -> Self {
        let (a, value) = (self.value, op.apply(self.value));
        let slope = match op {
            Unary::Negate => -1.0,
            Unary::Sin => a.cos(),
            Unary::Cos => -a.sin(),
            Unary::Tan => 1.0 + value * value,
            Unary::Asin => 1.0 / (1.0 - a * a).sqrt(),
            Unary::Acos => -1.0 / (1.0 - a * a).sqrt(),
            Unary::Atan => 1.0 / (1.0 + a * a),
            Unary::Sinh => a.cosh(),
            Unary::Cosh => a.sinh(),
            Unary::Tanh => 1.0 - value * value,
            Unary::Exp => value,
            Unary::Log => 1.0 / a,
            // At an empty tank the slope is infinite; nothing flows there, nothing changes.
            Unary::Sqrt => {
                if value > 0.0 {
                    0.5 / value
                } else {
                    0.0
                }
            }
            Unary::Abs => Unary::Sign.apply(a),
            Unary::Sign => 0.0,
            Unary::Square => 2.0 * a,
            Unary::Cube => 3.0 * a * a,
        };
        self.along(value, slope)
    }

    #[inline(always)]
    fn binary(self, op: Binary, other: Self) -> Self {
        let (a, b) = (self.value, other.value);
        match op {
            Binary::Add => self + other,
            Binary::Subtract => self - other,
            Binary::Multiply => self * other,
            Binary::Divide => self / other,
            Binary::Power => power(self, other),
            Binary::Atan2 => {
                let square = a * a + b * b;
                self.blend(a.atan2(b), b / square, other, -a / square)
            }
            Binary::Min => {
                if a <= b {
                    self
                } else {
                    other
                }
            }
            Binary::Max => {
                if a >= b {
                    self
                } else {
                    other
                }
            }
        }
    }
}

/// `a^b`; an exponent that does not move needs no logarithm of its base.
fn power(base: Dual, exponent: Dual) -> Dual {
    let (a, b) = (base.value, exponent.value);
    let value = a.powf(b);
    let by_base = b * a.powf(b - 1.0);
    let moves = exponent.tangent.iter().any(|&t| t != 0.0);
    let by_exponent = if moves { value * a.ln() } else { 0.0 };
    base.blend(value, by_base, exponent, by_exponent)
}

#[cfg(test)]
mod tests {
    use super::{Dual, Number};
    use crate::expression::{Binary, Unary};

    const UNARY: [Unary; 17] = [
        Unary::Negate,
        Unary::Sin,
        Unary::Cos,
        Unary::Tan,
        Unary::Asin,
        Unary::Acos,
        Unary::Atan,
        Unary::Sinh,
        Unary::Cosh,
        Unary::Tanh,
        Unary::Exp,
        Unary::Log,
        Unary::Sqrt,
        Unary::Abs,
        Unary::Sign,
        Unary::Square,
        Unary::Cube,
    ];

    #[test]
    fn operations_on_one_value_carry_their_derivative() {
        let h = 1e-6;
        for op in UNARY {
            let x = 0.37;
            let dual = Dual::direction(x, 3).unary(op);
            let difference = (op.apply(x + h) - op.apply(x - h)) / (2.0 * h);
            assert_eq!(dual.value.to_bits(), op.apply(x).to_bits());
            assert!((dual.tangent[3] - difference).abs() < 1e-8, "{op:?}");
            assert_eq!(dual.tangent[2], 0.0);
        }
    }

    #[test]
    fn operations_on_two_values_carry_both_derivatives() {
        let (h, a, b) = (1e-6, 0.8, 1.7);
        use Binary::{Add, Atan2, Divide, Max, Min, Multiply, Power, Subtract};
        for op in [Add, Subtract, Multiply, Divide, Power, Atan2, Min, Max] {
            let dual = Dual::direction(a, 0).binary(op, Dual::direction(b, 7));
            let by_a = (op.apply(a + h, b) - op.apply(a - h, b)) / (2.0 * h);
            let by_b = (op.apply(a, b + h) - op.apply(a, b - h)) / (2.0 * h);
            assert_eq!(dual.value, op.apply(a, b));
            assert!((dual.tangent[0] - by_a).abs() < 1e-8, "{op:?}");
            assert!((dual.tangent[7] - by_b).abs() < 1e-8, "{op:?}");
        }
    }
}
