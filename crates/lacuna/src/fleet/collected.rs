//! A fleet that is done: what its machines lack, and which are unlike the others.

use super::page::page;
use super::quantities::{Quantity, Sort, quantities};
use super::unlike::{FALSE_RATE, Unlike, unlike};
use super::work::FAILED;
use crate::discrepancy::Diagnosis;
use crate::discrepancy::diagnosis::{Calibration, Estimate, Finding, Verdict};
use crate::files::write_together;
use crate::report;
use crate::report::number::{plain, with_std};
use crate::table::Table;
use serde::Serialize;
use std::collections::BTreeMap;
use std::error::Error;
use std::fmt::Write;
use std::path::Path;

/// Number of fleet.json's schema: fields are added under the same number, never renamed or removed.
const SCHEMA: u32 = 1;
/// Means below so many of their standard deviations, or spreads, are none.
const NOTHING: f64 = 2.0;

/// A machine that was diagnosed.
#[derive(Clone, Debug)]
pub struct Diagnosed {
    /// Its name.
    pub name: String,
    /// Its diagnosis.
    pub diagnosis: Diagnosis,
}

/// A machine that could not be diagnosed.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Failed {
    /// Its name.
    pub name: String,
    /// Why.
    pub error: String,
}

/// A fleet that is done.
pub struct Collected {
    pub(super) machines: Vec<Diagnosed>,
    pub(super) failed: Vec<Failed>,
    pub(super) quantities: Vec<Quantity>,
    pub(super) unlike: Vec<Unlike>,
}

/// Read the results of all machines of these names in a folder, and compare them.
///
/// # Errors
/// A machine without results, or results that cannot be read, with their path.
pub fn collect(folder: &Path, names: &[&str]) -> Result<Collected, Box<dyn Error>> {
    let (mut machines, mut failed) = (vec![], vec![]);
    for name in names {
        let folder = folder.join(name);
        let name = (*name).to_owned();
        match error_of(&folder)? {
            Some(error) => failed.push(Failed { name, error }),
            None => machines.push(Diagnosed { name, diagnosis: diagnosis_of(&folder)? }),
        }
    }
    let quantities = quantities(&machines);
    let unlike = unlike(&quantities, says);
    Ok(Collected { machines, failed, quantities, unlike })
}

/// Why a machine could not be diagnosed, where it could not.
fn error_of(folder: &Path) -> Result<Option<String>, Box<dyn Error>> {
    #[derive(serde::Deserialize)]
    struct Told {
        error: String,
    }
    let path = folder.join(FAILED);
    if !path.exists() {
        return Ok(None);
    }
    let text = std::fs::read_to_string(&path).map_err(|e| format!("{}: {e}", path.display()))?;
    let told: Told = serde_json::from_str(&text).map_err(|e| format!("{}: {e}", path.display()))?;
    Ok(Some(told.error))
}

fn diagnosis_of(folder: &Path) -> Result<Diagnosis, Box<dyn Error>> {
    let path = folder.join("diagnosis.json");
    let text = std::fs::read_to_string(&path)
        .map_err(|e| format!("{}: {e}; this machine is not diagnosed yet", path.display()))?;
    Ok(serde_json::from_str(&text).map_err(|e| format!("{}: {e}", path.display()))?)
}

/// What fleet.json holds.
#[derive(Serialize)]
struct Results<'a> {
    schema: u32,
    version: &'static str,
    model: &'a str,
    /// Share of the machines called unlike that are not, on average and at most.
    false_rate: f64,
    unlike: &'a [Unlike],
    machines: Vec<OneMachine<'a>>,
    failed: &'a [Failed],
    quantities: &'a [Quantity],
}

#[derive(Serialize)]
struct OneMachine<'a> {
    name: &'a str,
    verdict: Verdict,
    findings: Vec<OneFinding<'a>>,
    calibration: &'a BTreeMap<String, Calibration>,
}

#[derive(Serialize)]
struct OneFinding<'a> {
    class: &'a str,
    channel: &'a str,
    #[serde(skip_serializing_if = "Option::is_none")]
    other: Option<&'a str>,
    parameters: &'a BTreeMap<String, Estimate>,
    probability: f64,
}

impl<'a> OneFinding<'a> {
    fn of(f: &'a Finding) -> Self {
        Self {
            class: &f.class,
            channel: &f.channel,
            other: f.other.as_deref(),
            parameters: &f.parameters,
            probability: f.probability,
        }
    }
}

impl Collected {
    /// The model's name; empty where no machine could be diagnosed.
    pub fn model(&self) -> &str {
        self.machines.first().map_or("", |m| &m.diagnosis.model)
    }

    /// The machines that are unlike the others, the clearest first.
    pub fn unlike(&self) -> &[Unlike] {
        &self.unlike
    }

    /// The machines that could not be diagnosed.
    pub fn failed(&self) -> &[Failed] {
        &self.failed
    }

