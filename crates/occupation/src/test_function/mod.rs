//! Test functions phi and the functionals y -> int phi^(k) y dt that they make of sampled signals.

mod compact;
mod endpoint;
mod initial_derivative;

use serde::{Deserialize, Serialize};

use crate::functional::Functional;
use crate::quadrature::{Quadrature, QuadratureError};

pub use initial_derivative::InitialDerivative;

/// A family of weights phi(t) under which a trajectory is integrated.
///
/// With s partial integrations, a trajectory of gamma^(s) = f(gamma) + g(gamma) u obeys, for each member of the family,
///
/// ```text
/// int phi (f(gamma) + g(gamma) u) dt = (-1)^s int phi^(s) gamma dt + boundary terms
/// ```
///
/// and the boundary terms vanish where phi has compact support.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(tag = "kind", rename_all = "snake_case")]
pub enum TestFunction {
    /// The paper's phi(t) = (T - t)^(s-1) / (s-1)! on the whole recording \[0, T\]: one functional a recording.
    /// It needs the derivatives gamma', ..., gamma^(s-1) at time 0 (see [`InitialDerivative`]).
    Endpoint {
        /// Order s of the dynamics.
        order: usize,
    },
    /// phi(t) = (1 - tau^2)^p with tau going from -1 to 1 over a window, one functional a window.
    /// It needs no initial derivative.
    ///
    /// Each window begins and ends at samples: its true width is the span between samples nearest to `width`.
    Compact {
        /// Exponent p: phi and its first p - 1 derivatives vanish at both ends of a window.
        exponent: u32,
        /// Width of the window, in seconds.
        width: f64,
        /// Samples from the start of one window to that of the next.
        stride: usize,
    },
}

impl TestFunction {
    /// The functionals y -> int phi^(derivative) y dt of a recording sampled at `times` (seconds), in order of time.
    ///
    /// Endpoint functionals are plain quadrature sums. Compact ones are quadrature sums of which the weights are then
    /// corrected, so that they are exact where y is a polynomial of degree up to `derivative` + 3 (that is, where
    /// y^(derivative) is a cubic), on uneven times too: a constant offset of y thus never leaks into int phi'' y.
    /// Tests: `tests/functionals.rs`.
    ///
    /// # Errors
    /// `derivative` beyond order - 1 (endpoint) or exponent - 1 (compact); order, exponent or stride of zero; a width
    /// that is not positive; a window longer than the recording or with fewer than `derivative` + 6 samples; times that
    /// the quadrature refuses.
    pub fn functionals(
        &self,
        times: &[f64],
        quadrature: Quadrature,
        derivative: usize,
    ) -> Result<Vec<Functional>, TestFunctionError> {
        match *self {
            Self::Endpoint { order } => {
                endpoint::functional(times, quadrature, order, derivative).map(|only| vec![only])
            }
            Self::Compact { exponent, width, stride } => {
                compact::Windows { exponent, width, stride }
                    .functionals(times, quadrature, derivative)
            }
        }
    }

    /// The right-hand sides Y of the regression as functionals of the samples: int phi gamma^(s) dt without gamma^(s).
    ///
    /// * compact: (-1)^s int phi^(s) gamma dt;
    /// * endpoint: gamma(T) - sum_{k < s} gamma^(k)(0) T^k / k!, so gamma(T) - gamma(0) for s = 1. The derivatives
    ///   come from the first samples as `initial` says; with [`InitialDerivative::Given`] the terms k >= 1 are left
    ///   out, and the caller subtracts them.
    ///
    /// # Errors
    /// As [`TestFunction::functionals`]; an endpoint function of another order; too few samples for `initial`.
    pub fn right_hand_sides(
        &self,
        times: &[f64],
        quadrature: Quadrature,
        order: usize,
        initial: InitialDerivative,
    ) -> Result<Vec<Functional>, TestFunctionError> {
        match *self {
            Self::Endpoint { order: own } if own != order => {
                Err(TestFunctionError::Order { expected: order, found: own })
            }
            Self::Endpoint { .. } => {
                endpoint::right_hand_side(times, order, initial).map(|only| vec![only])
            }
            Self::Compact { .. } => {
                let mut functionals = self.functionals(times, quadrature, order)?;
                if order % 2 == 1 {
                    functionals
                        .iter_mut()
                        .flat_map(|functional| &mut functional.weights)
                        .for_each(|w| *w = -*w);
                }
                Ok(functionals)
            }
        }
    }
}

/// A test function that does not suit the recording or itself.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum TestFunctionError {
    /// The times do not suit the quadrature.
    #[error(transparent)]
    Quadrature(#[from] QuadratureError),
    /// A width that is no positive number.
    #[error("the window's width must be positive and finite, found {found} s")]
    Width {
        /// Width given, in seconds.
        found: f64,
    },
    /// Order, exponent or stride of zero.
    #[error("{name} must be at least 1, found 0")]
    Zero {
        /// Which of them.
        name: &'static str,
    },
    /// An endpoint test function of another order than the regression.
    #[error("the endpoint test function has order {found}, the regression order {expected}")]
    Order {
        /// Order of the regression.
        expected: usize,
        /// Order of the test function.
        found: usize,
    },
    /// A derivative that does not vanish at the ends of the window, or is identically zero.
    #[error(
        "derivatives of this test function are available up to order {highest}, asked for {found}"
    )]
    Derivative {
        /// Highest derivative available.
        highest: usize,
        /// Derivative asked for.
        found: usize,
    },
    /// A window that does not fit into the recording.
    #[error("the window of {width} s is longer than the recording of {duration} s")]
    WindowTooLong {
        /// Width of the window, in seconds.
        width: f64,
        /// Duration of the recording, in seconds.
        duration: f64,
    },
    /// A window or a recording with too few samples.
    #[error("{what} from {start} s on needs at least {expected} samples, found {found}")]
    TooFewSamples {
        /// What needs the samples.
        what: &'static str,
        /// Time of its first sample, in seconds.
        start: f64,
        /// Samples needed.
        expected: usize,
        /// Samples found.
        found: usize,
    },
    /// A local polynomial without the derivatives that the order needs, or with fewer samples than coefficients.
    #[error(
        "a local polynomial of degree {degree} through {samples} samples does not give the derivative of order {derivative}"
    )]
    LocalPolynomial {
        /// Degree of the polynomial.
        degree: usize,
        /// Number of samples it is fitted to.
        samples: usize,
        /// Highest derivative needed.
        derivative: usize,
    },
    /// Sample times so unequal that the weights cannot be computed.
    #[error("the sample times from {start} s on are too unequal for exact weights")]
    Degenerate {
        /// Time of the first sample concerned, in seconds.
        start: f64,
    },
}
