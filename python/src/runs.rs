//! Models run on recordings, compared and checked.

use crate::error::told;
use crate::model::Model;
use crate::recording::{Recording, logs, read_all};
use lacuna::check::Report;
use lacuna::comparison::{Compared, Named, Pair, labels};
use lacuna::recordings;
use lacuna::simulation::{self, Settings, Simulation};
use numpy::{IntoPyArray, PyArray1};
use pyo3::prelude::*;
use std::error::Error;
use std::path::{Path, PathBuf};

/// Columns by name, time among them.
type Columns<'py> = Vec<(String, Bound<'py, PyArray1<f64>>)>;

/// Run a model on a recording's inputs: the errors as JSON and in words, and what was simulated.
#[pyfunction]
pub fn simulate<'py>(
    py: Python<'py>,
    model: &Bound<'py, Model>,
    recording: &Bound<'py, Recording>,
    horizon: Option<f64>,
    warmup: usize,
) -> PyResult<(String, String, Columns<'py>)> {
    let own = model.get();
    let settings = Settings { horizon: checked(horizon)?, warmup };
    let like = recording.get().read(&own.model, 1).map_err(told)?;
    let called = own.called();
    let run = py.detach(|| -> Result<Simulation, String> {
        let run = Simulation::of((&own.model, &called), &like, settings);
        run.and_then(|run| run.check_finite(&called).map(|()| run)).map_err(|e| e.to_string())
    });
    let run = unless_raised(&[own], run)?;
    let report = simulation::Report::of(&run, own.model.name(&called), settings);
    let json = serde_json::to_string(&report).map_err(told)?;
    let recordings::Recording { time, columns, .. } = run.recording();
    let time = (own.model.time_column().to_owned(), time.into_pyarray(py));
    let columns = columns.into_iter().map(|c| (c.name, c.values.into_pyarray(py)));
    Ok((json, report.text(), std::iter::once(time).chain(columns).collect()))
}

/// What is in recordings, and whether they fit a model: as JSON and in words.
#[pyfunction]
pub fn check(
    py: Python<'_>,
    model: &Bound<'_, Model>,
    recordings: Vec<Py<Recording>>,
) -> PyResult<(String, String)> {
    let own = model.get();
    let equations = own.equations()?;
    let logs = logs(&recordings, &own.model, 1)?;
    let report = py.detach(|| Report::of(equations, logs).map_err(|e| e.to_string()));
    let report = unless_raised(&[own], report)?;
    let warnings = report.warnings().iter().map(|w| format!("warning: {w}\n"));
    let text = report.text() + &warnings.collect::<String>();
    Ok((serde_json::to_string(&report).map_err(told)?, text))
}

/// Two models compared on recordings.
#[pyclass(frozen, module = "lacuna._lacuna")]
pub struct Comparison(Compared);

/// Run two models on recordings.
#[pyfunction]
pub fn compare(
    py: Python<'_>,
    models: (Py<Model>, Py<Model>),
    recordings: Vec<Py<Recording>>,
    horizon: Option<f64>,
    warmup: usize,
) -> PyResult<Comparison> {
    let settings = Settings { horizon: checked(horizon)?, warmup };
    let own = [models.0.get(), models.1.get()];
    let called = own.map(Model::called);
    let [a, b] = labels(called.each_ref().map(Path::new));
    let named = |m: &Model, label| Named { model: m.model.clone(), file: m.called(), label };
    let named = [named(own[0], a), named(own[1], b)];
    let a = read_all(&recordings, &own[0].model, 1)?;
    let b = read_all(&recordings, &own[1].model, 1)?;
    let compared = py.detach(|| {
        let pairs = a.iter().zip(&b).map(|(a, b)| Pair::of(&named, [a, b], settings));
        let pairs = pairs.collect::<Result<Vec<_>, Box<dyn Error>>>();
        pairs.and_then(|pairs| Compared::of(&named, &pairs, settings)).map_err(|e| e.to_string())
    });
    unless_raised(&own, compared).map(Comparison)
}

#[pymethods]
impl Comparison {
    /// What compare.json holds.
    fn json(&self) -> PyResult<String> {
        self.0.json().map_err(told)
    }

    /// The errors as a table, and who is closer.
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

fn checked(horizon: Option<f64>) -> PyResult<Option<f64>> {
    match horizon {
        Some(h) if !(h > 0.0 && h.is_finite()) => {
            Err(told(format!("horizon: expected a positive number of seconds, found '{h}'")))
        }
        horizon => Ok(horizon),
    }
}

/// What the functions of models raised comes before all that followed from it.
fn unless_raised<T>(models: &[&Model], result: Result<T, String>) -> PyResult<T> {
    match models.iter().find_map(|m| m.raised.take()) {
        Some(error) => Err(error),
        None => result.map_err(told),
    }
}
