//! Reading MCAP: joint states and commands of two topics on one time.

#[path = "shared/joint_state.rs"]
mod joint_state;

use std::fs::{self, File};
use std::path::Path;

use joint_state::{SCHEMA, joint_state};
use lacuna_recordings::{RecordingSource, Wanted, read, read_log};
use mcap::records::MessageHeader;
use tempfile::TempDir;

const START: u64 = 1_750_000_000_000_000_000;

/// Two joints, all but efforts, stamped 5 s before the log's clock.
fn joints(k: u64) -> Vec<u8> {
    let at = k as f64 / 7.0;
    let stamp = START - 5_000_000_000 + k * 10_000_000;
    joint_state(stamp, &["shoulder", "elbow"], [&[at, -at], &[2.0 * at, -2.0 * at], &[]])
}

fn write(path: &Path) {
    let mut writer = mcap::Writer::new(File::create(path).unwrap()).unwrap();
    let schema =
        writer.add_schema("sensor_msgs/msg/JointState", "ros2msg", SCHEMA.as_bytes()).unwrap();
    let joint = writer.add_channel(schema, "/joint_states", "cdr", &Default::default()).unwrap();
    let command = writer.add_channel(0, "/command", "json", &Default::default()).unwrap();
    let mut put = |channel_id, log_time, data: &[u8]| {
        let header = MessageHeader { channel_id, sequence: 0, log_time, publish_time: log_time };
        writer.write_to_known_channel(&header, data).unwrap();
    };
    for k in 0..200 {
        if k % 4 == 0 {
            put(command, START + k * 10_000_000, format!("{{\"u\": {k}}}").as_bytes());
        }
        put(joint, START + k * 10_000_000, &joints(k));
    }
    writer.finish().unwrap();
}

#[test]
fn two_topics_of_two_clocks_come_on_one_time() {
    let folder = TempDir::new().unwrap();
    let path = folder.path().join("run.mcap");
    write(&path);
    let source = RecordingSource::file(&path);
    let log = read_log(&source, &Wanted::all("t").holding(["/command.u".to_owned()])).unwrap();
    let run = &log.recording;
    assert_eq!(run.len(), 200);
    assert_eq!(run.time[7], 0.07);
    let position = run.column("/joint_states.position[shoulder]").unwrap();
    assert_eq!(position[7], 1.0);
    assert_eq!(run.column("/joint_states.velocity[elbow]").unwrap()[7], -2.0);
    assert_eq!(run.column("/command.u").unwrap()[..6], [0.0, 0.0, 0.0, 0.0, 4.0, 4.0]);
    assert_eq!((&*log.clocks[0].topic, log.clocks[0].offset), ("/joint_states", 5.0));
    let straight = read(&source, "t").unwrap();
    assert_eq!(straight.column("/command.u").unwrap()[..3], [0.0, 1.0, 2.0]);
}

/// The slower topic makes the rows where it alone is measured; what nobody wants is named by its first message.
#[test]
fn rows_are_those_of_what_is_measured() {
    let folder = TempDir::new().unwrap();
    let path = folder.path().join("run.mcap");
    write(&path);
    let source = RecordingSource::file(&path);
    let input = "/joint_states.position[elbow]".to_owned();
    let wanted = |measured: &str| {
        Wanted::only("t", [measured.to_owned()])
            .needing([input.clone()])
            .measuring([measured.to_owned()])
            .holding([input.clone()])
    };
    let log = read_log(&source, &wanted("/command.u")).unwrap();
    let run = &log.recording;
    assert_eq!((run.len(), run.time[1]), (50, 0.04));
    let names: Vec<&str> = run.columns.iter().map(|c| &*c.name).collect();
    assert_eq!(names, ["/command.u", "/joint_states.position[elbow]"]);
    assert_eq!(run.column(&input).unwrap()[3], -12.0 / 7.0);
    assert_eq!((log.others.len(), &*log.clocks[0].topic), (3, "/command"));
    // What no topic has is told with all that there is.
    let said = read_log(&source, &wanted("/command.x")).unwrap_err().to_string();
    assert!(said.contains("none of the columns that are measured (/command.x)"), "{said}");
    assert!(said.contains("/command.u") && said.contains("velocity[elbow]"), "{said}");
}

#[test]
fn a_log_that_is_cut_is_told() {
    let folder = TempDir::new().unwrap();
    let path = folder.path().join("run.mcap");
    write(&path);
    let whole = fs::read(&path).unwrap();
    for length in [0, 5, whole.len() / 2, whole.len() - 1] {
        fs::write(&path, &whole[..length]).unwrap();
        let said = read(&RecordingSource::file(&path), "t").unwrap_err().to_string();
        assert!(said.contains("cannot be read as MCAP"), "{said}");
    }
}

/// Messages as long as the one before, of other joints or with none of the list: each number goes where it belongs.
#[test]
fn messages_of_changing_layout_keep_their_columns() {
    let folder = TempDir::new().unwrap();
    let path = folder.path().join("run.mcap");
    let mut writer = mcap::Writer::new(File::create(&path).unwrap()).unwrap();
    let schema = writer.add_schema("sensor_msgs/msg/JointState", "ros2msg", SCHEMA.as_bytes());
    let none = Default::default();
    let joint = writer.add_channel(schema.unwrap(), "/joint_states", "cdr", &none).unwrap();
    for k in 0..60u64 {
        let (h, t) = (k as f64, -(k as f64));
        let stamp = START + k * 10_000_000;
        let data = match k % 5 {
            0 | 1 => joint_state(stamp, &["hip", "toe"], [&[h, t], &[], &[]]),
            2 => joint_state(stamp, &["toe", "hip"], [&[t, h], &[], &[]]),
            3 => joint_state(stamp, &["hip", "toe"], [&[], &[h, t], &[]]),
            _ => joint_state(stamp, &["hip"], [&[h], &[], &[]]),
        };
        let header = MessageHeader {
            channel_id: joint,
            sequence: k as u32,
            log_time: stamp,
            publish_time: stamp,
        };
        writer.write_to_known_channel(&header, &data).unwrap();
    }
    writer.finish().unwrap();
    let run = read(&RecordingSource::file(&path), "t").unwrap();
    let column = |name: &str| run.column(&format!("/joint_states.{name}")).unwrap();
    for k in 0..60 {
        let (at, missing) = (k as f64, f64::NAN);
        let [hip, toe, velocity] = match k % 5 {
            0..=2 => [at, -at, missing],
            3 => [missing, missing, at],
            _ => [at, missing, missing],
        };
        let found = ["position[hip]", "position[toe]", "velocity[hip]"].map(column);
        for (found, expected) in found.iter().zip([hip, toe, velocity]) {
            assert_eq!(found[k].to_bits(), expected.to_bits(), "row {k}");
        }
        assert_eq!(run.time[k], k as f64 / 100.0);
    }
}
