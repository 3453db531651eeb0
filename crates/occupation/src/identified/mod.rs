//! The identified model: drift and control effectiveness as sums of kernels.

mod expansion;
mod file;
mod occupation;
mod uncertainty;

use std::borrow::Cow;

use faer::Mat;

use crate::kernel::KernelSpec;
use crate::occupation_kernels::OccupationKernels;
pub(crate) use expansion::{Expansion, SavedExpansion};
pub use file::{ModelFileError, Names, SavedModelError};
pub(crate) use occupation::{OccupationExpansion, SavedOccupation};
pub use uncertainty::Uncertainty;
pub(crate) use uncertainty::{RowPosterior, TermOf};

/// H(x) = \[f(x) g(x)\], an n x (m + 1) matrix, as sums over points,
///
/// ```text
/// f_i(x) = sum_k w_ik K(x, p_k),   g_ij(x) = sum_k w_ijk K(x, p_k)
/// ```
///
/// with one kernel and one set of points for all entries (the samples, for [`crate::Regression`]), or others for each
/// (landmarks, for [`crate::Identification`]). The latter comes with standard deviations.
#[derive(Debug, Clone, PartialEq)]
pub struct IdentifiedModel {
    order: usize,
    dimension: usize,
    inputs: usize,
    arguments: usize,
    expansions: Vec<Expansion>,
    occupation: Option<OccupationExpansion>,
    uncertainty: Option<Uncertainty>,
    names: Option<Names>,
}

/// Standard deviations of f (n) and g (n x m) at a point.
#[derive(Debug, Clone, PartialEq)]
pub struct StandardDeviations {
    /// Of f.
    pub f: Vec<f64>,
    /// Of g.
    pub g: Vec<f64>,
    /// Of f before the data.
    pub f_prior: Vec<f64>,
    /// Of g before the data.
    pub g_prior: Vec<f64>,
}

impl IdentifiedModel {
    /// H(x) = sum_a W_a Gamma_a(x)^T, in the form that is cheaper to evaluate.
    pub(crate) fn of_weights(
        kernel: KernelSpec,
        order: usize,
        occupation: &OccupationKernels,
        weights: &Mat<f64>,
    ) -> Self {
        let (n, m, d) = (weights.ncols(), occupation.input_count(), occupation.argument_count());
        let apart = occupation.are_apart().then(|| {
            let rows = (0..weights.nrows()).flat_map(|a| (0..n).map(move |i| weights[(a, i)]));
            let saved = SavedOccupation {
                kernel: kernel.clone(),
                lengths: occupation.functionals().iter().map(|f| f.weights.len()).collect(),
                functionals: occupation
                    .functionals()
                    .iter()
                    .flat_map(|f| f.weights.clone())
                    .collect(),
                points: occupation.arguments().to_vec(),
                inputs: occupation.inputs().to_vec(),
                weights: rows.collect(),
            };
            OccupationExpansion::new(saved, [d, m, n])
        });
        match apart.flatten() {
            Some(sum) => {
                let mut model = Self::of_expansions(order, [n, m, d], Vec::new(), None);
                model.occupation = Some(sum);
                model
            }
            None => Self::fold(kernel, order, occupation, weights),
        }
    }

    /// The weights are folded per sample, beta_k = sum_a c_a(k) W_a in R^n, so that
    ///
    /// ```text
    /// f(x) = sum_k beta_k K(x, x_k),   g(x) = sum_k beta_k K(x, x_k) u_k^T
    /// ```
    ///
    /// costs one kernel value a sample, however many test functions overlap there; samples without weight are left out.
    fn fold(
        kernel: KernelSpec,
        order: usize,
        occupation: &OccupationKernels,
        weights: &Mat<f64>,
    ) -> Self {
        let n = weights.ncols();
        let mut folded = vec![0.0; occupation.samples() * n];
        for (a, functional) in occupation.functionals().iter().enumerate() {
            let samples = folded[functional.first * n..functional.end() * n].chunks_exact_mut(n);
            for (coefficient, c) in samples.zip(&functional.weights) {
                let entries = coefficient.iter_mut().enumerate();
                entries.for_each(|(i, entry)| *entry += c * weights[(a, i)]);
            }
        }
        let shape = [n, occupation.input_count(), occupation.argument_count()];
        let samples = [occupation.arguments(), occupation.inputs()];
        let expansion = Expansion::of_samples(kernel, shape, samples, &folded);
        Self::of_expansions(order, shape, vec![expansion], None)
    }

