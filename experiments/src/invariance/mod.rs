//! Invariance: what says nothing of a machine changes nothing of its diagnosis.
//!
//! ```text
//! diagnosis(T(model, recordings)) = T(diagnosis(model, recordings))
//! ```
//!
//! Cases are drawn as for [`crate::concealed`]. Each is diagnosed as it is and under every transformation T of
//! [`TRANSFORMATIONS`], one file each. Where T changes nothing but order, names or threads, every number of
//! `diagnosis.json` must be the same to the last bit; else verdict and names must be the same and probabilities within
//! [`WITHIN`]. Results are written after each diagnosis, and a rerun does what is not there.

mod answer;
mod channels;
mod columns;
mod mirror;
mod names;
mod noise;
mod order;
mod parameter;
mod posed;
mod rest;
mod scale;
mod split;
mod threads;
mod times;
mod twice;
mod units;
mod vectors;

pub use answer::{Answer, Finding, WITHIN};
pub use posed::Posed;

use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::path::PathBuf;
use std::time::Duration;

use crate::cli::Common;
use crate::concealed::case::{Case, Plan, plans};
use crate::concealed::tool::Tool;
use crate::{StudyError, output, progress};

/// Name of the study and of its results.
pub const NAME: &str = "invariance";
/// Stands for no transformation.
const AS_IT_IS: &str = "as it is";

/// How far two diagnoses must agree.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Agreement {
    /// Every number, to the last bit.
    Identical,
    /// Verdict and names; probabilities within [`WITHIN`].
    Same,
}

/// A case that is to be transformed.
#[derive(Debug)]
pub struct Subject<'a> {
    /// Seed of the study.
    pub seed: u64,
    /// What the case is about.
    pub plan: &'a Plan,
    /// The case.
    pub case: &'a Case,
    /// Its model and recordings.
    pub posed: Posed,
}

/// A change that says nothing of the machine.
pub trait Transformation: Sync {
    /// What it does, in a word or two.
    fn name(&self) -> &'static str;

    /// How far the diagnoses must agree.
    fn agreement(&self) -> Agreement;

    /// The same case told otherwise; none where it cannot be.
    ///
    /// # Errors
    /// [`StudyError`] where the case cannot be drawn anew.
    fn apply(&self, subject: &Subject) -> Result<Option<Posed>, StudyError>;
}

/// All transformations.
pub static TRANSFORMATIONS: &[&dyn Transformation] = &[
    &order::Order,
    &names::Names,
    &twice::Twice,
    &split::Split,
    &threads::Threads,
    &vectors::Vectors,
    &columns::Columns,
    &units::Units,
    &times::Times,
    &channels::Channels,
    &parameter::Parameter,
    &mirror::Mirror,
    &scale::Scale(1e-6),
    &scale::Scale(1e6),
    &noise::Noise,
    &rest::Rest,
];

/// What is drawn, and who is asked.
#[derive(Clone, Debug)]
pub struct Settings {
    /// Cases.
    pub cases: usize,
    /// Transformations by name; none: all.
    pub only: Vec<String>,
    /// Longest that a diagnosis may take (s).
    pub timeout: u64,
    /// Keep the files of all diagnoses in this directory.
    pub keep: Option<PathBuf>,
    /// The command under test; by default the one beside this executable.
    pub lacuna: Option<PathBuf>,
}

/// One diagnosis.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
pub struct Row {
    /// Case.
    pub case: String,
    /// Plant.
    pub plant: String,
    /// Topic.
    pub topic: String,
    /// The transformation.
    pub transformation: String,
    /// The diagnosis; none where there is none.
    pub answer: Option<Answer>,
    /// What went wrong, where there is none.
    pub crash: Option<String>,
    /// Wall time (s).
    pub seconds: f64,
}

/// What became of a transformation over the cases.
#[derive(Clone, Copy, Debug, Default, Deserialize, PartialEq, Serialize)]
pub struct Count {
    /// Cases.
    pub cases: usize,
    /// Those with the same verdict and names.
    pub same: usize,
    /// Those with probabilities within [`WITHIN`], too.
    pub probable: usize,
    /// Those with the same numbers, to the last bit.
    pub identical: usize,
}

/// What the study found.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
pub struct Results {
    /// [`NAME`].
    pub experiment: String,
    /// The command that produced this file.
    pub command: String,
    /// Seed of all draws.
    pub seed: u64,
    /// Number of cases.
    pub cases: usize,
    /// By transformation.
    pub counts: BTreeMap<String, Count>,
    /// Every diagnosis.
    pub rows: Vec<Row>,
}

/// Carry out the study, write its results and print them.
///
/// # Errors
/// [`StudyError`] when the command is not there, a case cannot be drawn, or files cannot be written.
pub fn run(settings: &Settings, common: &Common) -> Result<(), StudyError> {
    let mut results = Results::begun(settings, common);
    let tool = Tool::find(settings.lacuna.as_deref(), Duration::from_secs(settings.timeout), 1)?;
    let chosen: Vec<&dyn Transformation> = TRANSFORMATIONS
        .iter()
        .copied()
        .filter(|t| settings.only.is_empty() || settings.only.iter().any(|o| o == t.name()))
        .collect();
    let bar = progress::bar(settings.cases * (chosen.len() + 1), "diagnoses", common.quiet);
    for plan in plans(common.seed, settings.cases, None) {
        let case = Case::draw(common.seed, &plan)?;
        let posed = Posed::of(&case)?;
        let subject = Subject { seed: common.seed, plan: &plan, case: &case, posed };
        let place = (settings, common);
        results.ask(&tool, &subject, AS_IT_IS, || Ok(Some(subject.posed.clone())), place)?;
        bar.inc(1);
        // A case without a diagnosis in time says nothing of transformations.
        let answered =
            results.rows.iter().any(|r| r.case == case.sealed.case && r.answer.is_some());
        if !answered {
            continue;
        }
        for t in &chosen {
            results.ask(&tool, &subject, t.name(), || t.apply(&subject), place)?;
            bar.inc(1);
        }
    }
    bar.finish_and_clear();
    if !common.quiet {
        results.print();
    }
    Ok(())
}

