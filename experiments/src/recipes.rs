//! Ways to identify a model, side by side: each study is carried out with every recipe.

use lacuna_occupation::{
    Arguments, ExponentialDotProduct, FitError, Identification, Identified, IdentifiedModel,
    InitialDerivative, InputPath, Motion, Quadrature, Regression, TestFunction, TrajectoryData,
};
use std::collections::BTreeMap;
use thiserror::Error;

use crate::StudyError;
use crate::identified::Evaluate;
use crate::sindy::{SparseRegressionError, sindyc, wsindy};

/// A way to identify a model from trajectories.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Recipe {
    /// Settings and estimates of the paper: exponential dot product kernel with mu = 5,
    /// lambda = 1e-3, Simpson's rule over whole trajectories, and for order 2 the initial
    /// velocity as the first forward difference.
    Paper,
    /// This project's regression with nothing set by hand: no initial derivatives, kernels, regularisation and noise
    /// from the data, refined along the model's own trajectories ([`lacuna_occupation::Identification`]).
    Lacuna,
    /// What the paper compares itself with: sparse regression of numerical derivatives on a library
    /// of monomials and trigonometric functions ([`sindyc`]).
    Sindyc,
    /// The same library in weak form ([`wsindy`]).
    Wsindy,
}

/// What a recipe makes.
pub type Model = Box<dyn Evaluate>;

impl Recipe {
    /// All recipes.
    pub const ALL: [Self; 4] = [Self::Paper, Self::Lacuna, Self::Sindyc, Self::Wsindy];

    /// Those by occupation kernels.
    pub const KERNELS: [Self; 2] = [Self::Paper, Self::Lacuna];

    /// Those that take seconds on any study.
    pub const QUICK: [Self; 3] = [Self::Paper, Self::Sindyc, Self::Wsindy];

    /// Name in result files and legends.
    pub fn name(self) -> &'static str {
        match self {
            Self::Paper => "paper",
            Self::Lacuna => "lacuna",
            Self::Sindyc => "sindyc",
            Self::Wsindy => "wsindy",
        }
    }

    /// Identify `x'' = f(x) + g(x) u` from noisy positions.
    ///
    /// # Errors
    /// [`IdentificationError`] when the regression fails.
    pub fn duffing(self, data: &[TrajectoryData]) -> Result<Model, IdentificationError> {
        self.identify(data, 2)
    }

    /// Identify `x' = f(x) + g(x) u` from states.
    ///
    /// # Errors
    /// [`IdentificationError`] when the regression fails.
    pub fn manipulator(self, data: &[TrajectoryData]) -> Result<Model, IdentificationError> {
        self.identify(data, 1)
    }

    fn identify(self, data: &[TrajectoryData], order: usize) -> Result<Model, IdentificationError> {
        Ok(match self {
            Self::Paper => Box::new(paper(order, PAPER_LAMBDA).fit(data)?),
            Self::Lacuna => Box::new(lacuna(data, order)?.model),
            Self::Sindyc => Box::new(sindyc(data, order)?),
            Self::Wsindy => Box::new(wsindy(data, order)?),
        })
    }

    /// Identify `x' = f(x) + g(x) u` from states by occupation kernels; none for the recipes of sparse regression.
    ///
    /// # Errors
    /// [`IdentificationError`] when the regression fails.
    pub fn occupation_kernels(
        self,
        data: &[TrajectoryData],
    ) -> Result<Option<IdentifiedModel>, IdentificationError> {
        Ok(match self {
            Self::Paper => Some(paper(1, PAPER_LAMBDA).fit(data)?),
            Self::Lacuna => Some(lacuna(data, 1)?.model),
            Self::Sindyc | Self::Wsindy => None,
        })
    }
}

/// Why a recipe makes no model of the data.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum IdentificationError {
    /// The occupation kernel regression failed.
    #[error(transparent)]
    OccupationKernels(#[from] FitError),
    /// The identification failed.
    #[error(transparent)]
    Identification(#[from] lacuna_occupation::IdentificationError),
    /// The sparse regression failed.
    #[error(transparent)]
    SparseRegression(#[from] SparseRegressionError),
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

/// Everything from the noisy coordinates and the sampled inputs alone.
///
/// # Errors
/// As [`Identification::identify`].
pub fn lacuna(
    data: &[TrajectoryData],
    order: usize,
) -> Result<Identified, lacuna_occupation::IdentificationError> {
    let motions: Vec<Motion> = data.iter().map(Motion::try_from).collect::<Result<_, _>>()?;
    let arguments = if order == 1 { Arguments::State } else { Arguments::Coordinates };
    Identification::new(order, arguments, InputPath::Smooth).identify(&motions)
}

/// What `measure` finds for each of the recipes, by name.
///
/// # Errors
/// The first error of `measure`.
pub fn with_each<T>(
    recipes: &[Recipe],
    mut measure: impl FnMut(Recipe) -> Result<T, StudyError>,
) -> Result<BTreeMap<String, T>, StudyError> {
    recipes.iter().map(|&r| Ok((r.name().to_owned(), measure(r)?))).collect()
}
