//! The file of a fleet: one model, many machines.
//!
//! ```toml
//! model = "arm.toml"                # paths are relative to this file
//! machines = "data/*/"              # a folder is a machine: its name, its recordings,
//! recordings = "*.csv"              # which of its files, if not all that can be read,
//! held_out = "proof/*.csv"          # and which are for proof alone, if not those in its folder held_out
//! [[machine]]                       # instead or besides: a machine by its name
//! name = "line 7"
//! recordings = ["line7/a.csv", "line7/b.csv#t=0..20", "line7/more/*.csv"]
//! held_out = ["line7/c.csv"]
//! [options]                         # as of `lacuna diagnose`
//! exclude = ["CLASS@CHANNEL"]       # only, exact, learn_remainder, time_budget
//! ```

use super::Settings;
use crate::discrepancy::Selector;
use crate::plants::model::{ModelError, Place};
use crate::recordings::{READERS, RecordingSource};
use serde::Deserialize;
use std::collections::BTreeMap;
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::time::Duration;
use toml::Spanned;

/// Names that results of the whole fleet have in the folder of its machines.
const RESULTS: [&str; 2] = ["fleet.json", "fleet.html"];
/// Where a machine's folder has the recordings for proof alone.
const HELD_OUT: &str = "held_out/*";

/// A machine and its files.
#[derive(Clone, Debug, PartialEq)]
pub struct Machine {
    /// Its name, and that of the folder of its results.
    pub name: String,
    /// Recordings to fit.
    pub recordings: Vec<RecordingSource>,
    /// Recordings for proof alone.
    pub held_out: Vec<RecordingSource>,
    /// Where recordings were looked for, to be told where there are none.
    pub sought: String,
}

/// What the file says.
#[derive(Clone, Debug)]
pub struct Plan {
    /// The model's file.
    pub model: PathBuf,
    /// The machines, by their names.
    pub machines: Vec<Machine>,
    /// How each is diagnosed.
    pub settings: Settings,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct File {
    model: String,
    machines: Option<Spanned<String>>,
    recordings: Option<Spanned<String>>,
    held_out: Option<Spanned<String>>,
    #[serde(default)]
    machine: Vec<RawMachine>,
    #[serde(default)]
    options: RawOptions,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RawMachine {
    name: Spanned<String>,
    recordings: Vec<Spanned<String>>,
    #[serde(default)]
    held_out: Vec<Spanned<String>>,
}

#[derive(Default, Deserialize)]
#[serde(default, deny_unknown_fields)]
struct RawOptions {
    learn_remainder: bool,
    exclude: Vec<Spanned<String>>,
    only: Vec<Spanned<String>>,
    exact: Vec<String>,
    time_budget: Option<Spanned<f64>>,
}

impl Plan {
    /// Read a fleet's file and find the recordings of its machines.
    ///
    /// # Errors
    /// What is wrong with the file, with its line and column.
    pub fn read(path: &Path) -> Result<Self, ModelError> {
        let file = path.display().to_string();
        let text = std::fs::read_to_string(path).map_err(|e| {
            let message = format!("the fleet's file cannot be read: {e}");
            ModelError { file: file.clone(), place: None, message }
        })?;
        let folder = path.parent().unwrap_or(Path::new("")).to_owned();
        Reader { text: &text, file: &file, folder }.plan()
    }
}

struct Reader<'a> {
    text: &'a str,
    file: &'a str,
    folder: PathBuf,
}

impl Reader<'_> {
    fn plan(&self) -> Result<Plan, ModelError> {
        let raw: File = toml::from_str(self.text).map_err(|e| {
            let place = e.span().map(|s| Place::of(self.text, s.start, s.end));
            ModelError {
                file: self.file.to_owned(),
                place,
                message: e.message().replace('\n', " "),
            }
        })?;
        let mut machines = BTreeMap::new();
        for machine in &raw.machine {
            self.add(&mut machines, machine.name.span(), self.machine(machine)?)?;
        }
        match &raw.machines {
            Some(pattern) => {
                for machine in
                    self.folders(pattern, raw.recordings.as_ref(), raw.held_out.as_ref())?
                {
                    self.add(&mut machines, pattern.span(), machine)?;
                }
            }
            None => {
                if let Some(stray) = raw.recordings.as_ref().or(raw.held_out.as_ref()) {
                    let message = "this says which files of the folders of `machines` are meant, and there is no \
                                   `machines`; the recordings of a [[machine]] stand in it";
                    return Err(self.error(stray.span(), message.to_owned()));
                }
            }
        }
        if machines.is_empty() {
            let message = "no machines; expected machines = \"data/*/\" (a folder is a machine) or [[machine]] \
                           with name and recordings";
            return Err(ModelError {
                file: self.file.to_owned(),
                place: None,
                message: message.to_owned(),
            });
        }
        let settings = self.settings(&raw.options)?;
        let machines = machines.into_values().collect();
        Ok(Plan { model: self.folder.join(&raw.model), machines, settings })
    }

