//! Columns in other units than the model's channels.

use super::units::other;
use super::{Agreement, Posed, Subject, Transformation};
use crate::StudyError;
use toml_edit::{ArrayOfTables, Item, Table, value};

pub(super) struct Columns;

impl Transformation for Columns {
    fn name(&self) -> &'static str {
        "columns"
    }

    fn agreement(&self) -> Agreement {
        Agreement::Same
    }

    fn apply(&self, subject: &Subject) -> Result<Option<Posed>, StudyError> {
        let mut posed = subject.posed.clone();
        let mut measurements = ArrayOfTables::new();
        for channel in posed.channels() {
            let Some((unit, factor)) = other(&channel.unit) else { continue };
            let rate = channel.velocity.map(|name| (name, format!("{unit}/s")));
            for (name, unit) in std::iter::once((channel.name, unit.to_owned())).chain(rate) {
                let mut there = false;
                for column in posed.columns().filter(|c| c.name == name) {
                    there = true;
                    column.values.iter_mut().for_each(|y| *y *= factor);
                }
                if there {
                    let mut table = Table::new();
                    table["column"] = value(&name);
                    table["of"] = value(&name);
                    table["unit"] = value(unit);
                    measurements.push(table);
                }
            }
        }
        let any = !measurements.is_empty();
        posed.model.insert("measurement", Item::ArrayOfTables(measurements));
        Ok(any.then_some(posed))
    }
}
