//! A model whose functions are sums of library functions.

use lacuna_occupation::{EvaluationError, TrajectoryData};

use super::{Library, NormalEquations, SparseRegressionError, Stlsq};
use crate::identified::Evaluate;

/// Greatest degree of the library's monomials.
const DEGREE: usize = 3;

/// `f_i(x) = Theta(x) c_i0` and `g_ij(x) = Theta(x) c_ij`.
#[derive(Clone, Debug, PartialEq)]
pub struct LibraryModel {
    library: Library,
    inputs: usize,
    /// One vector a coordinate: the coefficients of Theta, then those of Theta u_j for each input.
    coefficients: Vec<Vec<f64>>,
}

impl LibraryModel {
    /// Sparse regression by `stlsq` of the rows that `gather` adds for each trajectory.
    ///
    /// # Errors
    /// No trajectory, trajectories of different shapes, the first error of `gather`, and those of
    /// [`Stlsq::solve`].
    pub(super) fn fit(
        data: &[TrajectoryData],
        stlsq: Stlsq,
        gather: impl Fn(
            &Library,
            &TrajectoryData,
            &mut NormalEquations,
        ) -> Result<(), SparseRegressionError>,
    ) -> Result<Self, SparseRegressionError> {
        let first = data.first().ok_or(SparseRegressionError::NoTrajectory)?;
        let (library, inputs) = (Library::new(first.argument_count(), DEGREE), first.input_count());
        let mut equations = NormalEquations::new(library.size() * (1 + inputs), first.dimension());
        for (trajectory, recording) in data.iter().enumerate() {
            if let Some((what, expected, found)) = first.other_shape(recording) {
                return Err(SparseRegressionError::Shape { trajectory, what, expected, found });
            }
            gather(&library, recording, &mut equations)?;
        }
        Ok(Self { library, inputs, coefficients: stlsq.solve(&equations)? })
    }
}

impl Evaluate for LibraryModel {
    fn evaluate(&self, x: &[f64], f: &mut [f64], g: &mut [f64]) -> Result<(), EvaluationError> {
        let (n, m, terms) = (self.coefficients.len(), self.inputs, self.library.size());
        for (what, expected, found) in
            [("x", self.library.arguments(), x.len()), ("f", n, f.len()), ("g", n * m, g.len())]
        {
            if expected != found {
                return Err(EvaluationError { what, expected, found });
            }
        }
        f.fill(0.0);
        g.fill(0.0);
        for (term, value) in self.library.values(x).enumerate() {
            for (i, c) in self.coefficients.iter().enumerate() {
                f[i] += c[term] * value;
                for j in 0..m {
                    g[i * m + j] += c[(1 + j) * terms + term] * value;
                }
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// f = (1 - y^2, 2 x), g = (0.5, x y) of two coordinates x, y and one input.
    #[test]
    fn coefficients_are_those_of_their_functions() {
        // 1, x, y, x^2, x y, y^2, then cubes and trigonometric functions; then the same times u.
        let library = Library::new(2, 3);
        let mut coefficients = vec![vec![0.0; 2 * library.size()]; 2];
        (coefficients[0][0], coefficients[0][5], coefficients[1][1]) = (1.0, -1.0, 2.0);
        (coefficients[0][library.size()], coefficients[1][library.size() + 4]) = (0.5, 1.0);
        let model = LibraryModel { library, inputs: 1, coefficients };
        let (mut f, mut g) = ([9.0; 2], [9.0; 2]);
        model.evaluate(&[2.0, 3.0], &mut f, &mut g).unwrap();
        assert_eq!((f, g), ([-8.0, 4.0], [0.5, 6.0]));
        let refused = model.evaluate(&[2.0, 3.0], &mut f, &mut [0.0; 3]);
        assert_eq!(refused, Err(EvaluationError { what: "g", expected: 2, found: 3 }));
    }

    #[test]
    fn unlike_trajectories_are_refused() {
        let trajectory = |inputs| {
            let times = vec![0.0, 1.0];
            TrajectoryData::new(times, vec![0.0; 2], inputs, vec![0.0; 2]).unwrap()
        };
        let fit =
            |data: &[TrajectoryData]| LibraryModel::fit(data, Stlsq::PYSINDY, |_, _, _| Ok(()));
        assert_eq!(fit(&[]), Err(SparseRegressionError::NoTrajectory));
        let refused = fit(&[trajectory(vec![0.0; 2]), trajectory(vec![0.0; 4])]);
        let expected =
            SparseRegressionError::Shape { trajectory: 1, what: "inputs", expected: 1, found: 2 };
        assert_eq!(refused, Err(expected));
    }
}
