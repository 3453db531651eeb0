//! Recordings as CSV: a header line, then one row per time.
//!
//! Cells are separated by commas, semicolons or tabs (found from the header line). Lines
//! that begin with `#` and blank lines are skipped; a byte-order mark, CRLF line ends
//! and quoted cells are understood. Empty cells, `nan`, `NA` and `N/A` are missing samples.

use std::fs;
use std::io::{self, Write};
use std::path::Path;

use lacuna_units::names::nearest;

use crate::error::RecordingError;
use crate::kinds::{Kind, kind};
use crate::log::{Log, Wanted};
use crate::reader::Reader;
use crate::recording::{Column, Recording};
use crate::source::{RecordingSource, Selection};

/// Longest piece of a bad cell that an error message repeats, in characters.
const LONGEST_QUOTE: usize = 40;

/// Bytes by which UTF-16 is told from binary data.
const WIDE_HEAD: usize = 16;

/// Name of the time column where the writer is told none.
const DEFAULT_TIME_COLUMN: &str = "t";

/// Reads CSV. Errors: no header, ragged row, cell that is not a number in a column that is wanted, time
/// missing or not increasing, each with its line.
pub struct Csv;

impl Reader for Csv {
    fn format(&self) -> &'static str {
        "CSV"
    }

    fn extensions(&self) -> &'static [&'static str] {
        &["csv", "tsv", "txt", "dat", ""]
    }

    /// A table of text begins like any other text: only its name tells.
    fn recognises(&self, _head: &[u8]) -> bool {
        false
    }

    /// All columns of numbers are kept: the text of each has to be looked at anyway.
    fn read(&self, source: &RecordingSource, wanted: &Wanted) -> Result<Log, RecordingError> {
        let bytes = fs::read(&source.path).map_err(|error| RecordingError::Unreadable {
            path: source.path.clone(),
            source: error,
        })?;
        read_bytes(&bytes, source, wanted).map(Into::into)
    }
}

/// The whole of a file's bytes as a recording.
fn read_bytes(
    bytes: &[u8],
    source: &RecordingSource,
    wanted: &Wanted,
) -> Result<Recording, RecordingError> {
    let file = source.path.display().to_string();
    let text = text_of(bytes, &file)?;
    let mut table = Table::open(text, file)?;
    let time_index = table.time_index(&wanted.time)?;
    let columns = table.read_rows(time_index, wanted, &source.selection)?;
    Ok(into_recording(source.name(), table.names, columns, time_index))
}

/// The columns that there are, time apart.
fn into_recording(
    name: String,
    names: Vec<String>,
    mut columns: Vec<Option<Vec<f64>>>,
    time_index: usize,
) -> Recording {
    let time = columns[time_index].take().unwrap_or_default();
    let column =
        |(name, values): (String, Option<Vec<f64>>)| Some(Column { name, values: values? });
    let columns = names.into_iter().zip(columns).filter_map(column).collect();
    Recording { name, time, columns }
}

/// The bytes as text, without a byte-order mark, if they can be a table at all.
fn text_of<'a>(bytes: &'a [u8], file: &str) -> Result<&'a str, RecordingError> {
    let bytes = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
    let not_csv = |found, advice| RecordingError::NotCsv { file: file.into(), found, advice };
    if let Some(Kind { found, advice, .. }) = kind(bytes) {
        return Err(not_csv(found, advice));
    }
    if is_wide(bytes) {
        return Err(not_csv("UTF-16 text", "save it as UTF-8"));
    }
    if bytes.contains(&0) {
        return Err(not_csv("binary data", "export the recording as CSV text"));
    }
    str::from_utf8(bytes).map_err(|error| RecordingError::NotUtf8 {
        file: file.into(),
        line: 1 + line_ends(&bytes[..error.valid_up_to()]),
    })
}

/// UTF-16 without a byte-order mark: of the pairs of bytes that it begins with, one half is zero.
fn is_wide(bytes: &[u8]) -> bool {
    let (pairs, _) = bytes[..bytes.len().min(WIDE_HEAD)].as_chunks::<2>();
    let zero_at = |side: usize| pairs.iter().all(|pair| pair[side] == 0 && pair[1 - side] != 0);
    !pairs.is_empty() && (zero_at(0) || zero_at(1))
}

/// A table whose header line has been read.
struct Table<'a> {
    text: &'a str,
    file: String,
    reader: ::csv::Reader<&'a [u8]>,
    names: Vec<String>,
}

impl<'a> Table<'a> {
    fn open(text: &'a str, file: String) -> Result<Self, RecordingError> {
        let header = text.lines().find(|line| !is_skipped(line)).unwrap_or_default();
        let reader = ::csv::ReaderBuilder::new()
            .delimiter(delimiter(header))
            .comment(Some(b'#'))
            .has_headers(false)
            .flexible(true)
            .from_reader(text.as_bytes());
        let mut table = Self { text, file, reader, names: Vec::new() };
        table.read_header()?;
        Ok(table)
    }

