//! The compiled part of the Python package `lacuna`: what the commands do, for arrays in memory.
//!
//! | Python | here | of the library |
//! | --- | --- | --- |
//! | `Recording` | `recording` | [`lacuna::recordings`] |
//! | `Model`, a function as one | `model`, `function` | [`lacuna::models`], [`lacuna::plants`] |
//! | `diagnose` | `diagnosis`, `waiting` | [`lacuna::diagnosed`] |
//! | `simulate`, `compare`, `check` | `runs` | [`lacuna::simulation`], [`lacuna::comparison`], [`lacuna::check`] |
//! | `compare_runs` | `difference` | [`lacuna::difference`] |
//! | `fleet` | `fleet` | [`lacuna::fleet`] |
//! | `fleet.identify` | `stream` | [`lacuna::trajectories`], [`lacuna::occupation::Stream`] |
//! | `Model.from_fmu` | `fmu` | [`lacuna::fmu`] |
//! | `Identifier` | `identification` | [`lacuna::occupation`] |
//!
//! Results cross as JSON, which they are written as anyhow; series cross as arrays.

mod diagnosis;
mod difference;
mod error;
mod fleet;
mod fmu;
mod function;
mod identification;
mod model;
mod recording;
mod runs;
mod stream;
mod waiting;

use pyo3::prelude::*;

/// What `lacuna` stands on; not to be imported by others.
#[pymodule]
mod _lacuna {
    #[pymodule_export]
    use crate::diagnosis::{Diagnosis, diagnose};
    #[pymodule_export]
    use crate::difference::{Difference, compare_runs};
    #[pymodule_export]
    use crate::error::LacunaError;
    #[pymodule_export]
    use crate::fleet::{fleet_collect, fleet_diagnose, fleet_plan};
    #[pymodule_export]
    use crate::fmu::{evaluate_fmu, evaluate_fmus_with};
    #[pymodule_export]
    use crate::identification::{Identified, identify};
    #[pymodule_export]
    use crate::model::Model;
    #[pymodule_export]
    use crate::recording::Recording;
    #[pymodule_export]
    use crate::runs::{Comparison, check, compare, simulate};
    #[pymodule_export]
    use crate::stream::{Stream, Sums, Trajectories};
}