    fn error(&self, span: Range<usize>, message: String) -> ModelError {
        let place = Some(Place::of(self.text, span.start, span.end));
        ModelError { file: self.file.to_owned(), place, message }
    }

    /// Add a machine whose name no other has and that can be a folder's.
    fn add(
        &self,
        machines: &mut BTreeMap<String, Machine>,
        span: Range<usize>,
        machine: Machine,
    ) -> Result<(), ModelError> {
        let name = machine.name.clone();
        let bad = |c: char| "/\\:*?\"<>|".contains(c) || c.is_control();
        if name.is_empty()
            || name.starts_with('.')
            || name.contains(bad)
            || RESULTS.contains(&&*name)
        {
            let message = format!(
                "'{name}' cannot be the name of a machine: it is that of the folder of its results, without \
                 / \\ : * ? \" < > | and no dot in front"
            );
            return Err(self.error(span, message));
        }
        match machines.insert(name.clone(), machine) {
            None => Ok(()),
            Some(_) => Err(self.error(span, format!("two machines are called '{name}'"))),
        }
    }

    fn machine(&self, raw: &RawMachine) -> Result<Machine, ModelError> {
        let all = |sources: &[Spanned<String>]| -> Result<Vec<_>, ModelError> {
            let found = sources.iter().map(|s| self.sources(s)).collect::<Result<Vec<_>, _>>()?;
            Ok(found.concat())
        };
        let sought: Vec<&str> = raw.recordings.iter().map(|s| s.get_ref().as_str()).collect();
        Ok(Machine {
            name: raw.name.get_ref().clone(),
            recordings: all(&raw.recordings)?,
            held_out: all(&raw.held_out)?,
            sought: format!("\"{}\" beside {}", sought.join("\", \""), self.file),
        })
    }

    /// A recording, or all that a pattern matches.
    fn sources(&self, said: &Spanned<String>) -> Result<Vec<RecordingSource>, ModelError> {
        let text = said.get_ref();
        if text.contains(['*', '?']) {
            let found = self.matching(&self.folder, text, said.span())?;
            return Ok(found
                .into_iter()
                .filter(|p| p.is_file())
                .map(RecordingSource::file)
                .collect());
        }
        let mut source: RecordingSource =
            text.parse().map_err(|e| self.error(said.span(), format!("{e}")))?;
        source.path = self.folder.join(&source.path);
        Ok(vec![source])
    }

    /// A machine of every folder that matches.
    fn folders(
        &self,
        pattern: &Spanned<String>,
        recordings: Option<&Spanned<String>>,
        held_out: Option<&Spanned<String>>,
    ) -> Result<Vec<Machine>, ModelError> {
        let found = self.matching(&self.folder, pattern.get_ref(), pattern.span())?;
        let machine = |folder: PathBuf| -> Result<Machine, ModelError> {
            let files = |said: Option<&Spanned<String>>, otherwise: &str| {
                let (pattern, span) = said.map_or((otherwise, 0..0), |s| (s.get_ref(), s.span()));
                let found = self.matching(&folder, pattern, span)?;
                let chosen = |p: &PathBuf| p.is_file() && (said.is_some() || is_read(p));
                Ok::<_, ModelError>(found.into_iter().filter(chosen).collect::<Vec<_>>())
            };
            let held_out = files(held_out, HELD_OUT)?;
            let mut recordings = files(recordings, "*")?;
            recordings.retain(|p| !held_out.contains(p));
            let sources =
                |files: Vec<PathBuf>| files.into_iter().map(RecordingSource::file).collect();
            Ok(Machine {
                name: folder.file_name().unwrap_or_default().to_string_lossy().into_owned(),
                recordings: sources(recordings),
                held_out: sources(held_out),
                sought: folder.display().to_string(),
            })
        };
        let machines = found.into_iter().filter(|p| p.is_dir()).map(machine);
        let machines = machines.collect::<Result<Vec<_>, _>>()?;
        match machines.is_empty() {
            true => {
                let message = format!("no folder matches '{}'", pattern.get_ref());
                Err(self.error(pattern.span(), message))
            }
            false => Ok(machines),
        }
    }

    /// What matches a pattern in a folder, sorted.
    fn matching(
        &self,
        folder: &Path,
        pattern: &str,
        span: Range<usize>,
    ) -> Result<Vec<PathBuf>, ModelError> {
        let whole = match Path::new(pattern).is_absolute() || folder.as_os_str().is_empty() {
            true => pattern.to_owned(),
            false => format!("{}/{pattern}", glob::Pattern::escape(&folder.to_string_lossy())),
        };
        let options =
            glob::MatchOptions { require_literal_leading_dot: true, ..Default::default() };
        let found = glob::glob_with(&whole, options).map_err(|e| {
            self.error(span.clone(), format!("'{pattern}' is no pattern: {}", e.msg))
        })?;
        found.map(|path| path.map_err(|e| self.error(span.clone(), format!("{e}")))).collect()
    }

