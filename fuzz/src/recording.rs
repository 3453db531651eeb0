//! Recordings, whole and in part; the first line is the part (`#rows=1..7`), or empty.

use super::{file, told};
use lacuna::recordings::{RecordingSource, read};

/// What cannot be read is told.
pub fn survive(data: &[u8]) {
    let end = data.iter().position(|b| *b == b'\n').unwrap_or(0);
    let (part, bytes) = data.split_at(end);
    let path = file("recording.csv", bytes.get(1..).unwrap_or(&[]));
    let wanted = format!("{}{}", path.display(), String::from_utf8_lossy(part));
    let Ok(source) = wanted.parse::<RecordingSource>() else { return };
    told(read(&source, "t"));
}
