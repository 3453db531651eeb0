//! The file of a compiled model: JSON with a version.

use std::fs;
use std::path::Path;

use lacuna_realtime::{Eight, Evaluator, Group, LandmarkSum, Products, Profile, Series, Shape};
use serde::{Deserialize, Serialize};

use super::{CompileError, Compiled, Function};
use crate::{ModelFileError, Names};

/// Version of the saved form.
const VERSION: u32 = 1;

/// What the file holds; `compiled` is its version, by which the file is known.
#[derive(Debug, Serialize, Deserialize)]
struct SavedCompiled {
    compiled: u32,
    order: usize,
    dimension: usize,
    inputs: usize,
    arguments: usize,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    names: Option<Names>,
    lower: Vec<f64>,
    upper: Vec<f64>,
    tolerance: f64,
    functions: Vec<Function>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    series: Option<SavedSeries>,
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    sums: Vec<SavedSum>,
}

#[derive(Debug, Serialize, Deserialize)]
struct SavedSeries {
    degrees: Vec<u16>,
    outer: SavedProducts,
    inner: SavedProducts,
    groups: Vec<SavedGroup>,
}

#[derive(Debug, Serialize, Deserialize)]
struct SavedProducts {
    parents: Vec<u16>,
    factors: Vec<u16>,
}

#[derive(Debug, Serialize, Deserialize)]
struct SavedGroup {
    entries: Vec<u16>,
    blocks: Vec<[u16; 2]>,
    coefficients: Vec<f64>,
}

#[derive(Debug, Serialize, Deserialize)]
struct SavedSum {
    profile: SavedProfile,
    centre: Vec<f64>,
    factors: Vec<f64>,
    entries: Vec<u16>,
    tiles: Vec<f64>,
}

/// [`Profile`], which knows no files.
#[derive(Debug, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
enum SavedProfile {
    Exponential,
    Power { offset: f64, degree: u32 },
    Gaussian,
    MaternHalf,
    MaternThreeHalves,
    MaternFiveHalves,
}

#[derive(Deserialize)]
struct VersionOnly {
    compiled: u32,
}

impl Compiled {
    /// The model as JSON, with the version `compiled`; [`Compiled::load`] brings back the same values to the last bit.
    pub fn to_json(&self) -> String {
        let shape = self.evaluator.shape();
        let saved = SavedCompiled {
            compiled: VERSION,
            order: self.order,
            dimension: shape.dimension,
            inputs: shape.inputs,
            arguments: shape.arguments,
            names: self.names.clone(),
            lower: self.evaluator.lower().to_vec(),
            upper: self.evaluator.upper().to_vec(),
            tolerance: self.tolerance,
            functions: self.functions.clone(),
            series: self.evaluator.series().map(SavedSeries::of),
            sums: self.evaluator.sums().iter().map(SavedSum::of).collect(),
        };
        serde_json::to_string(&saved).expect("numbers and strings become JSON")
    }

    /// Reads what [`Compiled::to_json`] gave.
    ///
    /// # Errors
    /// A file that cannot be read, is no JSON of a compiled model, or holds one that is not consistent.
    pub fn load(path: &Path) -> Result<Self, ModelFileError> {
        let text = fs::read_to_string(path).map_err(|error| ModelFileError::io(path, &error))?;
        let json = |reason: String| ModelFileError::Json { path: path.to_owned(), reason };
        let VersionOnly { compiled } =
            serde_json::from_str(&text).map_err(|error| json(error.to_string()))?;
        if compiled != VERSION {
            let expected = "expected version 1 of the compiled model's format, found";
            return Err(json(format!("{expected} {compiled}")));
        }
        let saved: SavedCompiled =
            serde_json::from_str(&text).map_err(|error| json(error.to_string()))?;
        saved.restore().map_err(json)
    }
}

