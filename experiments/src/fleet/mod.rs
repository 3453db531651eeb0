//! Drawn fleets: does `lacuna fleet`, which sees files alone, find the machines that are unlike the others, and no
//! other?

mod draw;

pub use draw::Difference;

use lacuna_recordings::write_csv_with_time;
use serde::{Deserialize, Serialize};
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use std::time::Duration;

use crate::cli::Common;
use crate::concealed::ConcealedError;
use crate::concealed::tool::Tool;
use crate::{StudyError, output, progress};

/// Name of the study and of its results.
pub const NAME: &str = "fleet";
/// A fleet that takes longer than this is lost.
const LONGEST: Duration = Duration::from_secs(24 * 3600);
const FLEET: &str = "model = \"arm.toml\"\nmachines = \"data/*/\"\nheld_out = \"proof.csv\"\n";

/// What is drawn, and who is asked.
#[derive(Clone, Debug)]
pub struct Settings {
    /// Fleets.
    pub fleets: u64,
    /// Machines of each.
    pub machines: u64,
    /// Of them, those that are unlike the others.
    pub unlike: u64,
    /// Machines diagnosed at a time.
    pub jobs: usize,
    /// The command under test; by default the one beside this executable.
    pub lacuna: Option<PathBuf>,
}

/// What the study found.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
pub struct Results {
    /// [`NAME`].
    pub experiment: String,
    /// Seed of all draws.
    pub seed: u64,
    /// Fleets.
    pub fleets: u64,
    /// Machines of each.
    pub machines: u64,
    /// Machines that are unlike the others, by how, and of those the ones that were called so.
    pub unlike: BTreeMap<Difference, Count>,
    /// Machines that were called unlike and are not.
    pub mistaken: u64,
    /// Fleets with such a machine.
    pub fleets_mistaken: u64,
}

/// Machines.
#[derive(Clone, Copy, Debug, Default, Deserialize, PartialEq, Serialize)]
pub struct Count {
    /// How many there are.
    pub all: u64,
    /// How many were called unlike.
    pub found: u64,
}

/// Carry out the study, write its results and print them.
///
/// # Errors
/// [`StudyError`] when the command is not there or fails, or files cannot be written.
pub fn run(settings: &Settings, common: &Common) -> Result<(), StudyError> {
    let tool = Tool::find(settings.lacuna.as_deref(), LONGEST, 1)?;
    let mut results = Results {
        experiment: NAME.to_owned(),
        seed: common.seed,
        fleets: settings.fleets,
        machines: settings.machines,
        unlike: BTreeMap::new(),
        mistaken: 0,
        fleets_mistaken: 0,
    };
    let bar = progress::bar(settings.fleets as usize, "fleets", common.quiet);
    for fleet in 0..settings.fleets {
        let (truth, called) = one(settings, (common.seed, fleet), &tool)?;
        results.count(&truth, &called);
        bar.inc(1);
    }
    bar.finish_and_clear();
    let file = output::write_json(&common.out, NAME, &results)?;
    if !common.quiet {
        results.print();
        println!("wrote {}", file.display());
    }
    Ok(())
}

impl Results {
    fn count(&mut self, truth: &BTreeMap<String, Difference>, called: &BTreeSet<String>) {
        for (machine, difference) in truth {
            let count = self.unlike.entry(*difference).or_default();
            count.all += 1;
            count.found += u64::from(called.contains(machine));
        }
        let mistaken = called.iter().filter(|name| !truth.contains_key(*name)).count() as u64;
        self.mistaken += mistaken;
        self.fleets_mistaken += u64::from(mistaken > 0);
    }

    fn print(&self) {
        println!("{} fleets of {} machines, seed {}", self.fleets, self.machines, self.seed);
        for (difference, count) in &self.unlike {
            println!("{difference:?}: {} of {} found", count.found, count.all);
        }
        println!("called unlike by mistake: {} in {} fleets", self.mistaken, self.fleets_mistaken);
    }
}

/// Draw a fleet, have it diagnosed, and tell which machines are unlike the others and which are called so.
fn one(
    settings: &Settings,
    (seed, fleet): (u64, u64),
    tool: &Tool,
) -> Result<(BTreeMap<String, Difference>, BTreeSet<String>), StudyError> {
    let written = |path: &Path| {
        let path = path.to_owned();
        move |source| StudyError::Write { path, source }
    };
    let folder = tempfile::tempdir().map_err(written(&std::env::temp_dir()))?;
    for (name, text) in [("arm.toml", draw::model()), ("fleet.toml", FLEET.to_owned())] {
        let path = folder.path().join(name);
        std::fs::write(&path, text).map_err(written(&path))?;
    }
    let mut truth = BTreeMap::new();
    for machine in 0..settings.machines {
        let (name, difference) = (format!("m{machine:03}"), difference(settings, machine));
        truth.extend(difference.map(|d| (name.clone(), d)));
        let place = folder.path().join("data").join(&name);
        std::fs::create_dir_all(&place).map_err(written(&place))?;
        let stream = fleet * settings.machines + machine;
        for (k, recording) in draw::recordings((seed, stream), difference)?.iter().enumerate() {
            let proof = k + 1 == draw::RECORDINGS;
            let file = if proof { "proof.csv".to_owned() } else { format!("run{k}.csv") };
            write_csv_with_time(&place.join(file), recording, "t").map_err(ConcealedError::from)?;
        }
    }
    let jobs = settings.jobs.to_string();
    let words = ["fleet", "fleet.toml", "--out", "out", "--quiet", "--jobs", &jobs];
    tool.run(folder.path(), &words.map(Into::into))?;
    let found: Found = output::read_json(&folder.path().join("out/fleet.json"))?;
    Ok((truth, found.unlike.into_iter().map(|u| u.machine).collect()))
}

/// How a machine of a fleet is unlike the others, if it is: so many are, evenly among them, each in the next way.
fn difference(settings: &Settings, machine: u64) -> Option<Difference> {
    let before = |m: u64| m * settings.unlike / settings.machines;
    let is = before(machine + 1) > before(machine);
    is.then(|| Difference::ALL[(before(machine) as usize) % Difference::ALL.len()])
}

/// What is read of fleet.json.
#[derive(Deserialize)]
struct Found {
    unlike: Vec<Called>,
}

#[derive(Deserialize)]
struct Called {
    machine: String,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn as_many_are_unlike_as_are_asked_for() {
        let settings = Settings { fleets: 1, machines: 30, unlike: 5, jobs: 1, lacuna: None };
        let all: Vec<Difference> = (0..30).filter_map(|m| difference(&settings, m)).collect();
        assert_eq!(
            (all.len(), &all[..4], all[4]),
            (5, &Difference::ALL[..], Difference::NoFriction)
        );
    }

    #[test]
    fn machines_differ_and_are_drawn_anew_alike() {
        let angle = |machine, difference| {
            draw::recordings((3, machine), difference).unwrap()[0].columns[0].values.clone()
        };
        assert_eq!(angle(1, None), angle(1, None));
        assert_ne!(angle(1, None), angle(2, None));
        let apart =
            |d| angle(1, Some(d)).iter().zip(angle(1, None)).any(|(a, b)| (a - b).abs() > 0.01);
        assert!(Difference::ALL.into_iter().all(apart));
    }
}
