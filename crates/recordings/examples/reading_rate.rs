//! How fast large logs are read, and in how much memory.
//!
//! ```text
//! cargo run --release -p lacuna-recordings --example reading_rate -- make run.mcap 1000
//! cargo run --release -p lacuna-recordings --example reading_rate -- read run.mcap
//! ```
//!
//! `make` writes about so many megabytes: as MCAP joint states of seven joints (CDR, 1 kHz), commands (JSON,
//! 100 Hz) and accelerations that nobody wants (CDR, 1 kHz), in compressed chunks unless the name has `plain` in it; as
//! Parquet twenty columns of noise. `read` reads a position and a command, then all columns, and tells megabytes of the
//! file per second and the most memory that it took.

#[path = "../tests/shared/joint_state.rs"]
mod joint_state;

use std::error::Error;
use std::fs::{self, File};
use std::path::Path;
use std::sync::Arc;
use std::time::Instant;

use joint_state::{SCHEMA, joint_state};
use lacuna_recordings::{RecordingSource, Wanted, read_log};
use mcap::records::MessageHeader;
use mcap::{Compression, WriteOptions};
use parquet::column::writer::ColumnWriter;
use parquet::file::properties::WriterProperties;
use parquet::file::writer::SerializedFileWriter;
use parquet::schema::parser::parse_message_type;

const JOINTS: usize = 7;
const IMU: &str = "float64[9] orientation\nfloat64[3] rates\nfloat64[3] accelerations\n";
const START: u64 = 1_750_000_000_000_000_000;
const COLUMNS: usize = 20;
const GROUP: usize = 1 << 18;

/// Numbers that do not compress: the golden ratio's multiples are spread evenly.
fn noise(k: usize) -> f64 {
    (k as f64 * 0.618_033_988_749_895).fract()
}

/// The joints' states at the k-th time.
fn joints(k: usize) -> Vec<u8> {
    let names: Vec<String> = (0..JOINTS).map(|j| format!("arm_joint_{j}")).collect();
    let names: Vec<&str> = names.iter().map(String::as_str).collect();
    let list = |l: usize| -> Vec<f64> { (0..JOINTS).map(|j| noise(k * 21 + l * 7 + j)).collect() };
    let [positions, velocities, efforts] = [0, 1, 2].map(list);
    joint_state(START + k as u64 * 1_000_000, &names, [&positions, &velocities, &efforts])
}

fn make_mcap(path: &Path, bytes: u64) -> Result<(), Box<dyn Error>> {
    let plain = path.to_string_lossy().contains("plain");
    let compression = (!plain).then_some(Compression::Zstd);
    let options = WriteOptions::new().compression(compression);
    let mut writer = options.create(File::create(path)?)?;
    let schema = |writer: &mut mcap::Writer<_>, name, text: &str| {
        writer.add_schema(name, "ros2msg", text.as_bytes())
    };
    let state = schema(&mut writer, "sensor_msgs/msg/JointState", SCHEMA)?;
    let imu = schema(&mut writer, "own_msgs/msg/Imu", IMU)?;
    let none = Default::default();
    let state = writer.add_channel(state, "/joint_states", "cdr", &none)?;
    let imu = writer.add_channel(imu, "/imu", "cdr", &none)?;
    let command = writer.add_channel(0, "/command", "json", &none)?;
    for k in 0.. {
        let log_time = START + k as u64 * 1_000_000;
        let mut put = |channel_id, data: &[u8]| {
            let sequence = k as u32;
            let header = MessageHeader { channel_id, sequence, log_time, publish_time: log_time };
            writer.write_to_known_channel(&header, data)
        };
        put(state, &joints(k))?;
        let numbers = (0..15).flat_map(|j| noise(k * 15 + j).to_le_bytes());
        put(imu, &[0, 1, 0, 0].into_iter().chain(numbers).collect::<Vec<u8>>())?;
        if k % 10 == 0 {
            put(command, format!("{{\"torque\": {}}}", noise(k)).as_bytes())?;
        }
        if k % 10_000 == 0 && fs::metadata(path)?.len() >= bytes {
            break;
        }
    }
    writer.finish()?;
    Ok(())
}

fn make_parquet(path: &Path, bytes: u64) -> Result<(), Box<dyn Error>> {
    let fields: String = (0..COLUMNS).map(|c| format!("required double c{c};")).collect();
    let schema =
        Arc::new(parse_message_type(&format!("message m {{ required double t; {fields} }}"))?);
    let properties =
        WriterProperties::builder().set_compression(parquet::basic::Compression::SNAPPY);
    let file = File::create(path)?;
    let mut writer = SerializedFileWriter::new(file, schema, Arc::new(properties.build()))?;
    for rows in (0..).step_by(GROUP) {
        let mut group = writer.next_row_group()?;
        for c in 0..=COLUMNS {
            let Some(mut column) = group.next_column()? else { break };
            if let ColumnWriter::DoubleColumnWriter(own) = column.untyped() {
                let value = |k: usize| if c == 0 { k as f64 / 1e3 } else { noise(k * COLUMNS + c) };
                own.write_batch(&(rows..rows + GROUP).map(value).collect::<Vec<_>>(), None, None)?;
            }
            column.close()?;
        }
        group.close()?;
        if fs::metadata(path)?.len() >= bytes {
            break;
        }
    }
    writer.close()?;
    Ok(())
}

/// The most memory that the process took, in MiB.
fn peak() -> String {
    let status = fs::read_to_string("/proc/self/status").unwrap_or_default();
    let kib = status
        .lines()
        .find_map(|l| l.strip_prefix("VmHWM:")?.split_whitespace().next()?.parse().ok());
    kib.map_or_else(|| "?".to_owned(), |kib: u64| format!("{} MiB", kib >> 10))
}

fn read(path: &Path) -> Result<(), Box<dyn Error>> {
    let megabytes = fs::metadata(path)?.len() as f64 / 1e6;
    let measured = ["/joint_states.position[arm_joint_3]", "c3"].map(str::to_owned);
    let inputs = ["/command.torque", "c4"].map(str::to_owned);
    let two = Wanted::only("t", measured.iter().chain(&inputs).cloned());
    let two = two.measuring(measured).holding(inputs);
    for (what, wanted) in [("two columns", two), ("all columns", Wanted::all("t"))] {
        let begin = Instant::now();
        let log = read_log(&RecordingSource::file(path), &wanted)?;
        let seconds = begin.elapsed().as_secs_f64();
        println!(
            "{what}: {} rows, {} columns, {megabytes:.0} MB in {seconds:.2} s: {:.0} MB/s, {} at most",
            log.recording.len(),
            log.recording.columns.len(),
            megabytes / seconds,
            peak()
        );
    }
    Ok(())
}

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    match &arguments.iter().map(String::as_str).collect::<Vec<_>>()[..] {
        ["make", file, megabytes] => {
            let (path, bytes) = (Path::new(file), megabytes.parse::<u64>()? * 1_000_000);
            if file.ends_with(".parquet") {
                make_parquet(path, bytes)
            } else {
                make_mcap(path, bytes)
            }
        }
        ["read", file] => read(Path::new(file)),
        _ => Err("expected make FILE MEGABYTES or read FILE".into()),
    }
}
