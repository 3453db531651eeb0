//! Reading MATLAB files of version 5: numbers of every type, structs, both orders of bytes, and what is refused.

use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::Command;

use flate2::Compression;
use flate2::write::ZlibEncoder;
use lacuna_recordings::{Log, Recording, RecordingError, RecordingSource, Wanted, read_log};
use tempfile::TempDir;

const DOUBLE: u32 = 6;
const COMPLEX: u32 = 0x800;

/// How a file is written.
#[derive(Clone, Copy, Debug)]
struct Manner {
    big_endian: bool,
    compressed: bool,
}

const PLAIN: Manner = Manner { big_endian: false, compressed: false };

impl Manner {
    fn word(self, word: u32) -> [u8; 4] {
        if self.big_endian { word.to_be_bytes() } else { word.to_le_bytes() }
    }

    fn element(self, kind: u32, data: &[u8]) -> Vec<u8> {
        let mut bytes = [self.word(kind), self.word(data.len() as u32)].concat();
        bytes.extend(data);
        bytes.resize(bytes.len().next_multiple_of(8), 0);
        bytes
    }

    /// An element that stands in its tag.
    fn small(self, kind: u32, data: &[u8]) -> Vec<u8> {
        let mut bytes = self.word((data.len() as u32) << 16 | kind).to_vec();
        bytes.extend(data);
        bytes.resize(8, 0);
        bytes
    }

    fn array(self, class: u32, name: &str, dims: &[u32], parts: &[Vec<u8>]) -> Vec<u8> {
        let words =
            |words: &[u32]| -> Vec<u8> { words.iter().flat_map(|w| self.word(*w)).collect() };
        let name = match name.len() {
            1..=4 => self.small(1, name.as_bytes()),
            _ => self.element(1, name.as_bytes()),
        };
        let head = [self.element(6, &words(&[class, 0])), self.element(5, &words(dims)), name];
        self.element(14, &[head.concat(), parts.concat()].concat())
    }

    fn doubles(self, name: &str, dims: &[u32], values: &[f64]) -> Vec<u8> {
        let bytes = |v: &f64| if self.big_endian { v.to_be_bytes() } else { v.to_le_bytes() };
        let data: Vec<u8> = values.iter().flat_map(bytes).collect();
        self.array(DOUBLE, name, dims, &[self.element(9, &data)])
    }

    /// Structs with the same fields.
    fn structs(self, name: &str, count: u32, fields: &[&str], values: &[Vec<u8>]) -> Vec<u8> {
        let names: Vec<u8> =
            fields.iter().flat_map(|f| [f.as_bytes(), &vec![0; 16 - f.len()]].concat()).collect();
        let head = [self.small(5, &self.word(16)), self.element(1, &names)];
        self.array(2, name, &[1, count], &[head.concat(), values.concat()])
    }

    fn file(self, arrays: &[Vec<u8>]) -> Vec<u8> {
        let mut bytes = format!("{:124}", "MATLAB 5.0 MAT-file").into_bytes();
        bytes.extend(if self.big_endian { *b"\x01\0MI" } else { *b"\0\x01IM" });
        for array in arrays {
            if !self.compressed {
                bytes.extend(array);
                continue;
            }
            let mut encoder = ZlibEncoder::new(Vec::new(), Compression::default());
            encoder.write_all(array).unwrap();
            let data = encoder.finish().unwrap();
            bytes.extend([self.word(15), self.word(data.len() as u32)].concat());
            bytes.extend(data);
        }
        bytes
    }
}

const ROWS: u32 = 5;

fn series(scale: f64) -> Vec<f64> {
    (0..ROWS).map(|k| scale * f64::from(k) + 0.5).collect()
}

