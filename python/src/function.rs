//! A Python function as a simulator: asked for many points at once, its derivatives by differences.

use lacuna::plants::dynamics::{Mass, Point, Simulator, Sizes};
use numpy::{PyArray1, PyArray2, PyArrayMethods, PyReadonlyArrayDyn, PyUntypedArrayMethods};
use pyo3::prelude::*;
use std::fmt;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// What a function raised while nobody could be told: the first of its exceptions.
#[derive(Clone, Default)]
pub struct Raised(Arc<Mutex<Option<PyErr>>>);

impl Raised {
    fn lock(&self) -> MutexGuard<'_, Option<PyErr>> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Whether something was raised.
    pub fn is_some(&self) -> bool {
        self.lock().is_some()
    }

    /// What was raised, and nothing from now on.
    pub fn take(&self) -> Option<PyErr> {
        self.lock().take()
    }

    fn put(&self, error: PyErr) {
        self.lock().get_or_insert(error);
    }
}

/// What functions say of inertia.
pub enum Inertia {
    /// Nothing: what they give are accelerations.
    Unit,
    /// One of its own gives the mass matrix `(batch, n, n)`; the other gives forces.
    Function(Py<PyAny>),
    /// In what is given for a point its mass matrix, row-major, stands before the forces.
    Before,
}

/// Functions of `(x, u, p, t)`, arrays with a row a point: accelerations and rates, or with a mass
/// matrix generalised forces and rates.
pub struct PythonFunction {
    /// Gives `(batch, n + s)`, or `(batch, n^2 + n + s)` with the mass matrix before.
    pub rates: Py<PyAny>,
    pub inertia: Inertia,
    pub sizes: Sizes,
    pub raised: Raised,
}

impl fmt::Debug for PythonFunction {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("a function in Python")
    }
}

impl PythonFunction {
    /// Mass matrix (where there is one) and rates of rows of points.
    fn call(&self, py: Python<'_>, points: &[f64], rates: &mut [f64]) -> PyResult<()> {
        let Sizes { parameters, inputs, coordinates: n, .. } = self.sizes;
        let (states, variables) = (self.sizes.machine_states(), self.sizes.variables());
        let width = parameters + variables;
        let batch = points.len() / width;
        let part = |first: usize, count: usize| -> PyResult<Bound<'_, PyArray2<f64>>> {
            let rows = points.chunks_exact(width).flat_map(|row| &row[first..first + count]);
            PyArray1::from_iter(py, rows.copied()).reshape([batch, count])
        };
        let (x, u) = (part(parameters, states)?, part(parameters + states, inputs)?);
        let (p, t) = (part(0, parameters)?, part(width - 1, 1)?.reshape([batch])?);
        let arguments = (x, u, p, t);
        let given = self.rates.bind(py).call1(arguments.clone())?;
        let first = if matches!(self.inertia, Inertia::Before) { 0 } else { n * n };
        scatter(&given, rates, self.sizes.rates(), first)?;
        match &self.inertia {
            Inertia::Before => Ok(()),
            Inertia::Function(mass) => {
                scatter(&mass.bind(py).call1(arguments)?, rates, self.sizes.rates(), 0)
            }
            Inertia::Unit => {
                for row in rates.chunks_exact_mut(self.sizes.rates()) {
                    (0..n * n).for_each(|k| row[k] = f64::from(u8::from(k % (n + 1) == 0)));
                }
                Ok(())
            }
        }
    }
}

/// Write what a function gave, a row a point, into rows of this width from column `first` on.
fn scatter(given: &Bound<'_, PyAny>, to: &mut [f64], width: usize, first: usize) -> PyResult<()> {
    let given: PyReadonlyArrayDyn<'_, f64> = given.extract()?;
    let own = given.len() / (to.len() / width);
    let values = given.as_slice()?;
    for (to, row) in to.chunks_exact_mut(width).zip(values.chunks_exact(own.max(1))) {
        to[first..first + own].copy_from_slice(row);
    }
    Ok(())
}

impl Simulator for PythonFunction {
    fn mass(&self) -> Mass {
        match self.inertia {
            Inertia::Unit => Mass::Unit,
            Inertia::Function(_) | Inertia::Before => Mass::Matrix,
        }
    }

    fn evaluate(&self, at: &Point<'_>, mass: &mut [f64], force: &mut [f64]) {
        let parts =
            [at.parameters, at.coordinates, at.velocities, at.states, at.inputs, &[at.time]];
        let mut rates = vec![0.0; self.sizes.rates()];
        self.evaluate_all(self.sizes, &parts.concat(), &mut rates);
        let (own_mass, own_force) = rates.split_at(mass.len());
        mass.copy_from_slice(own_mass);
        force.copy_from_slice(own_force);
    }

    fn evaluate_all(&self, _sizes: Sizes, points: &[f64], rates: &mut [f64]) {
        // What has raised once is called off, and is not called again.
        let called = match self.raised.is_some() {
            true => None,
            false => Some(Python::attach(|py| self.call(py, points, rates))),
        };
        match called {
            Some(Ok(())) => {}
            Some(Err(error)) => {
                self.raised.put(error);
                rates.fill(f64::NAN);
            }
            None => rates.fill(f64::NAN),
        }
    }
}