    fn read_header(&mut self) -> Result<(), RecordingError> {
        let mut record = ::csv::StringRecord::new();
        let Some(line) = self.next(&mut record)? else {
            return Err(RecordingError::Empty { file: self.file.clone() });
        };
        let names: Vec<String> = record.iter().map(|name| name.trim().to_owned()).collect();
        let file = self.file.clone();
        if names.iter().all(|name| name.parse::<f64>().is_ok()) {
            return Err(RecordingError::NoHeader {
                file,
                line: line.number(),
                found: quoted(&names.join(", ")),
            });
        }
        if let Some(column) = first_repeated(&names) {
            return Err(RecordingError::DuplicateColumn { file, line: line.number(), column });
        }
        self.names = names;
        Ok(())
    }

    fn time_index(&self, wanted: &str) -> Result<usize, RecordingError> {
        self.names.iter().position(|name| name == wanted).ok_or_else(|| {
            RecordingError::NoTimeColumn {
                file: self.file.clone(),
                wanted: wanted.into(),
                separated: ", separated by a comma, semicolon or tab,",
                available: self.names.clone(),
                suggestion: nearest(wanted, self.names.iter().map(String::as_str)).map(Into::into),
            }
        })
    }

    /// The next record that is not blank, and where it stands.
    fn next(
        &mut self,
        record: &mut ::csv::StringRecord,
    ) -> Result<Option<Place<'a>>, RecordingError> {
        loop {
            let before = Place { text: self.text, byte: self.reader.position().byte() as usize };
            match self.reader.read_record(record) {
                Ok(false) => return Ok(None),
                // A line of spaces is one blank cell to the reader, and a blank line to people.
                Ok(true) if record.len() == 1 && record[0].trim().is_empty() => {}
                Ok(true) => return Ok(Some(before)),
                Err(error) => return Err(self.unreadable(error)),
            }
        }
    }

    fn unreadable(&self, error: ::csv::Error) -> RecordingError {
        RecordingError::Unreadable { path: self.file.clone().into(), source: error.into() }
    }

    /// All columns of the selected rows; none in the place of what holds something else than numbers and
    /// is not wanted, as the name of a machine.
    fn read_rows(
        &mut self,
        time_index: usize,
        wanted: &Wanted,
        selection: &Selection,
    ) -> Result<Vec<Option<Vec<f64>>>, RecordingError> {
        let mut columns = vec![Some(Vec::new()); self.names.len()];
        let mut times = 0;
        let mut record = ::csv::StringRecord::new();
        let mut rows = 0;
        let mut previous: Option<(Place<'a>, f64)> = None;
        while let Some(place) = self.next(&mut record)? {
            let row = rows;
            rows += 1;
            if !selection.has_row(row) {
                continue;
            }
            self.check_width(&record, place, row)?;
            if row == 0 {
                self.check_numbers(&record, time_index, place)?;
            }
            let time = self.time(&record[time_index], time_index, place)? * wanted.seconds;
            if !selection.has_time(time) {
                continue;
            }
            self.check_order(previous, (place, time))?;
            previous = Some((place, time));
            times += 1;
            for (index, column) in columns.iter_mut().enumerate() {
                let Some(values) = column else { continue };
                if index == time_index {
                    values.push(time);
                    continue;
                }
                match self.number(&record[index], index, place) {
                    Ok(value) => values.push(value),
                    Err(_) if !wanted.keeps(&self.names[index]) => *column = None,
                    Err(error) => return Err(error),
                }
            }
        }
        self.check_selection(selection, rows, times)?;
        Ok(columns)
    }

    fn check_width(
        &self,
        record: &::csv::StringRecord,
        place: Place,
        rows: usize,
    ) -> Result<(), RecordingError> {
        let (expected, found) = (self.names.len(), record.len());
        if found == expected {
            return Ok(());
        }
        let (file, line) = (self.file.clone(), place.number());
        let at_end = self.reader.position().byte() as usize == self.text.len();
        if found < expected && rows > 0 && at_end && !self.text.ends_with(['\n', '\r']) {
            return Err(RecordingError::CutRow { file, line, expected, found, rows });
        }
        Err(RecordingError::RaggedRow { file, line, expected, found })
    }

    /// That the first row is no row of units; one without a dimension may be called 1.
    fn check_numbers(
        &self,
        record: &::csv::StringRecord,
        time_index: usize,
        place: Place,
    ) -> Result<(), RecordingError> {
        let begins_number = |first: char| first.is_ascii_digit() || "+-.".contains(first);
        let is_word = |cell: &str| !cell.starts_with(begins_number);
        let time = record[time_index].trim();
        let no_number = record.iter().map(str::trim).all(|cell| cell == "1" || is_word(cell));
        if is_missing(time) || !is_word(time) || !no_number {
            return Ok(());
        }
        Err(RecordingError::WordsForNumbers {
            file: self.file.clone(),
            line: place.number(),
            found: quoted(&record.iter().collect::<Vec<_>>().join(", ")),
        })
    }

    fn check_order(
        &self,
        previous: Option<(Place, f64)>,
        (place, later): (Place, f64),
    ) -> Result<(), RecordingError> {
        match previous {
            Some((before, earlier)) if later <= earlier => Err(RecordingError::TimeNotIncreasing {
                file: self.file.clone(),
                earlier_line: before.number(),
                earlier,
                line: place.number(),
                later,
            }),
            _ => Ok(()),
        }
    }

    fn check_selection(
        &self,
        selection: &Selection,
        rows: usize,
        selected: usize,
    ) -> Result<(), RecordingError> {
        let (file, selection) = (self.file.clone(), *selection);
        if rows == 0 {
            let line = Place { text: self.text, byte: 0 }.number();
            return Err(RecordingError::HeaderOnly { file, line });
        }
        match selection {
            Selection::Rows { to: Some(to), .. } if to > rows => {
                Err(RecordingError::SelectionBeyondEnd { file, selection, rows })
            }
            _ if selected == 0 => Err(RecordingError::EmptySelection { file, selection, rows }),
            _ => Ok(()),
        }
    }

    fn time(&self, cell: &str, index: usize, place: Place) -> Result<f64, RecordingError> {
        if is_clock(cell) {
            return Err(RecordingError::TimeOfDay {
                file: self.file.clone(),
                line: place.number(),
                column: self.names[index].clone(),
                found: quoted(cell.trim()),
            });
        }
        let time = self.number(cell, index, place)?;
        if time.is_nan() {
            return Err(RecordingError::MissingTime {
                file: self.file.clone(),
                line: place.number(),
                column: self.names[index].clone(),
            });
        }
        Ok(time)
    }

    fn number(&self, cell: &str, index: usize, place: Place) -> Result<f64, RecordingError> {
        let cell = cell.trim();
        if is_missing(cell) {
            return Ok(f64::NAN);
        }
        match cell.parse::<f64>() {
            Ok(value) if value.is_finite() => Ok(value),
            _ => Err(RecordingError::NotANumber {
                file: self.file.clone(),
                line: place.number(),
                column: self.names[index].clone(),
                found: quoted(cell),
            }),
        }
    }
}

