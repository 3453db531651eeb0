//! Reading Parquet: the same numbers as from CSV, names of nested columns, selections, and what is refused.

use std::fs::{self, File};
use std::path::{Path, PathBuf};
use std::sync::Arc;

use lacuna_recordings::{
    Recording, RecordingError, RecordingSource, RowGroups, Wanted, read, read_log, write_csv,
};
use parquet::basic::{Compression, GzipLevel, ZstdLevel};
use parquet::column::writer::ColumnWriter;
use parquet::file::properties::WriterProperties;
use parquet::file::writer::SerializedFileWriter;
use parquet::schema::parser::parse_message_type;
use tempfile::TempDir;

/// Values of a leaf with their definition and repetition levels.
enum Leaf {
    Bool(Vec<bool>, Vec<i16>, Vec<i16>),
    I32(Vec<i32>, Vec<i16>, Vec<i16>),
    I64(Vec<i64>, Vec<i16>, Vec<i16>),
    F32(Vec<f32>, Vec<i16>, Vec<i16>),
    F64(Vec<f64>, Vec<i16>, Vec<i16>),
}

fn flat(values: impl IntoIterator<Item = f64>) -> Leaf {
    Leaf::F64(values.into_iter().collect(), vec![], vec![])
}

fn levels(all: &[i16]) -> Option<&[i16]> {
    (!all.is_empty()).then_some(all)
}

/// Writes row groups of leaves in the order of the schema.
fn write(path: &Path, schema: &str, compression: Compression, groups: Vec<Vec<Leaf>>) {
    let schema = Arc::new(parse_message_type(schema).unwrap());
    let properties = WriterProperties::builder().set_compression(compression).build();
    let file = File::create(path).unwrap();
    let mut writer = SerializedFileWriter::new(file, schema, Arc::new(properties)).unwrap();
    for leaves in groups {
        let mut group = writer.next_row_group().unwrap();
        for leaf in leaves {
            let mut column = group.next_column().unwrap().unwrap();
            macro_rules! batch {
                ($writer:ident, $values:ident, $defs:ident, $reps:ident) => {
                    $writer.write_batch(&$values, levels(&$defs), levels(&$reps)).unwrap()
                };
            }
            match (column.untyped(), leaf) {
                (ColumnWriter::BoolColumnWriter(w), Leaf::Bool(v, d, r)) => batch!(w, v, d, r),
                (ColumnWriter::Int32ColumnWriter(w), Leaf::I32(v, d, r)) => batch!(w, v, d, r),
                (ColumnWriter::Int64ColumnWriter(w), Leaf::I64(v, d, r)) => batch!(w, v, d, r),
                (ColumnWriter::FloatColumnWriter(w), Leaf::F32(v, d, r)) => batch!(w, v, d, r),
                (ColumnWriter::DoubleColumnWriter(w), Leaf::F64(v, d, r)) => batch!(w, v, d, r),
                _ => panic!("a leaf of another type than the schema's"),
            };
            column.close().unwrap();
        }
        group.close().unwrap();
    }
    writer.close().unwrap();
}

const FLAT: &str = "message m { required double t; optional double q; required double u; }";

fn time(k: usize) -> f64 {
    k as f64 / 100.0
}

fn q(k: usize) -> f64 {
    (0.07 * k as f64).sin() / 3.0
}

/// Rows of a file, in groups of these sizes; every seventh `q` is missing.
fn rows(sizes: &[usize]) -> Vec<Vec<Leaf>> {
    let mut from = 0;
    let group = |size: &usize| {
        let range = from..from + size;
        from += size;
        let present = |k: &usize| k % 7 != 3;
        vec![
            flat(range.clone().map(time)),
            Leaf::F64(
                range.clone().filter(present).map(q).collect(),
                range.clone().map(|k| i16::from(present(&k))).collect(),
                vec![],
            ),
            flat(range.map(|k| -1e-7 * k as f64)),
        ]
    };
    sizes.iter().map(group).collect()
}

fn made(folder: &TempDir, compression: Compression) -> PathBuf {
    let path = folder.path().join("run.parquet");
    write(&path, FLAT, compression, rows(&[9000, 1, 999]));
    path
}

fn source(path: &Path, selection: &str) -> RecordingSource {
    format!("{}{selection}", path.display()).parse().unwrap()
}

