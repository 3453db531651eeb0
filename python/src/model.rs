//! Models: read by the reader of the command, or built from a function.

use crate::error::told;
use crate::function::{Inertia, PythonFunction, Raised};
use crate::recording::Recording;
use lacuna::discrepancy::Dataset;
use lacuna::models::{AnyModel, no_equations, read_equations};
use lacuna::plants::dynamics::Sizes;
use lacuna::plants::model::{Augmentation, Builder, Measured, Parameter};
use lacuna::plants::{self, Hold};
use numpy::{
    IntoPyArray, PyArray1, PyArray2, PyArrayMethods, PyReadonlyArray1, PyReadonlyArray2, ToPyArray,
};
use pyo3::prelude::*;
use std::path::PathBuf;

/// A model of equations, or one that was identified.
#[pyclass(frozen, module = "lacuna._lacuna")]
pub struct Model {
    pub model: AnyModel,
    /// Its file, where it has one.
    file: Option<PathBuf>,
    /// What its function raised, where it is one.
    pub raised: Raised,
}

/// A parameter: name, value, unit, and its standard deviation, relative or in its unit.
#[derive(FromPyObject)]
struct GivenParameter(String, f64, String, Option<f64>, Option<f64>);

/// A second-order coordinate: name, name of its velocity, unit, unit of its force.
#[derive(FromPyObject)]
struct GivenCoordinate(String, String, String, Option<String>);

/// What a function is the equations of.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
struct Described {
    name: String,
    coordinates: Vec<GivenCoordinate>,
    states: Vec<(String, String)>,
    inputs: Vec<(String, String)>,
    parameters: Vec<GivenParameter>,
    measurements: Vec<(String, String, String)>,
    time: String,
    input_hold: String,
}

#[pymethods]
impl Model {
    /// A model of equations: TOML, URDF, MJCF or an FMU; for recordings as `like`, if one is given.
    #[staticmethod]
    #[pyo3(signature = (path, like=None))]
    fn read(path: PathBuf, like: Option<Py<Recording>>) -> PyResult<Self> {
        let mut model = read_equations(&path, None).map_err(told)?;
        if let Some(like) = like {
            let recorded = like
                .get()
                .as_recorded((&model.time_column, model.time_seconds), 1)
                .map_err(told)?;
            let columns: Vec<String> = recorded.columns.into_iter().map(|c| c.name).collect();
            model = model.driven_by(&columns).map_err(told)?;
        }
        Ok(Self::of(model, Some(path), Raised::default()))
    }

    /// A model of either kind.
    #[staticmethod]
    fn read_any(path: PathBuf) -> PyResult<Self> {
        let model = AnyModel::read(&path, None).map_err(told)?;
        Ok(Self { model, file: Some(path), raised: Raised::default() })
    }

    /// A model of equations from its text.
    #[staticmethod]
    fn of_text(text: &str, called: &str) -> PyResult<Self> {
        let model = plants::Model::from_text(text, called).map_err(told)?;
        Ok(Self::of(model, None, Raised::default()))
    }

