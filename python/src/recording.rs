//! Recordings: a file, or columns in memory.

use crate::error::told;
use lacuna::discrepancy::DiagnoseError;
use lacuna::models::AnyModel;
use lacuna::recordings::{
    self, Column, Log, RecordingError, RecordingSource, Unit, UnitError, Wanted, convert, read_log,
};
use numpy::{PyArray1, PyReadonlyArray1, ToPyArray};
use pyo3::prelude::*;
use std::collections::BTreeMap;

/// One recording: a file or a part of one, or columns.
#[pyclass(frozen, module = "lacuna._lacuna")]
pub struct Recording {
    from: Source,
    /// Column of time; that of the model where it is not said.
    time: Option<String>,
    /// Units of columns, where they are not those that the model says.
    units: BTreeMap<String, String>,
    name: Option<String>,
}

/// Where it comes from.
enum Source {
    File(RecordingSource),
    Columns(Vec<Column>),
}

/// Columns, column of time, units, name.
type Parts<'py> = (
    Option<Vec<(String, Bound<'py, PyArray1<f64>>)>>,
    Option<String>,
    BTreeMap<String, String>,
    Option<String>,
);

#[pymethods]
impl Recording {
    /// A recording from a file, read when it is used.
    #[staticmethod]
    fn of_file(
        file: &str,
        time: Option<String>,
        units: BTreeMap<String, String>,
        name: Option<String>,
    ) -> PyResult<Self> {
        let from = Source::File(file.parse().map_err(told)?);
        Ok(Self { from, time, units, name })
    }

    /// A recording from columns, which are copied.
    #[staticmethod]
    fn of_columns(
        columns: Vec<(String, PyReadonlyArray1<'_, f64>)>,
        time: Option<String>,
        units: BTreeMap<String, String>,
        name: Option<String>,
    ) -> Self {
        let column = |(name, values): (String, PyReadonlyArray1<'_, f64>)| Column {
            name,
            values: values.as_array().to_vec(),
        };
        let from = Source::Columns(columns.into_iter().map(column).collect());
        Self { from, time, units, name }
    }

    /// Its name, where it has one.
    #[getter]
    fn name(&self) -> Option<String> {
        match &self.from {
            Source::File(source) => Some(self.name.clone().unwrap_or_else(|| source.name())),
            Source::Columns(_) => self.name.clone(),
        }
    }

    /// What it was made of, but for a file: columns, column of time, units, name.
    fn parts<'py>(&self, py: Python<'py>) -> Parts<'py> {
        let array = |c: &Column| (c.name.clone(), c.values.to_pyarray(py));
        let columns = match &self.from {
            Source::File(_) => None,
            Source::Columns(columns) => Some(columns.iter().map(array).collect()),
        };
        (columns, self.time.clone(), self.units.clone(), self.name.clone())
    }

    /// Names of its columns; none of a file, which is not read yet.
    #[getter]
    fn columns(&self) -> Option<Vec<String>> {
        match &self.from {
            Source::File(_) => None,
            Source::Columns(columns) => Some(columns.iter().map(|c| c.name.clone()).collect()),
        }
    }
}

impl Recording {
    /// The recording as a model takes it ([`Recording::log`]).
    pub fn read(
        &self,
        model: &AnyModel,
        number: usize,
    ) -> Result<recordings::Recording, DiagnoseError> {
        Ok(self.log(model, number)?.recording)
    }

    /// What a model uses of the recording, its columns in the units that the model says; it is the
    /// `number`-th, which names one without a name.
    pub fn log(&self, model: &AnyModel, number: usize) -> Result<Log, DiagnoseError> {
        let time = self.time.as_deref().unwrap_or_else(|| model.time_column());
        let mut wanted = model.wanted().needing(self.units.keys().cloned());
        time.clone_into(&mut wanted.time);
        // Its own unit of time comes before that of the model.
        if self.units.contains_key(time) {
            wanted.seconds = 1.0;
        }
        let mut log = self.in_own_units(&wanted, number)?;
        for (column, unit) in &self.units {
            self.convert(&mut log.recording, (column, unit), (model, time))?;
        }
        Ok(log)
    }

    /// The recording in its own units, where no model says them; its times in a unit of so many seconds.
    pub fn as_recorded(
        &self,
        (time, seconds): (&str, f64),
        number: usize,
    ) -> Result<recordings::Recording, RecordingError> {
        let wanted = Wanted::all(self.time.as_deref().unwrap_or(time)).counting(seconds);
        Ok(self.in_own_units(&wanted, number)?.recording)
    }

    /// Add the units of its columns to those of others.
    ///
    /// # Errors
    /// A column that another recording has in another unit.
    pub fn add_units(&self, all: &mut BTreeMap<String, String>) -> PyResult<()> {
        for (column, unit) in &self.units {
            let other = all.entry(column.clone()).or_insert_with(|| unit.clone());
            if other != unit {
                return Err(told(format!(
                    "column '{column}' is in {other} in one recording and in {unit} in another: without a model \
                     they must agree"
                )));
            }
        }
        Ok(())
    }

    fn in_own_units(&self, wanted: &Wanted, number: usize) -> Result<Log, RecordingError> {
        let mut log = match &self.from {
            Source::File(source) => read_log(source, wanted)?,
            Source::Columns(columns) => {
                let name = format!("recording {number}");
                let name = self.name.as_deref().unwrap_or(&name);
                let mut own =
                    recordings::Recording::from_columns(name, columns.clone(), &wanted.time)?;
                own.time.iter_mut().for_each(|t| *t *= wanted.seconds);
                own.into()
            }
        };
        if let Some(name) = &self.name {
            log.recording.name.clone_from(name);
        }
        Ok(log)
    }

    /// Bring a column from its own unit to that in which the model takes it.
    fn convert(
        &self,
        recording: &mut recordings::Recording,
        (column, unit): (&str, &str),
        (model, time): (&AnyModel, &str),
    ) -> Result<(), DiagnoseError> {
        let name = recording.name.clone();
        let in_unit = |values: &[f64], to: &str| {
            converted(values, unit, to).map_err(|source| DiagnoseError::Unit {
                recording: name.clone(),
                column: column.to_owned(),
                source: Box::new(source),
            })
        };
        if column == time {
            recording.time = in_unit(&recording.time, "s")?;
            return Ok(());
        }
        let own = recording.column(column)?;
        // What no model says the unit of is taken as it was recorded.
        let AnyModel::Equations(equations) = model else { return Ok(()) };
        let Some(to) = equations.column_unit(column) else { return Ok(()) };
        let values = in_unit(own, &to)?;
        for own in recording.columns.iter_mut().filter(|c| c.name == column) {
            own.values.clone_from(&values);
        }
        Ok(())
    }
}

fn converted(values: &[f64], from: &str, to: &str) -> Result<Vec<f64>, UnitError> {
    if from == to {
        return Ok(values.to_vec());
    }
    convert(values, &Unit::parse(from)?, &Unit::parse(to)?)
}

/// All recordings as a model takes them, numbered from `first`.
pub fn read_all(
    all: &[Py<Recording>],
    model: &AnyModel,
    first: usize,
) -> PyResult<Vec<recordings::Recording>> {
    Ok(logs(all, model, first)?.into_iter().map(|log| log.recording).collect())
}

/// The same with what else is said of their files.
pub fn logs(all: &[Py<Recording>], model: &AnyModel, first: usize) -> PyResult<Vec<Log>> {
    let read = |(k, r): (usize, &Py<Recording>)| r.get().log(model, first + k).map_err(told);
    all.iter().enumerate().map(read).collect()
}
