//! Recordings of the formats that are no text; the first line is the name's ending and the part (`mat#rows=1..7`).

use super::{file, told};
use lacuna::recordings::{RecordingSource, Wanted, read_log};

const ENDINGS: [&str; 3] = ["mat", "mcap", "parquet"];

/// What cannot be read is told.
pub fn survive(data: &[u8]) {
    let end = data.iter().position(|b| *b == b'\n').unwrap_or(0);
    let (first, bytes) = data.split_at(end);
    let first = String::from_utf8_lossy(first);
    let (ending, part) = first.split_at(first.find('#').unwrap_or(first.len()));
    if !ENDINGS.contains(&ending) {
        return;
    }
    let path = file(&format!("run.{ending}"), bytes.get(1..).unwrap_or(&[]));
    let Ok(source) = format!("{}{part}", path.display()).parse::<RecordingSource>() else { return };
    for wanted in [Wanted::all("t"), Wanted::only("t", ["q".to_owned()])] {
        told(read_log(&source, &wanted).map(|log| log.recording));
    }
}
