//! Other names for channels, parameters and files, in another alphabetical order.

use super::{Agreement, Posed, Subject, Transformation};
use crate::StudyError;
use std::collections::BTreeMap;
use toml_edit::{Item, Table, value};

pub(super) struct Names;

impl Transformation for Names {
    fn name(&self) -> &'static str {
        "names"
    }

    fn agreement(&self) -> Agreement {
        Agreement::Identical
    }

    fn apply(&self, subject: &Subject) -> Result<Option<Posed>, StudyError> {
        let mut posed = subject.posed.clone();
        let channels = posed.channels().into_iter();
        let mut all: Vec<String> =
            channels.flat_map(|c| std::iter::once(c.name).chain(c.velocity)).collect();
        all.extend(posed.parameters());
        all.sort();
        // The last comes first now. No other word of a diagnosis holds such a name.
        let new = |(k, old): (usize, String)| {
            let name = format!("zz{:02}zz{old}", 99 - k);
            (old, name)
        };
        let names: BTreeMap<String, String> = all.into_iter().enumerate().map(new).collect();
        posed.substitute(&names);
        for section in ["input", "coordinate", "state"] {
            for table in posed.tables(section) {
                rename(table, &names);
            }
        }
        if let Some(table) = posed.model.get_mut("parameters").and_then(Item::as_table_mut) {
            let renamed: Vec<(String, Item)> =
                table.iter().map(|(k, v)| (names[k].clone(), v.clone())).collect();
            table.clear();
            renamed.into_iter().for_each(|(name, item)| {
                table.insert(&name, item);
            });
        }
        posed.columns().for_each(|c| c.name = names[&c.name].clone());
        let count = posed.recordings.len();
        for (k, recording) in posed.recordings.iter_mut().enumerate() {
            recording.name = format!("log{}.csv", count - k);
        }
        posed.names = names.into_iter().map(|(old, new)| (new, old)).collect();
        Ok(Some(posed))
    }
}

fn rename(table: &mut Table, names: &BTreeMap<String, String>) {
    for key in ["name", "velocity"] {
        if let Some(name) = table.get(key).and_then(Item::as_str) {
            table[key] = value(&names[name]);
        }
    }
}
