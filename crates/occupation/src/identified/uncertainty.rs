//! How well f and g are known.
//!
//! ```text
//! var f_i(x) = phi(x)^T C phi(x) + a^2 (K(x, x) - phi(x) . phi(x))
//! ```
//!
//! with the features phi of the landmarks, the posterior covariance C of their coefficients, and what the landmarks
//! leave of the prior variance: far from all data the prior's standard deviation a sqrt(K(x, x)) returns.

use faer::{Mat, MatRef};
use serde::{Deserialize, Serialize};

use crate::identification::{Basis, ScaledKernel};
use crate::kernel::Kernel;

/// Posterior of all coordinates.
#[derive(Debug, Clone, PartialEq)]
pub struct Uncertainty {
    rows: Vec<RowPosterior>,
}

/// Posterior of f_i, g_i1, ..., g_im.
#[derive(Debug, Clone)]
pub(crate) struct RowPosterior {
    saved: SavedRow,
    bases: Vec<Basis>,
}

/// What a model's file holds of it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(crate) struct SavedRow {
    terms: Vec<SavedTerm>,
    /// Lower triangle of D^-1 C D^-1 (prior standard deviations D), row after row.
    covariance: Vec<f64>,
}

#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
struct SavedTerm {
    block: usize,
    kernel: ScaledKernel,
    amplitude: f64,
    /// In the order in which they were taken, points x d.
    landmarks: Vec<f64>,
}

/// One function of the row, for its posterior.
pub(crate) struct TermOf<'t> {
    pub block: usize,
    pub amplitude: f64,
    pub basis: &'t Basis,
}

impl RowPosterior {
    /// From the covariance over the prior's standard deviations, for the features of all terms one after the other.
    pub fn of(terms: &[TermOf<'_>], covariance: MatRef<'_, f64>) -> Self {
        let saved_terms = terms.iter().map(|term| SavedTerm {
            block: term.block,
            kernel: term.basis.kernel.clone(),
            amplitude: term.amplitude,
            landmarks: term.basis.landmarks.clone(),
        });
        let size = covariance.nrows();
        let lower = (0..size).flat_map(|i| (0..=i).map(move |j| (i, j)));
        let saved = SavedRow {
            terms: saved_terms.collect(),
            covariance: lower.map(|(i, j)| covariance[(i, j)]).collect(),
        };
        Self { saved, bases: terms.iter().map(|term| term.basis.clone()).collect() }
    }

    fn restore(saved: SavedRow) -> Option<Self> {
        let bases: Option<Vec<Basis>> = saved
            .terms
            .iter()
            .map(|term| Basis::of_landmarks(term.kernel.clone(), term.landmarks.clone()))
            .collect();
        let bases = bases?;
        let size: usize = bases.iter().map(Basis::rank).sum();
        (saved.covariance.len() == size * (size + 1) / 2).then_some(Self { saved, bases })
    }

    /// Standard deviation of each term at x, with its block, and the prior's.
    fn deviations(&self, x: &[f64]) -> Vec<(usize, f64, f64)> {
        let mut first = 0;
        let mut found = Vec::new();
        for (term, basis) in self.saved.terms.iter().zip(&self.bases) {
            let features: Mat<f64> = basis.features(x);
            let rank = basis.rank();
            let mut known = 0.0;
            let mut explained = 0.0;
            for i in 0..rank {
                let row = &self.saved.covariance[(first + i) * (first + i + 1) / 2 + first..];
                let p = features[(0, i)];
                explained += p * p;
                let cross: f64 = (0..i).map(|j| row[j] * features[(0, j)]).sum();
                known += p * (2.0 * cross + row[i] * p);
            }
            let mut scaled = vec![0.0; x.len()];
            basis.kernel.scale(x, &mut scaled);
            let whole = basis.kernel.family.kernel().evaluate(&scaled, &scaled);
            let variance = known.max(0.0) + (whole - explained).max(0.0);
            let prior = term.amplitude * whole.sqrt();
            found.push((term.block, term.amplitude * variance.sqrt(), prior));
            first += rank;
        }
        found
    }
}

impl PartialEq for RowPosterior {
    fn eq(&self, other: &Self) -> bool {
        self.saved == other.saved
    }
}

impl Uncertainty {
    pub(crate) fn new(rows: Vec<RowPosterior>) -> Self {
        Self { rows }
    }

    pub(crate) fn saved(&self) -> Vec<SavedRow> {
        self.rows.iter().map(|row| row.saved.clone()).collect()
    }

    /// None where the landmarks do not make a basis or the covariance has another size.
    pub(crate) fn restore(saved: Vec<SavedRow>, arguments: usize) -> Option<Self> {
        let fits = |row: &SavedRow| {
            row.terms.iter().all(|t| {
                t.kernel.centre.len() == arguments
                    && t.kernel.widths.len() == arguments
                    && t.landmarks.len().is_multiple_of(arguments)
            })
        };
        if !saved.iter().all(fits) {
            return None;
        }
        let rows: Option<Vec<RowPosterior>> =
            saved.into_iter().map(RowPosterior::restore).collect();
        rows.map(Self::new)
    }

    /// Writes the standard deviations of f (n) and g (n x m) at x, after the data and before them (the prior's).
    pub(crate) fn evaluate(&self, x: &[f64], after: [&mut [f64]; 2], before: [&mut [f64]; 2]) {
        let [f, g] = after;
        let [f_prior, g_prior] = before;
        let inputs = g.len() / f.len();
        for (i, row) in self.rows.iter().enumerate() {
            for (block, sd, prior) in row.deviations(x) {
                if block == 0 {
                    (f[i], f_prior[i]) = (sd, prior);
                } else {
                    let at = i * inputs + block - 1;
                    (g[at], g_prior[at]) = (sd, prior);
                }
            }
        }
    }
}
