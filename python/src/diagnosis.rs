//! A diagnosis and what can be told, drawn and written of it.

use crate::error::told;
use crate::model::Model;
use crate::recording::{Recording, read_all};
use crate::waiting::watched;
use lacuna::diagnosed::{Diagnosed, datasets};
use lacuna::discrepancy::diagnose::{Options, Outcome, diagnose as search};
use lacuna::discrepancy::{Dataset, DiagnoseError, Scope, Selector, Watch};
use lacuna::fleet::Settings;
use lacuna::plants;
use lacuna::recordings;
use lacuna::report;
use pyo3::prelude::*;
use std::path::PathBuf;
use std::time::Duration;

/// What may be asked of a diagnosis.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub struct Asked {
    exclude: Vec<String>,
    only: Vec<String>,
    exact: Vec<String>,
    learn_remainder: bool,
    time_budget: Option<f64>,
}

impl Asked {
    fn options(&self) -> PyResult<Options> {
        let selectors = |texts: &[String]| -> PyResult<Vec<Selector>> {
            texts.iter().map(|text| text.parse().map_err(told)).collect()
        };
        Ok(Options {
            learn_remainder: self.learn_remainder,
            scope: Scope { only: selectors(&self.only)?, exclude: selectors(&self.exclude)? },
            exact: self.exact.clone(),
            ..Options::default()
        })
    }

    /// The same for every machine of a fleet.
    pub fn settings(&self) -> PyResult<Settings> {
        let Options { learn_remainder, scope, exact, .. } = self.options()?;
        let Scope { only, exclude } = scope;
        Ok(Settings { learn_remainder, only, exclude, exact, time_budget: self.budget()? })
    }

    fn budget(&self) -> PyResult<Option<Duration>> {
        let Some(seconds) = self.time_budget else { return Ok(None) };
        let budget = Some(seconds).filter(|s| *s > 0.0);
        match budget.and_then(|s| Duration::try_from_secs_f64(s).ok()) {
            Some(budget) => Ok(Some(budget)),
            None => Err(told("time_budget: expected a positive number of seconds")),
        }
    }
}

/// A diagnosis.
#[pyclass(frozen, module = "lacuna._lacuna")]
pub struct Diagnosis {
    found: Diagnosed,
    model: Py<Model>,
}

/// Find the physics that a model leaves out.
#[pyfunction]
pub fn diagnose(
    py: Python<'_>,
    model: Py<Model>,
    recordings: Vec<Py<Recording>>,
    held_out: Vec<Py<Recording>>,
    asked: Asked,
    progress: Option<Py<PyAny>>,
) -> PyResult<Diagnosis> {
    let own = model.get();
    let (equations, options, budget) = (own.equations()?, asked.options()?, asked.budget()?);
    let training = read_all(&recordings, &own.model, 1)?;
    let proof = read_all(&held_out, &own.model, 1 + training.len())?;
    let outcome = watched(py, progress.as_ref(), &own.raised, |watch| {
        found(equations, (&training, &proof), options, (watch, budget))
    })?;
    let (data, outcome) = outcome.map_err(told)?;
    Ok(Diagnosis { found: Diagnosed::new(equations.clone(), &data, outcome), model })
}

/// What is found, and the data that it was fitted to.
fn found(
    model: &plants::Model,
    (training, held_out): (&[recordings::Recording], &[recordings::Recording]),
    options: Options,
    (watch, budget): (Watch<'_>, Option<Duration>),
) -> Result<(Dataset, Outcome), DiagnoseError> {
    let (training, held_out) = datasets(model, training, held_out)?;
    let watch = match budget {
        Some(budget) => watch.within(budget),
        None => watch,
    };
    let outcome = search(model, &training, &held_out, options, &watch)?;
    Ok((training, outcome))
}

#[pymethods]
impl Diagnosis {
    /// What diagnosis.json holds.
    fn json(&self) -> PyResult<String> {
        self.found.json().map_err(told)
    }

    /// The summary in words.
    fn summary(&self) -> String {
        report::summary(self.found.diagnosis(), false)
    }

    /// The model with what was found.
    fn augmented(&self) -> PyResult<Model> {
        let (own, text) = (self.model.get(), self.found.augmented_text().map_err(told)?);
        let equations = own.equations()?;
        let augmented = match equations.is_text() {
            true => plants::Model::from_text(&text, "augmented.toml"),
            false => equations.with_text(&text, "augmented.toml"),
        };
        Ok(Model::of(augmented.map_err(told)?, None, own.raised.clone()))
    }

    /// The page; `command` is what repeats the diagnosis.
    fn page(&self, command: &str) -> PyResult<String> {
        self.found.page(command).map_err(told)
    }

    /// Write the files of the command to a folder.
    fn save(&self, folder: PathBuf, command: &str, figures: bool) -> PyResult<()> {
        self.found.write(&folder, command).map_err(told)?;
        if figures {
            self.found.write_figures(&folder).map_err(told)?;
        }
        Ok(())
    }
}
