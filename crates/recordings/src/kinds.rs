//! Kinds of files that are recognised by their first bytes and are not read here.

/// A kind of file.
pub(crate) struct Kind {
    first: &'static [u8],
    /// What it is.
    pub found: &'static str,
    /// What to do with it.
    pub advice: &'static str,
}

const fn of(first: &'static [u8], found: &'static str, advice: &'static str) -> Kind {
    Kind { first, found, advice }
}

static KINDS: &[Kind] = &[
    of(b"PK\x03\x04", "a spreadsheet or zip archive", "export the sheet as CSV, or unpack it"),
    of(b"PAR1", "a Parquet file", "name it .parquet"),
    of(b"\x1f\x8b", "gzip-compressed data", "decompress it first"),
    of(b"\x89HDF", "an HDF5 or MATLAB 7.3 file", "export its signals as CSV"),
    of(b"MATLAB 5.0", "a MATLAB file", "name it .mat"),
    of(b"MATLAB 7.3", "a MATLAB 7.3 file", "save it with save(..., '-v7')"),
    of(b"\x89MCAP", "an MCAP log", "name it .mcap"),
    of(b"#ROSBAG", "a ROS bag", "export its topics as CSV"),
    of(b"SQLite format 3", "an SQLite database or ROS 2 bag", "export its topics as CSV"),
    of(b"ULog", "a PX4 log", "convert it with ulog2csv"),
    of(b"MDF ", "a measurement data file (MDF)", "export its channels as CSV"),
    of(b"\xff\xfe", "UTF-16 text", "save it as UTF-8"),
    of(b"\xfe\xff", "UTF-16 text", "save it as UTF-8"),
    of(b"<", "an HTML or XML page", "download the data itself, not the page that shows it"),
    of(b"{", "JSON", "write it as a table: a header line, then one row per time"),
    of(b"[", "JSON or TOML", "write it as a table: a header line, then one row per time"),
    of(b"%PDF", "a PDF document", "ask for the data as CSV"),
];

/// The kind that a file of these first bytes is of, if it is one of these.
pub(crate) fn kind(bytes: &[u8]) -> Option<&'static Kind> {
    let start = bytes.trim_ascii_start();
    KINDS.iter().find(|kind| start.starts_with(kind.first))
}
