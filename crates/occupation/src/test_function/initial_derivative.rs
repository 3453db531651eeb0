use faer::Mat;
use serde::{Deserialize, Serialize};

use super::TestFunctionError;
use crate::linear::solve_positive_definite;

/// Where the endpoint test function of order s >= 2 takes the derivatives y', ..., y^(s-1) at the first sample from.
///
/// Compact test functions need none, and order 1 neither.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(tag = "kind", rename_all = "snake_case")]
pub enum InitialDerivative {
    /// Forward differences of the first samples (the paper): (y_1 - y_0) / (t_1 - t_0) for y'; for y^(k) the k-th
    /// derivative of the polynomial through the first k + 1 samples. Noise of sd sigma becomes sigma sqrt(2) / step.
    #[default]
    ForwardDifference,
    /// Known ones: [`crate::TrajectoryData::with_initial_derivatives`].
    Given,
    /// The derivatives at the first sample of a least-squares polynomial through the first samples.
    LocalPolynomial {
        /// Number of samples fitted.
        samples: usize,
        /// Degree of the polynomial, less than `samples`.
        degree: usize,
    },
}

impl InitialDerivative {
    /// Weights r with y^(k)(t_0) = sum_i r_i y_i, or none where the derivatives are given.
    pub(super) fn weights(
        self,
        times: &[f64],
        derivative: usize,
    ) -> Result<Option<Vec<f64>>, TestFunctionError> {
        match self {
            Self::Given => Ok(None),
            Self::ForwardDifference => {
                polynomial_derivative(times, derivative + 1, derivative, derivative).map(Some)
            }
            Self::LocalPolynomial { samples, degree } => {
                polynomial_derivative(times, samples, degree, derivative).map(Some)
            }
        }
    }
}

/// Weights of the derivative at the first sample of the least-squares polynomial through the first `samples` samples.
///
/// With the Vandermonde matrix V of x = (t - t_0) / span, the coefficients are (V^T V)^-1 V^T y; the k-th, times
/// k! / span^k, is the derivative.
fn polynomial_derivative(
    times: &[f64],
    samples: usize,
    degree: usize,
    derivative: usize,
) -> Result<Vec<f64>, TestFunctionError> {
    if degree < derivative || samples <= degree {
        return Err(TestFunctionError::LocalPolynomial { degree, samples, derivative });
    }
    let start = times[0];
    if times.len() < samples {
        let what = "the estimate of the initial derivative";
        return Err(TestFunctionError::TooFewSamples {
            what,
            start,
            expected: samples,
            found: times.len(),
        });
    }
    let span = times[samples - 1] - start;
    let vandermonde =
        Mat::from_fn(samples, degree + 1, |i, j| ((times[i] - start) / span).powi(j as i32));
    let mut normal = vandermonde.transpose() * &vandermonde;
    let mut selector = Mat::from_fn(degree + 1, 1, |j, _| if j == derivative { 1.0 } else { 0.0 });
    solve_positive_definite(&mut normal, &mut selector)
        .map_err(|_| TestFunctionError::Degenerate { start })?;
    let weights = &vandermonde * &selector;
    let scale: f64 = (1..=derivative).map(|factor| factor as f64 / span).product();
    Ok(weights.col(0).iter().map(|weight| weight * scale).collect())
}