/// Bit for bit, so that missing samples are equal.
fn bits(r: &Recording) -> (Vec<u64>, Vec<(String, Vec<u64>)>) {
    let bits = |v: &[f64]| v.iter().map(|v| if v.is_nan() { 1 } else { v.to_bits() }).collect();
    (bits(&r.time), r.columns.iter().map(|c| (c.name.clone(), bits(&c.values))).collect())
}

#[test]
fn every_compression_gives_what_csv_gives_to_the_last_bit() {
    let folder = TempDir::new().unwrap();
    let csv = folder.path().join("run.csv");
    for compression in [
        Compression::UNCOMPRESSED,
        Compression::SNAPPY,
        Compression::GZIP(GzipLevel::default()),
        Compression::ZSTD(ZstdLevel::default()),
    ] {
        let path = made(&folder, compression);
        let found = read(&source(&path, ""), "t").unwrap();
        assert_eq!((found.len(), &*found.name), (10_000, "run.parquet"));
        assert_eq!(found.column("q").unwrap()[4], q(4));
        assert!(found.column("q").unwrap()[3].is_nan());
        write_csv(&csv, &found).unwrap();
        for selection in ["", "#rows=8999..9002", "#rows=..5", "#t=1.5..", "#t=89.985..90.02"] {
            let text = read(&source(&csv, selection), "t").unwrap();
            let found = read(&source(&path, selection), "t").unwrap();
            assert_eq!(bits(&found), bits(&text), "{selection}");
            assert_eq!(found.name, format!("run.parquet{selection}"));
        }
    }
}

#[test]
fn a_file_of_another_name_is_known_by_its_first_bytes() {
    let folder = TempDir::new().unwrap();
    let path = folder.path().join("run.log");
    fs::rename(made(&folder, Compression::SNAPPY), &path).unwrap();
    assert_eq!(read(&source(&path, ""), "t").unwrap().len(), 10_000);
}

/// As robots' learning sets are written: lists of one length, times in single precision.
const LISTS: &str = "message m {
    optional group observation.state (LIST) { repeated group list { optional float element; } }
    required float timestamp;
    required int64 frame_index;
    required boolean next.done;
    optional group pose { required double x; optional group points (LIST) {
        repeated group list { required group element { required double y; } } } }
}";

fn lists() -> TempDir {
    let folder = TempDir::new().unwrap();
    // Three rows: [0.5, 1.5], [null, 2.5], null.
    let state = Leaf::F32(vec![0.5, 1.5, 2.5], vec![3, 3, 2, 3, 0], vec![0, 1, 0, 1, 0]);
    let y = Leaf::F64(vec![7.0, 8.0, 9.0], vec![3, 3, 3, 2], vec![0, 1, 0, 0]);
    let leaves = vec![
        state,
        Leaf::F32(vec![0.0, 0.1, 0.2], vec![], vec![]),
        Leaf::I64(vec![0, 1, 2], vec![], vec![]),
        Leaf::Bool(vec![false, false, true], vec![], vec![]),
        Leaf::F64(vec![1.0, 2.0, 3.0], vec![1, 1, 1], vec![]),
        y,
    ];
    write(&folder.path().join("run.parquet"), LISTS, Compression::SNAPPY, vec![leaves]);
    folder
}

#[test]
fn groups_and_lists_become_columns() {
    let folder = lists();
    let found = read(&source(&folder.path().join("run.parquet"), ""), "timestamp").unwrap();
    let names: Vec<&str> = found.columns.iter().map(|c| &*c.name).collect();
    assert_eq!(
        names,
        [
            "observation.state[0]",
            "observation.state[1]",
            "frame_index",
            "next.done",
            "pose.x",
            "pose.points[0].y",
            "pose.points[1].y",
        ]
    );
    assert_eq!(found.time, [0.0, f64::from(0.1f32), f64::from(0.2f32)]);
    assert_eq!(found.column("next.done").unwrap(), [0.0, 0.0, 1.0]);
    let near = |name: &str, expected: [f64; 3]| {
        let values = found.column(name).unwrap();
        for (value, expected) in values.iter().zip(expected) {
            assert!(
                *value == expected || value.is_nan() && expected.is_nan(),
                "{name}: {values:?}"
            );
        }
    };
    near("observation.state[0]", [0.5, f64::NAN, f64::NAN]);
    near("observation.state[1]", [1.5, 2.5, f64::NAN]);
    near("pose.points[0].y", [7.0, 9.0, f64::NAN]);
    near("pose.points[1].y", [8.0, f64::NAN, f64::NAN]);
}

