//! The study: draw, write, diagnose, unseal, score.

use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::time::Duration;
use tempfile::TempDir;

use super::case::{Case, Plan, plans};
use super::files::Folders;
use super::print;
use super::reliability::{Reliability, claims};
use super::row::{Row, judge};
use super::sealed::Group;
use super::summary::{Summary, confusion};
use super::tool::Tool;
use crate::StudyError;
use crate::cli::Common;
use crate::{figures, output, progress};

/// Name of the study, and of the directory of its results.
pub const NAME: &str = "concealed-physics";

/// What to do.
#[derive(Clone, Debug)]
pub struct Settings {
    /// Number of cases of each seed.
    pub cases: usize,
    /// Seeds that the cases are drawn from.
    pub seeds: Vec<u64>,
    /// One family; none: all.
    pub group: Option<Group>,
    /// Cases at once.
    pub jobs: usize,
    /// The `lacuna` command; none: beside the running executable.
    pub lacuna: Option<PathBuf>,
    /// Longest that one diagnosis may take (s).
    pub timeout: u64,
    /// Keep the cases' files here.
    pub keep: Option<PathBuf>,
}

/// What the study found.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
pub struct Results {
    /// [`NAME`].
    pub experiment: String,
    /// The command that produced this file.
    pub command: String,
    /// Version of the tool under test.
    pub tool: String,
    /// Seeds of all draws.
    pub seeds: Vec<u64>,
    /// Number of cases, of all seeds.
    pub cases: usize,
    /// Figures by family, and of all.
    pub groups: BTreeMap<String, Summary>,
    /// Findings by claimed probability.
    pub reliability: Reliability,
    /// True class, then found class, then how often.
    pub confusion: BTreeMap<String, BTreeMap<String, usize>>,
    /// Every case.
    pub rows: Vec<Row>,
}

/// Carry out the study, write its results and print them.
///
/// # Errors
/// [`StudyError`] when the tool is not there, a case cannot be drawn, or files cannot be written.
pub fn run(settings: &Settings, common: &Common) -> Result<(), StudyError> {
    let results = diagnosed(settings, common)?;
    let directory = common.out.join(NAME);
    let file = output::write_json(&directory, "statistics", &results)?;
    let svg = figures::concealed::confusion(&results.confusion);
    output::write_figure(&directory, "confusion", &svg)?;
    let svg = figures::concealed::reliability(&results.reliability)?;
    output::write_figure(&directory, "reliability", &svg)?;
    if !common.quiet {
        print::results(&results);
        println!("wrote {}", file.display());
    }
    Ok(())
}

/// Draw the cases, diagnose and score them.
///
/// # Errors
/// As [`run`].
pub fn diagnosed(settings: &Settings, common: &Common) -> Result<Results, StudyError> {
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    let timeout = Duration::from_secs(settings.timeout);
    let threads = (cores / settings.jobs).max(1);
    let tool = Tool::find(settings.lacuna.as_deref(), timeout, threads)?;
    let work = Work::new(settings.keep.as_deref())?;
    let rows = rows(settings, common, &tool, &work)?;
    Ok(Results {
        experiment: NAME.to_owned(),
        command: command(settings),
        tool: tool.version()?,
        seeds: settings.seeds.clone(),
        cases: rows.len(),
        groups: groups(&rows),
        reliability: Reliability::of(&claims(&rows)),
        confusion: confusion(&rows),
        rows,
    })
}

/// Where the cases' files are: two directories that know nothing of each other, unless they are kept.
struct Work {
    open: PathBuf,
    sealed: PathBuf,
    _temporary: Vec<TempDir>,
}

impl Work {
    fn new(keep: Option<&Path>) -> Result<Self, StudyError> {
        if let Some(keep) = keep {
            let (open, sealed) = (keep.join("cases"), keep.join("sealed"));
            return Ok(Self { open, sealed, _temporary: Vec::new() });
        }
        let temporary = || {
            tempfile::tempdir()
                .map_err(|source| StudyError::Write { path: std::env::temp_dir(), source })
        };
        let (open, sealed) = (temporary()?, temporary()?);
        Ok(Self {
            open: open.path().to_path_buf(),
            sealed: sealed.path().to_path_buf(),
            _temporary: vec![open, sealed],
        })
    }
}

fn rows(
    settings: &Settings,
    common: &Common,
    tool: &Tool,
    work: &Work,
) -> Result<Vec<Row>, StudyError> {
    let of = |&seed: &u64| {
        plans(seed, settings.cases, settings.group).into_iter().map(move |plan| (seed, plan))
    };
    let plans: Vec<(u64, Plan)> = settings.seeds.iter().flat_map(of).collect();
    let bar = progress::bar(plans.len(), "cases", common.quiet);
    let one = |(seed, plan): &(u64, Plan)| {
        let folders = Folders::of(&work.open, &work.sealed, &plan.id);
        folders.write(&Case::draw(*seed, plan)?)?;
        let row = judge(tool, &folders)?;
        if !common.quiet {
            bar.suspend(|| print::row(&row));
        }
        bar.inc(1);
        Ok(row)
    };
    let pool = rayon::ThreadPoolBuilder::new().num_threads(settings.jobs).build()?;
    let rows = pool.install(|| plans.par_iter().map(one).collect());
    bar.finish_and_clear();
    rows
}

fn groups(rows: &[Row]) -> BTreeMap<String, Summary> {
    let mut groups = BTreeMap::new();
    for group in Group::ALL {
        let of: Vec<&Row> = rows.iter().filter(|r| r.group == group).collect();
        if !of.is_empty() {
            groups.insert(group.name().to_owned(), Summary::of(&of));
        }
    }
    groups.insert("all".to_owned(), Summary::of(&rows.iter().collect::<Vec<_>>()));
    groups
}

fn command(settings: &Settings) -> String {
    let group = settings.group.map_or("all", Group::name);
    let seeds: Vec<String> = settings.seeds.iter().map(u64::to_string).collect();
    format!(
        "cargo run --release -p experiments -- {NAME} --cases {} --seeds {} --group {group}",
        settings.cases,
        seeds.join(",")
    )
}
