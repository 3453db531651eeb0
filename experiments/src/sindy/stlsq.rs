//! Sequentially thresholded least squares.

use super::{NormalEquations, SparseRegressionError};

/// Settings of the sequentially thresholded least squares (Brunton, Proctor, Kutz 2016).
///
/// Ridge regression, then again without the columns whose coefficient stayed below the threshold,
/// until none is left out any more; at last plain least squares on the columns that remain.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stlsq {
    /// Coefficients of smaller absolute value are set to zero.
    pub threshold: f64,
    /// Ridge of all regressions but the last.
    pub ridge: f64,
    /// Most regressions before the last.
    pub iterations: usize,
}

impl Stlsq {
    /// PySINDy's settings.
    pub const PYSINDY: Self = Self { threshold: 0.1, ridge: 0.05, iterations: 20 };

    /// Coefficients of each right-hand side, zeros included.
    ///
    /// # Errors
    /// [`SparseRegressionError::Dependent`] when the data do not tell columns apart.
    pub fn solve(
        &self,
        equations: &NormalEquations,
    ) -> Result<Vec<Vec<f64>>, SparseRegressionError> {
        (0..equations.targets()).map(|target| self.solve_one(equations, target)).collect()
    }

    fn solve_one(
        &self,
        equations: &NormalEquations,
        target: usize,
    ) -> Result<Vec<f64>, SparseRegressionError> {
        let mut support: Vec<usize> = (0..equations.columns()).collect();
        for _ in 0..self.iterations {
            let found = equations.solve(&support, target, self.ridge)?;
            let before = support.len();
            let mut large = found.iter().map(|c| c.abs() >= self.threshold);
            support.retain(|_| large.next().unwrap_or(false));
            if support.len() == before {
                break;
            }
        }
        let mut coefficients = vec![0.0; equations.columns()];
        for (&column, c) in support.iter().zip(equations.solve(&support, target, 0.0)?) {
            coefficients[column] = c;
        }
        Ok(coefficients)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::DMatrix;

    /// y = 2 + 0.5 t^2 on five points, regressed on 1, t, t^2; and y = 0.
    fn parabola() -> NormalEquations {
        let t = |k: usize| k as f64 - 1.5;
        let regressors = DMatrix::from_fn(5, 3, |k, j| t(k).powi(j as i32));
        let targets =
            DMatrix::from_fn(5, 2, |k, i| if i == 0 { 2.0 + 0.5 * t(k).powi(2) } else { 0.0 });
        let mut equations = NormalEquations::new(3, 2);
        // In two parts, as trajectories come.
        for part in [0..2, 2..5] {
            let rows = |m: &DMatrix<f64>| m.rows(part.start, part.len()).into_owned();
            equations.add(&rows(&regressors), &rows(&targets));
        }
        equations
    }

    #[test]
    fn small_coefficients_go_and_the_ridge_leaves_no_bias() {
        let found = Stlsq::PYSINDY.solve(&parabola()).unwrap();
        assert!((found[0][0] - 2.0).abs() < 1e-12 && (found[0][2] - 0.5).abs() < 1e-12);
        assert_eq!(found[0][1], 0.0);
        assert_eq!(found[1], [0.0; 3]);
    }

    #[test]
    fn a_threshold_above_all_coefficients_leaves_nothing() {
        let found = Stlsq { threshold: 10.0, ..Stlsq::PYSINDY }.solve(&parabola()).unwrap();
        assert_eq!(found, [[0.0; 3], [0.0; 3]]);
    }

    #[test]
    fn columns_that_are_dependent_without_ridge_are_refused() {
        let mut equations = NormalEquations::new(2, 1);
        equations.add(&DMatrix::from_element(4, 2, 1.0), &DMatrix::from_element(4, 1, 1.0));
        let refused = Stlsq { ridge: 0.0, ..Stlsq::PYSINDY }.solve(&equations);
        assert_eq!(refused, Err(SparseRegressionError::Dependent { columns: 2 }));
    }
}
