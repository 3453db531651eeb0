//! Reading and writing CSV: what is tolerated, what is refused and how it is said.

use std::fs;

use lacuna_recordings::{
    Column, Recording, RecordingError, RecordingSource, Wanted, read_log, write_csv,
    write_csv_with_time,
};
use proptest::prelude::*;
use tempfile::TempDir;

/// Reads `bytes` as the file run.csv, with an optional selection.
fn read(bytes: impl AsRef<[u8]>, selection: &str) -> Result<Recording, RecordingError> {
    let folder = TempDir::new().unwrap();
    let path = folder.path().join("run.csv");
    fs::write(&path, bytes).unwrap();
    let source: RecordingSource = format!("{}{selection}", path.display()).parse().unwrap();
    lacuna_recordings::read(&source, "t")
}

/// The error message, without the folder.
fn said(bytes: impl AsRef<[u8]>, selection: &str) -> String {
    let message = read(bytes, selection).unwrap_err().to_string();
    let start = message.find('/').unwrap();
    let end = message.find("run.csv").unwrap();
    format!("{}{}", &message[..start], &message[end..])
}

#[test]
fn the_usual_shapes_of_csv_are_read() {
    let expected = read("t,x,u\n0,1,2\n0.5,3,4\n", "").unwrap();
    assert_eq!(expected.name, "run.csv");
    assert_eq!(expected.time, [0.0, 0.5]);
    assert_eq!(expected.column("x").unwrap(), [1.0, 3.0]);
    assert_eq!(expected.column("u").unwrap(), [2.0, 4.0]);
    for text in [
        "t;x;u\n0;1;2\n0.5;3;4",
        "t\tx\tu\r\n0\t1\t2\r\n0.5\t3\t4\r\n",
        "\u{feff}t,x,u\n0,1,2\n0.5,3,4\n",
        "# made by hand\n\n \"t\" , x,u\n# first row\n0, 1 ,2\n\n   \n+5e-1,\"3\",4.0\n\n",
        "t,x,u\r0,1,2\r0.5,3,4\r",
    ] {
        assert_eq!(read(text.replace(" \"t\"", "\"t\""), "").unwrap(), expected, "{text:?}");
    }
    let quoted = read("\"t\";\"angle, load; side\"\n0;1\n", "").unwrap();
    assert_eq!(quoted.columns[0].name, "angle, load; side");
}

#[test]
fn missing_samples_become_nan() {
    let recording = read("t,x\n0,\n1,nan\n2,NaN\n3,NA\n4,N/A\n5,7\n", "").unwrap();
    let x = recording.column("x").unwrap();
    assert!(x[..5].iter().all(|value| value.is_nan()));
    assert_eq!(x[5], 7.0);
}

#[test]
fn text_that_nobody_wants_is_no_obstacle() {
    let folder = TempDir::new().unwrap();
    let source = RecordingSource::file(folder.path().join("run.csv"));
    fs::write(&source.path, "machine,t,x,n\n,0,1,5\nA1,1,2,6\nB2,2,3,7\n").unwrap();
    let wanted = Wanted::only("t", ["x".to_owned()]);
    let recording = read_log(&source, &wanted).unwrap().recording;
    let names: Vec<&str> = recording.columns.iter().map(|c| &*c.name).collect();
    assert_eq!((names, &recording.time[..]), (vec!["x", "n"], &[0.0, 1.0, 2.0][..]));
    assert_eq!(recording.column("x").unwrap(), [1.0, 2.0, 3.0]);
    for needed in ["machine", "x"] {
        let wanted = Wanted::only("t", [needed.to_owned()]);
        let said = read_log(&source, &wanted).map_err(|e| e.to_string());
        let told = said.as_ref().is_err_and(|e| e.contains("line 3, column 'machine'"));
        assert_eq!(told, needed == "machine", "{said:?}");
    }
}

#[test]
fn dates_for_seconds_are_told() {
    for time in ["2026-03-29T01:59:50.010", "29.03.2026 01:59:50", "00:00:07.5", "03/29/2026"] {
        let said = said(format!("t,x\n{time},1\n"), "");
        let start = "run.csv, line 2, column 't': expected a time as a number of seconds, found '";
        assert!(said.starts_with(&format!("{start}{time}'")), "{said}");
    }
    for time in ["-1.5e-3", "1.77e9", "12.5", "-7"] {
        read(format!("t,x\n{time},1\n"), "").unwrap();
    }
}

