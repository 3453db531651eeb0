//! A model and recordings as files, in a form that can be changed.

use lacuna_recordings::{Column, Recording, write_csv_with_time};
use std::collections::BTreeMap;
use std::ffi::OsString;
use std::fs;
use std::path::Path;
use toml_edit::{Array, ArrayOfTables, DocumentMut, Item, Table, Value, value};

use super::Answer;
use crate::StudyError;
use crate::concealed::ConcealedError;
use crate::concealed::case::Case;
use crate::concealed::tool::Tool;

/// Sections of tables that hold channels.
const CHANNELS: [&str; 3] = ["input", "coordinate", "state"];

/// A model and recordings.
#[derive(Clone, Debug)]
pub struct Posed {
    /// The model file.
    pub model: DocumentMut,
    /// The recordings, in the order in which they are given.
    pub recordings: Vec<Recording>,
    /// Column of time.
    pub time_column: String,
    /// What the names in the diagnosis stand for.
    pub names: BTreeMap<String, String>,
    /// What the command finds in its environment.
    pub environment: Vec<(&'static str, &'static str)>,
}

impl Posed {
    /// A case as it is.
    ///
    /// # Errors
    /// A model file that is none.
    pub fn of(case: &Case) -> Result<Self, StudyError> {
        let wrong = |e: toml_edit::TomlError| ConcealedError::Plant { reason: e.to_string() };
        let mut recordings = case.recordings.clone();
        for (k, recording) in recordings.iter_mut().enumerate() {
            recording.name = format!("run{k:02}.csv");
        }
        Ok(Self {
            model: case.files.model.parse().map_err(wrong)?,
            recordings,
            time_column: case.time_column.clone(),
            names: BTreeMap::new(),
            environment: vec![],
        })
    }

    /// What the command says of it, or complains of, and how long it took (s).
    ///
    /// # Errors
    /// [`StudyError`] where files cannot be written or the command cannot be started.
    pub fn diagnosed(
        &self,
        tool: &Tool,
        folder: &Path,
    ) -> Result<(Result<Answer, String>, f64), StudyError> {
        let failed = |path: &Path| {
            let path = path.to_owned();
            |source| StudyError::Write { path, source }
        };
        fs::create_dir_all(folder).map_err(failed(folder))?;
        let model = folder.join("model.toml");
        fs::write(&model, self.model.to_string()).map_err(failed(&model))?;
        for recording in &self.recordings {
            let path = folder.join(&recording.name);
            write_csv_with_time(&path, recording, &self.time_column)
                .map_err(ConcealedError::from)?;
        }
        let mut arguments: Vec<OsString> = vec!["diagnose".into(), "model.toml".into()];
        arguments.extend(self.recordings.iter().map(|r| OsString::from(&r.name)));
        arguments.push("--json".into());
        let tool = self.environment.iter().fold(tool.clone(), |t, (name, v)| t.with(name, v));
        let answer = tool.run(folder, &arguments)?;
        let said = folder.join("diagnosis.json");
        fs::write(&said, &answer.stdout).map_err(failed(&said))?;
        let outcome = match answer.code {
            Some(0) => Answer::read(&answer.stdout, &self.names).map_err(|e| e.to_string()),
            None => Err("no answer in time".to_owned()),
            Some(_) => Err(answer.complaint),
        };
        Ok((outcome, answer.seconds))
    }

    /// The tables of a section.
    pub fn tables(&mut self, section: &str) -> impl Iterator<Item = &mut Table> {
        let tables = self.model.get_mut(section).and_then(Item::as_array_of_tables_mut);
        tables.into_iter().flat_map(ArrayOfTables::iter_mut)
    }

    /// The values of parameters.
    pub fn parameters(&self) -> Vec<String> {
        let table = self.model.get("parameters").and_then(Item::as_table_like);
        table.into_iter().flat_map(|t| t.iter().map(|(name, _)| name.to_owned())).collect()
    }

