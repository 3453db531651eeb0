//! Control occupation kernel regression: drift and control effectiveness from whole trajectories, without numerical
//! differentiation.
//!
//! A trajectory gamma with input u of the system
//!
//! ```text
//! gamma^(s)(t) = f(gamma(t)) + g(gamma(t)) u(t)
//! ```
//!
//! integrated under a test function phi gives one linear equation for \[f g\], by s partial integrations:
//!
//! ```text
//! <[f_i g_i], Gamma_phi> = int phi (f_i(gamma) + g_i(gamma) u) dt = (-1)^s int phi^(s) gamma_i dt  (+ boundary terms)
//! Gamma_phi(x) = int phi(t) K(x, gamma(t)) (1, u(t))^T dt
//! ```
//!
//! The estimate of least norm plus misfit is H = \[f g\] = sum_a W_a Gamma_a^T with (G + lambda I) W = Y.
//!
//! | on paper | in code | shape |
//! | --- | --- | --- |
//! | coordinates gamma, kernel arguments x, inputs u | [`TrajectoryData`] | N x n, N x d, N x m |
//! | order s, ridge lambda | [`Regression::order`], [`Regression::lambda`] | |
//! | kernel K(x, y) | [`Kernel`], [`KernelSpec`] | R^d x R^d -> R |
//! | test function phi(t) | [`TestFunction`] | |
//! | y -> int phi^(k) y dt = sum_k c(k) y(t_k) | [`Functional`], [`TestFunction::functionals`] | |
//! | occupation kernels Gamma_a | [`OccupationKernels`] | A of them |
//! | Gram matrix G_ab = <Gamma_a, Gamma_b> | [`gram_matrix`] | A x A |
//! | right-hand sides Y_ai | [`WeakSystem::right_hand_sides`] | A x n |
//! | their noise covariance sigma^2 S, S = L L^T | [`SymmetricBanded`], [`BandedCholesky`] | A x A, banded |
//! | weights W | [`WeakSystem::weights`] | A x n |
//! | H(x) = \[f(x) g(x)\] | [`IdentifiedModel`] | n x (1 + m) |
//! | F F^T for G, from many trajectories | [`Regression::fit_streamed`] | A x r (1 + m) |
//!
//! [`Identification`] takes the method further: initial values as unknowns of a weak form over every sample, kernels,
//! regularisation and noise by marginal likelihood, few landmarks instead of every sample, and a refinement along the
//! model's own trajectories, with the model's adjoint for test function; its model knows its standard deviations.
//!
//! | on paper | in code | shape |
//! | --- | --- | --- |
//! | samples y, rates y', inputs u | [`Motion`] | N x n, N x n, N x m |
//! | f_i ~ GP(0, a_0^2 K_0), g_ij ~ GP(0, a_j^2 K_j) | [`identification::RowChoice`] | n rows of 1 + m |
//! | evidence of linear equations in closed form | [`identification::evidence`] | |
//! | monomials S that a polynomial has, p(S given y) | `identification::select` | |
//! | inner products of the equations of parts of the data | [`Stream`], [`Sums`] | |
//! | standard deviations of f and g at x | [`IdentifiedModel::standard_deviations`] | n, n x m |
//!
//! Source: M. Abudia, T. Channagiri, J. A. Rosenfeld, R. Kamalapurkar, "Control Occupation Kernel Regression", IEEE
//! Transactions on Automatic Control 71(7):4780-4787, 2026 (arXiv 2106.00103). The compact test functions and the
//! whitening generalise it: they need no initial velocity, and weigh overlapping windows by what noise they share.
//!
//! ```
//! use lacuna_occupation::{
//!     InitialDerivative, Polynomial, Quadrature, Regression, TestFunction, TrajectoryData,
//! };
//!
//! // x' = -x + u with u = 1 from x(0) = 0 and u = 0 from x(0) = 1
//! let times: Vec<f64> = (0..=20).map(|k| 0.05 * f64::from(k)).collect();
//! let rise: Vec<f64> = times.iter().map(|t| 1.0 - (-t).exp()).collect();
//! let decay: Vec<f64> = times.iter().map(|t| (-t).exp()).collect();
//! let trajectories = [
//!     TrajectoryData::new(times.clone(), rise.clone(), vec![1.0; 21], rise)?,
//!     TrajectoryData::new(times.clone(), decay.clone(), vec![0.0; 21], decay)?,
//! ];
//! let regression = Regression {
//!     kernel: Polynomial { degree: 1, offset: 1.0, scale: 1.0 }.into(),
//!     order: 1,
//!     test_function: TestFunction::Compact { exponent: 4, width: 0.5, stride: 1 },
//!     quadrature: Quadrature::Trapezoid,
//!     lambda: 1e-9,
//!     initial_derivative: InitialDerivative::default(),
//!     whiten: false,
//! };
//! let model = regression.fit(&trajectories)?;
//! let (mut f, mut g) = ([0.0], [0.0]);
//! model.evaluate(&[0.5], &mut f, &mut g)?;
//! assert!((f[0] + 0.5).abs() < 1e-4 && (g[0] - 1.0).abs() < 1e-4);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

pub mod compile;
pub mod functional;
pub mod gram;
pub mod identification;
pub mod identified;
pub mod kernel;
mod linear;
pub mod occupation_kernels;
mod pivoted;
pub mod quadrature;
pub mod regression;
mod sample;
mod simd;
pub mod test_function;
pub mod trajectory;
pub mod whitening;

pub use functional::Functional;
pub use gram::gram_matrix;
pub use identification::{
    Arguments, Family, Identification, IdentificationError, Identified, InputPath, Motion, Stream,
    Sums,
};
pub use identified::{
    EvaluationError, IdentifiedModel, ModelFileError, Names, SavedModelError, StandardDeviations,
    Uncertainty,
};
pub use kernel::{
    ExponentialDotProduct, Form, Gaussian, Kernel, KernelError, KernelSpec, Matern, Polynomial,
    Profile, Smoothness,
};
pub use linear::{Factor, NonPositivePivot};
pub use occupation_kernels::OccupationKernels;
pub use quadrature::{Quadrature, QuadratureError};
pub use regression::low_rank::{Fitted, Limits, LowRank, StreamError, Way};
pub use regression::{FitError, Regression, WeakSystem};
pub use sample::sample as evenly;
pub use test_function::{InitialDerivative, TestFunction, TestFunctionError};
pub use trajectory::{TrajectoryData, TrajectoryError};
pub use whitening::{BandedCholesky, SymmetricBanded, WhiteningError};