impl Results {
    /// What is there of an earlier run of the same cases.
    fn begun(settings: &Settings, common: &Common) -> Self {
        let fresh = Self {
            experiment: NAME.to_owned(),
            command: format!(
                "cargo run --release -p experiments -- {NAME} --cases {} --seed {}",
                settings.cases, common.seed
            ),
            seed: common.seed,
            cases: settings.cases,
            counts: BTreeMap::new(),
            rows: vec![],
        };
        let path = common.out.join(NAME).with_extension("json");
        match output::read_json::<Self>(&path) {
            Ok(earlier) if (earlier.seed, earlier.cases) == (fresh.seed, fresh.cases) => {
                Self { rows: earlier.rows, ..fresh }
            }
            _ => fresh,
        }
    }

    /// Have a case diagnosed under a transformation, unless that was done.
    fn ask(
        &mut self,
        tool: &Tool,
        subject: &Subject,
        transformation: &str,
        pose: impl Fn() -> Result<Option<Posed>, StudyError>,
        (settings, common): (&Settings, &Common),
    ) -> Result<(), StudyError> {
        let case = &subject.case.sealed;
        let done =
            self.rows.iter().any(|r| r.case == case.case && r.transformation == transformation);
        if done {
            return Ok(());
        }
        let Some(posed) = pose()? else { return Ok(()) };
        let failed = |source| StudyError::Write { path: std::env::temp_dir(), source };
        let temporary = tempfile::tempdir().map_err(failed)?;
        let folder = settings.keep.as_ref().map(|keep| keep.join(&case.case).join(transformation));
        let folder = folder.unwrap_or_else(|| temporary.path().to_owned());
        let (outcome, seconds) = posed.diagnosed(tool, &folder)?;
        let (answer, crash) = match outcome {
            Ok(answer) => (Some(answer), None),
            Err(complaint) => (None, Some(complaint)),
        };
        self.rows.push(Row {
            case: case.case.clone(),
            plant: case.plant.clone(),
            topic: case.topic.clone(),
            transformation: transformation.to_owned(),
            answer,
            crash,
            seconds,
        });
        self.count();
        output::write_json(&common.out, NAME, self)?;
        Ok(())
    }

    /// Every diagnosis of a transformed case with that of the case as it is.
    fn pairs(&self) -> impl Iterator<Item = (&Row, &Row)> {
        let plain = |row: &Row| {
            self.rows.iter().find(|r| r.case == row.case && r.transformation == AS_IT_IS)
        };
        let transformed = self.rows.iter().filter(|r| r.transformation != AS_IT_IS);
        transformed.filter_map(move |row| Some((plain(row)?, row)))
    }

    fn count(&mut self) {
        let mut counts: BTreeMap<String, Count> = BTreeMap::new();
        for (plain, row) in self.pairs() {
            let count = counts.entry(row.transformation.clone()).or_default();
            let compared = plain.answer.as_ref().zip(row.answer.as_ref());
            let is = |how: fn(&Answer, &Answer) -> bool| {
                usize::from(compared.is_some_and(|(a, b)| how(a, b)))
            };
            // Without an answer to either there is nothing that could differ.
            let silent = usize::from(plain.answer.is_none() && row.answer.is_none());
            count.cases += 1;
            count.same += is(Answer::is_same) + silent;
            count.probable += is(Answer::is_as_probable) + silent;
            count.identical += is(Answer::is_identical) + silent;
        }
        self.counts = counts;
    }

    /// Diagnoses that do not agree as far as they must.
    pub fn defects(&self) -> Vec<(&Row, &Row)> {
        let must = |row: &Row| {
            let of = TRANSFORMATIONS.iter().find(|t| t.name() == row.transformation);
            of.map_or(Agreement::Same, |t| t.agreement())
        };
        let agree = |plain: &Row, row: &Row| match (&plain.answer, &row.answer, must(row)) {
            (Some(a), Some(b), Agreement::Identical) => a.is_identical(b),
            (Some(a), Some(b), Agreement::Same) => a.is_as_probable(b),
            (None, None, _) => true,
            _ => false,
        };
        self.pairs().filter(|(plain, row)| !agree(plain, row)).collect()
    }

    fn print(&self) {
        println!("{:14} {:>6} {:>6} {:>9} {:>10}", "", "cases", "same", "probable", "identical");
        for (name, c) in &self.counts {
            println!("{name:14} {:6} {:6} {:9} {:10}", c.cases, c.same, c.probable, c.identical);
        }
        for (plain, row) in self.defects() {
            println!("{} {} ({}), {}:", row.case, row.plant, row.topic, row.transformation);
            for row in [plain, row] {
                match (&row.answer, &row.crash) {
                    (Some(answer), _) => println!("  {answer}"),
                    (None, crash) => println!("  {}", crash.as_deref().unwrap_or("no answer")),
                }
            }
        }
    }
}
