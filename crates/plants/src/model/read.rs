//! From the text of a model file to a [`Model`], every mistake with its place.

mod actuator;
mod channel;
mod define;
mod effect;
mod fmu;
mod robot;
mod value;

use super::name::check_name;
use super::units::same_unit;
use super::{
    Coordinate, Measured, Measurement, Model, ModelError, Parameter, Place, Quantity,
    RecordedInput, Source, Uncertainty,
};
use crate::Hold;
use crate::dynamics::{Equations, Nodes, Sizes};
use crate::expression::{FORCE_ON, Graph, NodeId, parse};
use actuator::RawActuator;
use define::Definitions;
use effect::RawEffect;
use fmu::RawFmu;
use indexmap::IndexMap;
use robot::RawRobot;
use serde::Deserialize;
use std::ops::Range;
use std::path::Path;
use std::sync::Arc;
use toml::Spanned;

/// Programs number their registers with 16 bits.
const LARGEST: usize = 60_000;

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct File {
    name: String,
    #[serde(default)]
    parameters: IndexMap<Spanned<String>, RawParameter>,
    robot: Option<Spanned<RawRobot>>,
    fmu: Option<Spanned<RawFmu>>,
    #[serde(default)]
    define: Definitions,
    #[serde(default)]
    input: Vec<RawInput>,
    #[serde(default)]
    coordinate: Vec<RawCoordinate>,
    mechanics: Option<RawMechanics>,
    #[serde(default)]
    state: Vec<RawState>,
    #[serde(default)]
    actuator: Vec<Spanned<RawActuator>>,
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
    /// One standard deviation of what is believed, relative to the value or in its unit.
    tolerance: Option<Spanned<f64>>,
    std: Option<Spanned<f64>>,
    /// Standard deviation of a value that a diagnosis wrote; what was believed before counts.
    #[serde(default, rename = "calibrated_std")]
    _calibrated_std: Option<f64>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RawInput {
    name: Spanned<String>,
    #[serde(default)]
    unit: String,
    /// Whether an actuator stands between what was recorded and the machine.
    #[serde(default = "yes")]
    actuator: bool,
    /// Known standard deviation of what was recorded.
    noise: Option<Spanned<f64>>,
}

fn yes() -> bool {
    true
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RawCoordinate {
    name: Spanned<String>,
    velocity: Spanned<String>,
    #[serde(default)]
    unit: String,
    force_unit: Option<Spanned<String>>,
    #[serde(default)]
    imposed: Option<Spanned<bool>>,
}

impl RawCoordinate {
    fn is_imposed(&self) -> bool {
        self.imposed.as_ref().is_some_and(|imposed| *imposed.get_ref())
    }
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
    time_unit: Spanned<String>,
    input_hold: Hold,
}

impl Default for RawRecordings {
    fn default() -> Self {
        Self {
            time: "t".to_owned(),
            time_unit: Spanned::new(0..0, "s".to_owned()),
            input_hold: Hold::default(),
        }
    }
}

impl Model {
    /// Read a model file, or a robot's own (URDF or MJCF) or an FMU, all that it does not say as where a
    /// model file does not.
    ///
    /// # Errors
    /// [`ModelError`] with the file, line and column, and what was expected there.
    pub fn read(path: &Path) -> Result<Self, ModelError> {
        let file = path.display().to_string();
        let text = std::fs::read(path).map_err(|e| {
            let message = format!("the model file cannot be read: {e}");
            ModelError { file: file.clone(), place: None, message }
        })?;
        if let Some(about) = fmu::about(path, &text) {
            let reader = Reader { text: &about, file: &file, robot: None };
            return reader.model(reader.file()?);
        }
        let text = String::from_utf8(text).map_err(|_| {
            let message = "this is no text file; a model is a TOML file in UTF-8".to_owned();
            ModelError { file: file.clone(), place: None, message }
        })?;
        match robot::about(path, &text) {
            Some(about) => {
                let reader = Reader { text: &about, file: &file, robot: Some(&text) };
                reader.model(reader.file()?)
            }
            None => Self::from_text(&text, &file),
        }
    }

    /// Read a model from its text; `file` is named in errors.
    ///
    /// # Errors
    /// [`ModelError`] with the line and column, and what was expected there.
    pub fn from_text(text: &str, file: &str) -> Result<Self, ModelError> {
        let reader = Reader { text, file, robot: None };
        reader.model(reader.file()?)
    }

    /// This model with the values of parameters and the effects of a text that
    /// [`Model::augmented_text`] wrote of it; `file` is named in errors. It is how a model that is
    /// no text itself takes up what was found.
    ///
    /// # Errors
    /// [`ModelError`] with the line and column, and what was expected there: also parameters
    /// that the model does not have.
    pub fn with_text(&self, text: &str, file: &str) -> Result<Self, ModelError> {
        let reader = Reader { text, file, robot: None };
        let raw = reader.file()?;
        let mut model = self.clone();
        for new in reader.parameters(&raw)? {
            match model.parameters.iter_mut().find(|p| p.name == new.name) {
                Some(own) => *own = new,
                None => return Err(reader.unknown_parameter(&raw, &new.name, self)),
            }
        }
        model.effects =
            raw.effect.iter().map(|e| reader.effect(e, &model)).collect::<Result<_, _>>()?;
        Ok(model)
    }
}

struct Reader<'a> {
    text: &'a str,
    file: &'a str,
    /// The text of the robot's own file, where that was read first.
    robot: Option<&'a str>,
}

/// The declared names: those of variables in the order of their slots, and definitions.
#[derive(Clone)]
struct Names {
    list: Vec<String>,
    sizes: Sizes,
    /// Definitions that are read.
    defined: Vec<(String, NodeId)>,
    /// The imposed coordinates.
    imposed: Vec<usize>,
}

impl Names {
    fn node(&self, graph: &mut Graph, name: &str) -> Option<NodeId> {
        let slot = self.list.iter().position(|n| n == name);
        slot.map(|slot| graph.variable(slot)).or_else(|| self.definition(name))
    }

    fn definition(&self, name: &str) -> Option<NodeId> {
        self.defined.iter().find(|(n, _)| n == name).map(|(_, node)| *node)
    }

    /// All names that an expression may use.
    fn all(&self) -> Vec<String> {
        self.list.iter().chain(self.defined.iter().map(|(name, _)| name)).cloned().collect()
    }

    /// The same with the forces that impose motion, which only measurements know of.
    fn with_forces(&self) -> Self {
        let mut all = self.clone();
        let coordinates = &self.list[self.sizes.parameters..];
        let forces = self.imposed.iter().map(|&c| format!("{FORCE_ON}{}", coordinates[c]));
        all.list.extend(forces);
        all
    }

    /// The entry of the machine's state, the input, or the force of that name.
    fn measured(&self, name: &str) -> Option<Measured> {
        let slot = self.list.iter().position(|n| n == name)?;
        let (variable, states) =
            (slot.checked_sub(self.sizes.parameters)?, self.sizes.machine_states());
        match variable {
            i if i < states => Some(Measured::State(i)),
            j if j < states + self.sizes.inputs => Some(Measured::Input(j - states)),
            // After time.
            k => {
                let force = k.checked_sub(self.sizes.variables())?;
                self.imposed.get(force).copied().map(Measured::Force)
            }
        }
    }
}

impl Reader<'_> {
    fn error(&self, span: Range<usize>, message: String) -> ModelError {
        let place = Some(Place::of(self.text, span.start, span.end));
        ModelError { file: self.file.to_owned(), place, message }
    }

    fn whole(&self, message: &str) -> ModelError {
        ModelError { file: self.file.to_owned(), place: None, message: message.to_owned() }
    }

    fn file(&self) -> Result<File, ModelError> {
        toml::from_str(self.text).map_err(|e| {
            let place = e.span().map(|s| Place::of(self.text, s.start, s.end));
            let message = e.message().replace('\n', " ");
            ModelError { file: self.file.to_owned(), place, message }
        })
    }

    /// Seconds in a unit of time.
    fn seconds(&self, unit: &Spanned<String>) -> Result<f64, ModelError> {
        value::factor(unit.get_ref(), "s").map_err(|_| {
            let message = format!(
                "'{}' is no unit of time; expected one as s, ms, us, ns, min or h",
                unit.get_ref()
            );
            self.error(unit.span(), message)
        })
    }

    fn model(&self, raw: File) -> Result<Model, ModelError> {
        if let Some(robot) = &raw.robot {
            return self.robot(&raw, robot);
        }
        if let Some(fmu) = &raw.fmu {
            return self.fmu(&raw, fmu);
        }
        let mut names = self.names(&raw)?;
        let parameters = self.parameters(&raw)?;
        let mut nodes = Nodes::default();
        self.define(&raw.define, &mut nodes.graph, &mut names)?;
        self.equations(&raw, &names, &mut nodes)?;
        let seen = names.with_forces();
        let measurements: Vec<Measurement> = raw
            .measurement
            .iter()
            .map(|m| self.measurement(m, &mut nodes, &seen))
            .collect::<Result<_, _>>()?;
        self.check_measured_inputs(&raw.measurement, &measurements)?;
        self.check_imposed(&raw, &names, &measurements)?;
        if nodes.graph.nodes().len() > LARGEST {
            return Err(self.whole("the model's expressions hold more than 60 000 operations"));
        }
        let equations = Equations::compile(&nodes, names.sizes);
        let state =
            |s: &RawState| Quantity { name: s.name.get_ref().clone(), unit: s.unit.clone() };
        let mut model = Model {
            name: raw.name,
            parameters,
            inputs: self.inputs(&raw.input)?,
            coordinates: raw.coordinate.iter().map(coordinate).collect(),
            states: raw.state.iter().map(state).collect(),
            effects: vec![],
            measurements,
            time_seconds: self.seconds(&raw.recordings.time_unit)?,
            time_column: raw.recordings.time,
            hold: raw.recordings.input_hold,
            assumptions: vec![],
            dynamics: Arc::new(equations.clone()),
            source: Some(Arc::new(Source {
                file: self.file.to_owned(),
                text: self.text.to_owned(),
                robot: None,
                fmu: None,
                alone: false,
            })),
        };
        self.check_force_units(&model, &raw.coordinate)?;
        self.actuators(&raw.actuator, &mut model, None, |servos| {
            Arc::new(equations.with_servos(servos))
        })?;
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
            check_name(name.get_ref(), &list)
                .map_err(|e| self.error(name.span(), e.to_string()))?;
            list.push(name.get_ref().clone());
        }
        self.check_defined(&raw.define, &list)?;
        // A model may use a name of its own for something else than time.
        if !list.iter().any(|n| n == "t") && !raw.define.contains_key("t") {
            list.push("t".to_owned());
        } else {
            list.push(String::new());
        }
        let sizes = Sizes {
            parameters: raw.parameters.len(),
            coordinates: raw.coordinate.len(),
            states: raw.state.len(),
            inputs: raw.input.len(),
        };
        let imposed = raw.coordinate.iter().enumerate().filter(|(_, c)| c.is_imposed());
        let imposed = imposed.map(|(i, _)| i).collect();
        Ok(Names { list, sizes, defined: vec![], imposed })
    }

    fn unknown_parameter(&self, raw: &File, name: &str, model: &Model) -> ModelError {
        let known: Vec<_> = model.parameters.iter().map(|p| p.name.as_str()).collect();
        let message =
            format!("'{}' has no parameter '{name}'; it has {}", model.name, known.join(", "));
        match raw.parameters.keys().find(|key| key.get_ref() == name) {
            Some(key) => self.error(key.span(), message),
            None => self.whole(&message),
        }
    }

    fn parameters(&self, raw: &File) -> Result<Vec<Parameter>, ModelError> {
        let mut parameters = Vec::new();
        for (name, p) in &raw.parameters {
            let value = *p.value.get_ref();
            if !value.is_finite() {
                let message = format!("the value of '{}' must be finite", name.get_ref());
                return Err(self.error(p.value.span(), message));
            }
            let (uncertainty, span) = self.uncertainty(name.get_ref(), p)?;
            let (name, unit) = (name.get_ref().clone(), p.unit.clone());
            let parameter = Parameter { name, value, unit, uncertainty };
            parameter.check().map_err(|e| self.error(span, e.to_string()))?;
            parameters.push(parameter);
        }
        Ok(parameters)
    }

    /// How sure the file is of a parameter, and where it says so.
    fn uncertainty(
        &self,
        name: &str,
        p: &RawParameter,
    ) -> Result<(Uncertainty, Range<usize>), ModelError> {
        let said = p.std.as_ref().or(p.tolerance.as_ref()).unwrap_or(&p.value);
        let number = |s: &Option<Spanned<f64>>| s.as_ref().map(|s| *s.get_ref());
        let uncertainty = value::uncertainty(name, number(&p.tolerance), number(&p.std));
        Ok((uncertainty.map_err(|e| self.error(said.span(), e))?, said.span()))
    }

    fn equations(&self, raw: &File, names: &Names, nodes: &mut Nodes) -> Result<(), ModelError> {
        let n = raw.coordinate.len();
        match &raw.mechanics {
            Some(mechanics) => self.mechanics(mechanics, n, names, nodes)?,
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
        Ok(())
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
        parse(text.get_ref(), graph, &names.all(), &lookup).map_err(|e| {
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
        nodes: &mut Nodes,
        names: &Names,
    ) -> Result<Measurement, ModelError> {
        let text = raw.of.get_ref();
        let of = match names.measured(text) {
            Some(of) => of,
            None => {
                let node = self.expression(&raw.of, &mut nodes.graph, names)?;
                nodes.outputs.push(node);
                Measured::Output(nodes.outputs.len() - 1)
            }
        };
        let (column, unit) = (raw.column.clone(), raw.unit.clone());
        Ok(Measurement { column, unit, of, text: text.clone() })
    }

    /// Of an input one recorded column is what drives the machine.
    fn check_measured_inputs(
        &self,
        raw: &[RawMeasurement],
        measurements: &[Measurement],
    ) -> Result<(), ModelError> {
        for (k, (m, raw)) in measurements.iter().zip(raw).enumerate() {
            let first = measurements[..k].iter().find(|earlier| earlier.of == m.of);
            if let (Measured::Input(_), Some(first)) = (m.of, first) {
                let message = format!(
                    "column '{}' already is the input '{}': an input is one column",
                    first.column, m.text
                );
                return Err(self.error(raw.of.span(), message));
            }
        }
        Ok(())
    }

    /// The motion of an imposed coordinate is that of its recorded position, and what the model
    /// says of it must be measured.
    fn check_imposed(
        &self,
        raw: &File,
        names: &Names,
        measurements: &[Measurement],
    ) -> Result<(), ModelError> {
        let n = names.sizes.coordinates;
        let measured = |of: Measured| measurements.iter().position(|m| m.of == of);
        for &c in &names.imposed {
            let rate = measured(Measured::State(c + n));
            if let (Some(rate), None) = (rate, measured(Measured::State(c))) {
                let message = format!(
                    "'{}' is the velocity of an imposed coordinate, whose motion is taken from its \
                     position: a measurement of '{}' is expected",
                    names.list[names.sizes.parameters + n + c],
                    names.list[names.sizes.parameters + c]
                );
                return Err(self.error(raw.measurement[rate].of.span(), message));
            }
        }
        let said = |m: &Measurement| matches!(m.of, Measured::Force(_) | Measured::Output(_));
        let nothing_free = names.imposed.len() == n && names.sizes.states == 0;
        let flag = raw.coordinate.iter().find_map(|c| c.imposed.as_ref());
        match flag.filter(|_| nothing_free && !measurements.iter().any(said)) {
            Some(flag) => {
                let message = "all motion is imposed, and nothing is measured that the model says: \
                     a [[measurement]] with of = \"force on ...\" is expected";
                Err(self.error(flag.span(), message.to_owned()))
            }
            None => Ok(()),
        }
    }

    /// What the model states of the unit of a force must be what its parameters and inputs say.
    fn check_force_units(&self, model: &Model, raw: &[RawCoordinate]) -> Result<(), ModelError> {
        for (channel, coordinate) in raw.iter().enumerate() {
            let Some(stated) = &coordinate.force_unit else { continue };
            let unit = stated.get_ref();
            let said = model.said_force_units(channel);
            if let Some(other) = said.iter().find(|said| !same_unit(&said.unit, unit)) {
                let message = format!(
                    "the generalised force of '{}' is said to be in {unit}; by the unit of '{}' it is in {}",
                    coordinate.name.get_ref(),
                    other.by,
                    other.unit
                );
                return Err(self.error(stated.span(), message));
            }
        }
        Ok(())
    }

    /// A mass matrix that is singular at rest is a mistake in the file.
    fn check_mass(&self, model: &Model, raw: Option<&RawMechanics>) -> Result<(), ModelError> {
        match raw {
            Some(raw) if model.is_singular_at_rest() => {
                let message = "the mass matrix is singular where all coordinates are 0: it cannot be solved for the accelerations";
                Err(self.error(raw.mass.span(), message.to_owned()))
            }
            _ => Ok(()),
        }
    }

    fn inputs(&self, raw: &[RawInput]) -> Result<Vec<RecordedInput>, ModelError> {
        let one = |raw: &RawInput| {
            let (name, noise) = (raw.name.get_ref(), raw.noise.as_ref());
            let mut input = RecordedInput::new(name, &raw.unit);
            input.actuator = raw.actuator;
            input.noise = noise.map(|std| *std.get_ref());
            match noise {
                Some(std) if !input.has_possible_noise() => {
                    let found = std.get_ref();
                    let message = format!(
                        "the noise of '{name}' is a standard deviation in its unit, 0 or more; found {found}"
                    );
                    Err(self.error(std.span(), message))
                }
                _ => Ok(input),
            }
        };
        raw.iter().map(one).collect()
    }
}

fn coordinate(raw: &RawCoordinate) -> Coordinate {
    Coordinate {
        name: raw.name.get_ref().clone(),
        velocity: raw.velocity.get_ref().clone(),
        unit: raw.unit.clone(),
        force_unit: raw.force_unit.as_ref().map(|unit| unit.get_ref().clone()),
        imposed: raw.is_imposed(),
    }
}
