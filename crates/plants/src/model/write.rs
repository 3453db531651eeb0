//! A model as text, with calibrated parameters and effects added, everything else as it was.

use super::units::factor;
use super::{Model, ModelEffect, ModelError, Parameter, Source, Uncertainty};
use lacuna_effects::{Effect, Kind, Variable};
use std::path::Path;
use std::sync::Arc;
use toml_edit::{Array, ArrayOfTables, DocumentMut, InlineTable, Item, Table, Value, value};

/// A text as a model file has it, in quotes.
#[must_use]
pub fn quoted(text: &str) -> String {
    Value::from(text).to_string()
}

/// What to change in a model.
#[derive(Clone, Debug, Default)]
pub struct Augmentation {
    /// Calibrated parameters: name, value, standard deviation.
    pub parameters: Vec<(String, f64, f64)>,
    /// Effects to add.
    pub effects: Vec<NewEffect>,
}

/// An effect to write into a model's text.
#[derive(Clone, Debug)]
pub struct NewEffect {
    /// The catalogue's entry.
    pub effect: &'static Effect,
    /// Name of the channel it acts on.
    pub channel: String,
    /// Name of the other channel of a coupling, or of the input that the effect depends on.
    pub other: Option<String>,
    /// Physical values in the catalogue's order ([`Effect::values`]): value, standard deviation,
    /// unit.
    pub parameters: Vec<(f64, Option<f64>, String)>,
}

impl NewEffect {
    /// An effect of a model, to be written into its text.
    #[must_use]
    pub fn of(model: &Model, e: &ModelEffect) -> Self {
        let over = e.over().unwrap_or(Variable::Coordinate);
        let units = model.effect_units_over(e.effect, (e.channel, e.other), over);
        let values = e.parameters.iter().zip(&e.std).zip(units);
        Self {
            effect: e.effect,
            channel: model.effect_channel_name(e.effect, e.channel).to_owned(),
            other: e.other.map(|o| model.effect_other_name(e.effect, o).to_owned()),
            parameters: values.map(|((value, std), unit)| (*value, *std, unit)).collect(),
        }
    }

    /// Name of the variable that a curve is over.
    fn over<'m>(&self, model: &'m Model) -> Option<&'m str> {
        let values: Vec<f64> = self.parameters.iter().map(|p| p.0).collect();
        let channel = (0..model.channels()).find(|&c| model.channel_name(c) == self.channel)?;
        model.variable_name(channel, self.effect.over(&values)?)
    }
}

impl Model {
    /// The model with an augmentation, as text.
    ///
    /// Of a model that was read from a file this is the file's text as it was read, comments and
    /// layout included, with the calibrated values and the new effects in their places. The
    /// equations of any other model are no text: then this is its parameters and its effects, old
    /// and new, with a comment that says so, for [`Model::with_text`].
    ///
    /// # Errors
    /// [`ModelError`] where the text that was read has effects in another form than `[[effect]]`.
    pub fn augmented_text(&self, augmentation: &Augmentation) -> Result<String, ModelError> {
        let Some(source) = &self.source else {
            let mut document = self.without_equations();
            self.augment(&mut document, &self.name, augmentation)?;
            return Ok(format!(
                "# The equations of '{}' are code: here are its parameters and effects.\n{document}",
                self.name
            ));
        };
        let failed = |e: toml_edit::TomlError| ModelError {
            file: source.file.clone(),
            place: None,
            message: e.message().to_owned(),
        };
        let mut document: DocumentMut = source.text.parse().map_err(failed)?;
        if let Some(path) = source.robot.as_ref().and_then(|robot| robot.path.as_ref()) {
            document["robot"]["file"] = value(absolute(path));
        }
        if let Some(path) = &source.fmu {
            document["fmu"]["file"] = value(absolute(path));
        }
        self.augment(&mut document, &source.file, augmentation)?;
        let out = document.to_string();
        debug_assert!(Model::from_text(&out, &source.file).is_ok(), "{out}");
        Ok(out)
    }

    /// Name, parameters and effects.
    fn without_equations(&self) -> DocumentMut {
        let mut document = DocumentMut::new();
        document["name"] = value(&self.name);
        let mut parameters = Table::new();
        for p in &self.parameters {
            parameters[&p.name] = value(as_entry(p));
        }
        document["parameters"] = Item::Table(parameters);
        let mut effects = ArrayOfTables::new();
        for e in &self.effects {
            effects.push(table(&NewEffect::of(self, e), self));
        }
        document["effect"] = Item::ArrayOfTables(effects);
        document
    }

    fn augment(
        &self,
        document: &mut DocumentMut,
        file: &str,
        augmentation: &Augmentation,
    ) -> Result<(), ModelError> {
        for (name, new, std) in &augmentation.parameters {
            if let Some(entry) = of_actuator(document, name) {
                self.calibrate(entry, name, (*new, *std));
                continue;
            }
            self.declare(document, name);
            let elsewhere = document.contains_key("actuator");
            let own = document["parameters"].as_table_like_mut();
            match own.and_then(|table| table.get_mut(name)) {
                Some(entry) => self.calibrate(entry, name, (*new, *std)),
                None if elsewhere => {
                    let message =
                        "actuators must be written as [[actuator]] tables, so that their \
                        parameters can be calibrated"
                            .to_owned();
                    return Err(ModelError { file: file.to_owned(), place: None, message });
                }
                None => {}
            }
        }
        let effects = document.entry("effect").or_insert(Item::ArrayOfTables(ArrayOfTables::new()));
        let Some(list) = effects.as_array_of_tables_mut() else {
            let message = "effects must be written as [[effect]] tables, so that more can be added"
                .to_owned();
            return Err(ModelError { file: file.to_owned(), place: None, message });
        };
        for effect in &augmentation.effects {
            list.push(table(effect, self));
        }
        if list.is_empty() {
            document.remove("effect");
        }
        Ok(())
    }