    /// Mass matrix and what follows it, a row a point, at states, inputs, parameters and times.
    fn rates<'py>(
        &self,
        py: Python<'py>,
        z: PyReadonlyArray2<'py, f64>,
        u: PyReadonlyArray2<'py, f64>,
        p: PyReadonlyArray2<'py, f64>,
        t: PyReadonlyArray1<'py, f64>,
    ) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let dynamics = self.equations()?.dynamics();
        let width = dynamics.sizes().rates();
        let (z, u, p, t) = (z.as_array(), u.as_array(), p.as_array(), t.as_array());
        let mut rates = vec![0.0; t.len() * width];
        for (k, rates) in rates.chunks_exact_mut(width).enumerate() {
            let variables = [z.row(k).to_vec(), u.row(k).to_vec(), vec![t[k]]].concat();
            dynamics.bind(&p.row(k).to_vec()).evaluate_once(&variables, rates);
        }
        match self.raised.take() {
            Some(error) => Err(error),
            None => rates.into_pyarray(py).reshape([t.len(), width]),
        }
    }

    /// The coordinates, by their numbers, that a recording measures, and where they are; NaN where nothing was
    /// measured.
    fn positions<'py>(
        &self,
        py: Python<'py>,
        recording: &Recording,
    ) -> PyResult<Vec<(usize, Bound<'py, PyArray1<f64>>)>> {
        let equations = self.equations()?;
        let read = recording.read(&self.model, 1).map_err(told)?;
        let dataset = Dataset::new(equations, &[read]).map_err(told)?;
        let coordinates = equations.coordinates.len();
        let of = dataset.outputs.iter().zip(&dataset.recordings[0].outputs);
        let positions = of.filter_map(|(output, values)| match output.of {
            Measured::State(c) if c < coordinates => Some((c, values.to_pyarray(py))),
            _ => None,
        });
        Ok(positions.collect())
    }

    /// Units of the forces on coordinates.
    #[getter]
    fn force_units(&self) -> Vec<String> {
        self.plain()
            .map_or_else(Vec::new, |m| (0..m.coordinates.len()).map(|c| m.force_unit(c)).collect())
    }

    /// A model whose equations are functions.
    #[staticmethod]
    fn from_function(
        rates: Py<PyAny>,
        mass: Option<Py<PyAny>>,
        described: Described,
    ) -> PyResult<Self> {
        Self::of_functions(rates, mass.map_or(Inertia::Unit, Inertia::Function), described)
    }

    /// A model whose equations are a simulator's: one function gives the mass matrix and the forces.
    #[staticmethod]
    fn from_simulator(simulator: Py<PyAny>, described: Described) -> PyResult<Self> {
        Self::of_functions(simulator, Inertia::Before, described)
    }

    /// Its name.
    #[getter]
    fn name(&self) -> String {
        self.model.name(&self.called())
    }

    /// Parameters: name, value, unit, standard deviation.
    #[getter]
    fn parameters(&self) -> Vec<(String, f64, String, f64)> {
        let one = |p: &Parameter| (p.name.clone(), p.value, p.unit.clone(), p.std());
        self.plain().map_or_else(Vec::new, |m| m.parameters.iter().map(one).collect())
    }

    /// Inputs: name and unit.
    #[getter]
    fn inputs(&self) -> Vec<(String, String)> {
        match &self.model {
            AnyModel::Equations(m) => {
                m.inputs.iter().map(|i| (i.name.clone(), i.unit.clone())).collect()
            }
            AnyModel::Identified(m) => {
                m.1.inputs.iter().map(|i| (i.clone(), String::new())).collect()
            }
        }
    }

    /// Coordinates, velocities and states: name and unit.
    #[getter]
    fn states(&self) -> Vec<(String, String)> {
        match &self.model {
            AnyModel::Equations(m) => {
                let one = |i| (m.state_name(i).to_owned(), m.state_unit(i));
                (0..m.machine_states()).map(one).collect()
            }
            AnyModel::Identified(m) => {
                m.1.arguments.iter().map(|a| (a.clone(), String::new())).collect()
            }
        }
    }

    /// Effects: class and channel.
    #[getter]
    fn effects(&self) -> Vec<(String, String)> {
        let Some(m) = self.plain() else { return vec![] };
        let channel = |e: &plants::model::ModelEffect| {
            (e.effect.class.to_owned(), m.effect_channel_name(e.effect, e.channel).to_owned())
        };
        m.effects.iter().map(channel).collect()
    }

    /// The file it was read from.
    #[getter]
    fn file(&self) -> Option<PathBuf> {
        self.file.clone()
    }

    /// Its text.
    fn text(&self) -> PyResult<String> {
        match &self.model {
            AnyModel::Equations(m) => m.augmented_text(&Augmentation::default()).map_err(told),
            AnyModel::Identified(m) => Ok(m.0.to_json()),
        }
    }
}

