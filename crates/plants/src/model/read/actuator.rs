//! `[[actuator]]`: what turns a command into the force on a coordinate, by a template.

use super::Reader;
use super::value::{check_range, factor, uncertainty};
use crate::dynamics::{Dynamics, Servo};
use crate::expression::hint;
use crate::model::name::unlike;
use crate::model::units::same_unit;
use crate::model::{Model, ModelEffect, ModelError, Parameter, RecordedInput, quoted};
use indexmap::IndexMap;
use lacuna_effects::{Parameter as Described, servo};
use serde::Deserialize;
use std::ops::Range;
use std::sync::Arc;
use toml::Spanned;

/// The entries of an `[[actuator]]`.
#[derive(Deserialize)]
#[serde(transparent)]
pub(super) struct RawActuator(IndexMap<Spanned<String>, Spanned<RawEntry>>);

#[derive(Deserialize)]
#[serde(
    untagged,
    expecting = "a name, a number, or a table with value, and perhaps unit and tolerance or std"
)]
enum RawEntry {
    Number(f64),
    Text(String),
    Table(RawNumber),
}

#[derive(Clone, Deserialize)]
#[serde(deny_unknown_fields)]
struct RawNumber {
    value: f64,
    unit: Option<String>,
    tolerance: Option<f64>,
    std: Option<f64>,
    /// Standard deviation of a value that a diagnosis wrote; what was believed before counts.
    #[serde(default, rename = "calibrated_std")]
    _calibrated_std: Option<f64>,
}

impl RawNumber {
    /// A value that is known, in the model's unit.
    fn of(value: f64) -> Self {
        Self { value, unit: None, tolerance: None, std: None, _calibrated_std: None }
    }
}

/// What a robot's own file states of the servo of a joint.
#[derive(Clone, Copy, Debug)]
pub(super) struct OfFile {
    pub gain: f64,
    pub damping: f64,
    pub limit: Option<f64>,
}

/// The line with which one begins.
const HEADER: &str = "[[actuator]]";
/// Keys that are names.
const NAMES: [&str; 3] = ["template", "channel", "command"];

/// Keys that are numbers.
const NUMBERS: [Described; 5] =
    [servo::GAIN, servo::DAMPING, servo::SATURATION, servo::BACKLASH, servo::DELAY];

/// What a servo's force is of, in the model's units.
struct Units {
    force: String,
    coordinate: String,
}

/// An `[[actuator]]` that is read.
struct Read {
    servo: Servo,
    parameters: Vec<Parameter>,
    /// Of the command, s.
    delay: Option<f64>,
}