    fn settings(&self, raw: &RawOptions) -> Result<Settings, ModelError> {
        let selectors = |texts: &[Spanned<String>]| -> Result<Vec<Selector>, ModelError> {
            let one = |t: &Spanned<String>| {
                t.get_ref().parse().map_err(|e| self.error(t.span(), format!("{e}")))
            };
            texts.iter().map(one).collect()
        };
        let budget = |seconds: &Spanned<f64>| {
            let positive = Some(*seconds.get_ref()).filter(|s| *s > 0.0);
            let budget = positive.and_then(|s| Duration::try_from_secs_f64(s).ok());
            let message = "time_budget: expected a positive number of seconds".to_owned();
            budget.ok_or_else(|| self.error(seconds.span(), message))
        };
        Ok(Settings {
            learn_remainder: raw.learn_remainder,
            only: selectors(&raw.only)?,
            exclude: selectors(&raw.exclude)?,
            exact: raw.exact.clone(),
            time_budget: raw.time_budget.as_ref().map(budget).transpose()?,
        })
    }
}

/// Whether a reader of recordings knows such files by the end of their names.
fn is_read(path: &Path) -> bool {
    let extension = path.extension().map(|e| e.to_string_lossy().to_lowercase());
    extension.is_some_and(|e| READERS.iter().any(|r| r.extensions().contains(&&*e)))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A folder with a fleet's file and empty files beside it.
    fn plan(text: &str, files: &[&str]) -> (tempfile::TempDir, Result<Plan, ModelError>) {
        let folder = tempfile::tempdir().unwrap();
        for file in files {
            let path = folder.path().join(file);
            std::fs::create_dir_all(path.parent().unwrap()).unwrap();
            std::fs::write(path, "").unwrap();
        }
        let path = folder.path().join("fleet.toml");
        std::fs::write(&path, text).unwrap();
        let plan = Plan::read(&path);
        (folder, plan)
    }

    fn names(sources: &[RecordingSource]) -> Vec<String> {
        sources.iter().map(RecordingSource::name).collect()
    }

    #[test]
    fn a_folder_is_a_machine() {
        let files = [
            "d/b/2.csv",
            "d/b/1.csv",
            "d/b/notes.md",
            "d/b/held_out/p.csv",
            "d/a/x.csv",
            "d/.c/x.csv",
        ];
        let (folder, plan) = plan("model = \"m.toml\"\nmachines = \"d/*/\"\n", &files);
        let plan = plan.unwrap();
        assert_eq!(plan.model, folder.path().join("m.toml"));
        let called: Vec<&str> = plan.machines.iter().map(|m| &*m.name).collect();
        assert_eq!(called, ["a", "b"]);
        assert_eq!(names(&plan.machines[1].recordings), ["1.csv", "2.csv"]);
        assert_eq!(names(&plan.machines[1].held_out), ["p.csv"]);
    }

    #[test]
    fn patterns_choose_files_and_machines_have_names_of_their_own() {
        let text = "model = \"m.toml\"\nmachines = \"d/*\"\nrecordings = \"*.csv\"\nheld_out = \"2*\"\n\
                    [[machine]]\nname = \"z\"\nrecordings = [\"z.csv#rows=1..5\", \"d/a/*\"]\n\
                    [options]\nonly = [\"dead_zone\"]\ntime_budget = 2\n";
        let (_folder, plan) = plan(text, &["d/a/1.csv", "d/a/2.csv", "z.csv"]);
        let plan = plan.unwrap();
        assert_eq!(names(&plan.machines[0].recordings), ["1.csv"]);
        assert_eq!(names(&plan.machines[0].held_out), ["2.csv"]);
        assert_eq!(names(&plan.machines[1].recordings), ["z.csv#rows=1..5", "1.csv", "2.csv"]);
        assert_eq!(plan.settings.only[0].class, "dead_zone");
        assert_eq!(plan.settings.time_budget, Some(Duration::from_secs(2)));
    }

    #[test]
    fn mistakes_are_told_with_their_place() {
        let machine = "[[machine]]\nname = \"a\"\nrecordings = []\n";
        for (text, place, says) in [
            ("model = \"m.toml\"\n".to_owned(), None, "no machines"),
            ("model = \"m\"\nmachines = \"d/*/\"\n".into(), Some(2), "no folder matches 'd/*/'"),
            (format!("model = \"m\"\n{machine}{machine}"), Some(6), "two machines are called 'a'"),
            (format!("model = \"m\"\nrecordings = \"*\"\n{machine}"), Some(2), "no `machines`"),
            (
                format!("model = \"m\"\n{}", machine.replace("\"a\"", "\"../a\"")),
                Some(3),
                "folder of its results",
            ),
            (
                format!("model = \"m\"\n{machine}[options]\nonly = [\"\"]\n"),
                Some(6),
                "expected CLASS",
            ),
            (format!("model = \"m\"\n{machine}[options]\ntime_budget = -1\n"), Some(6), "positive"),
            (format!("model = \"m\"\nmachin = 1\n{machine}"), Some(2), "unknown field `machin`"),
        ] {
            let error = plan(&text, &[]).1.unwrap_err();
            assert_eq!(error.place.as_ref().map(|p| p.line), place, "{text}: {error}");
            assert!(error.message.contains(says), "{error}");
        }
    }
}
