//! Two sets of recordings, one of a simulator, compared without a model.

use crate::error::told;
use crate::identification::input_path;
use crate::recording::Recording;
use lacuna::difference::{self, Runs};
use lacuna::identification::{Asked, ColumnUnit, Columns};
use lacuna::recordings;
use pyo3::prelude::*;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// What is said of the columns.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub struct Said {
    time: String,
    channels: Vec<String>,
    inputs: Vec<String>,
    order: Option<u8>,
    input_hold: String,
}

/// What of two sets of recordings differs.
#[pyclass(frozen, module = "lacuna._lacuna")]
pub struct Difference(difference::Difference);

/// Identify both and compare them.
#[pyfunction]
pub fn compare_runs(
    py: Python<'_>,
    simulated: Vec<Py<Recording>>,
    recorded: Vec<Py<Recording>>,
    said: Said,
) -> PyResult<Difference> {
    let path = input_path(&said.input_hold)?;
    let mut units = BTreeMap::new();
    for one in simulated.iter().chain(&recorded) {
        one.get().add_units(&mut units)?;
    }
    let units = units.into_iter().map(|(column, unit)| ColumnUnit { column, unit }).collect();
    let Said { time, channels, inputs, order, .. } = said;
    let asked = Asked { time: Some(time.clone()), channels, inputs, order, units };
    let read = |all: &[Py<Recording>], first: usize| -> PyResult<Vec<recordings::Recording>> {
        let one = |(k, r): (usize, &Py<Recording>)| {
            r.get().as_recorded((&time, 1.0), first + k).map_err(told)
        };
        all.iter().enumerate().map(one).collect()
    };
    let (simulated, recorded) = (read(&simulated, 1)?, read(&recorded, 1 + simulated.len())?);
    let first = simulated.first().ok_or_else(|| told("no recording of the simulator"))?;
    let columns = Columns::choose(&asked, first, time.clone(), vec![]).map_err(told)?;
    let runs = Runs { simulated, recorded, columns };
    let found = py.detach(|| {
        difference::compare_runs(runs, (&asked, path), &|_| ()).map_err(|e| e.to_string())
    });
    found.map(Difference).map_err(told)
}

#[pymethods]
impl Difference {
    /// What difference.json holds.
    fn json(&self) -> PyResult<String> {
        self.0.json().map_err(told)
    }

    /// The sentences, and the functions as a table.
    fn text(&self) -> String {
        self.0.text()
    }

    /// The page.
    fn page(&self) -> String {
        self.0.page()
    }

    /// Write the files of the command to a folder.
    fn save(&self, folder: PathBuf) -> PyResult<()> {
        self.0.write(Path::new(&folder)).map_err(told)
    }
}
