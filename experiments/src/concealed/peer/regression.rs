//! Sparse regression with a threshold that predicts recordings left out.

use nalgebra::{DMatrix, DVector};

use super::PeerError;
use super::library::Term;
use super::residual::Residuals;
use crate::sindy::{NormalEquations, Stlsq};

/// Thresholds on coefficients of columns and residuals of unit size.
const THRESHOLDS: [f64; 10] = [0.03, 0.05, 0.08, 0.12, 0.17, 0.23, 0.3, 0.4, 0.55, 0.75];
/// Ridge per row.
const RIDGE: f64 = 1e-6;
/// Share of a column that must be left once the parameters are taken out of it.
const LEFT: f64 = 0.02;

/// Share of a column that must be left once earlier terms are taken out of it as well.
const DEPENDENT: f64 = 1e-4;

/// The regression of one channel's residual, parameters taken out, everything of unit size.
pub struct Problem {
    /// Columns of the library that are left, by their number.
    terms: Vec<usize>,
    /// Values of these columns, recording by recording.
    columns: Vec<DMatrix<f64>>,
    /// Residuals, recording by recording.
    residuals: Vec<DMatrix<f64>>,
    /// Share of the residual's mean square that the parameters explain.
    pub explained: f64,
}

impl Problem {
    /// The regression of a channel's residual on terms.
    pub fn of(residuals: &Residuals, channel: usize, terms: &[Term]) -> Self {
        let rows: Vec<_> = residuals.recordings.iter().flatten().collect();
        let vector = |f: &dyn Fn(usize) -> f64| DVector::from_fn(rows.len(), |k, _| f(k));
        let basis = orthonormal(
            (0..rows.first().map_or(0, |r| r.sensitivity[channel].len()))
                .map(|p| vector(&|k| rows[k].sensitivity[channel][p])),
        );
        let mut target = vector(&|k| rows[k].residual[channel]);
        let before = target.norm_squared();
        project(&basis, &mut target);
        let explained = 1.0 - target.norm_squared() / before.max(f64::MIN_POSITIVE);
        let mut kept = Vec::new();
        let mut columns = Vec::new();
        let mut spanned = basis.clone();
        for (k, term) in terms.iter().enumerate() {
            let mut column = vector(&|r| (term.value)(&rows[r].sample(channel)));
            let size = column.norm();
            project(&basis, &mut column);
            let mut new = column.clone();
            project(&spanned, &mut new);
            // What parameters do, or earlier terms (the sign of a level is a constant), is no term.
            if column.norm() > LEFT * size && new.norm() > DEPENDENT * size {
                kept.push(k);
                spanned.push(new.normalize());
                columns.push(unit(column));
            }
        }
        let lengths: Vec<usize> = residuals.recordings.iter().map(Vec::len).collect();
        let all = match columns.is_empty() {
            true => DMatrix::zeros(rows.len(), 0),
            false => DMatrix::from_columns(&columns),
        };
        let target = unit(target);
        let target = DMatrix::from_column_slice(target.len(), 1, target.as_slice());
        Self {
            terms: kept,
            columns: split(&all, &lengths),
            residuals: split(&target, &lengths),
            explained,
        }
    }
}

/// An orthonormal basis of some vectors, dependent ones left out.
fn orthonormal(vectors: impl Iterator<Item = DVector<f64>>) -> Vec<DVector<f64>> {
    let mut basis: Vec<DVector<f64>> = Vec::new();
    for mut vector in vectors {
        let size = vector.norm();
        project(&basis, &mut vector);
        if vector.norm() > 1e-6 * size {
            basis.push(vector.normalize());
        }
    }
    basis
}

fn project(basis: &[DVector<f64>], vector: &mut DVector<f64>) {
    for direction in basis {
        let share = direction.dot(vector);
        vector.axpy(-share, direction, 1.0);
    }
}

/// Scaled to a root mean square of one.
fn unit(vector: DVector<f64>) -> DVector<f64> {
    let size = vector.norm() / (vector.len() as f64).sqrt();
    if size > 0.0 { vector / size } else { vector }
}

fn split(all: &DMatrix<f64>, lengths: &[usize]) -> Vec<DMatrix<f64>> {
    let mut begin = 0;
    let mut part = |&length: &usize| {
        begin += length;
        all.rows(begin - length, length).into_owned()
    };
    lengths.iter().map(&mut part).collect()
}

/// Numbers of the terms that a sparse regression keeps.
///
/// # Errors
/// [`PeerError::Regression`] where columns are dependent.
pub fn sparse(problem: &Problem) -> Result<Vec<usize>, PeerError> {
    if problem.terms.is_empty() {
        return Ok(Vec::new());
    }
    let folds = problem.columns.len();
    let equations = |left_out: Option<usize>| {
        let mut equations = NormalEquations::new(problem.terms.len(), 1);
        for r in (0..folds).filter(|r| Some(*r) != left_out) {
            equations.add(&problem.columns[r], &problem.residuals[r]);
        }
        equations
    };
    let rows: usize = problem.columns.iter().map(DMatrix::nrows).sum();
    let stlsq = |threshold| Stlsq { threshold, ridge: RIDGE * rows as f64, iterations: 20 };
    let error = |r: usize, c: &[f64]| {
        let c = DMatrix::from_column_slice(c.len(), 1, c);
        let left = &problem.residuals[r] - &problem.columns[r] * c;
        left.norm_squared() / left.nrows() as f64
    };
    let mut trials = Vec::new();
    for threshold in THRESHOLDS {
        let fold = |r| Ok(error(r, &stlsq(threshold).solve(&equations(Some(r)))?[0]));
        let errors = (0..folds).map(fold).collect::<Result<Vec<f64>, PeerError>>()?;
        trials.push((Some(threshold), errors));
    }
    let none = vec![0.0; problem.terms.len()];
    trials.push((None, (0..folds).map(|r| error(r, &none)).collect()));
    let Some(threshold) = sparsest(&trials) else { return Ok(Vec::new()) };
    let coefficients = stlsq(threshold).solve(&equations(None))?.remove(0);
    let kept = coefficients.iter().zip(&problem.terms).filter(|(c, _)| **c != 0.0);
    Ok(kept.map(|(_, term)| *term).collect())
}

/// The greatest threshold that predicts no worse than the best one by more than a standard error
/// of the differences between them over the recordings; none stands for no term at all.
fn sparsest(trials: &[(Option<f64>, Vec<f64>)]) -> Option<f64> {
    let mean = |errors: &[f64]| errors.iter().sum::<f64>() / errors.len() as f64;
    let best = trials.iter().min_by(|a, b| mean(&a.1).total_cmp(&mean(&b.1)))?;
    let good = |errors: &[f64]| {
        let worse: Vec<f64> = errors.iter().zip(&best.1).map(|(a, b)| a - b).collect();
        let n = worse.len() as f64;
        let variance = worse.iter().map(|d| (d - mean(&worse)).powi(2)).sum::<f64>() / (n - 1.0);
        mean(&worse) <= (variance / n).sqrt()
    };
    let sparsest = trials.iter().rev().find(|(_, errors)| good(errors));
    sparsest.and_then(|(threshold, _)| *threshold)
}