#[test]
fn what_nobody_wants_is_named_and_not_kept() {
    let folder = lists();
    let source = source(&folder.path().join("run.parquet"), "");
    let wanted = Wanted::only("timestamp", ["pose.x".to_owned()])
        .needing(["observation.state[1]".to_owned()]);
    let log = read_log(&source, &wanted).unwrap();
    let kept: Vec<&str> = log.recording.columns.iter().map(|c| &*c.name).collect();
    assert_eq!(kept, ["observation.state[1]", "pose.x"]);
    assert_eq!(log.others.len(), 5);
    let wanted = Wanted::only("timestamp", []).needing(["observation.state[2]".to_owned()]);
    let said = read_log(&source, &wanted).unwrap_err().to_string();
    assert!(
        said.contains("no column 'observation.state[2]' (did you mean 'observation.state["),
        "{said}"
    );
}

#[test]
fn timestamps_are_counted_from_the_first_row() {
    let folder = TempDir::new().unwrap();
    let path = folder.path().join("run.parquet");
    let schema = "message m { required int64 t (TIMESTAMP(NANOS,true)); required int32 u (UINT_32);
                  required int32 d (DECIMAL(9,2)); }";
    // A second's nanoseconds in this century leave no room for a fraction in a double.
    let stamps: Vec<i64> = (0..10).map(|k| 1_750_000_000_000_000_001 + 1_000_003 * k).collect();
    let u = Leaf::I32(vec![-1; 10], vec![], vec![]);
    let d = Leaf::I32(vec![-125; 10], vec![], vec![]);
    let leaves = vec![Leaf::I64(stamps, vec![], vec![]), u, d];
    write(&path, schema, Compression::SNAPPY, vec![leaves]);
    let found = read(&source(&path, "#rows=2..4"), "t").unwrap();
    assert_eq!(found.time, [0.002_000_006, 0.003_000_009]);
    assert_eq!(found.column("u").unwrap(), [4_294_967_295.0; 2]);
    assert_eq!(found.column("d").unwrap(), [-1.25; 2]);
}

/// Plain numbers may be of another unit, with selections in seconds all the same; timestamps say their own.
#[test]
fn times_may_be_counted_in_another_unit() {
    let folder = TempDir::new().unwrap();
    let path = folder.path().join("ms.parquet");
    let stamps = Leaf::I64((0..5).map(|k| 1_700_000_000_000 + 20 * k).collect(), vec![], vec![]);
    let plain = flat((0..5).map(|k| 20.0 * f64::from(k)));
    let schema = "message m { required int64 stamp (TIMESTAMP(MILLIS,true)); required double t; }";
    write(&path, schema, Compression::UNCOMPRESSED, vec![vec![stamps, plain]]);
    let times = |time: &str| {
        let wanted = Wanted::all(time).counting(1e-3);
        read_log(&source(&path, "#t=0.03.."), &wanted).unwrap().recording.time
    };
    assert_eq!(times("t"), [0.04, 0.06, 0.08]);
    assert_eq!(times("stamp"), times("t"));
}

/// The message without the folder.
fn said(path: &Path, selection: &str, time: &str) -> String {
    let message = read(&source(path, selection), time).unwrap_err().to_string();
    let folder = format!("{}/", path.parent().unwrap().display());
    message.replace(&folder, "")
}

#[test]
fn what_is_wrong_is_said() {
    let folder = TempDir::new().unwrap();
    let path = made(&folder, Compression::SNAPPY);
    let message = said(&path, "", "time");
    assert_eq!(
        message,
        "run.parquet has no time column 'time' (did you mean 't'?); its columns are: t, q, u; the model's [recordings] \
         section names the time column"
    );
    let message = said(&path, "#rows=0..10001", "t");
    assert!(message.starts_with("run.parquet has 10000 rows, fewer than"), "{message}");
    let message = said(&path, "#t=200..", "t");
    assert!(message.contains("holds none of the 10000 rows"), "{message}");
    let message = said(&path, "#rows=1..", "u");
    assert!(
        message.starts_with("run.parquet#rows=1..: time does not increase: -0.0000001 s in row 0"),
        "{message}"
    );
    let message = said(&path, "", "q");
    assert!(message.contains("row 3: the time column 'q' is missing here"), "{message}");
}

#[test]
fn a_list_that_grows_is_told_with_its_row() {
    let folder = TempDir::new().unwrap();
    let path = folder.path().join("run.parquet");
    let schema = "message m { required double t; repeated double x; }";
    let x = Leaf::F64(vec![1.0, 2.0, 3.0], vec![1, 1, 1], vec![0, 0, 1]);
    write(&path, schema, Compression::SNAPPY, vec![vec![flat([0.0, 1.0]), x]]);
    let message = said(&path, "", "t");
    assert!(
        message.starts_with("run.parquet, row 1 (from 0): the list 'x' has more than the 1"),
        "{message}"
    );
}

