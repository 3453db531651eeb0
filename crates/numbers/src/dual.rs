//! Numbers that carry their derivatives along.

use crate::{Linear, Number};
use std::ops::{Add, Div, Mul, Neg, Sub};

/// Directions that one evaluation carries along.
pub const LANES: usize = 8;

/// A value and its derivatives in [`LANES`] directions. The derivatives fill a line of the cache: none
/// is read from two.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(align(64))]
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

    /// Entry `entry` of many, where those from `first` on are carried along: itself a direction, if
    /// it is one of them.
    #[must_use]
    pub fn among(value: f64, entry: usize, first: usize) -> Self {
        match entry.wrapping_sub(first) {
            lane if lane < LANES => Self::direction(value, lane),
            _ => Self::constant(value),
        }
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

impl Add<f64> for Dual {
    type Output = Self;

    #[inline(always)]
    fn add(self, constant: f64) -> Self {
        Self { value: self.value + constant, ..self }
    }
}

impl Sub<f64> for Dual {
    type Output = Self;

    #[inline(always)]
    fn sub(self, constant: f64) -> Self {
        Self { value: self.value - constant, ..self }
    }
}

impl Mul<f64> for Dual {
    type Output = Self;

    #[inline(always)]
    fn mul(self, factor: f64) -> Self {
        self.along(factor * self.value, factor)
    }
}

impl Div<f64> for Dual {
    type Output = Self;

    #[inline(always)]
    fn div(self, divisor: f64) -> Self {
        self.along(self.value / divisor, 1.0 / divisor)
    }
}

impl Linear for Dual {
    const ZERO: Self = Self { value: 0.0, tangent: [0.0; LANES] };

    #[inline(always)]
    fn same(self) -> Self {
        Self { value: self.value, tangent: std::array::from_fn(|l| self.tangent[l]) }
    }

    #[inline(always)]
    fn by_itself() {
        std::hint::black_box(());
    }
}

impl Number for Dual {
    const PARTS: usize = 1 + LANES;

    #[inline(always)]
    fn constant(value: f64) -> Self {
        Self { value, tangent: [0.0; LANES] }
    }

    #[inline(always)]
    fn value(self) -> f64 {
        self.value
    }

    #[inline(always)]
    fn part(&self, part: usize) -> f64 {
        if part == 0 { self.value } else { self.tangent[part - 1] }
    }

    #[inline(always)]
    fn moves(self) -> bool {
        self.tangent.iter().any(|&t| t != 0.0)
    }

    #[inline(always)]
    fn mapped(self, value: f64, slope: f64) -> Self {
        self.along(value, slope)
    }

    #[inline(always)]
    fn sin(self) -> Self {
        self.sin_cos().0
    }

    #[inline(always)]
    fn cos(self) -> Self {
        self.sin_cos().1
    }

    #[inline(always)]
    fn sin_cos(self) -> (Self, Self) {
        let (sine, cosine) = self.value.sin_cos();
        (self.along(sine, cosine), self.along(cosine, -sine))
    }

    #[inline(always)]
    fn tan(self) -> Self {
        let value = self.value.tan();
        self.along(value, 1.0 + value * value)
    }

    #[inline(always)]
    fn asin(self) -> Self {
        self.along(self.value.asin(), 1.0 / (1.0 - self.value * self.value).sqrt())
    }

    #[inline(always)]
    fn acos(self) -> Self {
        self.along(self.value.acos(), -1.0 / (1.0 - self.value * self.value).sqrt())
    }

    #[inline(always)]
    fn atan(self) -> Self {
        self.along(self.value.atan(), 1.0 / (1.0 + self.value * self.value))
    }

    #[inline(always)]
    fn atan2(self, x: Self) -> Self {
        let (a, b) = (self.value, x.value);
        let square = a * a + b * b;
        self.blend(a.atan2(b), b / square, x, -a / square)
    }

    #[inline(always)]
    fn sinh(self) -> Self {
        self.along(self.value.sinh(), self.value.cosh())
    }

    #[inline(always)]
    fn cosh(self) -> Self {
        self.along(self.value.cosh(), self.value.sinh())
    }

    #[inline(always)]
    fn tanh(self) -> Self {
        let value = self.value.tanh();
        self.along(value, 1.0 - value * value)
    }

    #[inline(always)]
    fn exp(self) -> Self {
        let value = self.value.exp();
        self.along(value, value)
    }

    #[inline(always)]
    fn exp_m1(self) -> Self {
        let value = self.value.exp_m1();
        self.along(value, value + 1.0)
    }

    #[inline(always)]
    fn ln(self) -> Self {
        self.along(self.value.ln(), 1.0 / self.value)
    }

    #[inline(always)]
    fn sqrt(self) -> Self {
        let value = self.value.sqrt();
        // At an empty tank the slope is infinite; nothing flows there, nothing changes.
        self.along(value, if value > 0.0 { 0.5 / value } else { 0.0 })
    }

    #[inline(always)]
    fn powi(self, exponent: i32) -> Self {
        let slope = f64::from(exponent) * self.value.powi(exponent - 1);
        self.along(self.value.powi(exponent), slope)
    }

    #[inline(always)]
    fn powf(self, exponent: Self) -> Self {
        let (a, b) = (self.value, exponent.value);
        let value = a.powf(b);
        // An exponent that does not move needs no logarithm of its base.
        let by_exponent = if exponent.moves() { value * a.ln() } else { 0.0 };
        self.blend(value, b * a.powf(b - 1.0), exponent, by_exponent)
    }

    #[inline(always)]
    fn sign(self) -> Self {
        Self::constant(Number::sign(self.value))
    }

    #[inline(always)]
    fn abs(self) -> Self {
        self.along(self.value.abs(), if self.value < 0.0 { -1.0 } else { 1.0 })
    }

    #[inline(always)]
    fn max(self, other: Self) -> Self {
        if self.value >= other.value { self } else { other }
    }

    #[inline(always)]
    fn min(self, other: Self) -> Self {
        if self.value <= other.value { self } else { other }
    }
}
