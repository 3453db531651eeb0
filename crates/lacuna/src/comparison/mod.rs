//! What `compare` does: two models against the same recordings.

mod pair;
mod results;

pub use pair::{Named, Pair};

use crate::files::write_together;
use crate::report::{self, Comparison};
use crate::simulation::Settings;
use results::Results;
use std::error::Error;
use std::io;
use std::path::Path;

/// The errors of two models, and what is drawn of them.
pub struct Compared {
    results: Results,
    comparison: Comparison,
}

impl Compared {
    /// Compare two models by their runs.
    ///
    /// # Errors
    /// The recording without a channel of the first.
    pub fn of(
        models: &[Named; 2],
        pairs: &[Pair],
        settings: Settings,
    ) -> Result<Self, Box<dyn Error>> {
        pair::same_channels(pairs)?;
        let results = Results::of(models, pairs, settings);
        let comparison = results.comparison(pairs);
        Ok(Self { results, comparison })
    }

    /// What compare.json holds.
    ///
    /// # Errors
    /// None: these are numbers and names.
    pub fn json(&self) -> serde_json::Result<String> {
        serde_json::to_string_pretty(&self.results)
    }

    /// The errors as a table, and who is closer.
    pub fn text(&self) -> String {
        self.results.text(&self.comparison)
    }

    /// The page.
    pub fn page(&self) -> String {
        report::compare_page(&self.comparison)
    }

    /// Write compare.json and compare.html to a folder.
    ///
    /// # Errors
    /// The underlying error, with the path.
    pub fn write(&self, folder: &Path) -> io::Result<()> {
        let (data, html) = (folder.join("compare.json"), folder.join("compare.html"));
        write_together(&[(&data, &self.json()?), (&html, &self.page())])
    }
}

/// The names of the two files; their whole paths where the names are the same.
pub fn labels([a, b]: [&Path; 2]) -> [String; 2] {
    let name = |p: &Path| p.file_name().map(|n| n.to_string_lossy().into_owned());
    match (name(a), name(b)) {
        (Some(a), Some(b)) if a != b => [a, b],
        _ => [a, b].map(|p| p.display().to_string()),
    }
}