    /// What fleet.json holds.
    ///
    /// # Errors
    /// None: these are numbers and names.
    pub fn json(&self) -> serde_json::Result<String> {
        let mut machines = vec![];
        for Diagnosed { name, diagnosis } in &self.machines {
            machines.push(OneMachine {
                name,
                verdict: diagnosis.verdict,
                findings: diagnosis.findings.iter().map(OneFinding::of).collect(),
                calibration: &diagnosis.calibration,
            });
        }
        serde_json::to_string_pretty(&Results {
            schema: SCHEMA,
            version: env!("CARGO_PKG_VERSION"),
            model: self.model(),
            false_rate: FALSE_RATE,
            unlike: &self.unlike,
            machines,
            failed: &self.failed,
            quantities: &self.quantities,
        })
    }

    /// The page, `linked` where it stands beside the folders of the machines: it then leads to their pages.
    pub fn page(&self, linked: bool) -> String {
        report::fleet_page(&page(self, linked))
    }

    /// Write fleet.json and fleet.html to the folder of the machines' results.
    ///
    /// # Errors
    /// The underlying error, with the path.
    pub fn write(&self, folder: &Path) -> Result<(), Box<dyn Error>> {
        let (data, html) = (folder.join("fleet.json"), folder.join("fleet.html"));
        Ok(write_together(&[(&data, &self.json()?), (&html, &self.page(true))])?)
    }

    /// The sentence that matters.
    pub fn headline(&self) -> String {
        let n = self.machines.len();
        let names: Vec<&str> = self.unlike.iter().map(|u| &*u.machine).collect();
        match names.len() {
            _ if self.quantities.iter().all(|q| q.mean.is_none()) => {
                format!(
                    "{n} machines: too few, or too little in common, to say which is unlike the others"
                )
            }
            0 => format!("None of {n} machines is unlike the others"),
            1 => format!("1 of {n} machines is unlike the others: {}", names[0]),
            k => format!("{k} of {n} machines are unlike the others: {}", names.join(", ")),
        }
    }

    /// How many machines have which verdict, in words.
    pub(super) fn verdicts(&self) -> String {
        let words = [
            (Verdict::NoMismatch, "explained by the model as it is"),
            (Verdict::Miscalibrated, "miscalibrated"),
            (Verdict::MissingPhysics, "lacking physics that is named"),
            (Verdict::SensorFault, "with a sensor that is wrong"),
            (Verdict::Unexplained, "unexplained, and not compared"),
        ];
        let count = |v: Verdict| self.machines.iter().filter(|m| m.diagnosis.verdict == v).count();
        let told = words.map(|(v, words)| (count(v), words));
        let mut all: Vec<String> =
            told.iter().filter(|t| t.0 > 0).map(|(k, words)| format!("{k} {words}")).collect();
        if !self.failed.is_empty() {
            all.push(format!("{} not diagnosed", self.failed.len()));
        }
        all.join(", ")
    }

    /// All of it as plain text.
    pub fn text(&self) -> String {
        let mut out = format!("{}.\n  {}.\n", self.headline(), self.verdicts());
        for u in &self.unlike {
            for reason in &u.because {
                let _ = writeln!(out, "  {}: {}", u.machine, reason.says);
            }
        }
        let mut table = Table::new(&["quantity", "machines", "typical", "spread"]);
        for q in self.quantities.iter().filter(|q| q.mean.is_some()) {
            table.row(row(q));
        }
        out += &table.text();
        for f in &self.failed {
            let _ = writeln!(out, "  {} could not be diagnosed: {}", f.name, f.error);
        }
        out
    }
}

/// A quantity's line of a table: name, machines, typical value, spread.
pub(super) fn row(q: &Quantity) -> Vec<String> {
    let found = q.values.iter().filter(|v| v.found).count();
    let typical = match (q.mean, q.mean_std) {
        (Some(mean), Some(std)) => with_std(mean, std, &q.unit),
        _ => "too few machines".to_owned(),
    };
    let spread = q.spread.map_or_else(String::new, |s| plain(s, &q.unit));
    vec![q.name.clone(), format!("{found} of {}", q.values.len()), typical, spread]
}

/// What is special about a machine in a quantity, in words.
fn says(q: &Quantity, machine: usize) -> String {
    let v = &q.values[machine];
    let (mean, spread) = (q.mean.unwrap_or(f64::NAN), q.spread.unwrap_or(f64::NAN));
    let own = match v.found {
        true => format!("{} is {}", q.name, with_std(v.value, v.std, &q.unit)),
        false => format!("no {}", q.name),
    };
    let none =
        q.sort == Sort::Size && mean.abs() <= NOTHING * q.mean_std.unwrap_or(0.0).max(spread);
    match none {
        true => format!("{own}, where typical machines have none"),
        false => format!("{own}, where typical machines have {}", with_std(mean, spread, &q.unit)),
    }
}
