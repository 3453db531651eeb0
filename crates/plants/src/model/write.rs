//! A model file with calibrated parameters and effects added, everything else as it was.

use super::{Model, ModelError};
use lacuna_effects::Effect;
use toml_edit::{ArrayOfTables, DocumentMut, InlineTable, Item, Table, Value, value};

/// What to change in a model file.
#[derive(Clone, Debug, Default)]
pub struct Augmentation {
    /// Calibrated parameters: name, value, standard deviation.
    pub parameters: Vec<(String, f64, f64)>,
    /// Effects to add.
    pub effects: Vec<NewEffect>,
}

/// An effect to write into a model file.
#[derive(Clone, Debug)]
pub struct NewEffect {
    /// The catalogue's entry.
    pub effect: &'static Effect,
    /// Name of the channel it acts on.
    pub channel: String,
    /// Name of the other channel of a coupling.
    pub other: Option<String>,
    /// Physical parameters in the catalogue's order: value, standard deviation, unit.
    pub parameters: Vec<(f64, Option<f64>, String)>,
}

/// The text of a model file with an augmentation; comments and layout stay as they are.
///
/// # Errors
/// [`ModelError`] when `text` is no TOML.
pub fn augmented_text(
    text: &str,
    file: &str,
    augmentation: &Augmentation,
) -> Result<String, ModelError> {
    let mut document: DocumentMut = text.parse().map_err(|e: toml_edit::TomlError| ModelError {
        file: file.to_owned(),
        place: None,
        message: e.message().to_owned(),
    })?;
    for (name, new, std) in &augmentation.parameters {
        if let Some(entry) = document["parameters"].get_mut(name) {
            entry["value"] = value(*new);
            entry["std"] = value(*std);
        }
    }
    let effects = document.entry("effect").or_insert(Item::ArrayOfTables(ArrayOfTables::new()));
    let Some(list) = effects.as_array_of_tables_mut() else {
        let message = "effects must be written as [[effect]] tables, so that more can be added";
        return Err(ModelError { file: file.to_owned(), place: None, message: message.to_owned() });
    };
    for effect in &augmentation.effects {
        list.push(table(effect));
    }
    if augmentation.effects.is_empty()
        && document["effect"].as_array_of_tables().is_some_and(ArrayOfTables::is_empty)
    {
        document.remove("effect");
    }
    let out = document.to_string();
    debug_assert!(Model::from_text(&out, file).is_ok(), "{out}");
    Ok(out)
}

fn table(new: &NewEffect) -> Table {
    let mut table = Table::new();
    table["class"] = value(new.effect.class);
    table["channel"] = value(&new.channel);
    if let Some(other) = &new.other {
        table["other"] = value(other);
    }
    for (parameter, (number, std, unit)) in new.effect.parameters.iter().zip(&new.parameters) {
        let mut entry = InlineTable::new();
        entry.insert("value", Value::from(*number));
        if let Some(std) = std {
            entry.insert("std", Value::from(*std));
        }
        entry.insert("unit", Value::from(unit.as_str()));
        table[parameter.name] = value(entry);
    }
    table
}
