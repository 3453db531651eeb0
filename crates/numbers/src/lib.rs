//! Numbers that laws and models are evaluated in: plain ones, and [`Dual`] numbers that carry
//! derivatives along.
//!
//! A dual number is `a + sum_l a_l e_l` with `e_l e_m = 0`: evaluating a function on it gives
//! the function's value and, lane by lane, its exact derivatives in [`LANES`] directions, for
//! about the price of two evaluations:
//!
//! ```text
//! f(a + sum_l a_l e_l) = f(a) + sum_l f'(a) a_l e_l
//! ```
//!
//! | on paper | in code |
//! | --- | --- |
//! | a | [`Dual::value`] |
//! | a_l = da/de_l | [`Dual::tangent`] |
//! | f, in any kind of number | a function generic over [`Number`] |
//! | f(a), f'(a) | [`Number::mapped`] |
//!
//! Where a function has a kink, the derivative is that to the right: of |x| at 0 it is 1.

mod dual;
mod number;

pub use dual::{Dual, LANES};
pub use number::{Linear, Number, copy};