impl SavedCompiled {
    fn restore(self) -> Result<Compiled, String> {
        let shape =
            Shape { arguments: self.arguments, dimension: self.dimension, inputs: self.inputs };
        let series = self.series.map(SavedSeries::restore);
        let sums: Vec<LandmarkSum<'static>> =
            self.sums.into_iter().map(SavedSum::restore).collect();
        let evaluator =
            Evaluator::new(shape, self.lower.into(), self.upper.into(), series, sums.into())
                .map_err(|error| CompileError::from(error).to_string())?;
        let names = self.names.as_ref();
        let lengths = [
            ("functions", self.dimension * (1 + self.inputs), self.functions.len()),
            ("coordinates", self.dimension, names.map_or(self.dimension, |n| n.coordinates.len())),
            ("rates", self.dimension, names.map_or(self.dimension, |n| n.rates.len())),
            ("inputs", self.inputs, names.map_or(self.inputs, |n| n.inputs.len())),
            ("arguments", self.arguments, names.map_or(self.arguments, |n| n.arguments.len())),
        ];
        if let Some((what, expected, found)) = lengths.into_iter().find(|(_, e, f)| e != f) {
            return Err(format!("{what}: expected {expected}, found {found}"));
        }
        let place =
            |f: &Function| f.input.map_or(f.row, |j| self.dimension + f.row * self.inputs + j);
        if self.functions.iter().enumerate().any(|(k, f)| place(f) != k) {
            return Err(
                "functions: expected f_1, ..., f_n, g_11, ..., g_nm in this order".to_owned()
            );
        }
        Ok(Compiled {
            order: self.order,
            names: self.names,
            tolerance: self.tolerance,
            functions: self.functions,
            evaluator,
        })
    }
}

impl SavedSeries {
    fn of(series: &Series<'_>) -> Self {
        let group = |group: &Group<'_>| SavedGroup {
            entries: group.entries.to_vec(),
            blocks: group.blocks.to_vec(),
            coefficients: Eight::numbers(&group.coefficients),
        };
        Self {
            degrees: series.degrees.to_vec(),
            outer: SavedProducts::of(&series.outer),
            inner: SavedProducts::of(&series.inner),
            groups: series.groups.iter().map(group).collect(),
        }
    }

    fn restore(self) -> Series<'static> {
        let group = |group: SavedGroup| Group {
            entries: group.entries.into(),
            blocks: group.blocks.into(),
            coefficients: Eight::table(&group.coefficients).into(),
        };
        Series {
            degrees: self.degrees.into(),
            outer: self.outer.restore(),
            inner: self.inner.restore(),
            groups: self.groups.into_iter().map(group).collect::<Vec<_>>().into(),
        }
    }
}

impl SavedProducts {
    fn of(products: &Products<'_>) -> Self {
        Self { parents: products.parents.to_vec(), factors: products.factors.to_vec() }
    }

    fn restore(self) -> Products<'static> {
        Products { parents: self.parents.into(), factors: self.factors.into() }
    }
}

impl SavedSum {
    fn of(sum: &LandmarkSum<'_>) -> Self {
        let profile = match sum.profile {
            Profile::Exponential => SavedProfile::Exponential,
            Profile::Power { offset, degree } => SavedProfile::Power { offset, degree },
            Profile::Gaussian => SavedProfile::Gaussian,
            Profile::MaternHalf => SavedProfile::MaternHalf,
            Profile::MaternThreeHalves => SavedProfile::MaternThreeHalves,
            Profile::MaternFiveHalves => SavedProfile::MaternFiveHalves,
        };
        Self {
            profile,
            centre: sum.centre.to_vec(),
            factors: sum.factors.to_vec(),
            entries: sum.entries.to_vec(),
            tiles: Eight::numbers(&sum.tiles),
        }
    }

    fn restore(self) -> LandmarkSum<'static> {
        let profile = match self.profile {
            SavedProfile::Exponential => Profile::Exponential,
            SavedProfile::Power { offset, degree } => Profile::Power { offset, degree },
            SavedProfile::Gaussian => Profile::Gaussian,
            SavedProfile::MaternHalf => Profile::MaternHalf,
            SavedProfile::MaternThreeHalves => Profile::MaternThreeHalves,
            SavedProfile::MaternFiveHalves => Profile::MaternFiveHalves,
        };
        LandmarkSum {
            profile,
            centre: self.centre.into(),
            factors: self.factors.into(),
            entries: self.entries.into(),
            tiles: Eight::table(&self.tiles).into(),
        }
    }
}
