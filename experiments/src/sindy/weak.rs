//! Sparse identification in weak form.

use lacuna_occupation::{
    BandedCholesky, Functional, InitialDerivative, Quadrature, TestFunction, TrajectoryData,
};
use nalgebra::DMatrix;

use super::{LibraryModel, SparseRegressionError, Stlsq};

/// Windows of phi = (1 - tau^2)^4, 0.8 s wide, sliding by one sample.
const WINDOWS: TestFunction = TestFunction::Compact { exponent: 4, width: 0.8, stride: 1 };

/// The coefficients' threshold is that of [`Stlsq::PYSINDY`]; there is no ridge, since the columns
/// are whitened and a ridge would mean something else on them.
const STLSQ: Stlsq = Stlsq { ridge: 0.0, ..Stlsq::PYSINDY };

/// WSINDy: `int phi x^(s) dt = (-1)^s int phi^(s) x dt` regressed on the library's integrals
/// `int phi Theta(x) (1, u) dt`, with compactly supported polynomial test functions, as generalised
/// least squares with the covariance that white noise on the coordinates gives overlapping windows.
///
/// # Errors
/// [`SparseRegressionError`] for no or unlike trajectories, recordings shorter than a window, or
/// data that do not tell the library's functions apart.
pub fn wsindy(
    data: &[TrajectoryData],
    order: usize,
) -> Result<LibraryModel, SparseRegressionError> {
    LibraryModel::fit(data, STLSQ, |library, recording, equations| {
        let (times, rule) = (recording.times(), Quadrature::Trapezoid);
        let integrals = WINDOWS.functionals(times, rule, 0)?;
        let derivatives =
            WINDOWS.right_hand_sides(times, rule, order, InitialDerivative::default())?;
        let noise = BandedCholesky::of_functionals(&derivatives)?;
        let (n, samples) = (recording.dimension(), recording.samples());
        let coordinates = DMatrix::from_row_slice(samples, n, recording.coordinates());
        equations.add(
            &whitened(&integrals, &library.regressors(recording), &noise)?,
            &whitened(&derivatives, &coordinates, &noise)?,
        );
        Ok(())
    })
}

/// L^-1 times the values of the functionals on each column of the samples.
fn whitened(
    functionals: &[Functional],
    samples: &DMatrix<f64>,
    noise: &BandedCholesky,
) -> Result<DMatrix<f64>, SparseRegressionError> {
    let mut values = DMatrix::zeros(functionals.len(), samples.ncols());
    for (j, column) in samples.column_iter().enumerate() {
        let column = column.as_slice();
        let mut value: Vec<f64> = functionals.iter().map(|f| f.apply(column)).collect();
        noise.solve_lower_in_place(&mut value)?;
        values.column_mut(j).copy_from_slice(&value);
    }
    Ok(values)
}