    /// Names of channels by section, velocities with their coordinates.
    pub fn channels(&self) -> Vec<Channel> {
        let of = |section: &'static str| {
            let tables = self.model.get(section).and_then(Item::as_array_of_tables);
            tables.into_iter().flatten().map(move |table| {
                let text = |key: &str| table.get(key).and_then(Item::as_str).map(str::to_owned);
                Channel {
                    section,
                    name: text("name").unwrap_or_default(),
                    velocity: text("velocity"),
                    unit: text("unit").unwrap_or_default(),
                }
            })
        };
        CHANNELS.into_iter().flat_map(of).collect()
    }

    /// Change every expression of the model.
    pub fn expressions(&mut self, change: impl Fn(&str) -> String) {
        if let Some(mechanics) = self.model.get_mut("mechanics").and_then(Item::as_table_mut) {
            for (_, item) in mechanics.iter_mut() {
                if let Some(array) = item.as_array_mut() {
                    each(array, &change);
                }
            }
        }
        for table in self.tables("state") {
            if let Some(text) = table.get("derivative").and_then(Item::as_str) {
                table["derivative"] = value(change(text));
            }
        }
    }

    /// Put expressions in the place of names.
    pub fn substitute(&mut self, places: &BTreeMap<String, String>) {
        self.expressions(|text| substituted(text, places));
    }

    /// Count channels in other units: what was `q` is `factor q` now. Forces stay in their unit, along the
    /// coordinate.
    pub fn rescale(&mut self, factors: &BTreeMap<String, f64>) {
        let factor = |name: &str| factors.get(name).copied().unwrap_or(1.0);
        let channels = self.channels();
        let mut places = BTreeMap::new();
        for c in channels.iter().filter(|c| factor(&c.name) != 1.0) {
            for name in std::iter::once(&c.name).chain(&c.velocity) {
                places.insert(name.clone(), format!("({name}/({:?}))", factor(&c.name)));
            }
        }
        self.substitute(&places);
        let coordinates: Vec<f64> = channels
            .iter()
            .filter(|c| c.section == "coordinate")
            .map(|c| factor(&c.name))
            .collect();
        if let Some(rows) = self.array("mass") {
            for (i, row) in rows.iter_mut().filter_map(Value::as_array_mut).enumerate() {
                let sign = coordinates[i].signum();
                for (j, factor) in coordinates.iter().enumerate() {
                    scale(row, j, sign / factor);
                }
            }
        }
        if let Some(row) = self.array("force") {
            coordinates.iter().enumerate().for_each(|(i, f)| scale(row, i, f.signum()));
        }
        for table in self.tables("state") {
            let name = table.get("name").and_then(Item::as_str).unwrap_or_default();
            let factor = factor(name);
            if let Some(text) =
                table.get("derivative").and_then(Item::as_str).filter(|_| factor != 1.0)
            {
                table["derivative"] = value(format!("({factor:?})*({text})"));
            }
        }
        for c in &channels {
            for name in std::iter::once(&c.name).chain(&c.velocity) {
                let columns = self.recordings.iter_mut().flat_map(|r| &mut r.columns);
                for column in columns.filter(|column| column.name == *name) {
                    column.values.iter_mut().for_each(|y| *y *= factor(&c.name));
                }
            }
        }
    }

    /// Say the units of channels.
    pub fn say_units(&mut self, units: &BTreeMap<String, String>) {
        for section in CHANNELS {
            for table in self.tables(section) {
                let name = table.get("name").and_then(Item::as_str).unwrap_or_default();
                if let Some(unit) = units.get(name) {
                    table["unit"] = value(unit);
                }
            }
        }
    }

    /// An array of the mechanics.
    pub fn array(&mut self, name: &str) -> Option<&mut Array> {
        self.model.get_mut("mechanics")?.get_mut(name)?.as_array_mut()
    }

    /// Columns of all recordings.
    pub fn columns(&mut self) -> impl Iterator<Item = &mut Column> {
        self.recordings.iter_mut().flat_map(|r| &mut r.columns)
    }
}

/// A channel of a model file.
#[derive(Clone, Debug)]
pub struct Channel {
    /// Its section.
    pub section: &'static str,
    /// Its name.
    pub name: String,
    /// Its velocity's name.
    pub velocity: Option<String>,
    /// Its unit.
    pub unit: String,
}

fn each(array: &mut Array, change: &impl Fn(&str) -> String) {
    for entry in array.iter_mut() {
        match entry {
            Value::Array(row) => each(row, change),
            Value::String(text) => *entry = change(text.value()).into(),
            _ => {}
        }
    }
}

fn scale(row: &mut Array, k: usize, factor: f64) {
    let text = row.get(k).and_then(Value::as_str).map(str::to_owned);
    if let Some(text) = text.filter(|_| factor != 1.0) {
        row.replace(k, format!("({factor:?})*({text})"));
    }
}

/// An expression with others in the place of names.
pub fn substituted(text: &str, places: &BTreeMap<String, String>) -> String {
    let part_of_name = |c: char| c.is_ascii_alphanumeric() || c == '_';
    let mut out = String::new();
    let mut rest = text;
    while let Some(first) = rest.chars().next() {
        // A number's exponent is no name.
        let end = match part_of_name(first) || first == '.' {
            true => rest.find(|c: char| !(part_of_name(c) || c == '.')).unwrap_or(rest.len()),
            false => first.len_utf8(),
        };
        let (word, behind) = rest.split_at(end);
        out += places.get(word).map_or(word, String::as_str);
        rest = behind;
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn whole_names_are_replaced() {
        let places = [("q", "(q/2)"), ("e", "E")].map(|(a, b)| (a.to_owned(), b.to_owned()));
        let said = substituted("dq + q*sin(q2) - 1e-3*q/1.5e2 + e", &places.into());
        assert_eq!(said, "dq + (q/2)*sin(q2) - 1e-3*(q/2)/1.5e2 + E");
    }
}
