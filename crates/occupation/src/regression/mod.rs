//! Control occupation kernel regression: from trajectories to an [`IdentifiedModel`].

mod error;
pub mod low_rank;
mod weak_form;

use faer::Mat;
use serde::{Deserialize, Serialize};

use crate::gram::gram_matrix;
use crate::identified::IdentifiedModel;
use crate::kernel::KernelSpec;
use crate::linear::{NonPositivePivot, solve_positive_definite};
use crate::occupation_kernels::OccupationKernels;
use crate::quadrature::Quadrature;
use crate::test_function::{InitialDerivative, TestFunction};
use crate::trajectory::TrajectoryData;
use crate::whitening::SymmetricBanded;
pub use error::FitError;
pub(crate) use weak_form::{Equations, WeakForm};

/// Settings of a regression of x^(s) = f(x) + g(x) u.
///
/// The paper's second-order study, for example: exponential dot product kernel with mu = 5, `order` 2, endpoint test
/// function, Simpson, lambda = 1e-3, forward difference, no whitening.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Regression {
    /// Scalar kernel K of each of the m + 1 blocks.
    pub kernel: KernelSpec,
    /// Order s of the dynamics, 1 or more.
    pub order: usize,
    /// Weights phi(t) under which the trajectories are integrated.
    pub test_function: TestFunction,
    /// How integrals are approximated.
    pub quadrature: Quadrature,
    /// Ridge lambda > 0: of G, or with `whiten` of L^-1 G L^-T, where it is the noise variance over the prior variance
    /// of the kernel expansion.
    pub lambda: f64,
    /// Where initial derivatives come from (endpoint test function of order 2 or more only).
    pub initial_derivative: InitialDerivative,
    /// Whether right-hand sides are whitened by their noise covariance S = L L^T for white noise of unit variance on the
    /// regressed coordinates: right-hand sides of overlapping windows share samples, and so noise.
    pub whiten: bool,
}

/// The linear system of a regression before it is solved.
#[derive(Debug, Clone)]
pub struct WeakSystem {
    /// The occupation kernels Gamma_a.
    pub occupation: OccupationKernels,
    /// Gram matrix G_ab = <Gamma_a, Gamma_b>, not whitened.
    pub gram: Mat<f64>,
    /// Right-hand sides Y_ai (occupation kernels x n), not whitened.
    pub right_hand_sides: Mat<f64>,
    /// Covariance S = L L^T of the right-hand sides for white noise of unit variance, for whitened fits.
    pub noise_covariance: Option<SymmetricBanded>,
}

impl Regression {
    /// Solves (G + lambda I) W = Y, or whitened (G + lambda S) W = Y with the noise covariance S ([`WeakSystem::weights`]),
    /// and folds the weights W into the identified model H(x) = \[f(x) g(x)\] = sum_a W_a Gamma_a(x)^T.
    ///
    /// Results do not depend on the number of threads. Tests: `tests/reference.rs`, `tests/closed_form.rs`,
    /// `tests/recover.rs`.
    ///
    /// # Errors
    /// No trajectory; trajectories of different n, m or d; kernel parameters, lambda, order or test function out of
    /// range; missing initial derivatives; a system that is not positive definite, or whose solution is not finite.
    pub fn fit(&self, trajectories: &[TrajectoryData]) -> Result<IdentifiedModel, FitError> {
        let system = self.assemble(trajectories)?;
        let weights = system.weights(self.lambda)?;
        Ok(IdentifiedModel::of_weights(
            self.kernel.clone(),
            self.order,
            &system.occupation,
            &weights,
        ))
    }

