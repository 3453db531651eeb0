//! Sparse regression on a library of functions: the methods that ours are compared with.
//!
//! ```text
//! x^(s) = Theta(x) c_0 + sum_j Theta(x) u_j c_j      c sparse, found by STLSQ
//! ```
//!
//! * [`sindyc`]: sparse identification with control on numerical derivatives (Brunton, Proctor,
//!   Kutz 2016), with the settings that PySINDy has by default;
//! * [`wsindy`]: the same library in weak form, without any derivative of the data (Messenger and
//!   Bortz, Multiscale Modeling and Simulation 19(3), 2021).
//!
//! A library is prior knowledge. That of the Duffing oscillator's functions holds all of them (1, x,
//! x^3, sin x), so that it can be found exactly; the manipulator's (quotients of trigonometric
//! functions, tanh) are not in the library and can only be approximated.
//!
//! | on paper | in code |
//! | --- | --- |
//! | library Theta(x) | [`Library`] |
//! | normal equations of the regression | [`NormalEquations`] |
//! | sequentially thresholded least squares | [`Stlsq`] |
//! | coefficients c, as a model | [`LibraryModel`] |

mod error;
mod finite_difference;
mod library;
mod model;
mod normal_equations;
mod stlsq;
mod strong;
mod weak;

pub use error::SparseRegressionError;
pub use finite_difference::finite_difference;
pub use library::Library;
pub use model::LibraryModel;
pub use normal_equations::NormalEquations;
pub use stlsq::Stlsq;
pub use strong::sindyc;
pub use weak::wsindy;