/// Vectors of several types, matrices either way, structs, and what is no column.
fn sample(m: Manner) -> Vec<u8> {
    let shorts: Vec<u8> = (0..ROWS as i16)
        .flat_map(|k| if m.big_endian { (-k).to_be_bytes() } else { (-k).to_le_bytes() })
        .collect();
    let pairs: Vec<f64> = (0..2 * ROWS).map(f64::from).collect();
    let pose = m.structs("", 1, &["x"], &[m.doubles("", &[ROWS, 1], &series(3.0))]);
    let signals = [
        m.doubles("", &[ROWS, 1], &series(4.0)),
        m.array(4, "", &[1, 1], &[m.small(16, b"a")]),
        m.doubles("", &[ROWS, 2], &pairs),
        m.array(4, "", &[1, 1], &[m.small(16, b"b")]),
    ];
    m.file(&[
        m.doubles("t", &[ROWS, 1], &series(0.1)),
        m.array(10, "counts", &[1, ROWS], &[m.element(3, &shorts)]),
        // Whole doubles are written as bytes.
        m.array(DOUBLE, "on", &[ROWS, 1], &[m.element(2, &[0, 1, 1, 0, 255])]),
        m.doubles("tall", &[ROWS, 2], &pairs),
        m.doubles("wide", &[2, ROWS], &pairs),
        m.doubles("mass", &[1, 1], &[2.5]),
        m.structs("log", 1, &["pose", "q"], &[pose, m.doubles("", &[1, ROWS], &series(2.0))]),
        m.structs("signals", 2, &["values", "label"], &signals),
        m.array(DOUBLE | COMPLEX, "wave", &[ROWS, 1], &[]),
        m.array(1, "cells", &[1, 1], &[m.doubles("", &[1, 1], &[1.0])]),
        m.doubles("", &[1, 1], &[0.0]),
    ])
}

fn written(folder: &TempDir, bytes: &[u8]) -> PathBuf {
    let path = folder.path().join("run.mat");
    fs::write(&path, bytes).unwrap();
    path
}

fn all(path: &Path, selection: &str, time: &str) -> Result<Log, RecordingError> {
    let source: RecordingSource = format!("{}{selection}", path.display()).parse().unwrap();
    read_log(&source, &Wanted::all(time))
}

fn column<'r>(recording: &'r Recording, name: &str) -> &'r [f64] {
    recording.column(name).unwrap()
}

#[test]
fn variables_and_fields_become_columns() {
    let folder = TempDir::new().unwrap();
    let manners = [(false, false), (false, true), (true, false), (true, true)];
    for (big_endian, compressed) in manners {
        let manner = Manner { big_endian, compressed };
        let path = written(&folder, &sample(manner));
        let log = all(&path, "", "t").unwrap();
        let run = &log.recording;
        let names: Vec<&str> = run.columns.iter().map(|c| &*c.name).collect();
        let expected = [
            "counts",
            "on",
            "tall[0]",
            "tall[1]",
            "wide[0]",
            "wide[1]",
            "log.pose.x",
            "log.q",
            "signals[0].values",
            "signals[1].values[0]",
            "signals[1].values[1]",
        ];
        assert_eq!(names, expected, "{manner:?}");
        assert_eq!((&*run.name, &run.time), ("run.mat", &series(0.1)));
        assert_eq!(column(run, "counts"), [0.0, -1.0, -2.0, -3.0, -4.0]);
        assert_eq!(column(run, "on"), [0.0, 1.0, 1.0, 0.0, 255.0]);
        assert_eq!(column(run, "tall[1]"), [5.0, 6.0, 7.0, 8.0, 9.0]);
        assert_eq!(column(run, "wide[1]"), [1.0, 3.0, 5.0, 7.0, 9.0]);
        assert_eq!(column(run, "log.pose.x"), series(3.0));
        assert_eq!(column(run, "log.q"), series(2.0));
        assert_eq!(column(run, "signals[0].values"), series(4.0));
        assert_eq!(column(run, "signals[1].values[0]"), [0.0, 1.0, 2.0, 3.0, 4.0]);
        assert!(log.others.is_empty() && log.clocks.is_empty());
    }
}

