//! `[fmu]`: a model whose equations of motion are those of an FMU.

use super::{File, RawMeasurement, Reader};
use crate::dynamics::{Differences, Sizes, Unit};
use crate::model::{
    Coordinate, Measured, Measurement, Model, ModelError, Parameter, Quantity, RecordedInput,
    Source, Uncertainty, quoted, units::per_second,
};
use lacuna_fmu::{Description, Fmu, Question, Variable, Wanted};
use lacuna_units::{Unit as Measure, convert_factor};
use serde::Deserialize;
use std::path::Path;
use std::sync::Arc;
use toml::Spanned;

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RawFmu {
    file: Spanned<String>,
}

/// The model file that says no more than an FMU, by that one's path and first bytes; none where it is none.
pub(super) fn about(path: &Path, bytes: &[u8]) -> Option<String> {
    let named = path.extension().is_some_and(|kind| kind.eq_ignore_ascii_case("fmu"));
    let (name, stem) = (path.file_name()?.to_str()?, path.file_stem()?.to_str()?);
    (named || bytes.starts_with(b"PK\x03\x04"))
        .then(|| format!("name = {}\n\n[fmu]\nfile = {}\n", quoted(stem), quoted(name)))
}

impl Reader<'_> {
    pub(super) fn fmu(&self, raw: &File, table: &Spanned<RawFmu>) -> Result<Model, ModelError> {
        self.check_alone(raw, table.span(), "[fmu] says how all of it moves")?;
        let file = &table.get_ref().file;
        let path = self.beside(file.get_ref());
        if !path.exists() {
            let message = format!("the FMU {} is not there", path.display());
            return Err(self.error(file.span(), message));
        }
        // A mistake in the FMU is none of the file that names it.
        let in_fmu = |message: String| {
            let file = path.display().to_string();
            ModelError { file, place: None, message: format!("the FMU {message}") }
        };
        let fmu = Arc::new(Fmu::open(&path).map_err(|e| in_fmu(e.to_string()))?);
        let d = fmu.description();
        check_names(d).map_err(in_fmu)?;
        let pairs = pairs(&fmu).map_err(in_fmu)?;
        check_velocities(d, &pairs).map_err(in_fmu)?;
        let (coordinates, velocities): (Vec<usize>, Vec<usize>) = pairs.iter().copied().unzip();
        let paired = [coordinates, velocities].concat();
        let firsts: Vec<usize> = (0..d.states.len()).filter(|k| !paired.contains(k)).collect();
        let sizes = Sizes {
            parameters: d.parameters.len(),
            coordinates: pairs.len(),
            states: firsts.len(),
            inputs: d.inputs.len(),
        };
        let state = |k: usize| &d.states[k].variable;
        let order = [&paired[..], &firsts].concat();
        let mut model = Model {
            name: raw.name.clone(),
            parameters: d.parameters.iter().map(known).collect(),
            inputs: d.inputs.iter().map(|u| RecordedInput::new(&u.name, &u.unit)).collect(),
            coordinates: pairs.iter().map(|&(q, v)| coordinate(state(q), state(v))).collect(),
            states: firsts.iter().map(|&k| quantity(state(k))).collect(),
            effects: vec![],
            measurements: vec![],
            time_column: raw.recordings.time.clone(),
            time_seconds: self.seconds(&raw.recordings.time_unit)?,
            hold: raw.recordings.input_hold,
            assumptions: vec![],
            dynamics: Arc::new(Differences::new(Unit { fmu: fmu.clone(), order }, sizes)),
            source: Some(Arc::new(Source {
                file: self.file.to_owned(),
                text: self.text.to_owned(),
                robot: None,
                fmu: Some(path),
                alone: false,
            })),
        };
        self.beside_fmu(raw, d, &mut model)?;
        Ok(model)
    }

    /// All else that a model file says.
    fn beside_fmu(&self, raw: &File, d: &Description, model: &mut Model) -> Result<(), ModelError> {
        self.override_known(raw, d, model)?;
        for input in &raw.input {
            let own = model.inputs.iter_mut().find(|own| own.name == *input.name.get_ref());
            if let Some(own) = own.filter(|_| !input.unit.is_empty()) {
                let told = |why| self.error(input.name.span(), why);
                same(&input.unit, &mut own.unit, input.name.get_ref()).map_err(told)?;
            }
        }
        self.override_inputs(&raw.input, model)?;
        for m in &raw.measurement {
            let measurement = self.measured_of_fmu(m, d, model)?;
            model.measurements.push(measurement);
        }
        self.check_measured_inputs(&raw.measurement, &model.measurements)?;
        for e in &raw.effect {
            let effect = self.effect(e, model)?;
            model.effects.push(effect);
        }
        Ok(())
    }

    /// `[parameters]` beside an FMU: other values than it begins with, or how sure they are, in its
    /// units or in such as can be converted.
    fn override_known(
        &self,
        raw: &File,
        d: &Description,
        model: &mut Model,
    ) -> Result<(), ModelError> {
        for (new, raw_new) in self.parameters(raw)?.into_iter().zip(raw.parameters.values()) {
            let place = model.parameters.iter().position(|p| p.name == new.name);
            let Some(k) = place else { return Err(self.unknown_parameter(raw, &new.name, model)) };
            let (own, said) = (&mut model.parameters[k], &d.parameters[k]);
            let told = |why| self.error(raw_new.value.span(), why);
            let factor = factor(&new.unit, &mut own.unit, &new.name).map_err(told)?;
            let value = factor * new.value;
            if !(said.min..=said.max).contains(&value) {
                let message = format!(
                    "the FMU has '{}' between {} and {}; found {value}",
                    new.name, said.min, said.max
                );
                return Err(self.error(raw_new.value.span(), message));
            }
            own.value = value;
            if raw_new.tolerance.is_some() || raw_new.std.is_some() {
                own.uncertainty = match new.uncertainty {
                    Uncertainty::Absolute(std) => Uncertainty::Absolute(factor.abs() * std),
                    relative @ Uncertainty::Relative(_) => relative,
                };
            }
        }
        Ok(())
    }

    /// What a column measures: a state, an input, or an output, which may be another name of either.
    fn measured_of_fmu(
        &self,
        raw: &RawMeasurement,
        d: &Description,
        model: &Model,
    ) -> Result<Measurement, ModelError> {
        let (column, text) = (raw.column.clone(), raw.of.get_ref());
        let output = d.outputs.iter().position(|y| y.name == *text);
        let reference = output.map(|k| d.outputs[k].reference);
        let alias = |v: &Variable| reference == Some(v.reference) || v.name == *text;
        let state = d
            .states
            .iter()
            .map(|z| &z.variable)
            .find(|&z| alias(z))
            .and_then(|z| (0..model.machine_states()).find(|&s| model.state_name(s) == z.name));
        let input = || d.inputs.iter().position(alias).map(Measured::Input);
        let named = state.map(Measured::State).or_else(input);
        if let Some(of) = named {
            return Ok(Measurement { column, unit: raw.unit.clone(), of, text: text.clone() });
        }
        let Some(k) = output else {
            let states = d.states.iter().map(|z| &z.variable);
            let all = states.chain(&d.inputs).chain(&d.outputs);
            let known: Vec<&str> = all.map(|v| v.name.as_str()).collect();
            let message = format!(
                "of an FMU '{text}' is not measured; expected a state, input or output: {}",
                known.join(", ")
            );
            return Err(self.error(raw.of.span(), message));
        };
        let mut unit = d.outputs[k].unit.clone();
        if !raw.unit.is_empty() {
            same(&raw.unit, &mut unit, text).map_err(|why| self.error(raw.of.span(), why))?;
        }
        Ok(Measurement { column, unit, of: Measured::Output(k), text: text.clone() })
    }
}

