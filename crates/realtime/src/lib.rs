//! Identified models x^(s) = f(x) + g(x) u, evaluated in a control loop.
//!
//! Every function h (an f_i or a g_ij) is a truncated Chebyshev series on a box, a sum over landmarks, or both added:
//!
//! ```text
//! h(x) = sum_k c_k T_k1(z_1) ... T_kd(z_d) + sum_p w_p psi(s_p),    z_i = (2 x_i - l_i - u_i) / (u_i - l_i)
//! s_p  = sum_i (y_i - p_i)^2   or   sum_i y_i p_i,                  y_i = (x_i - a_i) b_i
//! ```
//!
//! The products T_k are split in two, those of the first arguments (outer) and those of the others (inner), so that
//! the table of products is the outer one times the inner one. Coefficients stand in blocks of one outer and eight
//! inner products for up to [`MOST_ENTRIES`] functions together: the sum is one multiplication and one
//! multiply-and-add a function for each eight coefficients, in vector registers.
//!
//! | on paper | in code | shape |
//! | --- | --- | --- |
//! | arguments x, drift f, control effectiveness g | [`Evaluator::evaluate`] | d, n, n x m (row-major) |
//! | box l, u | [`Evaluator::lower`], [`Evaluator::upper`] | d each |
//! | T_1(z_i), ..., T_Di(z_i) for all i, one after the other | [`Series::degrees`] | D_1 + ... + D_d |
//! | outer and inner products | [`Products`] | |
//! | c_k | [`Group::coefficients`] | blocks x functions x 8 |
//! | landmarks p, weights w | [`LandmarkSum::tiles`] | tiles x (d + functions) x 8 |
//! | psi | [`Profile`] | |
//!
//! An evaluation allocates nothing, takes no lock and does not panic; its time does not depend on x. The crate is
//! `no_std`; `std` (on by default) adds the choice of vector instructions at run time, `alloc` tables that are owned.
//! `cargo test -p lacuna-realtime --no-default-features --features alloc` tests the plain loops alone, and
//! `cargo build -p lacuna-realtime --no-default-features` builds what a controller without an allocator takes.
//!
//! ```
//! use lacuna_realtime::{Eight, Evaluator, Group, Products, Region, Series, Shape, Table};
//!
//! // f(x) = 1 + 2 T_1(x) + 3 T_2(x) on [-1, 1], no inputs.
//! static INNER: Products<'static> = Products {
//!     parents: Table::Borrowed(&[0, 0, 0, 0, 0, 0, 0, 0]),
//!     factors: Table::Borrowed(&[0, 0, 1, 0, 0, 0, 0, 0]),
//! };
//! let series = Series {
//!     degrees: Table::Borrowed(&[2]),
//!     outer: Products { parents: Table::Borrowed(&[0]), factors: Table::Borrowed(&[0]) },
//!     inner: INNER.clone(),
//!     groups: Table::Owned(vec![Group {
//!         entries: Table::Borrowed(&[0]),
//!         blocks: Table::Borrowed(&[[0, 0]]),
//!         coefficients: Table::Borrowed(&[Eight([1.0, 2.0, 3.0, 0.0, 0.0, 0.0, 0.0, 0.0])]),
//!     }]),
//! };
//! let shape = Shape { arguments: 1, dimension: 1, inputs: 0 };
//! let (lower, upper) = (Table::Borrowed(&[-1.0][..]), Table::Borrowed(&[1.0][..]));
//! let evaluator = Evaluator::new(shape, lower, upper, Some(series), Table::Borrowed(&[]))?;
//! let mut f = [0.0];
//! assert_eq!(evaluator.evaluate(&[0.5], &mut f, &mut [])?, Region::Inside);
//! assert!((f[0] - (1.0 + 2.0 * 0.5 + 3.0 * (2.0 * 0.25 - 1.0))).abs() < 1e-15);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

#![no_std]

#[cfg(feature = "alloc")]
extern crate alloc;
#[cfg(any(feature = "std", test))]
extern crate std;

mod eight;
mod error;
mod evaluator;
mod landmark_sum;
mod lanes;
mod series;
mod table;

pub use eight::Eight;
pub use error::{LengthError, TableError};
pub use evaluator::{Evaluator, Region, Shape};
pub use landmark_sum::{LandmarkSum, MOST_ARGUMENTS, MOST_SUMS, Profile};
pub use series::{Group, MOST_FACTORS, MOST_PRODUCTS, Products, Series};
pub use table::Table;

/// Values in a block: the lanes of the widest vector registers.
pub const LANES: usize = 8;

/// Most functions in a group: their sums and what is multiplied fit into 16 vector registers.
pub const MOST_ENTRIES: usize = 6;
