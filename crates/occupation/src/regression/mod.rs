//! Control occupation kernel regression: from trajectories to an [`IdentifiedModel`].

mod error;
pub mod low_rank;

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
        let mut occupation = OccupationKernels::new(first.argument_count(), first.input_count());
        let (mut right_hand_sides, mut noise) = (Vec::new(), Vec::new());
        for (index, data) in trajectories.iter().enumerate() {
            check_shape(first, data, index)?;
            let weak = self.weak_trajectory(index, data)?;
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

    fn weak_trajectory(
        &self,
        index: usize,
        data: &TrajectoryData,
    ) -> Result<WeakTrajectory, FitError> {
        let in_trajectory = |source| FitError::TestFunction { trajectory: index, source };
        let occupation = self
            .test_function
            .functionals(data.times(), self.quadrature, 0)
            .map_err(in_trajectory)?;
        let noise = self
            .test_function
            .right_hand_sides(data.times(), self.quadrature, self.order, self.initial_derivative)
            .map_err(in_trajectory)?;
        let known = self.known_initial_part(index, data)?;
        let n = data.dimension();
        let value = |a: usize, i: usize| noise[a].apply_column(data.coordinates(), n, i) - known[i];
        let right_hand_sides = (0..noise.len() * n).map(|k| value(k / n, k % n)).collect();
        Ok(WeakTrajectory { occupation, noise, right_hand_sides })
    }

    /// sum_{1 <= k < s} y^(k)(0) T^k / k! from given derivatives; zero where the samples, or nothing, supply them.
    fn known_initial_part(
        &self,
        index: usize,
        data: &TrajectoryData,
    ) -> Result<Vec<f64>, FitError> {
        let n = data.dimension();
        let mut known = vec![0.0; n];
        let endpoint = matches!(self.test_function, TestFunction::Endpoint { .. });
        if !endpoint || self.order == 1 || self.initial_derivative != InitialDerivative::Given {
            return Ok(known);
        }
        let derivatives = data.initial_derivatives().unwrap_or_default();
        let expected = (self.order - 1) * n;
        if derivatives.len() != expected {
            return Err(FitError::InitialDerivatives {
                trajectory: index,
                expected,
                found: derivatives.len(),
            });
        }
        let duration = data.times()[data.samples() - 1] - data.times()[0];
        let mut taylor = 1.0;
        for (k, derivative) in derivatives.chunks_exact(n).enumerate() {
            taylor *= duration / (k + 1) as f64;
            known.iter_mut().zip(derivative).for_each(|(sum, value)| *sum += taylor * value);
        }
        Ok(known)
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

struct WeakTrajectory {
    /// phi w: what the occupation kernels integrate with.
    occupation: Vec<crate::Functional>,
    /// What the right-hand sides do to the samples of a coordinate, and so to its noise.
    noise: Vec<crate::Functional>,
    /// Functionals x n.
    right_hand_sides: Vec<f64>,
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