#[test]
fn selections_pick_rows_and_times() {
    let text = "t,x\n0,10\n1,11\n# pause\n2,12\n3,13\n";
    let picked = |selection: &str| read(text, selection).unwrap().columns[0].values.clone();
    assert_eq!(picked("#rows=1..3"), [11.0, 12.0]);
    assert_eq!(picked("#rows=..1"), [10.0]);
    assert_eq!(picked("#rows=3.."), [13.0]);
    assert_eq!(picked("#t=1..3"), [11.0, 12.0]);
    assert_eq!(picked("#t=0.5.."), [11.0, 12.0, 13.0]);
    assert_eq!(read(text, "#rows=1..3").unwrap().name, "run.csv#rows=1..3");
    assert_eq!(
        said(text, "#rows=1..5"),
        "run.csv has 4 rows, fewer than the selection #rows=1..5 asks for"
    );
    assert_eq!(
        said(text, "#t=7.."),
        "run.csv: the selection #t=7.. holds none of the 4 rows; widen it"
    );
    // One run out of two that were joined.
    let joined = "t,x\n0,1\n1,2\n0,3\n1,4\n";
    assert_eq!(read(joined, "#rows=2..4").unwrap().columns[0].values, [3.0, 4.0]);
}

#[test]
fn errors_say_where_and_what() {
    for (text, message) in [
        (
            "# c\n\nt,x\n# c\n0,1\n\n# c\n1,1.5e\n",
            "run.csv, line 8, column 'x': expected a number, found '1.5e'; numbers are written \
             with a decimal point, a missing value as an empty cell, nan, NA or N/A",
        ),
        (
            "t,x\r\n0,1\r\n\r\n1,2,3\r\n",
            "run.csv, line 4: expected 2 cells as in the header, found 3; a missing value is \
             written as an empty cell",
        ),
        (
            "t,x\n0,1\n1,2\n1,3\n",
            "run.csv: time does not increase: 1 s on line 3, then 1 s on line 4; remove repeated \
             rows, and split runs that were joined into one file each (or select one with \
             #rows=FROM..TO)",
        ),
        (
            "t,x\n0,1\n,2\n",
            "run.csv, line 3: the time column 't' is empty here; every row needs a time, remove \
             rows without one",
        ),
        (
            "time,x\n0,1\n",
            "run.csv has no time column 't' (did you mean 'time'?); its columns, separated by a \
             comma, semicolon or tab, are: time, x; the model's [recordings] section names the \
             time column",
        ),
        (
            "stamp,x\n0,1\n",
            "run.csv has no time column 't'; its columns, separated by a comma, semicolon or \
             tab, are: stamp, x; the model's [recordings] section names the time column",
        ),
        ("t,x,x\n0,1,2\n", "run.csv, line 1: two columns are named 'x'; give each its own name"),
        (
            "# a\n0,1,2\n1,2,3\n",
            "run.csv, line 2: expected a header line with column names, found numbers (0, 1, 2); \
             write the names above the first row (without a leading #)",
        ),
        (
            "#a\n t,x\n\n",
            "run.csv has a header line (line 2) but no rows; was the recording interrupted?",
        ),
        (
            " \n# only\n",
            "run.csv is empty: a header line with the column names and at least one row of \
             numbers are needed",
        ),
        (
            "t,x\n0,inf\n",
            "run.csv, line 2, column 'x': expected a number, found 'inf'; numbers are written \
             with a decimal point, a missing value as an empty cell, nan, NA or N/A",
        ),
    ] {
        assert_eq!(said(text, ""), message);
    }
    let latin = read(b"t,x\n0,1\n1,\xb5\n", "").unwrap_err();
    assert!(matches!(latin, RecordingError::NotUtf8 { line: 3, .. }));
    let absent =
        lacuna_recordings::read(&RecordingSource::file("/nowhere/run.csv"), "t").unwrap_err();
    assert!(matches!(absent, RecordingError::Unreadable { .. }));
    assert!(absent.to_string().starts_with("cannot read /nowhere/run.csv: "));
}