impl Model {
    fn of_functions(rates: Py<PyAny>, inertia: Inertia, described: Described) -> PyResult<Self> {
        let raised = Raised::default();
        let sizes = described.sizes();
        let function = PythonFunction { rates, inertia, sizes, raised: raised.clone() };
        let built = described.builder()?.simulator(function).build();
        if let Ok(model) = &built {
            // Results of another shape are told here, and not when they are used.
            let rest = vec![0.0; sizes.variables()];
            model
                .dynamics()
                .bind(&model.values())
                .evaluate_once(&rest, &mut vec![0.0; sizes.rates()]);
        }
        match raised.take() {
            Some(error) => Err(error),
            None => Ok(Self::of(built.map_err(told)?, None, raised)),
        }
    }

    pub fn of(model: plants::Model, file: Option<PathBuf>, raised: Raised) -> Self {
        Self { model: AnyModel::Equations(Box::new(model)), file, raised }
    }

    /// What errors call it.
    pub fn called(&self) -> String {
        let name = || match &self.model {
            AnyModel::Equations(m) => m.name.clone(),
            AnyModel::Identified(_) => "an identified model".to_owned(),
        };
        self.file.as_ref().map_or_else(name, |file| file.display().to_string())
    }

    fn plain(&self) -> Option<&plants::Model> {
        match &self.model {
            AnyModel::Equations(m) => Some(m),
            AnyModel::Identified(_) => None,
        }
    }

    /// Its equations, for what needs parameters and laws.
    ///
    /// # Errors
    /// A model that was identified.
    pub fn equations(&self) -> PyResult<&plants::Model> {
        self.plain().ok_or_else(|| told(no_equations(&self.called())))
    }
}

impl Described {
    fn sizes(&self) -> Sizes {
        Sizes {
            parameters: self.parameters.len(),
            coordinates: self.coordinates.len(),
            states: self.states.len(),
            inputs: self.inputs.len(),
        }
    }

    fn builder(self) -> PyResult<Builder> {
        let mut builder = plants::Model::builder(&self.name).time_column(&self.time);
        builder = builder.hold(hold(&self.input_hold)?);
        for p in self.parameters {
            builder = p.declared(builder)?;
        }
        for (name, unit) in self.inputs {
            builder = builder.input(&name, &unit);
        }
        for GivenCoordinate(name, velocity, unit, force_unit) in self.coordinates {
            builder = builder.coordinate(&name, &velocity, &unit);
            builder = match force_unit {
                Some(unit) => builder.force_unit(&unit),
                None => builder,
            };
        }
        for (name, unit) in self.states {
            builder = builder.state(&name, &unit);
        }
        for (column, of, unit) in self.measurements {
            builder = builder.measurement(&column, &of, &unit);
        }
        Ok(builder)
    }
}

impl GivenParameter {
    fn declared(self, builder: Builder) -> PyResult<Builder> {
        let Self(name, value, unit, tolerance, std) = self;
        match (tolerance, std) {
            (Some(_), Some(_)) => {
                Err(told(format!("parameter '{name}': give its tolerance or its std, not both")))
            }
            (tolerance, None) => {
                Ok(builder.parameter(&name, value, &unit, tolerance.unwrap_or(0.0)))
            }
            (None, Some(std)) => Ok(builder.parameter_with_std(&name, value, &unit, std)),
        }
    }
}

fn hold(text: &str) -> PyResult<Hold> {
    match text {
        "zero-order" => Ok(Hold::ZeroOrder),
        "linear" => Ok(Hold::Linear),
        "band-limited" => Ok(Hold::BandLimited),
        other => Err(told(format!(
            "input_hold is \"zero-order\", \"linear\" or \"band-limited\"; found \"{other}\""
        ))),
    }
}
