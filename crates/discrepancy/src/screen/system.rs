//! The linear systems of the screening, before and after whitening.

use crate::evidence::{Evidence, Normal, regress};
use crate::weak::{Column, Whitener};

/// Target, columns and priors of a regression.
#[derive(Clone)]
pub(super) struct System {
    pub target: Column,
    pub columns: Vec<Column>,
    pub priors: Vec<Normal>,
}

impl System {
    pub(super) fn whitened(&self, whitener: &Whitener) -> WhitenedSystem {
        WhitenedSystem {
            target: whitener.whiten(&self.target),
            columns: self.columns.iter().map(|c| whitener.whiten(c)).collect(),
            priors: self.priors.clone(),
            log_determinant: whitener.log_determinant(),
        }
    }
}

/// A whitened base with its fit: what further terms are tried on.
pub(super) struct Ground {
    pub system: WhitenedSystem,
    pub fit: Evidence,
    pub residual: Column,
    pub whitener: Whitener,
}

pub(super) struct WhitenedSystem {
    pub target: Column,
    pub columns: Vec<Column>,
    pub priors: Vec<Normal>,
    pub log_determinant: f64,
}

impl WhitenedSystem {
    /// The same regression on some of the rows.
    pub(super) fn rows(&self, ranges: &[std::ops::Range<usize>]) -> Self {
        let pick = |c: &Column| ranges.iter().flat_map(|r| c[r.clone()].iter().copied()).collect();
        Self {
            target: pick(&self.target),
            columns: self.columns.iter().map(pick).collect(),
            priors: self.priors.clone(),
            log_determinant: 0.0,
        }
    }

    pub(super) fn refs(&self) -> Vec<&[f64]> {
        self.columns.iter().map(Vec::as_slice).collect()
    }

    pub(super) fn regress(&self) -> Option<Evidence> {
        regress(&self.target, &self.refs(), &self.priors, self.log_determinant)
    }

    pub(super) fn residual(&self, fit: &Evidence) -> Column {
        let mut residual = self.target.clone();
        for (column, b) in self.columns.iter().zip(&fit.coefficients) {
            residual.iter_mut().zip(column).for_each(|(r, x)| *r -= b * x);
        }
        residual
    }

    /// Take from a column what the base would explain of it: `c - X H^-1 X^T c`.
    pub(super) fn project_out(&self, fit: &Evidence, column: &mut [f64]) {
        let dots: Vec<f64> =
            self.columns.iter().map(|x| x.iter().zip(&*column).map(|(a, b)| a * b).sum()).collect();
        for (i, x) in self.columns.iter().enumerate() {
            let b: f64 = (0..dots.len()).map(|j| fit.covariance[(i, j)] * dots[j]).sum();
            column.iter_mut().zip(x).for_each(|(c, x)| *c -= b * x);
        }
    }
}
