//! Trajectories as linear equations of f and g, whatever these are sums of.
//!
//! ```text
//! int phi_a (f(x) + g(x) u) dt = Y_a + e_a,   e ~ N(0, sigma^2 S),   S = L L^T
//! ```

use faer::Mat;

use super::FitError;
use crate::functional::Functional;
use crate::occupation_kernels::OccupationKernels;
use crate::quadrature::Quadrature;
use crate::test_function::{InitialDerivative, TestFunction};
use crate::trajectory::TrajectoryData;
use crate::whitening::{BandedCholesky, WhiteningError};

/// How trajectories become equations: the settings of a [`super::Regression`] without what is regressed on.
#[derive(Debug, Clone, Copy)]
pub(crate) struct WeakForm {
    pub order: usize,
    pub test_function: TestFunction,
    pub quadrature: Quadrature,
    pub initial_derivative: InitialDerivative,
    pub whiten: bool,
}

/// The equations of one trajectory.
pub(super) struct WeakTrajectory {
    /// phi w: what the occupation kernels integrate with.
    pub occupation: Vec<Functional>,
    /// What the right-hand sides do to the samples of a coordinate, and so to its noise.
    pub noise: Vec<Functional>,
    /// Functionals x n.
    pub right_hand_sides: Vec<f64>,
}

impl WeakForm {
    /// Of the trajectory of this index, for errors.
    pub(super) fn trajectory(
        &self,
        index: usize,
        data: &TrajectoryData,
    ) -> Result<WeakTrajectory, FitError> {
        let in_trajectory = |source| FitError::TestFunction { trajectory: index, source };
        let occupation = self
            .test_function
            .functionals(data.times(), self.quadrature, 0)
            .map_err(in_trajectory)?;
        let noise = self
            .test_function
            .right_hand_sides(data.times(), self.quadrature, self.order, self.initial_derivative)
            .map_err(in_trajectory)?;
        let known = self.known_initial_part(index, data)?;
        let n = data.dimension();
        let value = |a: usize, i: usize| noise[a].apply_column(data.coordinates(), n, i) - known[i];
        let right_hand_sides = (0..noise.len() * n).map(|k| value(k / n, k % n)).collect();
        Ok(WeakTrajectory { occupation, noise, right_hand_sides })
    }

    /// sum_{1 <= k < s} y^(k)(0) T^k / k! from given derivatives; zero where the samples, or nothing, supply them.
    fn known_initial_part(
        &self,
        index: usize,
        data: &TrajectoryData,
    ) -> Result<Vec<f64>, FitError> {
        let n = data.dimension();
        let mut known = vec![0.0; n];
        let endpoint = matches!(self.test_function, TestFunction::Endpoint { .. });
        if !endpoint || self.order == 1 || self.initial_derivative != InitialDerivative::Given {
            return Ok(known);
        }
        let derivatives = data.initial_derivatives().unwrap_or_default();
        let expected = (self.order - 1) * n;
        if derivatives.len() != expected {
            return Err(FitError::InitialDerivatives {
                trajectory: index,
                expected,
                found: derivatives.len(),
            });
        }
        let duration = data.times()[data.samples() - 1] - data.times()[0];
        let mut taylor = 1.0;
        for (k, derivative) in derivatives.chunks_exact(n).enumerate() {
            taylor *= duration / (k + 1) as f64;
            known.iter_mut().zip(derivative).for_each(|(sum, value)| *sum += taylor * value);
        }
        Ok(known)
    }
}

/// The equations of some trajectories, one after the other.
pub(crate) struct Equations {
    dimension: usize,
    /// What is integrated.
    pub occupation: OccupationKernels,
    /// Functionals x n, not whitened.
    right: Vec<f64>,
    whiteners: Vec<BandedCholesky>,
}

impl Equations {
    /// None yet, of n coordinates, m inputs and d arguments.
    pub fn new([n, m, d]: [usize; 3]) -> Self {
        let occupation = OccupationKernels::new(d, m);
        Self { dimension: n, occupation, right: Vec::new(), whiteners: Vec::new() }
    }

    /// Appends those of the trajectory of this index.
    ///
    /// # Errors
    /// A test function that does not suit the trajectory, and noise that cannot be whitened.
    pub fn append(
        &mut self,
        form: &WeakForm,
        index: usize,
        data: &TrajectoryData,
    ) -> Result<(), FitError> {
        let weak = form.trajectory(index, data)?;
        if form.whiten {
            self.whiteners.push(BandedCholesky::of_functionals(&weak.noise)?);
        }
        self.occupation.append(data.arguments(), data.inputs(), weak.occupation);
        self.right.extend(weak.right_hand_sides);
        Ok(())
    }

    /// Number of equations of each coordinate.
    pub fn count(&self) -> usize {
        self.occupation.functionals().len()
    }

    /// Y, functionals x n, whitened where that is asked for.
    ///
    /// # Errors
    /// As [`Equations::whiten`].
    pub fn right_hand_sides(&self) -> Result<Mat<f64>, WhiteningError> {
        let n = self.dimension;
        let mut right = Mat::from_fn(self.count(), n, |a, i| self.right[a * n + i]);
        self.whiten(&mut right)?;
        Ok(right)
    }

    /// L^-1 times the columns of a matrix with a row an equation.
    ///
    /// # Errors
    /// A matrix with another number of rows.
    pub fn whiten(&self, matrix: &mut Mat<f64>) -> Result<(), WhiteningError> {
        let mut first = 0;
        for whitener in &self.whiteners {
            let range = first..first + whitener.size();
            for c in 0..matrix.ncols() {
                whitener.solve_lower_in_place(&mut matrix.col_as_slice_mut(c)[range.clone()])?;
            }
            first = range.end;
        }
        Ok(())
    }
}
