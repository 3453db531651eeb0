//! Drift and control effectiveness from arrays.

use crate::error::told;
use lacuna::discrepancy::prediction::simulate_identified;
use lacuna::discrepancy::{Dataset, DiagnoseError, IdentifiedPredictor, Prediction};
use lacuna::occupation::{
    Arguments, Family, Identification, IdentifiedModel, InputPath, Motion, Names,
};
use lacuna::recordings::{Column, Recording};
use numpy::{IntoPyArray, PyArray2, PyArray3, PyArrayMethods, PyReadonlyArray1, PyReadonlyArray2};
use pyo3::prelude::*;

/// How to identify.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub struct Settings {
    order: usize,
    input_path: String,
    kernel: Option<String>,
    widths: Option<Vec<f64>>,
    lambda: Option<f64>,
    window: Option<f64>,
    most_landmarks: usize,
    /// Names of the coordinates, of their rates where these are measured, and of the inputs.
    coordinates: Vec<String>,
    rates: Option<Vec<String>>,
    inputs: Vec<String>,
}

/// One trajectory: times, measured coordinates with their rates behind them where these are measured,
/// inputs.
type Given<'py> =
    (PyReadonlyArray1<'py, f64>, PyReadonlyArray2<'py, f64>, PyReadonlyArray2<'py, f64>);

/// An identified model.
#[pyclass(frozen, module = "lacuna._lacuna")]
pub struct Identified {
    model: IdentifiedModel,
    names: Names,
    report: String,
}

/// Identify f and g from trajectories.
#[pyfunction]
pub fn identify(
    py: Python<'_>,
    settings: Settings,
    trajectories: Vec<Given<'_>>,
) -> PyResult<Identified> {
    let identification = settings.identification()?;
    let motions =
        trajectories.iter().map(|given| settings.motion(given)).collect::<PyResult<Vec<_>>>()?;
    let found = py.detach(|| identification.identify(&motions)).map_err(told)?;
    Identified::of(found, settings.names(identification.input_path))
}

impl Settings {
    pub fn identification(&self) -> PyResult<Identification> {
        let mut identification =
            Identification::new(self.order, Arguments::State, input_path(&self.input_path)?);
        if let Some(kernel) = &self.kernel {
            identification.families = families(kernel)?;
        }
        identification.widths.clone_from(&self.widths);
        identification.lambda = self.lambda;
        identification.window = self.window;
        identification.most_landmarks = self.most_landmarks;
        Ok(identification)
    }

    fn motion(&self, (times, measured, inputs): &Given<'_>) -> PyResult<Motion> {
        let (n, measured) = (self.coordinates.len(), measured.as_array());
        let part = |columns: std::ops::Range<usize>| -> Vec<f64> {
            measured
                .rows()
                .into_iter()
                .flat_map(|row| columns.clone().map(move |c| row[c]))
                .collect()
        };
        let inputs = inputs.as_array().iter().copied().collect();
        let motion = Motion::new(times.as_array().to_vec(), part(0..n), inputs).map_err(told)?;
        match self.rates {
            Some(_) => motion.with_rates(part(n..2 * n)).map_err(told),
            None => Ok(motion),
        }
    }

    pub fn names(&self, input_path: InputPath) -> Names {
        let coordinates = self.coordinates.clone();
        let rate = |i: usize| self.rates.as_ref().map(|rates| rates[i].clone());
        let rates: Vec<Option<String>> = (0..coordinates.len()).map(rate).collect();
        let named = coordinates.iter().zip(&rates);
        let unmeasured =
            |(q, rate): (&String, &Option<String>)| rate.clone().unwrap_or(format!("d{q}"));
        let second = named.map(unmeasured).take(coordinates.len() * (self.order - 1));
        Names {
            arguments: coordinates.iter().cloned().chain(second).collect(),
            coordinates,
            rates,
            inputs: self.inputs.clone(),
            time: "t".to_owned(),
            input_path,
        }
    }
}

impl Identified {
    /// A model with the names of what it was identified from.
    pub fn of(found: lacuna::occupation::Identified, names: Names) -> PyResult<Self> {
        let report = serde_json::to_string(&found.report).map_err(told)?;
        Ok(Self { model: found.model.with_names(names.clone()), names, report })
    }
}

#[pymethods]
impl Identified {
    /// The model that `json` made.
    #[new]
    fn new(text: &str, report: String) -> PyResult<Self> {
        let model = IdentifiedModel::from_json(text).map_err(told)?;
        let names = model.names().cloned().ok_or_else(|| told(DiagnoseError::Unnamed))?;
        Ok(Self { model, names, report })
    }

    /// With what `pickle` makes it anew.
    fn __getnewargs__(&self) -> (String, String) {
        (self.json(), self.report())
    }

    /// What `lacuna identify` writes as model.json.
    fn json(&self) -> String {
        self.model.to_json()
    }

    /// What was chosen, and what the data cannot tell, as JSON.
    #[getter]
    fn report(&self) -> String {
        self.report.clone()
    }

    /// Drift `(N, n)` and control effectiveness `(N, n, m)` at states `(N, d)`.
    fn functions<'py>(
        &self,
        py: Python<'py>,
        states: PyReadonlyArray2<'py, f64>,
    ) -> PyResult<Functions<'py>> {
        self.at_all(py, &states, |x, f, g| self.model.evaluate(x, f, g).map_err(told))
    }

    /// Their standard deviations.
    fn deviations<'py>(
        &self,
        py: Python<'py>,
        states: PyReadonlyArray2<'py, f64>,
    ) -> PyResult<Functions<'py>> {
        self.at_all(py, &states, |x, f, g| {
            // A model of `identify` has them.
            if let Some(sd) = self.model.standard_deviations(x).map_err(told)? {
                f.copy_from_slice(&sd.f);
                g.copy_from_slice(&sd.g);
            }
            Ok(())
        })
    }

    /// States at `times` from the state `x0` along inputs.
    fn simulate<'py>(
        &self,
        py: Python<'py>,
        x0: PyReadonlyArray1<'py, f64>,
        times: PyReadonlyArray1<'py, f64>,
        inputs: PyReadonlyArray2<'py, f64>,
    ) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let (x0, times, inputs) = (x0.as_slice()?, times.as_slice()?, inputs.as_slice()?);
        let path = self.names.input_path;
        let run = py.detach(|| simulate_identified(&self.model, x0, (times, inputs), path));
        let run = run.map_err(told)?;
        run.states.into_pyarray(py).reshape([times.len(), run.width])
    }

    /// Of each measured channel the sum of squares that windows of `horizon` seconds leave, and that about
    /// its mean.
    fn squares(
        &self,
        py: Python<'_>,
        trajectory: Given<'_>,
        horizon: f64,
    ) -> PyResult<Vec<(f64, f64)>> {
        let recording = self.recording(&trajectory)?;
        py.detach(|| self.squares_of(&recording, horizon)).map_err(told)
    }
}

