//! Files that are written whole or not at all, progress, and whether to colour.

use crate::interrupt::uninterrupted;
use indicatif::{ProgressBar, ProgressStyle};
use std::io::{self, IsTerminal, Write};
use std::path::Path;
use std::time::Duration;
use tempfile::NamedTempFile;

/// Write a text file as [`write_together`] does.
///
/// # Errors
/// The underlying error, with the path.
pub fn write_whole(path: &Path, text: &str) -> io::Result<()> {
    write_together(&[(path, text)])
}

/// Write text files through temporary ones in the same folders, and rename these when all are
/// written: an error or an interruption leaves the old files or the new ones, never half of one
/// and nothing temporary.
///
/// # Errors
/// The underlying error, with the path.
pub fn write_together(files: &[(&Path, &str)]) -> io::Result<()> {
    let _writing = uninterrupted();
    let staged = files.iter().map(|(path, text)| Ok((stage(path, text)?, path)));
    for (file, path) in staged.collect::<io::Result<Vec<_>>>()? {
        file.persist(path).map_err(|e| named(path, e.error))?;
    }
    Ok(())
}

/// A temporary file beside `path` with the whole text; it is removed when it is dropped.
fn stage(path: &Path, text: &str) -> io::Result<NamedTempFile> {
    let folder = match path.parent() {
        Some(p) if !p.as_os_str().is_empty() => p,
        _ => Path::new("."),
    };
    std::fs::create_dir_all(folder).map_err(|e| named(path, e))?;
    let mut builder = tempfile::Builder::new();
    builder.suffix(".tmp");
    // Temporary files are private by default; a result is for all whom the umask allows.
    #[cfg(unix)]
    builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666));
    let mut file = builder.tempfile_in(folder).map_err(|e| named(path, e))?;
    file.write_all(text.as_bytes()).map_err(|e| named(path, e))?;
    Ok(file)
}

fn named(path: &Path, error: io::Error) -> io::Error {
    io::Error::new(error.kind(), format!("{}: {error}", path.display()))
}

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

/// Whether standard output wants colour.
#[must_use]
pub fn colour() -> bool {
    io::stdout().is_terminal() && std::env::var_os("NO_COLOR").is_none()
}
