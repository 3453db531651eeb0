//! `lacuna check`, `simulate` and `diagnose` on MCAP logs: what they say of the same run as CSV.

mod arm;
#[path = "../crates/recordings/tests/shared/joint_state.rs"]
mod joint_state;

use arm::{MODEL, record};
use joint_state::{SCHEMA, joint_state};
use lacuna::plants::Model;
use lacuna::recordings::{Recording, write_csv};
use mcap::records::MessageHeader;
use serde_json::Value;
use std::fs::File;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

const ROWS: usize = 700;
const RUNS: usize = 3;

const FRICTION: &str = "\n[[effect]]\nclass = \"coulomb_friction\"\nchannel = \"q\"\nmagnitude = 0.06\nsmoothing_velocity = 0.02\n";

/// Which columns of the logs are what.
const MEASURED: &str = r#"
[[measurement]]
column = "/joint_states.position[arm]"
of = "q"
unit = "rad"

[[measurement]]
column = "/command.torque"
of = "tau"
unit = "N m"
"#;

/// When the logs begin, ns.
const START: u64 = 1_750_000_000_000_000_000;
const MILLISECOND: u64 = 1_000_000;

/// A folder with the models and recordings of a machine that has friction, as CSV.
struct Bench {
    folder: tempfile::TempDir,
    runs: Vec<Recording>,
}

impl Bench {
    fn new() -> Self {
        let folder = tempfile::tempdir().unwrap();
        let truth = Model::from_text(&format!("{MODEL}{FRICTION}"), "truth.toml").unwrap();
        let runs = (0..RUNS).map(|run| record(&truth, (7, run as u64), ROWS)).collect();
        let bench = Self { folder, runs };
        std::fs::write(bench.path("model.toml"), MODEL).unwrap();
        std::fs::write(bench.path("log.toml"), format!("{MODEL}{MEASURED}")).unwrap();
        for (k, run) in bench.runs.iter().enumerate() {
            write_csv(&bench.path(&format!("run{k}.csv")), run).unwrap();
        }
        bench
    }

    /// Write the runs as logs; returns their names.
    fn logs(&self, clocks: Clocks) -> Vec<String> {
        let write = |(k, run): (usize, &Recording)| {
            let name = format!("run{k}.mcap");
            log(&self.path(&name), run, clocks);
            name
        };
        self.runs.iter().enumerate().map(write).collect()
    }

    fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    fn lacuna(&self, arguments: &[&str]) -> Output {
        let mut command = Command::new(env!("CARGO_BIN_EXE_lacuna"));
        command.args(arguments).current_dir(self.folder.path()).output().unwrap()
    }

    fn prints(&self, arguments: &[&str]) -> String {
        let output = self.lacuna(arguments);
        let said = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(0), "{arguments:?}: {said}");
        String::from_utf8(output.stdout).unwrap()
    }

    fn json(&self, arguments: &[&str]) -> Value {
        serde_json::from_str(&self.prints(arguments)).unwrap()
    }

    fn error(&self, arguments: &[&str]) -> String {
        let output = self.lacuna(arguments);
        assert_eq!(output.status.code(), Some(2), "{arguments:?}");
        String::from_utf8(output.stderr).unwrap()
    }

    /// The one finding of a diagnosis: its magnitude and standard deviation.
    fn friction(&self, model: &str, runs: &[String]) -> (f64, f64) {
        let mut arguments = vec!["diagnose", model, "--json"];
        arguments.extend(runs.iter().map(String::as_str));
        let found = self.json(&arguments);
        assert_eq!(found["verdict"], "missing_physics");
        assert_eq!(found["findings"].as_array().map(Vec::len), Some(1), "{}", found["findings"]);
        let finding = &found["findings"][0];
        assert_eq!(finding["class"], "coulomb_friction");
        assert_eq!(finding["channel"], "q");
        let number = |key: &str| finding["parameters"]["magnitude"][key].as_f64().unwrap();
        (number("value"), number("std"))
    }

    fn csv_friction(&self) -> (f64, f64) {
        let names: Vec<String> = (0..RUNS).map(|k| format!("run{k}.csv")).collect();
        self.friction("model.toml", &names)
    }
}

/// How a log is stamped.
#[derive(Clone, Copy, PartialEq)]
enum Clocks {
    /// Everything at once, logged without delay.
    One,
    /// The joint's clock is 5 s behind that of the log and its messages come late, the command's messages have no stamps
    /// and are sent shortly before they count.
    Several,
}

