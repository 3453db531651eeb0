//! Ways to identify a model, side by side: each study is carried out with every recipe.

use lacuna_occupation::{
    ExponentialDotProduct, IdentifiedModel, InitialDerivative, Quadrature, Regression,
    TestFunction, TrajectoryData,
};
use std::collections::BTreeMap;

use crate::StudyError;

/// A way to identify a model from trajectories.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Recipe {
    /// Settings and estimates of the paper: exponential dot product kernel with mu = 5,
    /// lambda = 1e-3, Simpson's rule over whole trajectories, and for order 2 the initial
    /// velocity as the first forward difference.
    Paper,
}

impl Recipe {
    /// All recipes.
    pub const ALL: [Self; 1] = [Self::Paper];

    /// Name in result files and legends.
    pub fn name(self) -> &'static str {
        match self {
            Self::Paper => "paper",
        }
    }

    /// Identify `x'' = f(x) + g(x) u` from noisy positions.
    ///
    /// # Errors
    /// [`StudyError::Regression`] when the regression fails.
    pub fn duffing(self, data: &[TrajectoryData]) -> Result<IdentifiedModel, StudyError> {
        match self {
            Self::Paper => Ok(paper(2, PAPER_LAMBDA).fit(data)?),
        }
    }

    /// Identify `x' = f(x) + g(x) u` from states.
    ///
    /// # Errors
    /// [`StudyError::Regression`] when the regression fails.
    pub fn manipulator(self, data: &[TrajectoryData]) -> Result<IdentifiedModel, StudyError> {
        match self {
            Self::Paper => Ok(paper(1, PAPER_LAMBDA).fit(data)?),
        }
    }
}

/// The paper's regularisation.
const PAPER_LAMBDA: f64 = 1e-3;

/// The paper's regression for a system of the given order.
pub fn paper(order: usize, lambda: f64) -> Regression {
    Regression {
        kernel: ExponentialDotProduct { mu: 5.0 }.into(),
        order,
        test_function: TestFunction::Endpoint { order },
        quadrature: Quadrature::Simpson,
        lambda,
        initial_derivative: InitialDerivative::ForwardDifference,
        whiten: false,
    }
}

/// What `measure` finds for each recipe, by name.
///
/// # Errors
/// The first error of `measure`.
pub fn with_each<T>(
    mut measure: impl FnMut(Recipe) -> Result<T, StudyError>,
) -> Result<BTreeMap<String, T>, StudyError> {
    Recipe::ALL.into_iter().map(|r| Ok((r.name().to_owned(), measure(r)?))).collect()
}
