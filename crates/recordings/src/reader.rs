//! Files of recordings, whatever their format: one reader a format, chosen by the file.

use std::fs::File;
use std::io::Read;
use std::path::Path;

use crate::csv::Csv;
use crate::error::RecordingError;
use crate::kinds::kind;
use crate::log::{Log, Wanted};
use crate::mat::Mat;
use crate::mcap::Mcap;
use crate::parquet::Parquet;
use crate::recording::Recording;
use crate::source::RecordingSource;

/// A format that recordings are kept in. A new one is a file with its reader and a line in
/// [`READERS`].
pub trait Reader: Sync {
    /// Name of the format.
    fn format(&self) -> &'static str;

    /// Extensions of its files' names, in lower case; `""` for names without one.
    fn extensions(&self) -> &'static [&'static str];

    /// Whether a file that begins with these bytes (up to 512) is of this format, whatever its
    /// name.
    fn recognises(&self, head: &[u8]) -> bool;

    /// Reads the rows of `source` and of its columns at least those that are wanted.
    ///
    /// Rows outside the selection are not looked at, so a selection can pick one run out of a
    /// file in which several were joined.
    ///
    /// # Errors
    /// A [`RecordingError`] that says where and what to do.
    fn read(&self, source: &RecordingSource, wanted: &Wanted) -> Result<Log, RecordingError>;
}

/// All readers.
pub static READERS: &[&dyn Reader] = &[&Csv, &Parquet, &Mcap, &Mat];

/// Bytes of a file that its reader may be recognised by.
const HEAD: u64 = 512;

/// Reads the rows of `source` with the reader whose file it is: by the extension of its name,
/// else by its first bytes. `time_column` names the column of times, in seconds.
///
/// # Errors
/// [`RecordingError::UnknownFormat`] lists the formats that are read; otherwise what
/// [`Reader::read`] says.
pub fn read(source: &RecordingSource, time_column: &str) -> Result<Recording, RecordingError> {
    Ok(read_log(source, &Wanted::all(time_column))?.recording)
}

/// The same of the columns that are wanted, with what else is said of the file.
///
/// # Errors
/// As [`read`]. Of a file of which columns were left out, [`RecordingError::NoSuchColumn`] where one is not
/// there that is needed, and [`RecordingError::NothingMeasured`]; where all are kept, who uses them tells.
pub fn read_log(source: &RecordingSource, wanted: &Wanted) -> Result<Log, RecordingError> {
    let log = choose(READERS, &source.path)?.read(source, wanted)?;
    if !log.others.is_empty() {
        let kept = log.recording.columns.iter().map(|c| &c.name);
        let names: Vec<&str> = kept.chain(&log.others).map(String::as_str).collect();
        wanted.check(&log.recording.name, &names)?;
    }
    Ok(log)
}

fn choose<'r>(readers: &[&'r dyn Reader], path: &Path) -> Result<&'r dyn Reader, RecordingError> {
    let extension =
        path.extension().map_or_else(String::new, |e| e.to_string_lossy().to_lowercase());
    let named = |reader: &&&dyn Reader| reader.extensions().contains(&&*extension);
    if let Some(reader) = readers.iter().find(named) {
        return Ok(*reader);
    }
    let head = head(path)?;
    if let Some(reader) = readers.iter().find(|reader| reader.recognises(&head)) {
        return Ok(*reader);
    }
    Err(RecordingError::UnknownFormat {
        file: path.display().to_string(),
        extension,
        found: kind(&head).map(|kind| (kind.found, kind.advice)),
        known: readers.iter().map(|reader| in_words(*reader)).collect(),
    })
}

/// A file that is there to be read, and how many bytes it has.
pub(crate) fn open(path: &Path) -> Result<(File, u64), RecordingError> {
    let opened = File::open(path).and_then(|file| Ok((file.metadata()?.len(), file)));
    let (bytes, file) =
        opened.map_err(|source| RecordingError::Unreadable { path: path.into(), source })?;
    Ok((file, bytes))
}

fn head(path: &Path) -> Result<Vec<u8>, RecordingError> {
    let mut head = Vec::new();
    let read = File::open(path).and_then(|file| file.take(HEAD).read_to_end(&mut head));
    read.map_err(|source| RecordingError::Unreadable { path: path.into(), source })?;
    Ok(head)
}

/// A format and the extensions that belong to it.
fn in_words(reader: &dyn Reader) -> String {
    let extension = |e: &&str| if e.is_empty() { "none".into() } else { format!(".{e}") };
    let extensions: Vec<String> = reader.extensions().iter().map(extension).collect();
    format!("{} ({})", reader.format(), extensions.join(", "))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A format with magic bytes.
    struct Tape;

    impl Reader for Tape {
        fn format(&self) -> &'static str {
            "tape"
        }

        fn extensions(&self) -> &'static [&'static str] {
            &["tape"]
        }

        fn recognises(&self, head: &[u8]) -> bool {
            head.starts_with(b"TAPE")
        }

        fn read(&self, source: &RecordingSource, _: &Wanted) -> Result<Log, RecordingError> {
            Ok(Recording { name: source.name(), time: vec![], columns: vec![] }.into())
        }
    }

    #[test]
    fn the_name_chooses_the_reader_and_the_first_bytes_where_it_does_not() {
        let folder = tempfile::tempdir().unwrap();
        let chosen = |name: &str, bytes: &[u8]| {
            let path = folder.path().join(name);
            std::fs::write(&path, bytes).unwrap();
            choose(&[&Csv, &Tape], &path).map(Reader::format)
        };
        for name in ["run.csv", "RUN.CSV", "run.tsv", "run.txt", "run.dat", "run"] {
            assert_eq!(chosen(name, b"t,x").unwrap(), "CSV", "{name}");
        }
        assert_eq!(chosen("run.tape", b"").unwrap(), "tape");
        assert_eq!(chosen("run.bin", b"TAPE 1").unwrap(), "tape");
        assert_eq!(chosen("run.csv", b"TAPE 1").unwrap(), "CSV");
        let said = chosen("run.bin", b"t,x").unwrap_err().to_string();
        assert!(
            said.ends_with(
                "run.bin: no reader for .bin files; formats that are read: \
             CSV (.csv, .tsv, .txt, .dat, none), tape (.tape)"
            ),
            "{said}"
        );
        let said = chosen("run.bin", b"ULog\x01").unwrap_err().to_string();
        assert!(said.contains("it looks like a PX4 log; convert it with ulog2csv"), "{said}");
        let absent = choose(&[&Csv], &folder.path().join("absent.bin")).map(Reader::format);
        assert!(matches!(absent, Err(RecordingError::Unreadable { .. })));
    }
}
