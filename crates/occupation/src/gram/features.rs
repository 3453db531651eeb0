//! Exact features of kernels of one argument.
//!
//! ```text
//! exp(xi eta) = sum_k phi_k(xi) phi_k(eta),   phi_k(xi) = xi^k / sqrt(k!)
//! exp(-(xi - eta)^2 / 2) = the same, phi_k(xi) = exp(-xi^2 / 2) xi^k / sqrt(k!)
//! ```
//!
//! A few tens of terms are exact to rounding where arguments lie within a few scales of the kernel. G = F F^T then, with
//! one row of (1 + m) features a functional: the cost does not grow with the square of the samples.

use faer::linalg::matmul::triangular::{BlockStructure, matmul};
use faer::{Accum, Mat, Par};

use crate::occupation_kernels::OccupationKernels;
use crate::simd::{Form, Profile};

/// Most terms that are still cheaper than kernel values.
const MOST_TERMS: usize = 64;
/// What the terms that are left out may be, relative to K(x, x).
const ROUNDING: f64 = 1e-17;

/// The series of a kernel over the range of the arguments.
pub(super) struct Features {
    gaussian: bool,
    scale: f64,
    /// Taken from Gaussian arguments, for which only differences count.
    centre: f64,
    /// 1 / sqrt(k) of each term.
    steps: Vec<f64>,
}

impl Features {
    /// None where there is no short series.
    pub fn of(form: &Form, occupation: &OccupationKernels) -> Option<Self> {
        let (&[scale], arguments) = (form.scales.as_slice(), occupation.arguments()) else {
            return None;
        };
        let gaussian = match form.profile {
            Profile::Gaussian => true,
            Profile::Exponential => false,
            _ => return None,
        };
        let (low, high) = arguments
            .iter()
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), x| (a.min(*x), b.max(*x)));
        let centre = if gaussian { 0.5 * (low + high) } else { 0.0 };
        let largest = (low - centre).abs().max((high - centre).abs()) * scale;
        let terms = terms(largest * largest)?;
        let steps = (1..terms).map(|k| 1.0 / (k as f64).sqrt()).collect();
        Some(Self { gaussian, scale, centre, steps })
    }

    fn terms(&self) -> usize {
        self.steps.len() + 1
    }

    fn write(&self, x: f64, features: &mut [f64]) {
        let xi = (x - self.centre) * self.scale;
        let mut term = if self.gaussian { (-0.5 * xi * xi).exp() } else { 1.0 };
        features[0] = term;
        for (feature, step) in features[1..].iter_mut().zip(&self.steps) {
            term *= xi * step;
            *feature = term;
        }
    }

    /// F F^T.
    pub fn gram(&self, occupation: &OccupationKernels) -> Mat<f64> {
        let (count, terms) = (occupation.functionals().len(), self.terms());
        let features = self.of_functionals(occupation);
        let mut gram = Mat::zeros(count, count);
        let features = faer::MatRef::from_row_major_slice(
            &features,
            count,
            terms * (occupation.input_count() + 1),
        );
        matmul(
            &mut gram,
            BlockStructure::TriangularLower,
            Accum::Replace,
            features,
            BlockStructure::Rectangular,
            features.transpose(),
            BlockStructure::Rectangular,
            1.0,
            Par::Seq,
        );
        for b in 1..count {
            for a in 0..b {
                gram[(a, b)] = gram[(b, a)];
            }
        }
        gram
    }

    /// int phi (1, u) of every functional, row after row.
    fn of_functionals(&self, occupation: &OccupationKernels) -> Vec<f64> {
        let (terms, columns) = (self.terms(), occupation.input_count() + 1);
        let mut rows = vec![0.0; occupation.functionals().len() * terms * columns];
        let mut features = vec![0.0; terms];
        for (functional, row) in
            occupation.functionals().iter().zip(rows.chunks_exact_mut(terms * columns))
        {
            for (k, weight) in (functional.first..).zip(&functional.weights) {
                self.write(occupation.argument(k)[0], &mut features);
                let inputs = std::iter::once(1.0).chain(occupation.input(k).iter().copied());
                for (u, sums) in inputs.zip(row.chunks_exact_mut(terms)) {
                    let factor = weight * u;
                    sums.iter_mut().zip(&features).for_each(|(sum, f)| *sum += factor * f);
                }
            }
        }
        rows
    }
}

/// Terms until r^k / k! is lost beside e^r, or none where they are too many.
fn terms(r: f64) -> Option<usize> {
    let mut term = 1.0;
    for k in 1..MOST_TERMS {
        term *= r / k as f64;
        if term < ROUNDING * r.exp() && k as f64 > r {
            return Some(k + 1);
        }
    }
    None
}
