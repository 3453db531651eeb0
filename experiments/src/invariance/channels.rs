//! Coordinates, inputs, states and parameters of the model in another order.

use super::{Agreement, Posed, Subject, Transformation};
use crate::StudyError;
use toml_edit::{Array, Item, Value};

pub(super) struct Channels;

impl Transformation for Channels {
    fn name(&self) -> &'static str {
        "channels"
    }

    fn agreement(&self) -> Agreement {
        Agreement::Same
    }

    fn apply(&self, subject: &Subject) -> Result<Option<Posed>, StudyError> {
        let mut posed = subject.posed.clone();
        for section in ["input", "coordinate", "state"] {
            if let Some(tables) =
                posed.model.get_mut(section).and_then(Item::as_array_of_tables_mut)
            {
                let all: Vec<_> = tables.iter().cloned().collect();
                // Tables are written where they stood, whatever their order here.
                let places: Vec<_> = all.iter().map(toml_edit::Table::position).collect();
                tables.clear();
                for (mut table, place) in all.into_iter().rev().zip(places) {
                    if let Some(place) = place {
                        table.set_position(place);
                    }
                    tables.push(table);
                }
            }
        }
        if let Some(rows) = posed.array("mass") {
            reverse(rows);
            rows.iter_mut().filter_map(Value::as_array_mut).for_each(reverse);
        }
        if let Some(row) = posed.array("force") {
            reverse(row);
        }
        if let Some(table) = posed.model.get_mut("parameters").and_then(Item::as_table_mut) {
            let all: Vec<_> = table.iter().map(|(k, v)| (k.to_owned(), v.clone())).collect();
            table.clear();
            all.into_iter().rev().for_each(|(name, item)| {
                table.insert(&name, item);
            });
        }
        Ok(Some(posed))
    }
}

fn reverse(array: &mut Array) {
    let all: Vec<Value> = array.iter().cloned().collect();
    array.clear();
    all.into_iter().rev().for_each(|v| array.push(v));
}
