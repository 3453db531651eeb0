//! The archive that an FMU is, unpacked with distrust: nothing is written outside of the folder it
//! is unpacked into, and no more than is declared, which is bounded.

use crate::FmuError;
use std::fs::File;
use std::io::{BufReader, Read, Write};
use std::path::{Component, Path};
use zip::ZipArchive;

/// Entries, bytes of all that is unpacked, bytes of the description.
const MOST_ENTRIES: usize = 100_000;
const MOST_BYTES: u64 = 2 << 30;
const MOST_DESCRIPTION: u64 = 64 << 20;

/// What an FMU must hold.
pub(crate) const DESCRIPTION: &str = "modelDescription.xml";

/// An opened archive whose entries all stay within it.
pub(crate) struct Archive {
    zip: ZipArchive<BufReader<File>>,
    names: Vec<String>,
}

impl Archive {
    pub(crate) fn open(path: &Path) -> Result<Self, FmuError> {
        let file = File::open(path).map_err(FmuError::io)?;
        let mut zip = ZipArchive::new(BufReader::new(file)).map_err(no_archive)?;
        if zip.len() > MOST_ENTRIES {
            let (found, limit) = (zip.len().to_string(), MOST_ENTRIES.to_string());
            return Err(FmuError::TooLarge { what: "entries, a number".to_owned(), found, limit });
        }
        let (mut names, mut total) = (vec![], 0u64);
        for k in 0..zip.len() {
            let entry = zip.by_index_raw(k).map_err(no_archive)?;
            let name = entry.name().map_err(no_archive)?.into_owned();
            check_name(&name)?;
            if entry.is_symlink() {
                return Err(FmuError::Escapes { entry: name, what: "a link" });
            }
            total = total.saturating_add(entry.size());
            names.push(name);
        }
        bounded("entries", total, MOST_BYTES)?;
        Ok(Self { zip, names })
    }

    /// The text of the description.
    pub(crate) fn description(&mut self) -> Result<String, FmuError> {
        if !self.names.iter().any(|n| n == DESCRIPTION) {
            let instead = match self.names.first() {
                Some(first) => format!(": the archive begins with '{first}'"),
                None => ": the archive is empty".to_owned(),
            };
            return Err(FmuError::Missing { missing: DESCRIPTION.to_owned(), instead });
        }
        let mut entry = self.zip.by_name(DESCRIPTION).map_err(no_archive)?;
        let declared = entry.size();
        bounded(DESCRIPTION, declared, MOST_DESCRIPTION)?;
        let mut bytes = vec![];
        copy(&mut entry, &mut bytes, DESCRIPTION, declared)?;
        String::from_utf8(bytes).map_err(|_| FmuError::Description {
            line: None,
            message: "this is no text in UTF-8".to_owned(),
        })
    }

    /// Names that begin so.
    pub(crate) fn within<'a>(&'a self, begin: &'a str) -> impl Iterator<Item = &'a str> {
        self.names.iter().map(String::as_str).filter(move |n| n.starts_with(begin))
    }

    /// Unpack all entries whose names begin with one of these.
    pub(crate) fn unpack(&mut self, begins: &[&str], into: &Path) -> Result<(), FmuError> {
        for k in 0..self.names.len() {
            let name = &self.names[k];
            if name.ends_with('/') || !begins.iter().any(|begin| name.starts_with(begin)) {
                continue;
            }
            let to = into.join(name);
            if let Some(folder) = to.parent() {
                std::fs::create_dir_all(folder).map_err(FmuError::io)?;
            }
            let mut entry = self.zip.by_index(k).map_err(no_archive)?;
            let declared = entry.size();
            let mut file = File::create(to).map_err(FmuError::io)?;
            copy(&mut entry, &mut file, name, declared)?;
        }
        Ok(())
    }
}

/// Copy as much as is declared, and nothing where there is more or less.
fn copy(
    from: &mut impl Read,
    to: &mut impl Write,
    name: &str,
    declared: u64,
) -> Result<(), FmuError> {
    let disguised = || FmuError::Disguised { entry: name.to_owned(), declared };
    match std::io::copy(&mut from.take(declared.saturating_add(1)), to) {
        Ok(copied) if copied == declared => Ok(()),
        Ok(_) => Err(disguised()),
        Err(error) if error.kind() == std::io::ErrorKind::InvalidData => Err(disguised()),
        Err(error) => Err(FmuError::io(error)),
    }
}

/// A name that leads outside, or means another place on another system.
fn check_name(name: &str) -> Result<(), FmuError> {
    let escapes = |what| Err(FmuError::Escapes { entry: name.to_owned(), what });
    if name.contains(['\\', '\0', ':']) {
        return escapes("a name that is none in an archive");
    }
    for component in Path::new(name).components() {
        match component {
            Component::Normal(_) | Component::CurDir => {}
            Component::ParentDir => return escapes("a path that leads outside"),
            Component::RootDir | Component::Prefix(_) => return escapes("an absolute path"),
        }
    }
    Ok(())
}

fn bounded(what: &str, found: u64, limit: u64) -> Result<(), FmuError> {
    let mib = |bytes: u64| format!("{} MiB", bytes.div_ceil(1 << 20));
    if found <= limit {
        return Ok(());
    }
    Err(FmuError::TooLarge { what: what.to_owned(), found: mib(found), limit: mib(limit) })
}

fn no_archive(error: zip::result::ZipError) -> FmuError {
    FmuError::NoArchive { reason: error.to_string() }
}
