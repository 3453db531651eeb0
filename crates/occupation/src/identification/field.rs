//! The functions f and g as weighted sums over landmarks, while they are being identified.

use super::basis::Basis;
use crate::vector::add_weighted_sums;

/// One function f_i (block 0) or g_ij (block j) with the weights of its landmarks.
#[derive(Debug, Clone)]
pub(crate) struct Term {
    pub row: usize,
    pub block: usize,
    pub basis: Basis,
    /// Prior standard deviation a.
    pub amplitude: f64,
    /// Coefficients of the features.
    pub coefficients: Vec<f64>,
    /// L^-T coefficients.
    pub weights: Vec<f64>,
}

impl Term {
    pub fn new(row: usize, block: usize, basis: Basis, amplitude: f64) -> Self {
        let zeros = vec![0.0; basis.rank()];
        Self { row, block, basis, amplitude, coefficients: zeros.clone(), weights: zeros }
    }

    pub fn set(&mut self, coefficients: &[f64]) {
        self.coefficients = coefficients.to_vec();
        self.weights = self.basis.to_weights(coefficients);
    }

    /// Prior standard deviations of the coefficients of some terms, one after the other.
    pub fn priors<'t>(terms: impl IntoIterator<Item = &'t Self>) -> Vec<f64> {
        terms.into_iter().flat_map(|t| std::iter::repeat_n(t.amplitude, t.basis.rank())).collect()
    }

    fn input(&self, u: &[f64]) -> f64 {
        if self.block == 0 { 1.0 } else { u[self.block - 1] }
    }
}

/// All functions, of n coordinates and m inputs.
#[derive(Debug, Clone)]
pub(crate) struct Field {
    pub dimension: usize,
    pub arguments: usize,
    pub terms: Vec<Term>,
}

/// Room for evaluations.
#[derive(Debug)]
pub(crate) struct Room {
    scaled: Vec<f64>,
    slopes: Vec<f64>,
}

impl Field {
    pub fn room(&self) -> Room {
        let most = self.terms.iter().map(|t| t.basis.rank()).max().unwrap_or(0);
        Room { scaled: vec![0.0; self.arguments], slopes: vec![0.0; most] }
    }

    /// Number of all features.
    pub fn features(&self) -> usize {
        self.terms.iter().map(|t| t.basis.rank()).sum()
    }

    pub fn coefficients(&self) -> Vec<f64> {
        self.terms.iter().flat_map(|t| &t.coefficients).copied().collect()
    }

    pub fn set(&mut self, coefficients: &[f64]) {
        let mut first = 0;
        for term in &mut self.terms {
            let rank = term.basis.rank();
            term.set(&coefficients[first..first + rank]);
            first += rank;
        }
    }

    /// Writes f(x) + g(x) u (n), and the kernel values of all landmarks (times nothing) to `values`.
    pub fn value(
        &self,
        x: &[f64],
        u: &[f64],
        values: &mut [f64],
        room: &mut Room,
        out: &mut [f64],
    ) {
        out.fill(0.0);
        let mut first = 0;
        for term in &self.terms {
            let values = &mut values[first..first + term.basis.rank()];
            term.basis.kernel_row(x, &mut room.scaled, values);
            let mut sum = [0.0];
            add_weighted_sums(values, &term.weights, &mut sum);
            out[term.row] += term.input(u) * sum[0];
            first += term.basis.rank();
        }
    }

    /// Writes d(f + g u)_i / dx_j to `jacobian` (n x d).
    pub fn jacobian(&self, x: &[f64], u: &[f64], room: &mut Room, jacobian: &mut [f64]) {
        jacobian.fill(0.0);
        let d = self.arguments;
        for term in &self.terms {
            let rank = term.basis.rank();
            term.basis.kernel.scale(x, &mut room.scaled);
            let row = &mut jacobian[term.row * d..(term.row + 1) * d];
            let slopes = &mut room.slopes[..rank];
            term.basis.add_gradient(&room.scaled, &term.weights, term.input(u), slopes, row);
        }
    }
}
