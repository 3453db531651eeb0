//! A process that evaluates, as seen by who asks it.

use crate::wire::{Widths, read_answer, write_question};
use crate::{FmuError, Question};
use std::ffi::OsString;
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::process::{Child, Stdio};
use std::sync::OnceLock;
use std::time::Duration;

/// How long an answer may take: that of a model that solves equations may take seconds.
const PATIENCE: Duration = Duration::from_secs(60);

static PROGRAM: OnceLock<(PathBuf, Vec<OsString>)> = OnceLock::new();

/// Say which program evaluates FMUs, and its first arguments: the folder follows them, and it must call
/// [`crate::serve`] with that. The first call counts.
pub fn evaluate_with(
    program: impl Into<PathBuf>,
    arguments: impl IntoIterator<Item = impl Into<OsString>>,
) {
    let arguments = arguments.into_iter().map(Into::into).collect();
    let _ = PROGRAM.set((program.into(), arguments));
}

/// The answers come by the socket that the process has in the place of its standard input, so that what
/// a library prints is no answer.
pub(crate) struct Process {
    child: Child,
    socket: socket::Socket,
    bytes: Vec<u8>,
}

impl Drop for Process {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

impl Process {
    /// Start one for the FMU that is unpacked in a folder.
    pub(crate) fn start(folder: &Path) -> Result<Self, FmuError> {
        let (program, arguments) = PROGRAM.get().ok_or(FmuError::NoEvaluator)?;
        let (socket, other) = socket::pair(PATIENCE).map_err(FmuError::io)?;
        let child = std::process::Command::new(program)
            .args(arguments)
            .arg(folder)
            .stdin(other)
            .stdout(Stdio::null())
            .stderr(Stdio::null())
            .spawn()
            .map_err(|e| FmuError::Evaluation {
                reason: format!("{} cannot be started: {e}", program.display()),
            })?;
        let mut process = Self { child, socket, bytes: vec![] };
        match read_answer(&mut io::BufReader::new(&mut process.socket), [&mut [], &mut []]) {
            Ok((true, _)) => Ok(process),
            Ok((false, reason)) => Err(FmuError::Evaluation { reason }),
            Err(error) => Err(FmuError::Evaluation { reason: process.end(&error) }),
        }
    }

    /// Ask; what went wrong, if something did. It fails where the process ended: then why.
    pub(crate) fn ask(
        &mut self,
        widths: Widths,
        question: &Question<'_>,
        numbers: [&mut [f64]; 2],
    ) -> Result<String, String> {
        write_question(&mut self.bytes, widths, question);
        let answered = match self.socket.write_all(&self.bytes) {
            Ok(()) => read_answer(&mut io::BufReader::new(&mut self.socket), numbers),
            Err(error) => Err(error),
        };
        answered.map(|(_, said)| said).map_err(|error| self.end(&error))
    }

    /// How a process ended that does not answer.
    fn end(&mut self, error: &io::Error) -> String {
        if matches!(error.kind(), io::ErrorKind::WouldBlock | io::ErrorKind::TimedOut) {
            return format!("it took more than {} s to answer", PATIENCE.as_secs());
        }
        match self.child.wait() {
            Ok(status) => format!("it ended the process that it was evaluated in ({status})"),
            Err(error) => error.to_string(),
        }
    }
}

#[cfg(unix)]
mod socket {
    use std::io;
    use std::os::fd::{AsFd, OwnedFd};
    use std::os::unix::net::UnixStream;
    use std::process::Stdio;
    use std::time::Duration;

    pub(crate) type Socket = UnixStream;

    /// Our end, which waits so long, and that of the process.
    pub(crate) fn pair(patience: Duration) -> io::Result<(Socket, Stdio)> {
        let (own, other) = UnixStream::pair()?;
        own.set_read_timeout(Some(patience))?;
        Ok((own, Stdio::from(OwnedFd::from(other))))
    }

    /// The end of this process, where it is one that evaluates.
    pub(crate) fn own() -> io::Result<Socket> {
        Ok(UnixStream::from(io::stdin().as_fd().try_clone_to_owned()?))
    }
}

#[cfg(not(unix))]
mod socket {
    use std::io;
    use std::net::TcpStream;
    use std::process::Stdio;
    use std::time::Duration;

    pub(crate) type Socket = TcpStream;

    pub(crate) fn pair(_: Duration) -> io::Result<(Socket, Stdio)> {
        Err(io::Error::new(io::ErrorKind::Unsupported, "FMUs are evaluated on Linux and macOS"))
    }

    pub(crate) fn own() -> io::Result<Socket> {
        Err(io::Error::from(io::ErrorKind::Unsupported))
    }
}

pub(crate) use socket::own;
