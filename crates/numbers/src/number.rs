//! What a function must know of numbers to be evaluated in any kind of them.

use std::fmt::Debug;
use std::ops::{Add, Div, Mul, Neg, Sub};

/// What can be added and scaled: all that linear maps need to know.
pub trait Linear: Copy + Add<Output = Self> + Mul<f64, Output = Self> {
    /// Nothing.
    const ZERO: Self;

    /// The same number, copied part by part, as arithmetic would write it. What is copied as bytes
    /// is moved in pieces of other widths, for which the next operation has to wait.
    #[inline(always)]
    #[must_use]
    fn same(self) -> Self {
        self
    }

    /// Said in a loop over numbers: each is a vector by itself, if it has lanes. Compilers otherwise put the same lane
    /// of neighbours into one vector, which they gather and scatter number by number.
    #[inline(always)]
    fn by_itself() {}
}

/// Copy numbers to where as many are, one by one.
#[inline(always)]
pub fn copy<T: Linear>(from: &[T], to: &mut [T]) {
    for (to, from) in to.iter_mut().zip(from) {
        *to = from.same();
    }
}

/// What laws, expressions and equations of motion are evaluated in.
pub trait Number:
    Linear
    + Debug
    + Send
    + Sync
    + 'static
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
    + Add<f64, Output = Self>
    + Sub<f64, Output = Self>
    + Div<f64, Output = Self>
{
    /// Whether numbers of this kind carry derivatives.
    const CARRIES: bool = Self::PARTS > 1;
    /// How many plain numbers it is made of.
    const PARTS: usize;

    /// A number that does not depend on anything.
    fn constant(value: f64) -> Self;

    /// Its value.
    fn value(self) -> f64;

    /// One of the [`PARTS`](Self::PARTS) that it is made of: its value, then its derivatives.
    fn part(&self, part: usize) -> f64;

    /// Whether it carries a derivative that is not 0.
    fn moves(self) -> bool;

    /// `f(self)`, given the value and the slope of f there.
    fn mapped(self, value: f64, slope: f64) -> Self;

    /// Sine.
    fn sin(self) -> Self;
    /// Cosine.
    fn cos(self) -> Self;
    /// Sine and cosine.
    fn sin_cos(self) -> (Self, Self);
    /// Tangent.
    fn tan(self) -> Self;
    /// Inverse of the sine.
    fn asin(self) -> Self;
    /// Inverse of the cosine.
    fn acos(self) -> Self;
    /// Inverse of the tangent.
    fn atan(self) -> Self;
    /// Angle of the point `(x, self)`.
    fn atan2(self, x: Self) -> Self;
    /// Hyperbolic sine.
    fn sinh(self) -> Self;
    /// Hyperbolic cosine.
    fn cosh(self) -> Self;
    /// Hyperbolic tangent.
    fn tanh(self) -> Self;
    /// e to this power.
    fn exp(self) -> Self;
    /// e to this power, less 1, exact near 0.
    fn exp_m1(self) -> Self;
    /// Natural logarithm.
    fn ln(self) -> Self;
    /// Square root. At 0 its slope is taken as 0: an empty tank stays empty.
    fn sqrt(self) -> Self;
    /// A whole power.
    fn powi(self, exponent: i32) -> Self;
    /// A power that may itself depend on something.
    fn powf(self, exponent: Self) -> Self;
    /// -1, 0 or 1; unlike of `f64::signum`, 0 has no sign.
    fn sign(self) -> Self;
    /// Absolute value; its slope at 0 is 1.
    fn abs(self) -> Self;
    /// The larger of two, this one where they are equal.
    fn max(self, other: Self) -> Self;
    /// The smaller of two, this one where they are equal.
    fn min(self, other: Self) -> Self;

    /// The nearest number between two bounds; itself on a bound.
    #[inline(always)]
    fn clamp(self, low: Self, high: Self) -> Self {
        if self.value() < low.value() {
            low
        } else if self.value() > high.value() {
            high
        } else {
            self
        }
    }
}

macro_rules! plainly {
    ($($name:ident)*) => {
        $(
            #[inline(always)]
            fn $name(self) -> Self {
                f64::$name(self)
            }
        )*
    };
}

impl Linear for f64 {
    const ZERO: Self = 0.0;
}

impl Number for f64 {
    const PARTS: usize = 1;

    #[inline(always)]
    fn constant(value: f64) -> Self {
        value
    }

    #[inline(always)]
    fn value(self) -> f64 {
        self
    }

    #[inline(always)]
    fn part(&self, _part: usize) -> f64 {
        *self
    }

    #[inline(always)]
    fn moves(self) -> bool {
        false
    }

    #[inline(always)]
    fn mapped(self, value: f64, _slope: f64) -> Self {
        value
    }

    plainly! { sin cos tan asin acos atan sinh cosh tanh exp exp_m1 ln sqrt abs }

    #[inline(always)]
    fn sin_cos(self) -> (Self, Self) {
        f64::sin_cos(self)
    }

    #[inline(always)]
    fn atan2(self, x: Self) -> Self {
        f64::atan2(self, x)
    }

    #[inline(always)]
    fn powi(self, exponent: i32) -> Self {
        f64::powi(self, exponent)
    }

    #[inline(always)]
    fn powf(self, exponent: Self) -> Self {
        f64::powf(self, exponent)
    }

    #[inline(always)]
    fn sign(self) -> Self {
        if self > 0.0 {
            1.0
        } else if self < 0.0 {
            -1.0
        } else {
            self * 0.0
        }
    }

    #[inline(always)]
    fn max(self, other: Self) -> Self {
        f64::max(self, other)
    }

    #[inline(always)]
    fn min(self, other: Self) -> Self {
        f64::min(self, other)
    }
}