/// Drift and control effectiveness.
type Functions<'py> = (Bound<'py, PyArray2<f64>>, Bound<'py, PyArray3<f64>>);

impl Identified {
    fn at_all<'py>(
        &self,
        py: Python<'py>,
        states: &PyReadonlyArray2<'py, f64>,
        mut at: impl FnMut(&[f64], &mut [f64], &mut [f64]) -> PyResult<()>,
    ) -> PyResult<Functions<'py>> {
        let (n, m, d) = (self.model.dimension(), self.model.inputs(), self.model.arguments());
        let states = states.as_slice()?;
        let count = states.len() / d;
        let (mut f, mut g) = (vec![0.0; count * n], vec![0.0; count * n * m]);
        for (k, x) in states.chunks_exact(d).enumerate() {
            at(x, &mut f[k * n..(k + 1) * n], &mut g[k * n * m..(k + 1) * n * m])?;
        }
        let f = f.into_pyarray(py).reshape([count, n])?;
        Ok((f, g.into_pyarray(py).reshape([count, n, m])?))
    }

    /// A trajectory as a recording with the model's names.
    fn recording(&self, (times, measured, inputs): &Given<'_>) -> PyResult<Recording> {
        let (measured, inputs) = (measured.as_array(), inputs.as_array());
        let measured_names = self.names.coordinates.iter().chain(self.names.rates.iter().flatten());
        let series = measured.columns().into_iter().chain(inputs.columns());
        let mut columns: Vec<Column> = measured_names
            .chain(&self.names.inputs)
            .zip(series)
            .map(|(name, values)| Column { name: name.clone(), values: values.to_vec() })
            .collect();
        columns.push(Column { name: self.names.time.clone(), values: times.as_array().to_vec() });
        Recording::from_columns("the trajectory", columns, &self.names.time).map_err(told)
    }

    fn squares_of(
        &self,
        recording: &Recording,
        horizon: f64,
    ) -> Result<Vec<(f64, f64)>, DiagnoseError> {
        let recordings = std::slice::from_ref(recording);
        let dataset = Dataset::of_identified(&self.names, self.model.order(), recordings)?;
        let observed = &dataset.recordings[0];
        let run = IdentifiedPredictor::new(&self.model, &dataset)?.windowed(observed, horizon)?;
        let left = |k: usize| (run.squares(observed, k).0, about_mean(&observed.outputs[k], &run));
        Ok((0..dataset.outputs.len()).map(left).collect())
    }
}

/// Sum of squares about the mean of what was measured.
fn about_mean(series: &[f64], run: &Prediction) -> f64 {
    let counted = || series[run.counted.clone()].iter().filter(|y| y.is_finite());
    let mean = counted().sum::<f64>() / counted().count().max(1) as f64;
    counted().map(|y| (y - mean).powi(2)).sum()
}

/// What inputs do between samples.
pub fn input_path(text: &str) -> PyResult<InputPath> {
    match text {
        "zero-order" => Ok(InputPath::Held),
        "linear" => Ok(InputPath::Linear),
        "smooth" => Ok(InputPath::Smooth),
        other => Err(told(format!(
            "input_hold is \"zero-order\", \"linear\" or \"smooth\"; found \"{other}\""
        ))),
    }
}

fn families(text: &str) -> PyResult<Vec<Family>> {
    Family::named(text).ok_or_else(|| {
        told(format!(
            "kernel is \"gaussian\", \"exponential\", \"matern\" or \"polynomial\"; found \"{text}\""
        ))
    })
}
