//! `lacuna fleet`: many machines with one model.

use super::Outcome;
use super::typed::typed;
use crate::output::spinner;
use crate::say::{say, sayln};
use clap::Args;
use indicatif::ProgressBar;
use lacuna::discrepancy::Watch;
use lacuna::files::check_folder;
use lacuna::fleet::{Machine, Plan, State, Work, collect};
use rayon::ThreadPoolBuilder;
use std::error::Error;
use std::io::{self, Write};
use std::num::NonZero;
use std::path::PathBuf;
use std::process::ExitCode;
use std::str::FromStr;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::thread;

#[derive(Args)]
pub struct Arguments {
    /// The fleet's file: one model, and the machines with their recordings
    fleet: PathBuf,
    /// Diagnose the i-th of n shares of the machines, for job arrays; whichever process ends last compares all
    #[arg(long, value_name = "I/N")]
    shard: Option<Shard>,
    /// Folder of the results: one folder a machine, fleet.json and fleet.html
    #[arg(long, default_value = "fleet")]
    out: PathBuf,
    /// Machines at a time; by default as many as the processor has cores
    #[arg(long, value_name = "N")]
    jobs: Option<NonZero<usize>>,
    /// Print fleet.json instead of the summary
    #[arg(long)]
    json: bool,
    /// Print nothing but errors
    #[arg(long)]
    quiet: bool,
}

/// The `index`-th (from 1) of `count` shares.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Shard {
    index: usize,
    count: usize,
}

impl FromStr for Shard {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let numbers =
            text.split_once('/').and_then(|(i, n)| Some((i.parse().ok()?, n.parse().ok()?)));
        match numbers {
            Some((index, count)) if (1..=count).contains(&index) => Ok(Self { index, count }),
            _ => Err(format!("expected I/N with I from 1 to N, such as 1/8; found '{text}'")),
        }
    }
}

impl Shard {
    /// Every `count`-th machine.
    fn of(self, machines: &[Machine]) -> Vec<&Machine> {
        machines.iter().skip(self.index - 1).step_by(self.count).collect()
    }
}

pub fn run(a: &Arguments) -> Outcome {
    check_folder(&a.out)?;
    let plan = Plan::read(&a.fleet)?;
    let work = Work::new(&plan.model, plan.settings.clone(), &a.out, &typed())?;
    let share = a.shard.unwrap_or(Shard { index: 1, count: 1 }).of(&plan.machines);
    let failed = all(a, &work, &share)?;
    let exit = ExitCode::from(if failed == 0 { 0 } else { 2 });
    let others = plan.machines.iter().filter(|m| !share.iter().any(|s| s.name == m.name));
    let open = others.filter(|m| !work.is_settled(m)).count();
    if open > 0 {
        if !a.quiet && !a.json {
            sayln!(
                "{open} machines of other shares are not done; the last process compares all of them."
            )?;
        }
        return Ok(exit);
    }
    let names: Vec<&str> = plan.machines.iter().map(|m| &*m.name).collect();
    let fleet = collect(&a.out, &names)?;
    fleet.write(&a.out)?;
    if a.json {
        sayln!("{}", fleet.json()?)?;
    } else if !a.quiet {
        say!("{}", fleet.text())?;
        sayln!("Written: {}", a.out.join("fleet.html").display())?;
    }
    Ok(exit)
}

/// Diagnose machines, several at a time; how many failed.
fn all(a: &Arguments, work: &Work, share: &[&Machine]) -> Result<usize, Box<dyn Error>> {
    let cores = thread::available_parallelism().map_or(1, NonZero::get);
    let jobs = a.jobs.map_or(cores, NonZero::get).min(share.len()).max(1);
    let bar = spinner(a.quiet || a.json);
    let (next, failed) = (AtomicUsize::new(0), AtomicUsize::new(0));
    let worker = || -> Result<(), String> {
        let pool = ThreadPoolBuilder::new().num_threads((cores / jobs).max(1)).build();
        let pool = pool.map_err(|e| e.to_string())?;
        while let Some(machine) = share.get(next.fetch_add(1, Ordering::Relaxed)) {
            let state = pool.install(|| one(work, machine, &bar));
            let state = state.map_err(|e| {
                // The others stop after the machine that they are at.
                next.store(share.len(), Ordering::Relaxed);
                e.clone()
            })?;
            failed.fetch_add(usize::from(matches!(state, State::Failed(_))), Ordering::Relaxed);
            bar.suspend(|| tell(a, machine, &state)).map_err(|e| e.to_string())?;
        }
        Ok(())
    };
    let ended = thread::scope(|scope| {
        let workers: Vec<_> = (0..jobs).map(|_| scope.spawn(worker)).collect();
        let join = |w: thread::ScopedJoinHandle<'_, Result<(), String>>| {
            w.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic))
        };
        workers.into_iter().map(join).collect::<Result<Vec<()>, String>>()
    });
    bar.finish_and_clear();
    ended?;
    Ok(failed.into_inner())
}

fn one(work: &Work, machine: &Machine, bar: &ProgressBar) -> Result<State, String> {
    let progress = |doing: &str| bar.set_message(format!("{}: {doing}", machine.name));
    let never = AtomicBool::new(false);
    let watch = Watch::new(&progress, &never);
    work.diagnose(&machine.name, || work.read(machine), watch).map_err(|e| e.to_string())
}

/// Say what became of a machine.
fn tell(a: &Arguments, machine: &Machine, state: &State) -> io::Result<()> {
    let name = &machine.name;
    match state {
        State::Failed(error) => {
            let _ = writeln!(io::stderr(), "lacuna: {name}: {error}");
            Ok(())
        }
        _ if a.quiet || a.json => Ok(()),
        State::Diagnosed => sayln!("{name}: diagnosed"),
        State::There => sayln!("{name}: was diagnosed before"),
    }
}

#[cfg(test)]
mod tests {
    use super::Shard;

    #[test]
    fn shares_are_numbered_from_one() {
        assert_eq!("2/3".parse(), Ok(Shard { index: 2, count: 3 }));
        for text in ["0/3", "4/3", "1", "a/b", "1/0", "-1/2"] {
            assert!(text.parse::<Shard>().is_err(), "{text}");
        }
    }
}
