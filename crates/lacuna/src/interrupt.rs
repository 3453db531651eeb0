//! Ctrl-C: no half-written file is left, and the terminal is as it was.

use lacuna::files::uninterrupted;
use std::io::{self, IsTerminal, Write};
use std::process::ExitCode;
use std::sync::atomic::{AtomicBool, Ordering};

/// Exit code of a process that was interrupted: 128 and the signal's number.
const INTERRUPTED: u8 = 130;
/// Back to the line's beginning, and the line erased: the spinner stands there.
const ERASE_LINE: &[u8] = b"\r\x1b[2K";

/// Whether a computation looks at [`CANCELLED`] and returns by itself.
static LISTENS: AtomicBool = AtomicBool::new(false);
/// Set by the first signal that comes while a computation listens.
static CANCELLED: AtomicBool = AtomicBool::new(false);

/// A computation that is cancelled by a signal, in place of the process being ended: it returns,
/// and with it all that stands on its stack. A second signal ends the process.
pub struct Cancellable(());

impl Cancellable {
    /// From now on until this is dropped.
    pub fn begin() -> Self {
        LISTENS.store(true, Ordering::SeqCst);
        Self(())
    }

    /// What a signal sets.
    pub fn token(&self) -> &'static AtomicBool {
        &CANCELLED
    }

    /// No longer; the exit code of what was cancelled meanwhile.
    pub fn end(self) -> Option<ExitCode> {
        drop(self);
        CANCELLED.load(Ordering::SeqCst).then(|| ExitCode::from(INTERRUPTED))
    }
}

impl Drop for Cancellable {
    fn drop(&mut self) {
        LISTENS.store(false, Ordering::SeqCst);
    }
}

/// On SIGINT, SIGTERM and SIGHUP cancel what listens; otherwise exit with 130, after what is being
/// written is written. What whoever started the process had ignored, as `nohup` does with SIGHUP,
/// stays ignored.
pub fn exit_when_interrupted() {
    hear(|| {
        if LISTENS.load(Ordering::SeqCst) && !CANCELLED.swap(true, Ordering::SeqCst) {
            return;
        }
        let _writing = uninterrupted();
        let mut terminal = io::stderr();
        if terminal.is_terminal() {
            // The process ends; there is nobody to tell that its terminal has gone.
            let _ = terminal.write_all(ERASE_LINE);
        }
        std::process::exit(i32::from(INTERRUPTED));
    });
}

/// Call `told` at every signal, from a thread of its own. Where that is refused, signals end the
/// process as if nobody had asked.
#[cfg(target_os = "linux")]
fn hear(told: impl Fn() + Send + 'static) {
    use signal_hook::consts::{SIGHUP, SIGINT, SIGTERM};
    let ignored = ignored();
    let heard = [SIGHUP, SIGINT, SIGTERM].into_iter().filter(|s| ignored >> (s - 1) & 1 == 0);
    if let Ok(mut signals) = signal_hook::iterator::Signals::new(heard) {
        std::thread::spawn(move || signals.forever().for_each(|_| told()));
    }
}

/// Other systems do not tell what is ignored: there all are refused where one is.
#[cfg(not(target_os = "linux"))]
fn hear(told: impl Fn() + Send + 'static) {
    let _ = ctrlc::try_set_handler(told);
}

/// The signals that are ignored, a bit each from the first (proc(5), SigIgn).
#[cfg(target_os = "linux")]
fn ignored() -> u64 {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let line = status.lines().find_map(|l| l.strip_prefix("SigIgn:"));
    line.and_then(|bits| u64::from_str_radix(bits.trim(), 16).ok()).unwrap_or(0)
}
