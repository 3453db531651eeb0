//! What is said on standard output.

use std::fmt::Arguments;
use std::io::{self, ErrorKind, Write};

/// Print. A reader that has gone, as in `lacuna diagnose ... | head -1`, has read enough: the work
/// goes on, and its exit code stays what it is.
///
/// # Errors
/// Whatever else keeps standard output from being written, such as a full disk.
pub fn print(text: Arguments) -> io::Result<()> {
    let mut out = io::stdout().lock();
    match out.write_fmt(text).and_then(|()| out.flush()) {
        Err(e) if e.kind() == ErrorKind::BrokenPipe => Ok(()),
        Err(e) => Err(io::Error::new(e.kind(), format!("standard output: {e}"))),
        Ok(()) => Ok(()),
    }
}

/// [`print()`] as `print!`, with its result.
macro_rules! say {
    ($($text:tt)*) => { $crate::say::print(format_args!($($text)*)) };
}

/// [`print()`] as `println!`, with its result.
macro_rules! sayln {
    ($($text:tt)*) => { $crate::say::print(format_args!("{}\n", format_args!($($text)*))) };
}

pub(crate) use {say, sayln};
