//! Progress, and whether to colour.

use indicatif::{ProgressBar, ProgressStyle};
use std::io::{self, IsTerminal, Write};
use std::time::{Duration, Instant};

/// A spinner that says what is being done, on a terminal and unless `quiet`.
#[must_use]
pub fn spinner(quiet: bool) -> ProgressBar {
    if quiet || !io::stderr().is_terminal() {
        return ProgressBar::hidden();
    }
    let style = ProgressStyle::with_template("{spinner} {elapsed:>4} {msg}");
    let bar = ProgressBar::new_spinner();
    if let Ok(style) = style {
        bar.set_style(style);
    }
    bar.enable_steady_tick(Duration::from_millis(120));
    bar
}

/// Tells every step on standard error, a line each after the seconds since it began.
pub fn steps() -> impl Fn(&str) + Sync {
    let begin = Instant::now();
    move |doing: &str| {
        // Nobody need read it.
        let _ = writeln!(io::stderr(), "{:8.1} s  {doing}", begin.elapsed().as_secs_f64());
    }
}

/// Whether standard output wants colour.
#[must_use]
pub fn colour() -> bool {
    io::stdout().is_terminal() && std::env::var_os("NO_COLOR").is_none()
}