    /// A parameter that the text leaves to the robot's own file, or to the FMU.
    fn declare(&self, document: &mut DocumentMut, name: &str) {
        let parameter = self.parameters.iter().find(|p| p.name == name);
        let elsewhere = |source: &Arc<Source>| source.robot.is_some() || source.fmu.is_some();
        let elsewhere = self.source.as_ref().is_some_and(elsewhere);
        let parameters = document.entry("parameters").or_insert(Item::Table(Table::new()));
        let (Some(p), Some(table)) = (parameter, parameters.as_table_like_mut()) else { return };
        if elsewhere && !table.contains_key(name) {
            table.insert(name, value(as_entry(p)));
        }
    }

    /// A parameter with its calibrated value, in the unit that its entry states; how sure the model was of it stays
    /// as it was.
    fn calibrate(&self, entry: &mut Item, name: &str, (new, std): (f64, f64)) {
        let own = self.parameters.iter().find(|p| p.name == name);
        let stated = entry.get("unit").and_then(Item::as_str);
        // Of a model that is text the two are the same, to the last bit.
        let stated = own.zip(stated).filter(|(own, stated)| own.unit != *stated);
        let factor = stated.and_then(|(own, stated)| factor(&own.unit, stated)).unwrap_or(1.0);
        entry["value"] = value(factor * new);
        if let Some(table) = entry.as_table_like_mut()
            && new == 0.0
            && table.remove("tolerance").is_some()
        {
            // Relative to 0 it would say nothing.
            table.insert("std", value(factor * own.map_or(0.0, Parameter::std)));
        }
        entry["calibrated_std"] = value(factor.abs() * std);
    }
}

/// The entry of an `[[actuator]]` that is a parameter, `elbow.kp`, unless `[parameters]` has it.
fn of_actuator<'d>(document: &'d mut DocumentMut, name: &str) -> Option<&'d mut Item> {
    let (channel, key) = name.rsplit_once('.')?;
    let parameters = document.get("parameters").and_then(Item::as_table_like);
    if parameters.is_some_and(|table| table.contains_key(name)) {
        return None;
    }
    let mut tables = document.get_mut("actuator")?.as_array_of_tables_mut()?.iter_mut();
    let is_of = |t: &&mut Table| t.get("channel").and_then(Item::as_str) == Some(channel);
    tables.find(is_of)?.get_mut(key)
}

/// A parameter as a model file says it.
fn as_entry(p: &Parameter) -> InlineTable {
    let mut entry = InlineTable::new();
    entry.insert("value", Value::from(p.value));
    entry.insert("unit", Value::from(p.unit.as_str()));
    let (key, size) = match p.uncertainty {
        Uncertainty::Relative(tolerance) => ("tolerance", tolerance),
        Uncertainty::Absolute(std) => ("std", std),
    };
    entry.insert(key, Value::from(size));
    entry
}

/// Where a file is, from anywhere: what is written may stand in another folder.
fn absolute(path: &Path) -> String {
    let path = path.canonicalize().unwrap_or_else(|_| path.to_owned());
    path.to_string_lossy().into_owned()
}

fn table(new: &NewEffect, model: &Model) -> Table {
    let mut table = Table::new();
    table["class"] = value(new.effect.class);
    table["channel"] = value(&new.channel);
    if let Some(other) = &new.other {
        table["other"] = value(other);
    }
    let mut rest = &new.parameters[..];
    for parameter in new.effect.parameters {
        let (own, others) = rest.split_at(parameter.kind.values().min(rest.len()));
        rest = others;
        if let Some(entry) = entry(parameter, own, new.over(model)) {
            table[parameter.name] = entry;
        }
    }
    table
}

/// The values of one parameter; nothing where there are none.
fn entry(
    p: &lacuna_effects::Parameter,
    own: &[(f64, Option<f64>, String)],
    over: Option<&str>,
) -> Option<Item> {
    let (number, std, unit) = own.first()?;
    let mut entry = InlineTable::new();
    match p.kind {
        Kind::Variable => return over.map(value),
        Kind::Number | Kind::Side => {
            entry.insert("value", Value::from(*number));
            if let Some(std) = std {
                entry.insert("std", Value::from(*std));
            }
        }
        Kind::Numbers(_) => {
            entry.insert("values", Value::Array(own.iter().map(|v| v.0).collect::<Array>()));
            if let Some(all) = own.iter().map(|v| v.1).collect::<Option<Array>>() {
                entry.insert("std", Value::Array(all));
            }
        }
    }
    entry.insert("unit", Value::from(unit.as_str()));
    Some(value(entry))
}