#[test]
fn a_part_of_it_and_what_is_wanted_alone() {
    let folder = TempDir::new().unwrap();
    let path = written(&folder, &sample(PLAIN));
    let run = all(&path, "#rows=1..3", "t").unwrap().recording;
    assert_eq!((run.time.len(), column(&run, "wide[1]")), (2, &[3.0, 5.0][..]));
    let run = all(&path, "#t=0.65..", "t").unwrap().recording;
    assert_eq!(column(&run, "counts"), [-2.0, -3.0, -4.0]);
    // The time may be a field.
    assert_eq!(all(&path, "", "log.q").unwrap().recording.time, series(2.0));
    let wanted = Wanted::only("t", ["log.q".to_owned(), "wide[1]".to_owned(), "none".to_owned()]);
    let log = read_log(&RecordingSource::file(&path), &wanted).unwrap();
    let kept: Vec<&str> = log.recording.columns.iter().map(|c| &*c.name).collect();
    assert_eq!(kept, ["wide[1]", "log.q"]);
    assert_eq!(log.others.len(), 9);
}

#[test]
fn what_cannot_be_used_is_told() {
    let folder = TempDir::new().unwrap();
    let path = written(&folder, &sample(PLAIN));
    let said = |time: &str, needed: &str| {
        let wanted = Wanted::only(time, []).needing([needed.to_owned()]);
        read_log(&RecordingSource::file(&path), &wanted).unwrap_err().to_string()
    };
    for (needed, part) in [
        ("wave", "'wave': complex numbers"),
        ("cells", "'cells': a cell array"),
        ("signals[0].label", "'signals[0].label': a text"),
        ("mass", "'mass': an array of 1 x 1, where there are 5 times"),
        ("log.p", "no column 'log.p' (did you mean 'log.q'?); its columns are: counts, on,"),
    ] {
        let said = said("t", needed);
        assert!(said.contains(part), "{said}");
    }
    assert!(said("tt", "on").contains("no time column 'tt' (did you mean 't'?)"));
    assert!(said("tall", "on").contains("'tall': an array of 5 x 2"));
    let beyond = all(&path, "#rows=0..6", "t").unwrap_err().to_string();
    assert!(beyond.contains("has 5 rows, fewer than"), "{beyond}");
    let nothing = all(&path, "#t=7..", "t").unwrap_err().to_string();
    assert!(nothing.contains("holds none of the 5 rows"), "{nothing}");
}

#[test]
fn other_versions_and_broken_files_are_told() {
    let folder = TempDir::new().unwrap();
    let said = |bytes: &[u8]| all(&written(&folder, bytes), "", "t").unwrap_err().to_string();
    let mut new = format!("{:124}", "MATLAB 7.3 MAT-file").into_bytes();
    new.extend(b"\0\x02IM");
    assert!(said(&new).contains("version MATLAB 7.3 (HDF5)"));
    assert!(said(&[0; 200]).contains("MATLAB 4"));
    assert!(said(&[b'a'; 200]).contains("does not begin as a MATLAB file"));
    assert!(said(b"t,q\n0,1\n").contains("it ends too soon"));
    let long =
        PLAIN.file(&[PLAIN.array(DOUBLE, "t", &[1 << 30, 1], &[PLAIN.element(9, &[0; 80])])]);
    assert!(said(&long).contains("'t' has 80 bytes, where 1073741824 numbers of 8 bytes"));
    let deep = (0..100).fold(PLAIN.doubles("", &[1, 1], &[1.0]), |below, k| {
        PLAIN.structs(if k == 99 { "s" } else { "" }, 1, &["f"], &[below])
    });
    assert!(said(&PLAIN.file(&[deep])).contains("more than 32 deep"));
}

