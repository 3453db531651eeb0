//! Errors of the library as an exception, in the same words.

use pyo3::PyErr;
use pyo3::exceptions::PyValueError;
use std::fmt::Display;

pyo3::create_exception!(
    lacuna,
    LacunaError,
    PyValueError,
    "What is wrong with a model, a recording or how they are used, in the words of the command."
);

/// What the library says, as an exception.
pub fn told(error: impl Display) -> PyErr {
    LacunaError::new_err(error.to_string())
}
