//! Progress bars of long studies.

use indicatif::{ProgressBar, ProgressStyle};

/// A bar of `steps` steps on standard error; silent when `quiet` or when standard error is not
/// a terminal.
pub fn bar(steps: usize, what: &'static str, quiet: bool) -> ProgressBar {
    if quiet {
        return ProgressBar::hidden();
    }
    let style = ProgressStyle::with_template("{msg} [{bar:30}] {pos}/{len}, {eta} left")
        .unwrap_or_else(|_| ProgressStyle::default_bar());
    ProgressBar::new(steps as u64).with_style(style).with_message(what)
}