/// A parameter that is known exactly.
fn known(p: &Variable) -> Parameter {
    let (name, unit) = (p.name.clone(), p.unit.clone());
    Parameter { name, value: p.start, unit, uncertainty: Uncertainty::Relative(0.0) }
}

fn quantity(z: &Variable) -> Quantity {
    Quantity { name: z.name.clone(), unit: z.unit.clone() }
}

fn coordinate(q: &Variable, v: &Variable) -> Coordinate {
    let (name, velocity, unit) = (q.name.clone(), v.name.clone(), q.unit.clone());
    Coordinate { name, velocity, unit, force_unit: None, imposed: false }
}

/// What a value in the unit `given` is multiplied by to be in the FMU's own; where it has none, `given` is it.
fn factor(given: &str, own: &mut String, name: &str) -> Result<f64, String> {
    if given.is_empty() || given == own {
        return Ok(1.0);
    }
    if own.is_empty() {
        given.clone_into(own);
        return Ok(1.0);
    }
    let converted =
        Measure::parse(given).and_then(|from| convert_factor(&from, &Measure::parse(own)?));
    converted.map_err(|e| format!("the FMU has '{name}' in {own}: {e}"))
}

/// That a unit is the FMU's own.
fn same(given: &str, own: &mut String, name: &str) -> Result<(), String> {
    match factor(given, own, name)? {
        1.0 => Ok(()),
        _ => Err(format!("the FMU has '{name}' in {own}; found {given}")),
    }
}

