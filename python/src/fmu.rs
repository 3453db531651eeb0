//! FMUs, whose code runs in processes of its own: interpreters that do nothing else.

use crate::error::told;
use pyo3::prelude::*;
use std::path::PathBuf;

/// Say which program evaluates FMUs, and its first arguments.
#[pyfunction]
pub fn evaluate_fmus_with(program: PathBuf, arguments: Vec<String>) {
    lacuna::fmu::evaluate_with(program, arguments);
}

/// What that program does with the folder of an FMU.
#[pyfunction]
pub fn evaluate_fmu(folder: PathBuf) -> PyResult<()> {
    lacuna::fmu::serve(&folder).map_err(told)
}