#[test]
fn files_of_another_kind_are_recognised() {
    for (bytes, kind) in [
        (&b"PK\x03\x04\x14\x00"[..], "a spreadsheet"),
        (b"PAR1\x15\x04", "a Parquet file"),
        (b"\n<!DOCTYPE html>\n<html>", "an HTML"),
        (b"{\"t\": [0, 1]}", "JSON"),
        (b"\xff\xfet\x00,\x00", "UTF-16"),
        (b"\x1f\x8b\x08\x00", "gzip"),
        (b"t,x\n0,\x00\x00\x01\n", "binary data"),
    ] {
        let error = read(bytes, "").unwrap_err();
        let RecordingError::NotCsv { found, .. } = &error else { panic!("{error}") };
        assert!(found.starts_with(kind), "{error}");
    }
}

#[test]
fn what_other_programs_write_is_read_or_told() {
    for (text, message) in [
        ("t;x\n0,0;1,5\n0,1;1,6\n", "run.csv, line 2, column 't': expected a number"),
        ("t,x\n0,1,5\n", "run.csv, line 2: expected 2 cells as in the header, found 3"),
        (
            "t,x,n\n[s],mm/s,1\n0,1,2\n",
            "run.csv, line 2: expected the first row of numbers, found words ([s], mm/s, 1); if \
             they are units, put a # in front of the line and state them in the model",
        ),
        (
            "t,x\n0,1\n# pause\n0.5,3\n1.",
            "run.csv, line 5: the file ends within this row, after 1 of 2 cells; was the recording \
             interrupted? Remove the row, or select those before it with #rows=0..2",
        ),
        ("t,x\n0,1\n1.\n", "run.csv, line 3: expected 2 cells as in the header, found 1"),
    ] {
        let said = said(text, "");
        assert!(said.starts_with(message), "{said}");
    }
    let before_the_cut = read("t,x\n0,1\n0.5,3\n1.", "#rows=0..2").unwrap();
    assert_eq!(before_the_cut.time, [0.0, 0.5]);
    let commented = read("t,x\n# s,mm\n0,1\n", "").unwrap();
    assert_eq!(commented.time, [0.0]);
    for encode in [u16::to_le_bytes, u16::to_be_bytes] {
        let wide: Vec<u8> = "t,x\n0,1\n".encode_utf16().flat_map(encode).collect();
        let error = read(wide, "").unwrap_err();
        assert!(matches!(error, RecordingError::NotCsv { found: "UTF-16 text", .. }), "{error}");
    }
}

#[test]
fn a_table_of_two_thousand_columns_is_read() {
    let cells = |name: &dyn Fn(usize) -> String| (1..=2000).map(name).collect::<Vec<_>>().join(",");
    let header = cells(&|k| format!("c{k}"));
    let row = cells(&|k| k.to_string());
    let wide = read(format!("t,{header}\n0,{row}\n1,{row}\n"), "").unwrap();
    assert_eq!(wide.columns.len(), 2000);
    assert_eq!(wide.column("c1999").unwrap(), [1999.0, 1999.0]);
}

#[test]
fn writing_refuses_what_no_reader_would_take() {
    let folder = TempDir::new().unwrap();
    let path = folder.path().join("out.csv");
    let column = |values: Vec<f64>| vec![Column { name: "x".into(), values }];
    let write = |time: Vec<f64>, columns| {
        write_csv(&path, &Recording { name: String::new(), time, columns })
    };
    let diverged = write(vec![0.0, 1.0], column(vec![0.0, f64::INFINITY]));
    assert!(matches!(diverged, Err(RecordingError::NotWritable { row: 1, .. })));
    let timeless = write(vec![f64::NAN], column(vec![0.0]));
    assert!(matches!(timeless, Err(RecordingError::NotWritable { row: 0, .. })));
    let short = write(vec![0.0, 1.0], column(vec![0.0]));
    assert!(matches!(short, Err(RecordingError::ColumnLength { expected: 2, found: 1, .. })));
    let nowhere = folder.path().join("absent/out.csv");
    let empty = Recording { name: String::new(), time: vec![0.0], columns: vec![] };
    assert!(matches!(write_csv(&nowhere, &empty), Err(RecordingError::Unwritable { .. })));
    // Not even a temporary file is left behind.
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 0);
}