/// Each name stands for one thing.
fn check_names(d: &Description) -> Result<(), String> {
    let states = d.states.iter().map(|z| &z.variable);
    let mut names: Vec<&str> =
        states.chain(&d.inputs).chain(&d.parameters).map(|v| v.name.as_str()).collect();
    names.sort_unstable();
    match names.windows(2).find(|two| two[0] == two[1]) {
        Some(two) => Err(format!("names two variables '{}'", two[0])),
        None => Ok(()),
    }
}

/// A velocity is in the unit of its coordinate per second.
fn check_velocities(d: &Description, pairs: &[(usize, usize)]) -> Result<(), String> {
    for &(q, v) in pairs {
        let (q, v) = (&d.states[q].variable, &d.states[v].variable);
        let expected = per_second(&q.unit);
        let (Ok(from), Ok(to)) = (Measure::parse(&expected), Measure::parse(&v.unit)) else {
            continue;
        };
        if q.unit.is_empty() || convert_factor(&from, &to) == Ok(1.0) {
            continue;
        }
        return Err(format!(
            "has '{}' in {} for the derivative of '{}', which is in {}: expected {expected}",
            v.name, v.unit, q.name, q.unit
        ));
    }
    Ok(())
}

/// Coordinates with their velocities: states whose derivative is another state, wherever it is asked for.
fn pairs(fmu: &Fmu) -> Result<Vec<(usize, usize)>, String> {
    /// Points about that of the start.
    const POINTS: usize = 5;
    let d = fmu.description();
    let n = d.states.len();
    let mut points = vec![];
    for k in 0..POINTS {
        // In no relation to each other.
        let off = |i: usize| ((k * n + i) as f64 * 0.754_877_666).fract() * 0.2 * (k.min(1) as f64);
        points.extend(d.parameters.iter().map(|p| p.start));
        let states = d.states.iter().map(|z| z.variable.start).enumerate();
        points.extend(states.map(|(i, start)| start + off(i) * start.abs().max(0.1)));
        points.extend(d.inputs.iter().map(|u| u.start));
        points.push(0.0);
    }
    let width = points.len() / POINTS;
    let mut rates = vec![0.0; POINTS * n];
    let question = Question { wanted: Wanted::Rates, points: &points, along: &[] };
    let said = fmu.evaluate(&question, &mut rates, &mut []);
    if rates[..n].iter().any(|rate| !rate.is_finite()) {
        let because = said.map_or_else(String::new, |said| format!(": {said}"));
        return Err(format!("cannot be evaluated where it starts{because}"));
    }
    let states = |k: usize| &points[k * width + d.parameters.len()..];
    let is = |q: usize, v: usize| {
        let mut rows = rates.chunks_exact(n).enumerate().skip(1);
        rows.all(|(k, rates)| (rates[q] - states(k)[v]).abs() <= 1e-12 * rates[q].abs())
    };
    let mut pairs: Vec<(usize, usize)> = vec![];
    for q in 0..n {
        let free = |k: usize| pairs.iter().all(|&(q, v)| q != k && v != k);
        let found = (0..n).find(|&v| v != q && free(q) && free(v) && is(q, v));
        pairs.extend(found.map(|v| (q, v)));
    }
    Ok(pairs)
}