/// A place in the text; its line number is counted only when an error needs it.
#[derive(Clone, Copy)]
struct Place<'a> {
    text: &'a str,
    byte: usize,
}

impl Place<'_> {
    /// Line, from 1, of the first line at or after this place that is not skipped: the
    /// reader's position before a record lies before the comments that precede it.
    fn number(self) -> usize {
        let (before, after) = self.text.as_bytes().split_at(self.byte);
        let mut line = 1 + line_ends(before);
        let mut rest = after;
        // The reader leaves the second half of a CRLF for the next record.
        if before.ends_with(b"\r") {
            rest = rest.strip_prefix(b"\n").unwrap_or(rest);
        }
        while let Some(end) = rest.iter().position(|&byte| byte == b'\n' || byte == b'\r') {
            if !is_skipped(&String::from_utf8_lossy(&rest[..end])) {
                break;
            }
            let width = if rest[end..].starts_with(b"\r\n") { 2 } else { 1 };
            rest = &rest[end + width..];
            line += 1;
        }
        line
    }
}

/// Number of line ends: LF, CR LF or a lone CR.
fn line_ends(bytes: &[u8]) -> usize {
    let is_end = |index: usize| match bytes[index] {
        b'\n' => index == 0 || bytes[index - 1] != b'\r',
        byte => byte == b'\r',
    };
    (0..bytes.len()).filter(|&index| is_end(index)).count()
}

fn is_skipped(line: &str) -> bool {
    line.trim().is_empty() || line.starts_with('#')
}

/// The separator that occurs most often in the header line, outside quotes.
fn delimiter(header: &str) -> u8 {
    let outside: String = header.split('"').step_by(2).collect();
    let count = |separator: char| outside.matches(separator).count();
    // On a tie the last wins, so the comma stands last.
    *[b'\t', b';', b','].iter().max_by_key(|&&separator| count(separator.into())).unwrap_or(&b',')
}

fn first_repeated(names: &[String]) -> Option<String> {
    let repeated = |(index, name): (usize, &String)| names[..index].contains(name);
    names.iter().enumerate().find(|&entry| repeated(entry)).map(|(_, name)| name.clone())
}

