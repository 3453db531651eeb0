//! From the text of a model file to a [`Model`], every mistake with its place.

mod channel;
mod effect;
mod value;

use super::{
    Coordinate, Measured, Measurement, Model, ModelError, Nodes, Parameter, Place, Quantity, System,
};
use crate::Hold;
use crate::expression::{Graph, NodeId, parse};
use effect::RawEffect;
use indexmap::IndexMap;
use serde::Deserialize;
use std::path::Path;
use toml::Spanned;

/// Programs number their registers with 16 bits.
const LARGEST: usize = 60_000;

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct File {
    name: String,
    #[serde(default)]
    parameters: IndexMap<Spanned<String>, RawParameter>,
    #[serde(default)]
    input: Vec<RawInput>,
    #[serde(default)]
    coordinate: Vec<RawCoordinate>,
    mechanics: Option<RawMechanics>,
    #[serde(default)]
    state: Vec<RawState>,
    #[serde(default)]
    effect: Vec<Spanned<RawEffect>>,
    #[serde(default)]
    measurement: Vec<RawMeasurement>,
    #[serde(default)]
    recordings: RawRecordings,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RawParameter {
    value: Spanned<f64>,
    #[serde(default)]
    unit: String,
    tolerance: Option<Spanned<f64>>,
    /// Standard deviation that a diagnosis wrote; the tolerance is what counts.
    #[serde(default, rename = "std")]
    _std: Option<f64>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RawInput {
    name: Spanned<String>,
    #[serde(default)]
    unit: String,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RawCoordinate {
    name: Spanned<String>,
    velocity: Spanned<String>,
    #[serde(default)]
    unit: String,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RawMechanics {
    mass: Spanned<Vec<Vec<Spanned<String>>>>,
    force: Spanned<Vec<Spanned<String>>>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RawState {
    name: Spanned<String>,
    #[serde(default)]
    unit: String,
    derivative: Spanned<String>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RawMeasurement {
    column: String,
    of: Spanned<String>,
    #[serde(default)]
    unit: String,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields, default)]
struct RawRecordings {
    time: String,
    input_hold: RawHold,
}

impl Default for RawRecordings {
    fn default() -> Self {
        Self { time: "t".to_owned(), input_hold: RawHold::ZeroOrder }
    }
}

#[derive(Deserialize)]
#[serde(rename_all = "kebab-case")]
enum RawHold {
    ZeroOrder,
    Linear,
}

impl Model {
    /// Read a model file.
    ///
    /// # Errors
    /// [`ModelError`] with the file, line and column, and what was expected there.
    pub fn read(path: &Path) -> Result<Self, ModelError> {
        let file = path.display().to_string();
        let text = std::fs::read(path).map_err(|e| {
            let message = format!("the model file cannot be read: {e}");
            ModelError { file: file.clone(), place: None, message }
        })?;
        let text = String::from_utf8(text).map_err(|_| {
            let message = "this is no text file; a model is a TOML file in UTF-8".to_owned();
            ModelError { file: file.clone(), place: None, message }
        })?;
        Self::from_text(&text, &file)
    }

    /// Read a model from its text; `file` is named in errors.
    ///
    /// # Errors
    /// [`ModelError`] with the line and column, and what was expected there.
    pub fn from_text(text: &str, file: &str) -> Result<Self, ModelError> {
        let reader = Reader { text, file };
        let raw: File = toml::from_str(text).map_err(|e| {
            let place = e.span().map(|s| Place::of(text, s.start, s.end));
            let message = e.message().replace('\n', " ");
            ModelError { file: file.to_owned(), place, message }
        })?;
        reader.model(raw)
    }
}

struct Reader<'a> {
    text: &'a str,
    file: &'a str,
}

/// The declared names and the slots of their variables.
struct Names {
    list: Vec<String>,
}

impl Names {
    fn node(&self, graph: &mut Graph, name: &str) -> Option<NodeId> {
        self.list.iter().position(|n| n == name).map(|slot| graph.variable(slot))
    }
}

impl Reader<'_> {
    fn error(&self, span: std::ops::Range<usize>, message: String) -> ModelError {
        let place = Some(Place::of(self.text, span.start, span.end));
        ModelError { file: self.file.to_owned(), place, message }
    }

    fn whole(&self, message: &str) -> ModelError {
        ModelError { file: self.file.to_owned(), place: None, message: message.to_owned() }
    }

    fn model(&self, raw: File) -> Result<Model, ModelError> {
        let names = self.names(&raw)?;
        let parameters = self.parameters(&raw)?;
        let equations = self.equations(&raw, &names)?;
        let (time_column, hold) = match raw.recordings.input_hold {
            RawHold::ZeroOrder => (raw.recordings.time, Hold::ZeroOrder),
            RawHold::Linear => (raw.recordings.time, Hold::Linear),
        };
        let quantity = |name: &Spanned<String>, unit: &String| Quantity {
            name: name.get_ref().clone(),
            unit: unit.clone(),
        };
        let mut model = Model {
            name: raw.name,
            parameters,
            inputs: raw.input.iter().map(|i| quantity(&i.name, &i.unit)).collect(),
            coordinates: raw.coordinate.iter().map(coordinate).collect(),
            states: raw.state.iter().map(|s| quantity(&s.name, &s.unit)).collect(),
            effects: vec![],
            measurements: vec![],
            time_column,
            hold,
            equations,
        };
        for m in &raw.measurement {
            let measurement = self.measurement(m, &mut model, &names)?;
            model.measurements.push(measurement);
        }
        for e in &raw.effect {
            let effect = self.effect(e, &model)?;
            model.effects.push(effect);
        }
        self.check_mass(&model, raw.mechanics.as_ref())?;
        Ok(model)
    }

    /// All names, in the order of their slots: parameters, coordinates, velocities, states,
    /// inputs, time.
    fn names(&self, raw: &File) -> Result<Names, ModelError> {
        if raw.coordinate.is_empty() && raw.state.is_empty() {
            let message = "the model has neither a [[coordinate]] nor a [[state]]: nothing moves";
            return Err(self.whole(message));
        }
        let parameters = raw.parameters.keys();
        let coordinates = raw.coordinate.iter().map(|c| &c.name);
        let velocities = raw.coordinate.iter().map(|c| &c.velocity);
        let states = raw.state.iter().map(|s| &s.name);
        let inputs = raw.input.iter().map(|i| &i.name);
        let all = parameters.chain(coordinates).chain(velocities).chain(states).chain(inputs);
        let mut list: Vec<String> = Vec::new();
        for name in all {
            self.check_name(name, &list)?;
            list.push(name.get_ref().clone());
        }
        // A model may use a name of its own for something else than time.
        if !list.iter().any(|n| n == "t") {
            list.push("t".to_owned());
        } else {
            list.push(String::new());
        }
        Ok(Names { list })
    }

    fn check_name(&self, name: &Spanned<String>, taken: &[String]) -> Result<(), ModelError> {
        let text = name.get_ref();
        let word = |c: char| c.is_ascii_alphanumeric() || c == '_';
        let plain = text.starts_with(|c: char| c.is_ascii_alphabetic() || c == '_')
            && text.chars().all(word);
        if !plain {
            let message = format!(
                "'{text}' cannot be a name: names begin with a letter and hold letters, digits and _"
            );
            return Err(self.error(name.span(), message));
        }
        if text == "pi" {
            return Err(self.error(name.span(), "'pi' is the number and cannot be a name".into()));
        }
        if taken.contains(text) {
            let message = format!("'{text}' is declared twice: each name stands for one thing");
            return Err(self.error(name.span(), message));
        }
        Ok(())
    }

    fn parameters(&self, raw: &File) -> Result<Vec<Parameter>, ModelError> {
        let mut parameters = Vec::new();
        for (name, p) in &raw.parameters {
            let value = *p.value.get_ref();
            if !value.is_finite() {
                let message = format!("the value of '{}' must be finite", name.get_ref());
                return Err(self.error(p.value.span(), message));
            }
            let tolerance = p.tolerance.as_ref().map_or(0.0, |t| *t.get_ref());
            if let Some(t) = p.tolerance.as_ref()
                && !(tolerance >= 0.0 && tolerance.is_finite())
            {
                let message = format!(
                    "a tolerance is a relative standard deviation, 0 or more; found {tolerance}"
                );
                return Err(self.error(t.span(), message));
            }
            let (name, unit) = (name.get_ref().clone(), p.unit.clone());
            parameters.push(Parameter { name, value, unit, tolerance });
        }
        Ok(parameters)
    }

    fn equations(&self, raw: &File, names: &Names) -> Result<Nodes, ModelError> {
        let mut nodes = Nodes::default();
        let n = raw.coordinate.len();
        match &raw.mechanics {
            Some(mechanics) => self.mechanics(mechanics, n, names, &mut nodes)?,
            None if n > 0 => {
                let message = "the model has coordinates but no [mechanics] with mass and force";
                return Err(self.whole(message));
            }
            None => {}
        }
        for s in &raw.state {
            let node = self.expression(&s.derivative, &mut nodes.graph, names)?;
            nodes.force.push(node);
        }
        if nodes.graph.nodes().len() > LARGEST {
            return Err(self.whole("the model's expressions hold more than 60 000 operations"));
        }
        Ok(nodes)
    }

    fn mechanics(
        &self,
        raw: &RawMechanics,
        n: usize,
        names: &Names,
        nodes: &mut Nodes,
    ) -> Result<(), ModelError> {
        let rows = raw.mass.get_ref();
        if rows.len() != n || rows.iter().any(|r| r.len() != n) {
            let found: Vec<_> = rows.iter().map(|r| r.len().to_string()).collect();
            let message = format!(
                "the mass matrix must be {n} x {n}, one row and column a coordinate; found rows of {} entries",
                if found.is_empty() { "no".to_owned() } else { found.join(", ") }
            );
            return Err(self.error(raw.mass.span(), message));
        }
        let forces = raw.force.get_ref();
        if forces.len() != n {
            let message =
                format!("there must be {n} forces, one a coordinate; found {}", forces.len());
            return Err(self.error(raw.force.span(), message));
        }
        for entry in rows.iter().flatten() {
            let node = self.expression(entry, &mut nodes.graph, names)?;
            nodes.mass.push(node);
        }
        for entry in forces {
            let node = self.expression(entry, &mut nodes.graph, names)?;
            nodes.force.push(node);
        }
        Ok(())
    }

    fn expression(
        &self,
        text: &Spanned<String>,
        graph: &mut Graph,
        names: &Names,
    ) -> Result<NodeId, ModelError> {
        let lookup = |graph: &mut Graph, name: &str| names.node(graph, name);
        parse(text.get_ref(), graph, &names.list, &lookup).map_err(|e| {
            // The span of a string begins with its quotes.
            let span = text.span();
            let quotes = (span.len().saturating_sub(text.get_ref().len())) / 2;
            let begin = span.start + quotes;
            self.error(begin + e.start..begin + e.end, format!("in an expression: {e}"))
        })
    }

    fn measurement(
        &self,
        raw: &RawMeasurement,
        model: &mut Model,
        names: &Names,
    ) -> Result<Measurement, ModelError> {
        let text = raw.of.get_ref();
        let state = (0..model.machine_states()).find(|&i| model.state_name(i) == text);
        let of = if let Some(state) = state {
            Measured::State(state)
        } else if let Some(input) = model.inputs.iter().position(|i| &i.name == text) {
            Measured::Input(input)
        } else {
            Measured::Expression(self.expression(&raw.of, &mut model.equations.graph, names)?)
        };
        let (column, unit) = (raw.column.clone(), raw.unit.clone());
        Ok(Measurement { column, unit, of, text: text.clone() })
    }

    /// A mass matrix that is singular at rest is a mistake in the file.
    fn check_mass(&self, model: &Model, raw: Option<&RawMechanics>) -> Result<(), ModelError> {
        let Some(raw) = raw else { return Ok(()) };
        let system = System::new(model);
        let rest = system.at_rest(&vec![0.0; model.machine_states()]);
        // The mechanics may be undefined at rest for other reasons (a division by a state);
        // only a determinant that vanishes is the mass matrix's fault.
        if system.mass_determinant(&rest) == 0.0 {
            let message = "the mass matrix is singular where all coordinates are 0: it cannot be solved for the accelerations";
            return Err(self.error(raw.mass.span(), message.to_owned()));
        }
        Ok(())
    }
}

fn coordinate(raw: &RawCoordinate) -> Coordinate {
    Coordinate {
        name: raw.name.get_ref().clone(),
        velocity: raw.velocity.get_ref().clone(),
        unit: raw.unit.clone(),
    }
}