    /// The occupation kernels of the trajectories, their Gram matrix and right-hand sides.
    ///
    /// # Errors
    /// As [`Regression::fit`], but for those of lambda and the solution.
    pub fn assemble(&self, trajectories: &[TrajectoryData]) -> Result<WeakSystem, FitError> {
        let first = trajectories.first().ok_or(FitError::NoTrajectory)?;
        self.validate(first)?;
        let form = self.weak_form();
        let mut occupation = OccupationKernels::new(first.argument_count(), first.input_count());
        let (mut right_hand_sides, mut noise) = (Vec::new(), Vec::new());
        for (index, data) in trajectories.iter().enumerate() {
            check_shape(first, data, index)?;
            let weak = form.trajectory(index, data)?;
            let before = occupation.samples();
            occupation.append(data.arguments(), data.inputs(), weak.occupation);
            right_hand_sides.extend(weak.right_hand_sides);
            noise.extend(weak.noise.into_iter().map(|functional| functional.shifted(before)));
        }
        let noise_covariance =
            if self.whiten { Some(SymmetricBanded::covariance(&noise)?) } else { None };
        let gram = gram_matrix(&self.kernel, &occupation);
        let n = first.dimension();
        let right_hand_sides = Mat::from_fn(noise.len(), n, |a, i| right_hand_sides[a * n + i]);
        Ok(WeakSystem { occupation, gram, right_hand_sides, noise_covariance })
    }

    fn validate(&self, first: &TrajectoryData) -> Result<(), FitError> {
        if self.order == 0 {
            return Err(FitError::Order);
        }
        Ok(self.kernel.validate(first.argument_count())?)
    }

    /// How trajectories become equations.
    fn weak_form(&self) -> WeakForm {
        WeakForm {
            order: self.order,
            test_function: self.test_function,
            quadrature: self.quadrature,
            initial_derivative: self.initial_derivative,
            whiten: self.whiten,
        }
    }
}

fn check_shape(
    first: &TrajectoryData,
    data: &TrajectoryData,
    trajectory: usize,
) -> Result<(), FitError> {
    match first.other_shape(data) {
        Some((what, expected, found)) => Err(FitError::Shape { trajectory, what, expected, found }),
        None => Ok(()),
    }
}

fn check_lambda(lambda: f64) -> Result<(), FitError> {
    let positive = lambda > 0.0 && lambda.is_finite();
    if positive { Ok(()) } else { Err(FitError::Lambda { found: lambda }) }
}

impl WeakSystem {
    /// Diagonal added to G in whitened fits, relative to its largest diagonal entry: the size of its rounding errors.
    ///
    /// Windows that slide by one sample are nearly dependent, and lambda S then does not reach above these errors.
    pub const ROUNDING_RIDGE: f64 = 1e-14;

    /// Weights W (occupation kernels x n): (G + lambda I) W = Y, or whitened (G + lambda S) W = Y, with
    /// [`WeakSystem::ROUNDING_RIDGE`].
    ///
    /// The latter is the ridge regression of the whitened system, W = L^-T (L^-1 G L^-T + lambda I)^-1 L^-1 Y, without
    /// the rounding errors of L^-1 G L^-T.
    ///
    /// # Errors
    /// A lambda that is not positive; a matrix that is not positive definite (raise lambda); weights that are not finite.
    pub fn weights(&self, lambda: f64) -> Result<Mat<f64>, FitError> {
        check_lambda(lambda)?;
        let mut matrix = self.gram.clone();
        match &self.noise_covariance {
            Some(covariance) => add_covariance(&mut matrix, covariance, lambda),
            None => (0..matrix.nrows()).for_each(|a| matrix[(a, a)] += lambda),
        }
        let mut weights = self.right_hand_sides.clone();
        solve_positive_definite(&mut matrix, &mut weights).map_err(
            |NonPositivePivot { index }| FitError::NotPositiveDefinite { index, lambda },
        )?;
        check_finite(&weights)?;
        Ok(weights)
    }
}

/// Adds lambda S and the rounding ridge.
fn add_covariance(matrix: &mut Mat<f64>, covariance: &SymmetricBanded, lambda: f64) {
    let rows = matrix.nrows();
    let largest = (0..rows).map(|a| matrix[(a, a)]).fold(0.0, f64::max);
    for a in 0..rows {
        for b in a.saturating_sub(covariance.bandwidth())..rows.min(a + covariance.bandwidth() + 1)
        {
            matrix[(a, b)] += lambda * covariance.get(a, b);
        }
        matrix[(a, a)] += WeakSystem::ROUNDING_RIDGE * largest;
    }
}

fn check_finite(weights: &Mat<f64>) -> Result<(), FitError> {
    for i in 0..weights.ncols() {
        if let Some(index) = weights.col_as_slice(i).iter().position(|weight| !weight.is_finite()) {
            return Err(FitError::NotFinite { index, coordinate: i });
        }
    }
    Ok(())
}
