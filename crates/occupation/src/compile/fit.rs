//! Chebyshev coefficients by least squares.

use faer::linalg::matmul::matmul;
use faer::linalg::matmul::triangular::{BlockStructure, matmul as triangular};
use faer::{Accum, Mat, Par};
use rayon::prelude::*;

use super::samples::Samples;
use crate::linear::solve_positive_definite;

/// Most terms of a series: what least squares can do in some seconds.
pub(crate) const MOST_TERMS: usize = 3600;
/// Points of a chunk of the normal equations.
const CHUNK: usize = 512;

/// Degrees k_1, ..., k_d of a term.
pub(crate) type Term = Vec<u8>;

/// Series with the same terms for several functions.
#[derive(Debug, Clone)]
pub(crate) struct Fit {
    /// The functions.
    pub functions: Vec<usize>,
    pub terms: Vec<Term>,
    /// Terms x functions.
    pub coefficients: Vec<f64>,
    /// Terms beyond which there is none in any direction.
    pub outermost: Vec<bool>,
}

/// Terms with sum_i k_i / D_i <= theta over the arguments with D_i > 0; none where there are more than [`MOST_TERMS`].
pub(crate) fn terms(degrees: &[usize], theta: f64) -> Option<Vec<Term>> {
    let mut found: Vec<(f64, Term)> = vec![(0.0, vec![0; degrees.len()])];
    for (i, &degree) in degrees.iter().enumerate().filter(|(_, d)| **d > 0) {
        let mut raised = Vec::new();
        for (weight, term) in &found {
            let most = (((theta - weight) * degree as f64 + 1e-9) as usize)
                .min(super::degrees::MOST_DEGREE);
            for k in 0..=most {
                let mut term = term.clone();
                term[i] = k as u8;
                raised.push((weight + k as f64 / degree as f64, term));
            }
            if raised.len() > MOST_TERMS {
                return None;
            }
        }
        found = raised;
    }
    Some(found.into_iter().map(|(_, term)| term).collect())
}

/// T_k(z), k = 0, ..., `degree`.
pub(crate) fn chebyshev(z: f64, degree: usize) -> Vec<f64> {
    let mut values = vec![1.0, z];
    for k in 2..=degree {
        values.push(2.0 * z * values[k - 1] - values[k - 2]);
    }
    values
}

/// Products T_k(z) of the terms.
pub(crate) fn products(terms: &[Term], z: &[f64], into: &mut [f64]) {
    let highest = |i: usize| terms.iter().map(|t| usize::from(t[i])).max().unwrap_or(0);
    let factors: Vec<Vec<f64>> =
        z.iter().enumerate().map(|(i, z)| chebyshev(*z, highest(i))).collect();
    for (product, term) in into.iter_mut().zip(terms) {
        let chosen = term.iter().zip(&factors).map(|(k, factors)| factors[usize::from(*k)]);
        *product = chosen.product();
    }
}

impl Fit {
    /// Least squares on points that are dense as the polynomials want it, by the normal equations: in that measure they
    /// are well conditioned. None where they are not, for want of points.
    pub fn new(functions: Vec<usize>, terms: Vec<Term>, samples: &Samples) -> Option<Self> {
        let (m, e) = (terms.len(), functions.len());
        let mut gram = Mat::<f64>::zeros(m, m);
        let mut right = Mat::<f64>::zeros(m, e);
        let chunks = samples.points.chunks(CHUNK).zip(samples.values.chunks(CHUNK));
        for (points, values) in chunks {
            let mut columns = Mat::<f64>::zeros(m, points.len());
            columns.as_mut().par_col_iter_mut().zip(points).for_each(|(column, z)| {
                if let Some(slice) = column.try_as_col_major_mut() {
                    products(&terms, z, slice.as_slice_mut());
                }
            });
            let known = Mat::from_fn(points.len(), e, |k, j| values[k][functions[j]]);
            triangular(
                &mut gram,
                BlockStructure::TriangularLower,
                Accum::Add,
                &columns,
                BlockStructure::Rectangular,
                columns.transpose(),
                BlockStructure::Rectangular,
                1.0,
                Par::Seq,
            );
            matmul(&mut right, Accum::Add, &columns, &known, 1.0, Par::Seq);
        }
        solve_positive_definite(&mut gram, &mut right).ok()?;
        let coefficients = (0..m).flat_map(|k| (0..e).map(move |j| (k, j)));
        let coefficients = coefficients.map(|(k, j)| right[(k, j)]).collect();
        let outermost = outermost(&terms);
        Some(Self { functions, terms, coefficients, outermost })
    }

    /// Leaves the functions that are marked.
    pub fn keep(&mut self, marked: &[bool]) {
        let mut columns = marked.iter().cycle();
        self.coefficients.retain(|_| columns.next() == Some(&true));
        let mut columns = marked.iter();
        self.functions.retain(|_| columns.next() == Some(&true));
    }

    /// Absolute values of one function's coefficients of the outermost terms.
    pub fn outermost_of(&self, column: usize) -> f64 {
        let rows = self.coefficients.chunks_exact(self.functions.len());
        let outermost = rows.zip(&self.outermost).filter(|(_, outermost)| **outermost);
        outermost.map(|(row, _)| row[column].abs()).sum()
    }

    /// Greatest error of each function on the samples.
    pub fn errors(&self, samples: &Samples) -> Vec<f64> {
        let e = self.functions.len();
        let one = |(z, values): (&Vec<f64>, &Vec<f64>)| {
            let mut basis = vec![0.0; self.terms.len()];
            products(&self.terms, z, &mut basis);
            let mut sums: Vec<f64> = self.functions.iter().map(|&j| -values[j]).collect();
            for (product, coefficients) in basis.iter().zip(self.coefficients.chunks_exact(e)) {
                sums.iter_mut().zip(coefficients).for_each(|(sum, c)| *sum += c * product);
            }
            sums.iter().map(|s| s.abs()).collect::<Vec<f64>>()
        };
        let greater = |a: Vec<f64>, b: Vec<f64>| a.iter().zip(&b).map(|(a, b)| a.max(*b)).collect();
        let pairs = samples.points.par_iter().zip(&samples.values);
        pairs.map(one).reduce(|| vec![0.0; e], greater)
    }
}

/// Whether no term is higher in every degree at once.
fn outermost(terms: &[Term]) -> Vec<bool> {
    let all: std::collections::HashSet<&Term> = terms.iter().collect();
    let used: Vec<usize> = (0..terms.first().map_or(0, Vec::len))
        .filter(|&i| terms.iter().any(|t| t[i] > 0))
        .collect();
    let lacks_one = |term: &Term| {
        used.iter().any(|&i| {
            let mut higher = term.clone();
            higher[i] += 1;
            !all.contains(&higher)
        })
    };
    terms.iter().map(lacks_one).collect()
}
