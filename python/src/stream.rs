//! Identification from more trajectories than fit into memory: what to read, what was chosen, and sums. Who sums what when
//! is Python's.

use crate::error::told;
use crate::identification::{Identified, Settings};
use lacuna::occupation;
use lacuna::trajectories::{Columns, TrajectoriesError};
use pyo3::prelude::*;
use pyo3::types::PyBytes;
use rayon::ThreadPoolBuilder;

/// Trajectories of many files.
#[pyclass(frozen, module = "lacuna._lacuna")]
pub struct Trajectories(lacuna::trajectories::Trajectories);

/// What was chosen on a sample of them.
#[pyclass(frozen, module = "lacuna._lacuna")]
pub struct Stream(occupation::Stream);

/// What a stream sums of some of them.
#[pyclass(frozen, module = "lacuna._lacuna")]
pub struct Sums(occupation::Sums);

/// Columns of time, trajectories, coordinates, rates and inputs.
type ColumnNames = (String, Option<String>, Vec<String>, Option<Vec<String>>, Vec<String>);

/// On one thread: other processes have the rest.
fn alone<T: Send, E: ToString + Send>(
    py: Python<'_>,
    work: impl FnOnce() -> Result<T, E> + Send,
) -> PyResult<T> {
    let pool = ThreadPoolBuilder::new().num_threads(1).build().map_err(told)?;
    py.detach(|| pool.install(work).map_err(|e| e.to_string())).map_err(told)
}

#[pymethods]
impl Trajectories {
    /// Those that `__getnewargs__` told of.
    #[new]
    fn new(json: &str) -> PyResult<Self> {
        serde_json::from_str(json).map(Self).map_err(told)
    }

    /// With what `pickle` makes them anew.
    fn __getnewargs__(&self) -> PyResult<(String,)> {
        Ok((serde_json::to_string(&self.0).map_err(told)?,))
    }

    /// Of the files that match a pattern, in columns of these names: time, trajectory, coordinates, rates, inputs.
    #[staticmethod]
    fn find(py: Python<'_>, pattern: &str, names: ColumnNames) -> PyResult<Self> {
        let (time, trajectory, coordinates, rates, inputs) = names;
        let columns = Columns { time, trajectory, coordinates, rates, inputs };
        alone(py, || lacuna::trajectories::Trajectories::find(pattern, columns)).map(Self)
    }

    /// Number of chunks.
    #[getter]
    fn chunks(&self) -> usize {
        self.0.chunks()
    }

    /// What is chosen on a sample of them.
    fn choose(&self, py: Python<'_>, settings: Settings) -> PyResult<Stream> {
        let identification = settings.identification()?;
        let chosen = alone(py, || -> Result<_, TrajectoriesError> {
            Ok(identification.stream(&self.0.sample()?, self.0.rows())?)
        });
        chosen.map(Stream)
    }
}

#[pymethods]
impl Stream {
    /// The one that `__getnewargs__` told of.
    #[new]
    fn new(json: &str) -> PyResult<Self> {
        occupation::Stream::from_json(json).map(Self).map_err(told)
    }

    /// With what `pickle` makes it anew.
    fn __getnewargs__(&self) -> (String,) {
        (self.0.to_json(),)
    }

    /// The sums of a chunk.
    fn sums(&self, py: Python<'_>, trajectories: &Trajectories, chunk: usize) -> PyResult<Sums> {
        alone(py, || trajectories.0.sums(&self.0, chunk)).map(Sums)
    }

    /// The model of the sums of all chunks.
    fn solve(
        &self,
        py: Python<'_>,
        settings: Settings,
        trajectories: &Trajectories,
        sums: &Sums,
    ) -> PyResult<Identified> {
        let mut names = settings.names(settings.identification()?.input_path);
        names.time.clone_from(&trajectories.0.columns().time);
        Identified::of(alone(py, || self.0.solve(&sums.0))?, names)
    }
}

#[pymethods]
impl Sums {
    /// Those that `__getnewargs__` told of.
    #[new]
    fn new(bytes: &[u8]) -> PyResult<Self> {
        occupation::Sums::from_bytes(bytes).map(Self).map_err(told)
    }

    /// With what `pickle` makes them anew.
    fn __getnewargs__<'py>(&self, py: Python<'py>) -> (Bound<'py, PyBytes>,) {
        (PyBytes::new(py, &self.0.to_bytes()),)
    }

    /// Bytes of memory: for who has to keep them.
    fn __sizeof__(&self) -> usize {
        self.0.bytes()
    }

    /// These and others, which follow them.
    fn plus(&self, py: Python<'_>, others: &Self) -> PyResult<Self> {
        let mut sums = self.0.clone();
        alone(py, || sums.merge(&others.0).map(|()| sums)).map(Self)
    }
}
