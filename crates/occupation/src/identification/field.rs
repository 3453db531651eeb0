//! The functions f and g as weighted sums over landmarks, while they are being identified.

use super::basis::Basis;
use super::table::Table;
use crate::simd::dot;

/// Tables reach beyond the data by this share of their range.
const BEYOND: f64 = 0.1;

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
    /// Least and greatest argument of the data, of functions of one argument.
    range: Option<[f64; 2]>,
    /// The same function, where it fits a table.
    table: Option<Table>,
}

impl Term {
    /// A function that is zero as yet, of the arguments `seen` (rows of d).
    pub fn new(row: usize, block: usize, basis: Basis, amplitude: f64, seen: &[f64]) -> Self {
        let zeros = vec![0.0; basis.rank()];
        let range = (basis.kernel.widths.len() == 1).then(|| {
            let limits = [f64::INFINITY, f64::NEG_INFINITY];
            seen.iter().fold(limits, |[low, high], &x| [low.min(x), high.max(x)])
        });
        let (coefficients, weights) = (zeros.clone(), zeros);
        Self { row, block, basis, amplitude, coefficients, weights, range, table: None }
    }

    pub fn set(&mut self, coefficients: &[f64]) {
        self.coefficients = coefficients.to_vec();
        self.weights = self.basis.to_weights(coefficients);
        self.table = self.range.and_then(|[low, high]| {
            let beyond = BEYOND * (high - low);
            let mut room = vec![0.0; self.basis.rank()];
            let room = std::cell::RefCell::new(&mut room);
            let function = |x: f64| {
                let room = &mut room.borrow_mut();
                let (mut scaled, mut slope) = ([0.0], [0.0]);
                let value = self.sum(&[x], &mut scaled, room);
                self.basis.add_gradient(&scaled, &self.weights, 1.0, room, &mut slope);
                [value, slope[0]]
            };
            Table::of([low - beyond, high + beyond], function)
        });
    }

    /// Prior standard deviations of the coefficients of some terms, one after the other.
    pub fn priors<'t>(terms: impl IntoIterator<Item = &'t Self>) -> Vec<f64> {
        terms.into_iter().flat_map(|t| std::iter::repeat_n(t.amplitude, t.basis.rank())).collect()
    }

    /// What the function is multiplied by.
    pub fn input(&self, u: &[f64]) -> f64 {
        if self.block == 0 { 1.0 } else { u[self.block - 1] }
    }

    #[inline(always)]
    fn tabulated(&self, x: &[f64]) -> Option<[f64; 2]> {
        self.table.as_ref()?.at(x[0])
    }

    /// The sum over all landmarks; `values` holds their kernel values afterwards.
    fn sum(&self, x: &[f64], scaled: &mut [f64], values: &mut [f64]) -> f64 {
        self.basis.kernel_row(x, scaled, values);
        dot(values, &self.weights)
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
    values: Vec<f64>,
}

impl Field {
    pub fn room(&self) -> Room {
        let most = self.terms.iter().map(|t| t.basis.rank()).max().unwrap_or(0);
        Room { scaled: vec![0.0; self.arguments], values: vec![0.0; most] }
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

    /// Writes f(x) + g(x) u (n).
    pub fn value(&self, x: &[f64], u: &[f64], room: &mut Room, out: &mut [f64]) {
        out.fill(0.0);
        for term in &self.terms {
            let value = match term.tabulated(x) {
                Some([value, _]) => value,
                None => term.sum(x, &mut room.scaled, &mut room.values[..term.basis.rank()]),
            };
            out[term.row] += term.input(u) * value;
        }
    }

    /// Writes the kernel values of all landmarks.
    pub fn kernel_values(&self, x: &[f64], room: &mut Room, values: &mut [f64]) {
        let mut rest = values;
        for term in &self.terms {
            let own;
            (own, rest) = rest.split_at_mut(term.basis.rank());
            term.basis.kernel_row(x, &mut room.scaled, own);
        }
    }

    /// Writes d(f + g u)_i / dx_j to `jacobian` (n x d).
    pub fn jacobian(&self, x: &[f64], u: &[f64], room: &mut Room, jacobian: &mut [f64]) {
        jacobian.fill(0.0);
        let d = self.arguments;
        for term in &self.terms {
            let row = &mut jacobian[term.row * d..(term.row + 1) * d];
            if let Some([_, slope]) = term.tabulated(x) {
                row[0] += term.input(u) * slope;
                continue;
            }
            term.basis.kernel.scale(x, &mut room.scaled);
            let slopes = &mut room.values[..term.basis.rank()];
            term.basis.add_gradient(&room.scaled, &term.weights, term.input(u), slopes, row);
        }
    }
}