impl Reader<'_> {
    /// Add the servos of a file to a model that has none, and to its dynamics by `with`. Those of a robot take the
    /// place of its joints' torques; `own` has what its file states of each.
    pub(super) fn actuators(
        &self,
        raw: &[Spanned<RawActuator>],
        model: &mut Model,
        own: Option<&[Option<OfFile>]>,
        with: impl FnOnce(Vec<Servo>) -> Arc<dyn Dynamics>,
    ) -> Result<(), ModelError> {
        let mut servos: Vec<Servo> = vec![];
        for table in raw {
            let read = self.actuator(table, model, own, &servos)?;
            servos.push(read.servo);
            model.parameters.extend(read.parameters);
            if let Some(delay) = read.delay {
                model.effects.push(delayed(read.servo.input, delay));
            }
        }
        model.dynamics = with(servos);
        Ok(())
    }

    fn actuator(
        &self,
        table: &Spanned<RawActuator>,
        model: &mut Model,
        own: Option<&[Option<OfFile>]>,
        before: &[Servo],
    ) -> Result<Read, ModelError> {
        let (header, raw) = (self.header(table.span(), HEADER), table.get_ref());
        self.check_template(raw, &header)?;
        self.check_keys(raw)?;
        let (name, place) = self.needs_name(raw, "channel", &header)?;
        let coordinate = self.driven((name, place), model, before)?;
        let command = match self.name(raw, "command")? {
            Some((command, place)) => (command.to_owned(), place),
            None => (servo::command_of(name), header.clone()),
        };
        let input = self.commanded(command, (coordinate, own.is_some()), model, before)?;
        let units =
            Units { force: model.force_unit(coordinate), coordinate: model.state_unit(coordinate) };
        let stated = own.and_then(|joints| *joints.get(coordinate)?);
        let number = |number: &Described, stated: Option<f64>| {
            self.number(raw, (name, number), &units, stated)
        };
        let gain = number(&servo::GAIN, stated.map(|s| s.gain))?.ok_or_else(|| {
            let unit = quoted(&servo::GAIN.unit.text(&units.force, &units.coordinate, ""));
            let message =
                format!("the servo of '{name}' needs kp = {{ value = ..., unit = {unit} }}");
            self.error(header, message)
        })?;
        let damping = number(&servo::DAMPING, Some(stated.map_or(0.0, |s| s.damping)))?;
        let limit = number(&servo::SATURATION, stated.and_then(|s| s.limit))?;
        let play = number(&servo::BACKLASH, None)?;
        let (saturates, plays) = (limit.is_some(), play.is_some());
        let delay = number(&servo::DELAY, None)?;
        self.check_delay(raw, delay.as_ref())?;
        Ok(Read {
            servo: Servo { coordinate, input, saturates, plays },
            parameters: [Some(gain), damping, limit, play].into_iter().flatten().collect(),
            delay: delay.map(|delay| delay.value),
        })
    }

    fn check_template(&self, raw: &RawActuator, header: &Range<usize>) -> Result<(), ModelError> {
        let (template, place) = self.needs_name(raw, "template", header)?;
        if template == servo::TEMPLATE {
            return Ok(());
        }
        let (found, known) = (quoted(template), quoted(servo::TEMPLATE));
        Err(self.error(place, format!("unknown template {found}; there is {known}")))
    }

    /// That a delay, which is an effect and no parameter, is not to be calibrated.
    fn check_delay(&self, raw: &RawActuator, delay: Option<&Parameter>) -> Result<(), ModelError> {
        match delay.zip(raw.get(servo::DELAY.name)) {
            Some((delay, place)) if delay.std() > 0.0 => {
                let message = "the delay that is stated is not calibrated: say it without tolerance or std, or \
                    leave it out, and a diagnosis looks for it";
                Err(self.error(place.span(), message.to_owned()))
            }
            _ => Ok(()),
        }
    }

    /// A name that a table gives, and its place.
    fn name<'r>(
        &self,
        raw: &'r RawActuator,
        key: &str,
    ) -> Result<Option<(&'r str, Range<usize>)>, ModelError> {
        let Some(value) = raw.get(key) else { return Ok(None) };
        match value.get_ref() {
            RawEntry::Text(text) => Ok(Some((text, value.span()))),
            _ => Err(self.error(value.span(), format!("'{key}' is a name, in quotes"))),
        }
    }

    fn needs_name<'r>(
        &self,
        raw: &'r RawActuator,
        key: &str,
        header: &Range<usize>,
    ) -> Result<(&'r str, Range<usize>), ModelError> {
        let missing = || format!("an actuator needs {key} = \"...\"");
        self.name(raw, key)?.ok_or_else(|| self.error(header.clone(), missing()))
    }

    fn check_keys(&self, raw: &RawActuator) -> Result<(), ModelError> {
        let known: Vec<String> =
            NAMES.into_iter().chain(NUMBERS.map(|n| n.name)).map(str::to_owned).collect();
        match raw.0.keys().find(|key| !known.contains(key.get_ref())) {
            Some(key) => {
                let (name, hint) = (key.get_ref(), hint(key.get_ref(), &known));
                let message =
                    format!("an actuator has no '{name}'{hint}; there are {}", known.join(", "));
                Err(self.error(key.span(), message))
            }
            None => Ok(()),
        }
    }

    /// The coordinate that an actuator drives, which none of those before does.
    fn driven(
        &self,
        (name, place): (&str, Range<usize>),
        model: &Model,
        before: &[Servo],
    ) -> Result<usize, ModelError> {
        let names: Vec<String> = model.coordinates.iter().map(|c| c.name.clone()).collect();
        let Some(found) = names.iter().position(|n| n == name) else {
            let hint = hint(name, &names);
            let message = format!(
                "an actuator drives a second-order coordinate, and '{name}' is none{hint}; there are {}",
                names.join(", ")
            );
            return Err(self.error(place, message));
        };
        if model.is_imposed(found) {
            let message = format!("the motion of '{name}' is imposed: no actuator drives it");
            return Err(self.error(place, message));
        }
        if before.iter().any(|s| s.coordinate == found) {
            let message = format!("'{name}' has an actuator already: a coordinate has one");
            return Err(self.error(place, message));
        }
        Ok(found)
    }

    /// The input that the servo of a coordinate follows, which none of those before does; of a robot, that of its joint.
    fn commanded(
        &self,
        (name, place): (String, Range<usize>),
        (coordinate, is_robot): (usize, bool),
        model: &mut Model,
        before: &[Servo],
    ) -> Result<usize, ModelError> {
        let (unit, command) = (model.state_unit(coordinate), (name, place.clone()));
        let input = match is_robot {
            true => self.renamed(command, (coordinate, &unit), model)?,
            false => self.followed(command, &unit, model)?,
        };
        if before.iter().any(|s| s.input == input) {
            let message = "another servo follows this command already: each has one of its own";
            return Err(self.error(place, message.to_owned()));
        }
        Ok(input)
    }

    /// The input that a servo follows, among those that are declared.
    fn followed(
        &self,
        (name, place): (String, Range<usize>),
        unit: &str,
        model: &Model,
    ) -> Result<usize, ModelError> {
        let names: Vec<String> = model.inputs.iter().map(|i| i.name.clone()).collect();
        let Some(found) = names.iter().position(|n| *n == name) else {
            let hint = hint(&name, &names);
            let message = format!(
                "the servo follows '{name}', which is no input{hint}; there are {}: say [[input]] with \
                 name = {}, unit = {}, or command = \"...\" here",
                if names.is_empty() { "none".to_owned() } else { names.join(", ") },
                quoted(&name),
                quoted(unit)
            );
            return Err(self.error(place, message));
        };
        let own = &model.inputs[found].unit;
        if own.is_empty() || unit.is_empty() || same_unit(own, unit) {
            return Ok(found);
        }
        let message = format!(
            "the servo follows '{name}', which is in {own}; a commanded position is in the unit of its \
             coordinate, {unit}"
        );
        Err(self.error(place, message))
    }

    /// The input of a robot's joint, which is no torque but a command.
    fn renamed(
        &self,
        (name, place): (String, Range<usize>),
        (coordinate, unit): (usize, &str),
        model: &mut Model,
    ) -> Result<usize, ModelError> {
        let states = (0..model.machine_states()).map(|s| model.state_name(s).to_owned());
        let inputs = model.inputs.iter().enumerate().filter(|(j, _)| *j != coordinate);
        let taken: Vec<String> = states.chain(inputs.map(|(_, i)| i.name.clone())).collect();
        unlike(&name, &taken).map_err(|e| self.error(place, e.to_string()))?;
        model.inputs[coordinate] = RecordedInput::new(&name, unit);
        Ok(coordinate)
    }

    /// A number of the servo of a channel, in the model's units; what the robot's own file says where the table
    /// does not.
    fn number(
        &self,
        raw: &RawActuator,
        (channel, number): (&str, &Described),
        units: &Units,
        stated: Option<f64>,
    ) -> Result<Option<Parameter>, ModelError> {
        let (key, expected) = (number.name, number.unit.text(&units.force, &units.coordinate, ""));
        let (given, place) = match raw.get(key) {
            None => (stated.map(RawNumber::of), 0..0),
            Some(entry) => (Some(self.quantity(key, entry)?), entry.span()),
        };
        let Some(given) = given else { return Ok(None) };
        let at = |message: String| self.error(place.clone(), message);
        check_range(number, given.value).map_err(at)?;
        let (factor, unit) = match given.unit {
            None => (1.0, expected),
            Some(written) => {
                let factor = factor(&written, &expected)
                    .map_err(|why| at(format!("'{key}' is given in {written}; {why}")))?;
                (factor, if factor == 1.0 { written } else { expected })
            }
        };
        let std = given.std.map(|std| factor * std);
        let uncertainty = uncertainty(key, given.tolerance, std).map_err(at)?;
        let name = format!("{channel}.{key}");
        let parameter = Parameter { name, value: factor * given.value, unit, uncertainty };
        parameter.check().map_err(|e| at(e.to_string()))?;
        Ok(Some(parameter))
    }

    fn quantity(&self, key: &str, entry: &Spanned<RawEntry>) -> Result<RawNumber, ModelError> {
        match entry.get_ref() {
            RawEntry::Table(table) => Ok(table.clone()),
            RawEntry::Number(value) => Ok(RawNumber::of(*value)),
            RawEntry::Text(_) => {
                let message = format!("'{key}' is a number, or a table with its value");
                Err(self.error(entry.span(), message))
            }
        }
    }
}

impl RawActuator {
    fn get(&self, key: &str) -> Option<&Spanned<RawEntry>> {
        self.0.iter().find(|(k, _)| k.get_ref() == key).map(|(_, value)| value)
    }
}

/// The delay of a command.
fn delayed(input: usize, delay: f64) -> ModelEffect {
    let effect = servo::delay_of_command();
    ModelEffect { effect, channel: input, other: None, parameters: vec![delay], std: vec![None] }
}