/// Whatever is cut off or changed, there is a recording or a reason.
#[test]
fn damage_is_told_and_nothing_panics() {
    let folder = TempDir::new().unwrap();
    for manner in [PLAIN, Manner { big_endian: true, compressed: true }] {
        let whole = sample(manner);
        for length in 0..whole.len() {
            if let Err(error) = all(&written(&folder, &whole[..length]), "", "t") {
                assert!(error.to_string().contains("run.mat"), "{error}");
            }
        }
        let cut = all(&written(&folder, &whole[..whole.len() - 1]), "", "t").unwrap_err();
        assert!(matches!(cut, RecordingError::Broken { .. }), "{cut}");
        for at in 0..whole.len() {
            let mut other = whole.clone();
            other[at] ^= [0x01, 0x80, 0xff][at % 3];
            if let Err(error) = all(&written(&folder, &other), "", "t") {
                assert!(error.to_string().contains("run.mat"), "{error}");
            }
        }
    }
}

/// What SciPy writes is read to the last bit.
#[test]
fn files_of_scipy_are_read() {
    let python = std::env::var("LACUNA_PYTHON").unwrap_or_else(|_| "python3".to_owned());
    let run = |code: &str| Command::new(&python).args(["-c", code]).output();
    if !run("import scipy.io").is_ok_and(|o| o.status.success()) {
        eprintln!("skipped: {python} does not know scipy (pip install scipy; LACUNA_PYTHON=...)");
        return;
    }
    let folder = TempDir::new().unwrap();
    for (compressed, oned) in [("True", "row"), ("False", "column")] {
        let path = folder.path().join(format!("{oned}.mat"));
        let code = format!(
            "import numpy as np, scipy.io\nk = np.arange(200)\nscipy.io.savemat({path:?}, dict(time=k / 100, \
             q=np.sin(0.07 * k) / 3, single=np.float32(0.1) * k.astype('float32'), big=k.astype('int64') - 2**40, \
             on=k % 3 == 0, xy=np.stack([k * 0.5, k / 7], axis=1), name='arm', mass=2.5, \
             run=dict(pose=dict(x=k / 3), gain=4)), do_compression={compressed}, oned_as='{oned}')",
            path = path.display().to_string()
        );
        let made = run(&code).unwrap();
        assert!(made.status.success(), "{}", String::from_utf8_lossy(&made.stderr));
        let run = all(&path, "", "time").unwrap().recording;
        let k = || (0..200).map(f64::from);
        assert_eq!(run.time, k().map(|k| k / 100.0).collect::<Vec<_>>());
        assert_eq!(run.columns.len(), 7);
        assert_eq!(column(&run, "run.pose.x"), k().map(|k| k / 3.0).collect::<Vec<_>>());
        assert_eq!(column(&run, "xy[1]"), k().map(|k| k / 7.0).collect::<Vec<_>>());
        assert_eq!(column(&run, "big")[3], 3.0 - 2f64.powi(40));
        assert_eq!(column(&run, "single")[7], f64::from(0.1f32 * 7.0));
        assert_eq!(column(&run, "on")[..4], [1.0, 0.0, 0.0, 1.0]);
    }
}

/// A selection is in seconds whatever the file counts in.
#[test]
fn times_may_be_counted_in_another_unit() {
    let folder = TempDir::new().unwrap();
    let path = written(&folder, &sample(Manner { big_endian: false, compressed: true }));
    let whole = all(&path, "", "t").unwrap().recording;
    let from = 60.0 * whole.time[1];
    let source: RecordingSource = format!("{}#t={from}..", path.display()).parse().unwrap();
    let later = read_log(&source, &Wanted::all("t").counting(60.0)).unwrap().recording;
    let expected: Vec<f64> = whole.time[1..].iter().map(|t| 60.0 * t).collect();
    assert_eq!(later.time, expected);
    assert_eq!(column(&later, "log.q"), &column(&whole, "log.q")[1..]);
}