#[test]
fn a_file_that_is_cut_or_damaged_gives_an_error_and_no_panic() {
    let folder = TempDir::new().unwrap();
    let path = made(&folder, Compression::ZSTD(ZstdLevel::default()));
    let whole = fs::read(&path).unwrap();
    for length in [0, 3, 4, 8, whole.len() / 2, whole.len() - 1] {
        fs::write(&path, &whole[..length]).unwrap();
        let message = said(&path, "", "t");
        assert!(message.starts_with("run.parquet cannot be read as Parquet: "), "{message}");
    }
    // What a flipped byte makes of it is either told or a number.
    let flipped = |at: usize, bits: u8| {
        let mut bytes = whole.clone();
        bytes[at] ^= bits;
        fs::write(&path, &bytes).unwrap();
        read(&source(&path, ""), "t")
    };
    for at in (0..whole.len()).step_by(whole.len() / 400) {
        let _ = flipped(at, 0x55);
    }
    // The lowest bit is the sign of a number at the end of the file, where places and lengths stand.
    let ends = whole.len().saturating_sub(600)..whole.len();
    let said: Vec<String> =
        ends.filter_map(|at| flipped(at, 1).err()).map(|e| e.to_string()).collect();
    assert!(said.iter().any(|s| s.contains("is said to lie outside the file")), "{said:?}");
}

#[test]
fn a_page_that_says_it_is_huge_is_refused_before_it_is_unpacked() {
    let folder = TempDir::new().unwrap();
    let path = folder.path().join("run.parquet");
    // Eighty million equal numbers: a small file, and a large page.
    let schema = "message m { required double t; }";
    let schema = Arc::new(parse_message_type(schema).unwrap());
    let properties = WriterProperties::builder()
        .set_compression(Compression::ZSTD(ZstdLevel::default()))
        .set_dictionary_enabled(false)
        .set_data_page_size_limit(usize::MAX)
        .set_data_page_row_count_limit(usize::MAX)
        .build();
    let file = File::create(&path).unwrap();
    let mut writer = SerializedFileWriter::new(file, schema, Arc::new(properties)).unwrap();
    let mut group = writer.next_row_group().unwrap();
    let mut column = group.next_column().unwrap().unwrap();
    let ColumnWriter::DoubleColumnWriter(w) = column.untyped() else { panic!("no doubles") };
    for _ in 0..80 {
        w.write_batch(&vec![0.0; 1_000_000], None, None).unwrap();
    }
    column.close().unwrap();
    group.close().unwrap();
    writer.close().unwrap();
    assert!(fs::metadata(&path).unwrap().len() < 1_000_000);
    let error = read(&source(&path, ""), "t").unwrap_err();
    assert!(matches!(error, RecordingError::TooLarge { .. }), "{error}");
}

#[test]
fn row_groups_are_read_one_by_one() {
    let folder = tempfile::tempdir().unwrap();
    let path = made(&folder, Compression::SNAPPY);
    let names = ["u", "t"].map(String::from);
    let mut groups = RowGroups::open(&path, &names).unwrap();
    assert_eq!(groups.count(), 3);
    assert_eq!([0, 1, 2].map(|k| groups.rows(k)), [9000, 1, 999]);
    // Any of them, in any order.
    let last = groups.read(2).unwrap();
    assert_eq!(last[1], (9001..10_000).map(time).collect::<Vec<_>>());
    assert_eq!(last[0][0], -1e-7 * 9001.0);
    assert_eq!(groups.read(1).unwrap()[1], [time(9000)]);
    let mut measured = RowGroups::open(&path, &["q".to_owned()]).unwrap();
    let values = measured.read(0).unwrap().remove(0);
    assert!(values[3].is_nan() && values[4] == q(4));

    let error = RowGroups::open(&path, &["tt".to_owned()]).err().unwrap().to_string();
    assert!(error.contains("has no column 'tt'") && error.contains("t, q, u"), "{error}");
    let bytes = fs::read(&path).unwrap();
    fs::write(&path, &bytes[..bytes.len() / 2]).unwrap();
    let error = RowGroups::open(&path, &names).err().unwrap().to_string();
    assert!(error.contains("run.parquet cannot be read as Parquet"), "{error}");
}