fn number() -> impl Strategy<Value = f64> {
    prop_oneof![
        4 => any::<f64>().prop_filter("finite", |value| value.is_finite()),
        4 => -1e3f64..1e3,
        1 => Just(f64::NAN),
        1 => Just(-0.0),
    ]
}

fn recording() -> impl Strategy<Value = Recording> {
    let names = prop::collection::btree_set("[a-z \",;#'_]{1,8}x", 0..4);
    (names, 1usize..20).prop_flat_map(|(names, rows)| {
        let values = prop::collection::vec(prop::collection::vec(number(), rows), names.len());
        let steps = prop::collection::vec(1e-6f64..1e3, rows);
        (Just(names), steps, values).prop_map(|(names, steps, values)| Recording {
            name: "run.csv".into(),
            time: steps
                .iter()
                .scan(-1.0, |t, step| {
                    *t += step;
                    Some(*t)
                })
                .collect(),
            // Space around names is not kept.
            columns: names
                .iter()
                .map(|name| name.trim().to_owned())
                .zip(values)
                .map(|(name, values)| Column { name, values })
                .collect(),
        })
    })
}

fn bits(recording: &Recording) -> Vec<(String, Vec<u64>)> {
    let of = |values: &[f64]| {
        values.iter().map(|v| if v.is_nan() { u64::MAX } else { v.to_bits() }).collect()
    };
    let columns = recording.columns.iter().map(|c| (c.name.clone(), of(&c.values)));
    std::iter::once(("t_s".to_owned(), of(&recording.time))).chain(columns).collect()
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::default() })]
    #[test]
    fn what_is_written_reads_back_to_the_bit(recording in recording()) {
        let names: std::collections::BTreeSet<_> =
            recording.columns.iter().map(|column| &column.name).collect();
        prop_assume!(names.len() == recording.columns.len());
        let folder = TempDir::new().unwrap();
        let path = folder.path().join("run.csv");
        write_csv_with_time(&path, &recording, "t_s").unwrap();
        let back = lacuna_recordings::read(&RecordingSource::file(&path), "t_s").unwrap();
        prop_assert_eq!(bits(&back), bits(&recording));
        prop_assert_eq!(&back.name, &recording.name);
    }

    #[test]
    fn random_bytes_are_answered(bytes in prop::collection::vec(any::<u8>(), 0..200)) {
        answered(&bytes)?;
    }

    #[test]
    fn mutilated_recordings_are_answered(
        changes in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>(), 0u8..4), 1..8)
    ) {
        let mut bytes = b"# log\r\nt;\"x;1\";u\r\n0;1;2\r\n0.5;nan;4\r\n\r\n1.0;5;-6e-1\r\n".to_vec();
        for (index, byte, kind) in changes {
            let at = index.index(bytes.len());
            match kind {
                0 => bytes[at] = byte,
                1 => bytes.insert(at, b"\",;\t\n\r#0e.-"[byte as usize % 11]),
                2 => { bytes.remove(at); bytes.push(b'0') }
                _ => bytes.truncate(at.max(1)),
            }
        }
        answered(&bytes)?;
    }
}

/// Whatever the bytes: a sound recording, or an error with a message and a place within
/// the file.
fn answered(bytes: &[u8]) -> Result<(), TestCaseError> {
    let lines = 1 + bytes.iter().filter(|&&byte| byte == b'\n' || byte == b'\r').count();
    match read(bytes, "") {
        Ok(recording) => {
            prop_assert!(recording.time.windows(2).all(|pair| pair[0] < pair[1]));
            prop_assert!(recording.columns.iter().all(|c| c.values.len() == recording.len()));
        }
        Err(
            error @ (RecordingError::NotUtf8 { line, .. }
            | RecordingError::HeaderOnly { line, .. }
            | RecordingError::NoHeader { line, .. }
            | RecordingError::DuplicateColumn { line, .. }
            | RecordingError::RaggedRow { line, .. }
            | RecordingError::CutRow { line, .. }
            | RecordingError::WordsForNumbers { line, .. }
            | RecordingError::NotANumber { line, .. }
            | RecordingError::MissingTime { line, .. }
            | RecordingError::TimeNotIncreasing { line, .. }),
        ) => prop_assert!((1..=lines).contains(&line), "{error}"),
        Err(error) => prop_assert!(error.to_string().contains("run.csv")),
    }
    Ok(())
}
