//! Functional mock-up units (FMUs) by the standard FMI, version 2.0 or 3.0, for model exchange: a simulator
//! as an archive with a shared library that says
//!
//! ```text
//! z' = f(z, u, t; p)        y = h(z, u, t; p)
//! ```
//!
//! | on paper | in code |
//! | --- | --- |
//! | continuous states z, their derivatives z' | [`Description::states`], [`Wanted::Rates`] |
//! | inputs u | [`Description::inputs`] |
//! | outputs y | [`Description::outputs`], [`Wanted::Outputs`] |
//! | parameters p | [`Description::parameters`] |
//! | (p, z, u, t) | a row of [`Question::points`] |
//! | df/dz, df/du, dh/dz, dh/du, where the FMU has them | [`Question::along`] |
//!
//! What changes at events (event indicators, discrete states, clocks, time events) is refused: f would
//! depend on what happened before.
//!
//! # In a process of its own
//!
//! The library is foreign code. It may crash, print, leak, change the rounding of numbers, keep state that its
//! instances share, or allow one instance a process. So it is loaded into processes that do nothing else, one for
//! every thread that asks ([`Fmu::evaluate`]), as many as ask at once: a crash is then a point
//! that cannot be evaluated, told ([`Fmu::trouble`]), and the next question goes to a new process. The
//! program evaluates for itself, called again with other arguments ([`evaluate_with`], [`serve`]), so that nothing
//! else need be installed.
//!
//! Evaluation in the program's own process, an instance a thread under a lock, would save the ten to thirty
//! microseconds that a question takes. It was not chosen: a crash can then be told but not survived, in Python it takes
//! the interpreter along, and nothing protects from state that instances share. In place of that a
//! question holds many points: all that differences need around one, or the point and derivatives there.

mod archive;
mod description;
mod error;
mod evaluator;
mod foreign;
mod process;
mod unit;
mod wire;

pub use description::{Description, State, Variable, Version};
pub use error::FmuError;
pub use process::evaluate_with;

use archive::{Archive, DESCRIPTION};
use process::Process;
use std::env::consts::{ARCH, DLL_SUFFIX, OS};
use std::fmt;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};
use tempfile::TempDir;
use wire::Widths;

/// What is asked for.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Wanted {
    /// Derivatives of the states by time.
    #[default]
    Rates,
    /// Outputs.
    Outputs,
}

/// Points at which values are asked for.
#[derive(Clone, Copy, Debug)]
pub struct Question<'a> {
    /// Which values.
    pub wanted: Wanted,
    /// Rows (p, z, u, t).
    pub points: &'a [f64],
    /// States and inputs (an input after all states) by which derivatives are wanted at the first point.
    /// None where the FMU has no derivatives.
    pub along: &'a [usize],
}

/// How often processes are started again before nothing more is asked.
const MOST_CRASHES: usize = 200;

/// An FMU that is unpacked and can be evaluated.
pub struct Fmu {
    description: Description,
    folder: TempDir,
    /// Processes that nobody is asking.
    idle: Mutex<Vec<Process>>,
    trouble: Mutex<Trouble>,
}

#[derive(Default)]
struct Trouble {
    failures: usize,
    crashes: usize,
    first: String,
}

impl fmt::Debug for Fmu {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Fmu").field("name", &self.description.name).finish_non_exhaustive()
    }
}

impl Fmu {
    /// Unpack an FMU and start it.
    ///
    /// # Errors
    /// What is wrong with the archive or the description, what it needs that is not supported, or why it does
    /// not start.
    pub fn open(path: &Path) -> Result<Self, FmuError> {
        let mut archive = Archive::open(path)?;
        let text = archive.description()?;
        let description = Description::read(&text)?;
        let platform = platform(description.version)?;
        let binaries = format!("binaries/{platform}/");
        let library = format!("{binaries}{}{DLL_SUFFIX}", description.identifier);
        if !archive.within(&library).any(|name| name == library) {
            return Err(no_binary(&archive, library));
        }
        let folder =
            tempfile::Builder::new().prefix("lacuna-fmu").tempdir().map_err(FmuError::io)?;
        archive.unpack(&[DESCRIPTION, &binaries, "resources/"], folder.path())?;
        let first = Process::start(folder.path())?;
        let (idle, trouble) = (Mutex::new(vec![first]), Mutex::default());
        Ok(Self { description, folder, idle, trouble })
    }

    /// What it says of itself.
    #[must_use]
    pub fn description(&self) -> &Description {
        &self.description
    }