    /// A model of n coordinates, m inputs and d arguments.
    pub(crate) fn of_expansions(
        order: usize,
        [dimension, inputs, arguments]: [usize; 3],
        expansions: Vec<Expansion>,
        uncertainty: Option<Uncertainty>,
    ) -> Self {
        let (occupation, names) = (None, None);
        Self { order, dimension, inputs, arguments, expansions, occupation, uncertainty, names }
    }

    /// The same with the names of what it was identified from.
    pub fn with_names(mut self, names: Names) -> Self {
        self.names = Some(names);
        self
    }

    /// Writes the drift f(x) (n) and the control effectiveness g(x) (n x m, row-major) at x (d). Allocates nothing.
    ///
    /// # Errors
    /// A slice of another length than d, n or n m.
    pub fn evaluate(&self, x: &[f64], f: &mut [f64], g: &mut [f64]) -> Result<(), EvaluationError> {
        check_length("x", self.arguments, x.len())?;
        check_length("f", self.dimension, f.len())?;
        check_length("g", self.dimension * self.inputs, g.len())?;
        f.fill(0.0);
        g.fill(0.0);
        self.expansions.iter().for_each(|expansion| expansion.add(x, f, g));
        self.occupation.iter().for_each(|expansion| expansion.add(x, f, g));
        Ok(())
    }

    /// Standard deviations of f and g at x (d); none for a model without them ([`crate::Regression`]).
    ///
    /// # Errors
    /// An x of another length than d.
    pub fn standard_deviations(
        &self,
        x: &[f64],
    ) -> Result<Option<StandardDeviations>, EvaluationError> {
        check_length("x", self.arguments, x.len())?;
        let Some(uncertainty) = &self.uncertainty else { return Ok(None) };
        let (n, entries) = (self.dimension, self.dimension * self.inputs);
        let mut sd = StandardDeviations {
            f: vec![0.0; n],
            g: vec![0.0; entries],
            f_prior: vec![0.0; n],
            g_prior: vec![0.0; entries],
        };
        uncertainty.evaluate(x, [&mut sd.f, &mut sd.g], [&mut sd.f_prior, &mut sd.g_prior]);
        Ok(Some(sd))
    }

    /// Number n of coordinates.
    pub fn dimension(&self) -> usize {
        self.dimension
    }

    /// Number m of inputs.
    pub fn inputs(&self) -> usize {
        self.inputs
    }

    /// Number d of arguments x.
    pub fn arguments(&self) -> usize {
        self.arguments
    }

    /// Order s of the dynamics.
    pub fn order(&self) -> usize {
        self.order
    }

    /// Number of points in all sums: kernel values that an evaluation costs.
    pub fn points(&self) -> usize {
        let landmarks: usize = self.expansions.iter().map(Expansion::points).sum();
        landmarks + self.occupation.as_ref().map_or(0, OccupationExpansion::points)
    }

    /// The sums that it is made of.
    pub(crate) fn expansions(&self) -> Cow<'_, [Expansion]> {
        match &self.occupation {
            None => Cow::Borrowed(&self.expansions),
            Some(sum) => {
                let folded = std::iter::once(sum.folded(self.dimension));
                Cow::Owned(self.expansions.iter().cloned().chain(folded).collect())
            }
        }
    }

    /// Names of what it was identified from, where given.
    pub fn names(&self) -> Option<&Names> {
        self.names.as_ref()
    }
}

fn check_length(what: &'static str, expected: usize, found: usize) -> Result<(), EvaluationError> {
    if expected == found { Ok(()) } else { Err(EvaluationError { what, expected, found }) }
}

/// A slice of the wrong length.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error("{what} must have {expected} entries, found {found}")]
pub struct EvaluationError {
    /// Which slice.
    pub what: &'static str,
    /// Its length for this model.
    pub expected: usize,
    /// Its length.
    pub found: usize,
}
