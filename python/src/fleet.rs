//! Many machines with one model: the plan, one machine, and all of them compared. Who does which machine when is
//! Python's.

use crate::diagnosis::Asked;
use crate::error::told;
use crate::function::Raised;
use crate::recording::{Recording, read_all};
use crate::waiting::watched;
use lacuna::discrepancy::Selector;
use lacuna::fleet::{Machine, Plan, State, Work, collect};
use lacuna::models::AnyModel;
use lacuna::recordings::RecordingSource;
use pyo3::prelude::*;
use rayon::ThreadPoolBuilder;
use serde_json::json;
use std::path::PathBuf;

/// Name, recordings to fit, recordings for proof alone.
type Planned = (String, Vec<String>, Vec<String>);

/// What a fleet's file says: the model's file, the machines, and how each is diagnosed as JSON.
#[pyfunction]
pub fn fleet_plan(file: PathBuf) -> PyResult<(PathBuf, Vec<Planned>, String)> {
    let plan = Plan::read(&file).map_err(told)?;
    let source = |s: &RecordingSource| format!("{}{}", s.path.display(), s.selection);
    let all = |sources: &[RecordingSource]| sources.iter().map(source).collect();
    let machine = |m: &Machine| (m.name.clone(), all(&m.recordings), all(&m.held_out));
    let texts = |all: &[Selector]| -> Vec<String> { all.iter().map(ToString::to_string).collect() };
    let settings = &plan.settings;
    let asked = json!({
        "exclude": texts(&settings.exclude),
        "only": texts(&settings.only),
        "exact": settings.exact,
        "learn_remainder": settings.learn_remainder,
        "time_budget": settings.time_budget.map(|b| b.as_secs_f64()),
    });
    let machines = plan.machines.iter().map(machine).collect();
    Ok((plan.model, machines, asked.to_string()))
}

/// Diagnose one machine in one thread, or find that this was done: `diagnosed`, `there`, or `failed` and why.
#[pyfunction]
pub fn fleet_diagnose(
    py: Python<'_>,
    place: (PathBuf, PathBuf),
    machine: (String, Vec<Py<Recording>>, Vec<Py<Recording>>),
    asked: Asked,
    command: &str,
) -> PyResult<(&'static str, Option<String>)> {
    let ((model, folder), (name, recordings, held_out)) = (place, machine);
    let work = Work::new(&model, asked.settings()?, &folder, command).map_err(told)?;
    let of = AnyModel::Equations(Box::new(work.model().clone()));
    let pool = ThreadPoolBuilder::new().num_threads(1).build().map_err(told)?;
    let read = || -> PyResult<_> {
        let training = read_all(&recordings, &of, 1)?;
        let proof = read_all(&held_out, &of, 1 + training.len())?;
        Ok((training, proof))
    };
    let state = watched(py, None, &Raised::default(), |watch| {
        let read = || read().map_err(|e| Python::attach(|py| e.value(py).to_string()).into());
        pool.install(|| work.diagnose(&name, read, watch).map_err(|e| e.to_string()))
    })?;
    Ok(match state.map_err(told)? {
        State::Diagnosed => ("diagnosed", None),
        State::There => ("there", None),
        State::Failed(error) => ("failed", Some(error)),
    })
}

/// Compare all machines, write fleet.json and fleet.html to their folder, and return the first, its words, and the page
/// for where the machines' own are not beside it.
#[pyfunction]
pub fn fleet_collect(folder: PathBuf, names: Vec<String>) -> PyResult<(String, String, String)> {
    let names: Vec<&str> = names.iter().map(String::as_str).collect();
    let fleet = collect(&folder, &names).map_err(told)?;
    fleet.write(&folder).map_err(told)?;
    Ok((fleet.json().map_err(told)?, fleet.text(), fleet.page(false)))
}