    /// Values at the points of a question, a row each, and derivatives of them at the first point, a row for each
    /// entry of [`Question::along`]. What cannot be evaluated is NaN, and why is said.
    ///
    /// # Panics
    /// Where the lengths do not fit.
    pub fn evaluate(
        &self,
        question: &Question<'_>,
        values: &mut [f64],
        slopes: &mut [f64],
    ) -> Option<String> {
        let widths = Widths::of(&self.description);
        let width = widths.values(question.wanted);
        let points = question.points.len() / (widths.parameters + widths.variables);
        assert_eq!(values.len(), points * width, "a row for each point");
        assert_eq!(slopes.len(), question.along.len() * width, "a row for each entry");
        if lock(&self.trouble).crashes >= MOST_CRASHES {
            values.fill(f64::NAN);
            slopes.fill(f64::NAN);
            return Some(self.trouble().unwrap_or_default());
        }
        let idle = lock(&self.idle).pop();
        let process = match idle {
            Some(process) => Ok(process),
            None => Process::start(self.folder.path()).map_err(|e| e.to_string()),
        };
        let answered = process.and_then(|mut process| {
            let said = process.ask(widths, question, [&mut *values, &mut *slopes])?;
            lock(&self.idle).push(process);
            Ok(said)
        });
        let (said, crashed) = match answered {
            Ok(said) if said.is_empty() => return None,
            Ok(said) => (said, false),
            Err(reason) => {
                values.fill(f64::NAN);
                slopes.fill(f64::NAN);
                (reason, true)
            }
        };
        let mut trouble = lock(&self.trouble);
        trouble.failures += usize::from(!crashed);
        trouble.crashes += usize::from(crashed);
        if trouble.first.is_empty() {
            trouble.first.clone_from(&said);
        }
        Some(said)
    }

    /// What went wrong so far, in a sentence; none where nothing did.
    #[must_use]
    pub fn trouble(&self) -> Option<String> {
        let trouble = lock(&self.trouble);
        let Trouble { failures, crashes, first } = &*trouble;
        match (failures, crashes) {
            (0, 0) => None,
            (failures, 0) => Some(format!(
                "The FMU could not be evaluated {failures} times, first because {first}."
            )),
            (failures, crashes) => Some(format!(
                "The FMU ended its process {crashes} times and could not be evaluated another {failures} \
                 times, first because {first}."
            )),
        }
    }
}

/// Evaluate the FMU that is unpacked in `folder` for the process that started this one: what a program does
/// that was named by [`evaluate_with`].
///
/// # Errors
/// Where the other process is gone.
pub fn serve(folder: &Path) -> std::io::Result<()> {
    let socket = process::own()?;
    evaluator::answer(folder, &socket, &socket)
}

/// A lock whose holder cannot leave halves behind.
fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

/// The folder of libraries for this machine.
fn platform(version: Version) -> Result<&'static str, FmuError> {
    let known = match (version, OS, ARCH) {
        (Version::Two, "linux", "x86_64") => "linux64",
        (Version::Two, "linux", "aarch64") | (Version::Three, "linux", "aarch64") => {
            "aarch64-linux"
        }
        (Version::Two, "macos", _) => "darwin64",
        (Version::Three, "linux", "x86_64") => "x86_64-linux",
        (Version::Three, "macos", "x86_64") => "x86_64-darwin",
        (Version::Three, "macos", "aarch64") => "aarch64-darwin",
        _ => {
            let what =
                format!("cannot be evaluated on {OS} on {ARCH}: Linux and macOS are supported");
            return Err(FmuError::unsupported(what));
        }
    };
    Ok(known)
}

fn library_file(folder: &Path, d: &Description) -> PathBuf {
    let platform = platform(d.version).unwrap_or_default();
    folder.join("binaries").join(platform).join(format!("{}{DLL_SUFFIX}", d.identifier))
}

fn no_binary(archive: &Archive, library: String) -> FmuError {
    let mut platforms: Vec<&str> = archive
        .within("binaries/")
        .filter_map(|name| name.strip_prefix("binaries/")?.split_once('/'))
        .map(|(platform, _)| platform)
        .collect();
    platforms.sort_unstable();
    platforms.dedup();
    let instead = match platforms.is_empty() {
        true if archive.within("sources/").next().is_some() => {
            ": it holds sources alone; have the tool that exported it compile them".to_owned()
        }
        true => String::new(),
        false => format!(
            ", the library for this machine; there are those for {}: export it for this platform too",
            platforms.join(", ")
        ),
    };
    FmuError::Missing { missing: library, instead }
}
