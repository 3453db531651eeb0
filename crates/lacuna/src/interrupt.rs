//! Ctrl-C: no half-written file is left, and the terminal is as it was.

use std::io::{self, IsTerminal, Write};
use std::sync::{Mutex, MutexGuard, PoisonError};

/// Exit code of a process that was interrupted: 128 and the signal's number.
const INTERRUPTED: i32 = 130;
/// Back to the line's beginning, and the line erased: the spinner stands there.
const ERASE_LINE: &[u8] = b"\r\x1b[2K";

/// Held while files are written: whoever interrupts waits for it, so that a set of files is there
/// whole or not at all, without temporary ones beside it.
static WRITING: Mutex<()> = Mutex::new(());

/// Not to be interrupted until this is dropped. Not to be asked for twice by one thread.
pub fn uninterrupted() -> MutexGuard<'static, ()> {
    WRITING.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Exit with 130 on SIGINT, SIGTERM and SIGHUP, after what is being written is written.
pub fn exit_when_interrupted() {
    let exit = || {
        let _writing = uninterrupted();
        let mut terminal = io::stderr();
        if terminal.is_terminal() {
            // The process ends; there is nobody to tell that its terminal has gone.
            let _ = terminal.write_all(ERASE_LINE);
        }
        std::process::exit(INTERRUPTED);
    };
    // Refused where a signal is ignored already, as under nohup: then it stays ignored.
    let _ = ctrlc::try_set_handler(exit);
}
