//! Files that are written whole or not at all.

use std::io::{self, Write};
use std::path::Path;
use std::sync::{Mutex, MutexGuard, PoisonError};
use tempfile::NamedTempFile;

/// Held while files are written: whoever interrupts waits for it, so that a set of files is there
/// whole or not at all, without temporary ones beside it.
static WRITING: Mutex<()> = Mutex::new(());

/// Not to be interrupted until this is dropped. Not to be asked for twice by one thread.
pub fn uninterrupted() -> MutexGuard<'static, ()> {
    WRITING.lock().unwrap_or_else(PoisonError::into_inner)
}

/// That a folder for results is one, or can be made: asked before they are computed, which may take long.
///
/// # Errors
/// The folder, and what is a file on the way to it.
pub fn check_folder(folder: &Path) -> io::Result<()> {
    match folder.ancestors().find(|path| path.exists()) {
        Some(there) if !there.is_dir() => {
            let (folder, there) = (folder.display(), there.display());
            let text = format!("cannot write to the folder {folder}: {there} is a file");
            Err(io::Error::new(io::ErrorKind::NotADirectory, text))
        }
        _ => Ok(()),
    }
}

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