/// Joint states (CDR), commands (JSON) and, at ten times their rate, accelerations that no model uses.
fn log(path: &Path, run: &Recording, clocks: Clocks) {
    let mut writer = mcap::Writer::new(File::create(path).unwrap()).unwrap();
    let schema =
        writer.add_schema("sensor_msgs/msg/JointState", "ros2msg", SCHEMA.as_bytes()).unwrap();
    let joint = writer.add_channel(schema, "/joint_states", "cdr", &Default::default()).unwrap();
    let command = writer.add_channel(0, "/command", "json", &Default::default()).unwrap();
    let imu = writer.add_channel(0, "/imu", "json", &Default::default()).unwrap();
    let mut messages = Vec::new();
    for (k, (q, tau)) in run.columns[0].values.iter().zip(&run.columns[1].values).enumerate() {
        let time = START + k as u64 * 10 * MILLISECOND;
        let (stamp, logged, sent) = match clocks {
            Clocks::One => (time, time, time),
            Clocks::Several => {
                let delay = MILLISECOND / 5 + MILLISECOND / 10 * (k as u64 * 7 % 13);
                (time - 5_000 * MILLISECOND, time + delay, time - MILLISECOND)
            }
        };
        messages.push((logged, joint, joint_state(stamp, &["arm"], [&[*q], &[0.0], &[]])));
        messages.push((sent, command, format!("{{\"torque\": {tau:?}}}").into_bytes()));
        let accelerations = (0..10).map(|j| {
            (time + j * MILLISECOND, imu, format!("{{\"x\": {j}, \"y\": 0.5}}").into_bytes())
        });
        messages.extend(accelerations);
    }
    messages.sort_by_key(|m| m.0);
    for (sequence, (log_time, channel_id, data)) in messages.into_iter().enumerate() {
        let sequence = sequence as u32;
        let header = MessageHeader { channel_id, sequence, log_time, publish_time: log_time };
        writer.write_to_known_channel(&header, &data).unwrap();
    }
    writer.finish().unwrap();
}

/// The same numbers at the same times: nothing but the rounding of times differs.
#[test]
fn a_log_of_one_clock_tells_what_csv_tells() {
    let bench = Bench::new();
    let (expected, std) = bench.csv_friction();
    assert!((expected - 0.06).abs() < f64::max(4.0 * std, 0.003), "{expected} +- {std}");
    let (found, found_std) = bench.friction("log.toml", &bench.logs(Clocks::One));
    assert!((found - expected).abs() < 1e-3 * std, "{found} {expected} +- {std}");
    assert!((found_std / std - 1.0).abs() < 1e-3, "{found_std} {std}");
}

/// Clocks are aligned to the least delay, a fifth of a millisecond, and commands held onto the samples of the joint,
/// not drawn between them: the finding moves by less than half its standard deviation.
#[test]
fn a_log_of_several_clocks_tells_what_csv_tells() {
    let bench = Bench::new();
    let (expected, std) = bench.csv_friction();
    let (found, found_std) = bench.friction("log.toml", &bench.logs(Clocks::Several));
    assert!((found - expected).abs() < 0.5 * std, "{found} {expected} +- {std}");
    assert!((found_std / std - 1.0).abs() < 0.1, "{found_std} {std}");
}

#[test]
fn check_tells_clocks_and_what_is_not_used() {
    let bench = Bench::new();
    bench.logs(Clocks::Several);
    let report = bench.json(&["check", "log.toml", "run0.mcap", "--json"]);
    let run = &report["recordings"][0];
    assert_eq!((&run["rows"], &run["uniform"]), (&ROWS.into(), &true.into()));
    let clocks = run["clocks"].as_array().unwrap();
    let topics: Vec<&str> = clocks.iter().map(|c| c["topic"].as_str().unwrap()).collect();
    assert_eq!(topics, ["/joint_states", "/command"]);
    let near = |of: &Value, expected: f64| (of.as_f64().unwrap() - expected).abs() < 1e-6;
    assert!(near(&clocks[0]["rate_hz"], 100.0) && clocks[0]["stamped"] == true, "{}", clocks[0]);
    // The least delay is taken for a part of the offset, and delays are told from it on.
    assert!(near(&clocks[0]["offset_s"], 5.0002) && near(&clocks[0]["delay_s"], 6e-4));
    assert!(near(&clocks[1]["offset_s"], 0.0) && clocks[1]["stamped"] == false);
    let not_used: Vec<&str> =
        report["not_used"].as_array().unwrap().iter().map(|n| n.as_str().unwrap()).collect();
    assert_eq!(not_used, ["/imu.x", "/imu.y", "/joint_states.velocity[arm]"]);
    let said = bench.prints(&["check", "log.toml", "run0.mcap"]);
    assert!(said.contains("Rows are the samples of /joint_states in run0.mcap"), "{said}");
    // Of a table there is nothing to say of clocks.
    let report = bench.json(&["check", "model.toml", "run0.csv", "--json"]);
    assert!(report["recordings"][0]["clocks"].is_null());
}

#[test]
fn what_a_log_does_not_hold_is_told_with_what_it_holds() {
    let bench = Bench::new();
    bench.logs(Clocks::One);
    let model = format!("{MODEL}{MEASURED}").replace("position[arm]", "position[am]");
    std::fs::write(bench.path("other.toml"), model).unwrap();
    let said = bench.error(&["simulate", "other.toml", "--like", "run0.mcap"]);
    assert!(said.contains("no column '/joint_states.position[am]'"), "{said}");
    assert!(said.contains("did you mean '/joint_states.position[arm]'"), "{said}");
    // Nothing is called as the channels of a model without measurements.
    let said = bench.error(&["check", "model.toml", "run0.mcap"]);
    assert!(said.contains("no column 'tau'") && said.contains("/imu.x"), "{said}");
    let still = "name = \"still\"\n[[coordinate]]\nname = \"q\"\nvelocity = \"dq\"\nunit = \"rad\"\n[mechanics]\n\
        mass = [[\"1\"]]\nforce = [\"-q\"]\n";
    std::fs::write(bench.path("still.toml"), still).unwrap();
    let said = bench.error(&["check", "still.toml", "run0.mcap"]);
    assert!(said.contains("none of the columns that are measured (q, dq)"), "{said}");
    assert!(said.contains("/imu.x"), "{said}");
}
