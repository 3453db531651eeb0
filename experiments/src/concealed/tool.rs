//! The tool under test: the `lacuna` command, as a process that sees files alone.

use serde::Deserialize;
use std::collections::BTreeMap;
use std::ffi::OsString;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use super::ConcealedError;
use crate::StudyError;

/// How often a running process is looked at.
const LOOK: Duration = Duration::from_millis(20);
/// Threads that one process may use, as rayon reads it.
const THREADS: &str = "RAYON_NUM_THREADS";

/// The command.
#[derive(Clone, Debug)]
pub struct Tool {
    program: PathBuf,
    timeout: Duration,
    threads: usize,
    environment: Vec<(String, String)>,
}

/// What a process left behind.
#[derive(Clone, Debug)]
pub struct Answer {
    /// Exit code; none when it was ended.
    pub code: Option<i32>,
    /// Standard output.
    pub stdout: String,
    /// Last line of standard error.
    pub complaint: String,
    /// Wall time (s).
    pub seconds: f64,
}

impl Tool {
    /// The command at `path`, or else beside the running executable.
    ///
    /// # Errors
    /// [`ConcealedError::NoBinary`] when it is not there.
    pub fn find(
        path: Option<&Path>,
        timeout: Duration,
        threads: usize,
    ) -> Result<Self, ConcealedError> {
        let name = format!("lacuna{}", std::env::consts::EXE_SUFFIX);
        let program = match path {
            Some(path) => path.to_path_buf(),
            None => std::env::current_exe().unwrap_or_default().with_file_name(name),
        };
        // Cases run in their own directories.
        match program.canonicalize() {
            Ok(program) if program.is_file() => {
                Ok(Self { program, timeout, threads, environment: vec![] })
            }
            _ => Err(ConcealedError::NoBinary { path: program }),
        }
    }

    /// The same that finds this in its environment.
    #[must_use]
    pub fn with(mut self, name: &str, value: &str) -> Self {
        self.environment.push((name.to_owned(), value.to_owned()));
        self
    }

    /// Its version, as it says.
    ///
    /// # Errors
    /// [`ConcealedError::Run`] when it cannot be started.
    pub fn version(&self) -> Result<String, StudyError> {
        Ok(self.run(Path::new("."), &["--version".into()])?.stdout.trim().to_owned())
    }

    /// Run it in a directory.
    ///
    /// # Errors
    /// [`ConcealedError::Run`] when it cannot be started.
    pub fn run(&self, directory: &Path, arguments: &[OsString]) -> Result<Answer, StudyError> {
        let failed = |source| ConcealedError::Run { program: self.program.clone(), source };
        let begin = Instant::now();
        let (said, complained) =
            (tempfile::tempfile().map_err(failed)?, tempfile::tempfile().map_err(failed)?);
        let mut child = Command::new(&self.program)
            .args(arguments)
            .current_dir(directory)
            .env(THREADS, self.threads.to_string())
            .envs(self.environment.iter().map(|(name, value)| (name, value)))
            .stdin(Stdio::null())
            .stdout(said.try_clone().map_err(failed)?)
            .stderr(complained.try_clone().map_err(failed)?)
            .spawn()
            .map_err(failed)?;
        let code = self.wait(&mut child, begin).map_err(failed)?;
        let complaint = text(complained).map_err(failed)?;
        Ok(Answer {
            code,
            stdout: text(said).map_err(failed)?,
            complaint: complaint.trim().lines().last().unwrap_or("").to_owned(),
            seconds: begin.elapsed().as_secs_f64(),
        })
    }

    fn wait(&self, child: &mut Child, begin: Instant) -> std::io::Result<Option<i32>> {
        loop {
            if let Some(status) = child.try_wait()? {
                return Ok(status.code());
            }
            if begin.elapsed() > self.timeout {
                child.kill()?;
                child.wait()?;
                return Ok(None);
            }
            std::thread::sleep(LOOK);
        }
    }

    /// Errors of a model by channel on a recording, over windows of `horizon` seconds; none where
    /// the command fails.
    ///
    /// # Errors
    /// [`ConcealedError::Run`] when it cannot be started.
    pub fn errors(
        &self,
        model: &Path,
        recording: &Path,
        horizon: f64,
    ) -> Result<Option<BTreeMap<String, f64>>, StudyError> {
        let arguments = [
            "simulate".into(),
            model.into(),
            "--like".into(),
            recording.into(),
            "--horizon".into(),
            horizon.to_string().into(),
            "--json".into(),
        ];
        let answer = self.run(Path::new("."), &arguments)?;
        let report: Option<Simulation> = serde_json::from_str(&answer.stdout).ok();
        Ok(report.map(|r| r.channels.into_iter().map(|(name, e)| (name, e.rmse)).collect()))
    }
}

/// What a process wrote to a file.
fn text(mut file: std::fs::File) -> std::io::Result<String> {
    use std::io::{Read, Seek};
    file.rewind()?;
    let mut bytes = Vec::new();
    file.read_to_end(&mut bytes)?;
    Ok(String::from_utf8_lossy(&bytes).into_owned())
}

#[derive(Deserialize)]
struct Simulation {
    channels: BTreeMap<String, ChannelError>,
}

#[derive(Deserialize)]
struct ChannelError {
    rmse: f64,
}
