//! Units read at run time: `N m s/rad`, `kg m^2`, `mm/s`, `degC`.
//!
//! A unit is a vector of exponents of the base units and a factor (for a temperature
//! scale also an offset):
//!
//! ```text
//! value in base units = factor * value + offset
//! ```
//!
//! | on paper | in code |
//! | --- | --- |
//! | exponents of m, kg, s, A, K | [`Dimension`], also of angle and cycle |
//! | factor, offset | in [`Unit`], 0.001 for mm; 273.15 for degC |
//! | a product of symbols, known or not | [`Product`] |
//!
//! **Angles.** rad is 1: `N m/rad` fits `N m`, and `rad/s` fits `1/s`. deg, rev and rpm are
//! multiples of rad. The exponent of the angle is remembered all the same, for one purpose:
//! Hz counts cycles, so Hz turns into rad/s (or rpm, deg/s) with 2 pi, but into 1/s with 1.
//!
//! **Grammar.** Factors are joined by a space, `*` or a middle dot, `/` divides by the next
//! factor only, `^` raises to a power that may be negative or a fraction (`m^2.5/s`),
//! parentheses group: `m^3/(s V)`. `s2` and `s²` mean `s^2`. A space after a division
//! (`N/m s`) is refused, as half of its readers would read it the other way.

mod dimension;
mod error;
pub mod names;
mod parse;
mod product;
mod table;
mod unit;

pub use dimension::Dimension;
pub use error::UnitError;
pub use product::Product;
pub use unit::{Unit, convert, convert_factor};