/// Whether a cell tells a date or a time of day: 2026-03-29T01:59:50, 00:00:07.5, 29.03.2026.
fn is_clock(cell: &str) -> bool {
    let parts: Vec<&str> = cell.split(['-', ':', '.', '/', 'T', ' ']).collect();
    let digits = |part: &&str| !part.is_empty() && part.bytes().all(|b| b.is_ascii_digit());
    cell.contains(':') || parts.iter().take_while(|part| digits(part)).count() >= 3
}

fn is_missing(cell: &str) -> bool {
    matches!(cell, "" | "NA" | "N/A")
        || cell.eq_ignore_ascii_case("nan")
        || cell.eq_ignore_ascii_case("-nan")
}

fn quoted(text: &str) -> String {
    match text.char_indices().nth(LONGEST_QUOTE) {
        Some((end, _)) => format!("{}...", &text[..end]),
        None => text.into(),
    }
}

/// Writes `recording` to `path`, its time in a column `t`.
///
/// Numbers are written with as many digits as reading them back exactly needs, missing
/// samples as empty cells. The file appears whole or not at all: it is written beside
/// `path` under another name and renamed.
///
/// # Errors
/// [`RecordingError::Unwritable`], [`RecordingError::ColumnLength`],
/// [`RecordingError::NotWritable`].
pub fn write_csv(path: &Path, recording: &Recording) -> Result<(), RecordingError> {
    write_csv_with_time(path, recording, DEFAULT_TIME_COLUMN)
}

/// [`write_csv`] with the name that the time column shall have.
///
/// # Errors
/// As [`write_csv`].
pub fn write_csv_with_time(
    path: &Path,
    recording: &Recording,
    time_column: &str,
) -> Result<(), RecordingError> {
    check_writable(path, recording, time_column)?;
    let unwritable = |source| RecordingError::Unwritable { path: path.into(), source };
    let text = to_text(recording, time_column).map_err(unwritable)?;
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    let beside = path.with_file_name(format!(".{name}.{}.tmp", std::process::id()));
    let written = write_whole(&beside, &text).and_then(|()| fs::rename(&beside, path));
    if written.is_err() {
        // The failure itself is reported; what is left of the file is of no use.
        let _ = fs::remove_file(&beside);
    }
    written.map_err(unwritable)
}

fn write_whole(path: &Path, text: &[u8]) -> io::Result<()> {
    let mut file = fs::File::create(path)?;
    file.write_all(text)?;
    file.sync_all()
}

fn check_writable(
    path: &Path,
    recording: &Recording,
    time_column: &str,
) -> Result<(), RecordingError> {
    let bad = |column: &str, row, found| RecordingError::NotWritable {
        path: path.into(),
        column: column.into(),
        row,
        found,
    };
    if let Some(row) = recording.time.iter().position(|t| !t.is_finite()) {
        return Err(bad(time_column, row, recording.time[row]));
    }
    for column in &recording.columns {
        if column.values.len() != recording.time.len() {
            return Err(RecordingError::ColumnLength {
                path: path.into(),
                column: column.name.clone(),
                expected: recording.time.len(),
                found: column.values.len(),
            });
        }
        if let Some(row) = column.values.iter().position(|value| value.is_infinite()) {
            return Err(bad(&column.name, row, column.values[row]));
        }
    }
    Ok(())
}

fn to_text(recording: &Recording, time_column: &str) -> io::Result<Vec<u8>> {
    let names = recording.columns.iter().map(|column| column.name.as_str());
    let names: Vec<&str> = std::iter::once(time_column).chain(names).collect();
    // A reader that looks for the separator must not find another one within a name, nor
    // take the header for a comment.
    let misleading = names.iter().any(|name| name.contains([';', '\t', '#']));
    let style = if misleading { ::csv::QuoteStyle::Always } else { ::csv::QuoteStyle::Necessary };
    let mut writer = ::csv::WriterBuilder::new().quote_style(style).from_writer(Vec::new());
    writer.write_record(names)?;
    let text = writer.into_inner().map_err(|error| error.into_error())?;
    let mut writer = ::csv::Writer::from_writer(text);
    for (row, &time) in recording.time.iter().enumerate() {
        let values = recording.columns.iter().map(|column| column.values[row]);
        writer.write_record(std::iter::once(time).chain(values).map(cell))?;
    }
    writer.into_inner().map_err(|error| error.into_error())
}

/// The shortest text that reads back as the same number.
fn cell(value: f64) -> String {
    match value.abs() {
        _ if value.is_nan() => String::new(),
        size if size != 0.0 && !(1e-5..1e15).contains(&size) => format!("{value:e}"),
        _ => format!("{value}"),
    }
}
