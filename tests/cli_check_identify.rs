//! `lacuna check` and `lacuna identify` as a user runs them.

use lacuna::excitation::{SinusoidRanges, SumOfSinusoids, add_gaussian_noise, rng};
use lacuna::occupation::IdentifiedModel;
use lacuna::plants::integrate::rk4_sampled;
use lacuna::plants::{Duffing, Hold};
use serde_json::Value;
use std::fmt::Write;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

const STEP: f64 = 0.02;
const ROWS: usize = 600;

const MODEL: &str = r#"
name = "duffing"

[parameters]
k1 = { value = 1, unit = "N/m", tolerance = 0.1 }
k3 = { value = 1, unit = "N/m^3", tolerance = 0.1 }
b = { value = 2, unit = "1", tolerance = 0.1 }

[[input]]
name = "u"
unit = "N"

[[coordinate]]
name = "x"
velocity = "dx"
unit = "m"

[mechanics]
mass = [["1"]]
force = ["k1*x - k3*x^3 + (b + sin(x))*u"]

[recordings]
time = "t"
"#;

/// A folder with a model and recordings of the paper's Duffing oscillator.
struct Bench {
    folder: tempfile::TempDir,
}

/// One simulated run: times, positions, velocities, held inputs.
struct Run {
    t: Vec<f64>,
    x: Vec<f64>,
    dx: Vec<f64>,
    u: Vec<f64>,
}

impl Run {
    fn new(seed: u64) -> Self {
        let mut rng = rng(seed, 0);
        let ranges = SinusoidRanges {
            amplitude: -1.0..=1.0,
            angular_frequency: 1.0..=6.0,
            phase: 0.0..=std::f64::consts::TAU,
        };
        let t: Vec<f64> = (0..ROWS).map(|k| STEP * k as f64).collect();
        let u = SumOfSinusoids::random(&mut rng, 1, 3, &ranges).unwrap().sample(&t);
        let plant = Duffing::default();
        let x0 = [0.5 * seed as f64 - 1.0, 0.0];
        let path = rk4_sampled(&plant, &x0, &t, &u, Hold::ZeroOrder, 2).unwrap();
        let column = |i: usize| (0..ROWS).map(|k| path.state(k)[i]).collect::<Vec<f64>>();
        let (mut x, mut dx) = (column(0), column(1));
        add_gaussian_noise(&mut x, 1e-3, &mut rng).unwrap();
        add_gaussian_noise(&mut dx, 1e-2, &mut rng).unwrap();
        Self { t, x, dx, u }
    }

    /// The run as CSV, with these columns of numbers.
    fn csv(columns: &[(&str, &[f64])]) -> String {
        let names: Vec<&str> = columns.iter().map(|c| c.0).collect();
        let mut text = names.join(",") + "\n";
        for k in 0..columns[0].1.len() {
            let cells: Vec<String> = columns.iter().map(|c| c.1[k].to_string()).collect();
            writeln!(text, "{}", cells.join(",")).unwrap();
        }
        text
    }

    fn position_only(&self) -> String {
        Self::csv(&[("t", &self.t), ("x", &self.x), ("u", &self.u)])
    }
}

impl Bench {
    fn new() -> Self {
        let bench = Self { folder: tempfile::tempdir().unwrap() };
        bench.write("model.toml", MODEL);
        bench
    }

    fn with_runs(seeds: std::ops::RangeInclusive<u64>) -> (Self, Vec<String>) {
        let bench = Self::new();
        let write = |seed| {
            let name = format!("run{seed}.csv");
            bench.write(&name, &Run::new(seed).position_only());
            name
        };
        let names = seeds.map(write).collect();
        (bench, names)
    }

    fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    fn write(&self, name: &str, text: &str) {
        std::fs::write(self.path(name), text).unwrap();
    }

    fn lacuna(&self, arguments: &[&str]) -> Output {
        Command::new(env!("CARGO_BIN_EXE_lacuna"))
            .args(arguments)
            .current_dir(self.folder.path())
            .output()
            .unwrap()
    }

    fn json(&self, arguments: &[&str]) -> Value {
        let output = self.lacuna(arguments);
        assert!(output.status.success(), "{}", stderr(&output));
        serde_json::from_slice(&output.stdout).unwrap()
    }

    /// The message of a run that must end with exit code 2, on one line, without a panic.
    fn error(&self, arguments: &[&str]) -> String {
        let output = self.lacuna(arguments);
        let said = stderr(&output);
        assert_eq!(output.status.code(), Some(2), "{said}");
        assert!(said.starts_with("lacuna: "), "{said}");
        assert!(!said.contains("panicked"), "{said}");
        said
    }
}

fn stderr(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

fn stdout(output: &Output) -> String {
    String::from_utf8_lossy(&output.stdout).into_owned()
}

fn arguments<'a>(command: &[&'a str], files: &'a [String]) -> Vec<&'a str> {
    command.iter().copied().chain(files.iter().map(String::as_str)).collect()
}

fn warnings(report: &Value) -> Vec<&str> {
    report["warnings"].as_array().unwrap().iter().map(|w| w.as_str().unwrap()).collect()
}

#[test]
fn check_tells_what_good_recordings_hold() {
    let (bench, runs) = Bench::with_runs(1..=3);
    let report = bench.json(&arguments(&["check", "model.toml", "--json"], &runs));
    assert_eq!(warnings(&report), [""; 0]);
    assert_eq!(report["recordings"][0]["rows"], ROWS);
    assert!((report["recordings"][2]["step_s"].as_f64().unwrap() - STEP).abs() < 1e-9);
    assert_eq!(report["recordings"][1]["uniform"], true);
    assert_eq!(report["not_measured"], serde_json::json!(["dx"]));
    let noise = report["channels"][0]["noise_sd"].as_f64().unwrap();
    assert!((noise / 1e-3 - 1.0).abs() < 0.15, "{noise}");
    // Three recordings with three frequencies each, some of them close together.
    let order = report["inputs"][0]["order"].as_u64().unwrap();
    assert!((6..=18).contains(&order), "{order}");
    for p in report["parameters"]["list"].as_array().unwrap() {
        assert_eq!(p["excited"], true);
        assert!(p["std_after"].as_f64().unwrap() < 0.1 * p["std_before"].as_f64().unwrap(), "{p}");
    }
    let text = stdout(&bench.lacuna(&arguments(&["check", "model.toml"], &runs)));
    assert!(text.contains("run2.csv") && text.contains("no warnings"), "{text}");
    let quiet = bench.lacuna(&arguments(&["check", "model.toml", "--quiet"], &runs));
    assert_eq!((stdout(&quiet).as_str(), quiet.status.code()), ("", Some(0)));
}

#[test]
fn check_converts_units_and_names_columns_that_are_not_used() {
    let bench = Bench::new();
    let measured = "[[measurement]]\ncolumn = \"x_mm\"\nof = \"x\"\nunit = \"mm\"\n";
    bench.write("model.toml", &format!("{MODEL}\n{measured}"));
    let run = Run::new(1);
    let mm: Vec<f64> = run.x.iter().map(|x| (1e3 * x / 100.0).round() * 100.0).collect();
    let columns: [(&str, &[f64]); 4] =
        [("t", &run.t), ("x_mm", &mm), ("u", &run.u), ("temperature", &run.dx)];
    bench.write("run.csv", &Run::csv(&columns));
    let report = bench.json(&["check", "model.toml", "run.csv", "--json"]);
    let channel = &report["channels"][0];
    assert_eq!((&channel["column"], &channel["unit"]), (&"x_mm".into(), &"m".into()));
    assert!((channel["factor"].as_f64().unwrap() - 1e-3).abs() < 1e-15);
    assert!((channel["quantum"].as_f64().unwrap() - 0.1).abs() < 1e-6);
    assert_eq!(report["not_used"], serde_json::json!(["temperature"]));
}

#[test]
fn check_warns_of_what_the_recordings_cannot_tell() {
    let bench = Bench::new();
    let run = Run::new(2);
    // Rest in the well at x = 1, where the input does nothing and drifts are balanced.
    let still: Vec<f64> = run
        .x
        .iter()
        .enumerate()
        .map(|(k, _)| 1.0 + 1e-3 * ((k * k * 7 % 11) as f64 - 5.0))
        .collect();
    let zero = vec![0.0; ROWS];
    bench.write("still.csv", &Run::csv(&[("t", &run.t), ("x", &still), ("u", &zero)]));
    let output = bench.lacuna(&["check", "model.toml", "still.csv", "--json"]);
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    let report: Value = serde_json::from_slice(&output.stdout).unwrap();
    let said = warnings(&report).join("\n");
    assert!(said.contains("channel 'x' barely moves"), "{said}");
    assert!(said.contains("input 'u' never changes"), "{said}");
    assert!(said.contains("parameter 'b' is not excited"), "{said}");
    assert!(said.contains("'k1' and 'k3' cannot be told apart"), "{said}");
}

#[test]
fn check_warns_of_dropped_rows_other_sampling_and_other_units() {
    let bench = Bench::new();
    let (run, other) = (Run::new(1), Run::new(2));
    bench.write("run1.csv", &run.position_only());
    let text = run.position_only();
    let keep = |(k, _): &(usize, &str)| *k == 0 || k % 50 > 4;
    let kept: Vec<&str> = text.lines().enumerate().filter(keep).map(|(_, l)| l).collect();
    bench.write("gaps.csv", &kept.join("\n"));
    let mm: Vec<f64> = other.x.iter().map(|x| 1e3 * x).collect();
    let slow: Vec<f64> = other.t.iter().map(|t| 2.0 * t).collect();
    bench.write("other.csv", &Run::csv(&[("t", &slow), ("x", &mm), ("u", &other.u)]));
    let files = ["run1.csv", "gaps.csv", "other.csv"].map(str::to_owned);
    let report = bench.json(&arguments(&["check", "model.toml", "--json"], &files));
    let said = warnings(&report).join("\n");
    assert!(said.contains("other.csv: column 'x' moves"), "{said}");
    assert!(said.contains("other.csv is sampled every 0.04 s"), "{said}");
    assert!(said.contains("gaps.csv: 9 % of the rows are dropped"), "{said}");
    assert_eq!(report["recordings"][1]["gaps"], 11);
}

#[test]
fn identify_learns_the_duffing_oscillator_from_positions() {
    let (bench, runs) = Bench::with_runs(1..=8);
    let report = bench.json(&arguments(&["identify", "--json", "--out", "found"], &runs));
    assert_eq!((&report["time"], &report["order"]), (&"t".into(), &2.into()));
    assert_eq!(report["arguments"], serde_json::json!(["x", "dx"]));
    assert_eq!(report["held_out_recordings"], serde_json::json!(["run7.csv", "run8.csv"]));
    let relative = |set: &str| report[set][0]["relative"].as_f64().unwrap();
    assert!(relative("training") < 0.05, "{report}");
    assert!(relative("held_out") < 0.1, "{report}");
    learned(&bench.path("found"));
    drawn(&bench.path("found/functions.svg"));
    let text = stdout(
        &bench.lacuna(&arguments(&["identify", "--kernel", "polynomial", "--out", "again"], &runs)),
    );
    assert!(text.contains("functions.svg shows f and g"), "{text}");
}

/// A diagram of each function against each argument that it depends on.
fn drawn(figure: &Path) {
    let svg = std::fs::read_to_string(figure).unwrap();
    assert!(svg.starts_with("<svg") && svg.ends_with("</svg>\n"));
    for title in ["f of x against x", "f of x against dx", "g of x by u against x"] {
        assert!(svg.contains(title), "{title}");
    }
    assert!(!svg.contains("g of x by u against dx"), "g depends on x alone");
    // Three diagrams, each with its curve's band, under one legend.
    for (text, count) in [("median", 3), ("± 2 standard deviations", 1), ("<polygon", 3)] {
        assert_eq!(svg.matches(text).count(), count, "{text}");
    }
}

/// The learned drift and effectiveness against the true ones, along the recordings.
fn learned(folder: &Path) {
    let model = IdentifiedModel::load(&folder.join("model.json")).unwrap();
    let truth = Duffing::default();
    let table = |name: &str| -> Vec<Vec<f64>> {
        let text = std::fs::read_to_string(folder.join(name)).unwrap();
        let row = |l: &str| l.split(',').map(|c| c.parse().unwrap()).collect();
        text.lines().skip(1).map(row).collect()
    };
    let (drift, effectiveness) = (table("drift.csv"), table("effectiveness.csv"));
    assert!(drift.len() <= 1000 && drift.len() > 500 && effectiveness.len() == drift.len());
    let mut errors = [0.0, 0.0];
    for (f, g) in drift.iter().zip(&effectiveness) {
        // recording, t, x, dx, value
        let (mut own_f, mut own_g) = ([0.0], [0.0]);
        model.evaluate(&f[2..4], &mut own_f, &mut own_g).unwrap();
        assert_eq!((own_f[0], own_g[0]), (f[4], g[4]));
        errors[0] += (f[4] - truth.f(f[2])).powi(2) / drift.len() as f64;
        errors[1] += (g[4] - truth.g(f[2])).powi(2) / drift.len() as f64;
    }
    let [f, g] = errors.map(f64::sqrt);
    eprintln!("rms error of f {f:.3}, of g {g:.3}");
    assert!(f < 0.2 && g < 0.2, "rms error of f {f}, of g {g}");
}

#[test]
fn identify_takes_a_whole_state_for_a_first_order_system() {
    let bench = Bench::new();
    let run = Run::new(3);
    let columns: [(&str, &[f64]); 4] =
        [("time_s", &run.t), ("x", &run.x), ("dx", &run.dx), ("force", &run.u)];
    bench.write("run.csv", &Run::csv(&columns));
    let report = bench.json(&["identify", "run.csv", "--json"]);
    assert_eq!((&report["time"], &report["order"]), (&"time_s".into(), &1.into()));
    assert_eq!(report["channels"], serde_json::json!(["x", "dx"]));
    assert_eq!(report["inputs"], serde_json::json!(["force"]));
    assert!(report["training"][0]["relative"].as_f64().unwrap() < 0.1, "{report}");
    // Positions alone with their velocities beside them are of second order.
    let report = bench.json(&["identify", "run.csv", "--json", "--channels", "x"]);
    assert_eq!((&report["order"], &report["velocities"][0]), (&2.into(), &"dx".into()));
    // Every kernel works.
    for kernel in ["exponential", "matern", "polynomial"] {
        let report =
            bench.json(&["identify", "run.csv", "--json", "--channels", "x", "--kernel", kernel]);
        assert!(report["training"][0]["relative"].as_f64().unwrap() < 0.5, "{kernel}: {report}");
    }
}

#[test]
fn identify_says_when_the_input_is_a_function_of_the_state() {
    let bench = Bench::new();
    let run = Run::new(3);
    let feedback: Vec<f64> = run.x.iter().zip(&run.dx).map(|(x, v)| -2.0 * x - 0.5 * v).collect();
    bench.write(
        "run.csv",
        &Run::csv(&[("t", &run.t), ("x", &run.x), ("dx", &run.dx), ("u", &feedback)]),
    );
    let text = stdout(&bench.lacuna(&["identify", "run.csv", "--channels", "x"]));
    assert!(text.contains("the effectiveness of 'u' cannot be told from the drift"), "{text}");
}

#[test]
fn wrong_recordings_are_refused_with_the_place() {
    let (bench, _) = Bench::with_runs(1..=1);
    let text = std::fs::read_to_string(bench.path("run1.csv")).unwrap();
    bench.write("no_input.csv", &text.replacen("t,x,u", "t,x,v", 1));
    bench.write("no_channel.csv", &text.replacen("t,x,u", "t,xx,u", 1));
    bench.write("no_time.csv", &text.replacen("t,x,u", "clock,x,u", 1));
    let mut lines: Vec<&str> = text.lines().collect();
    lines.swap(10, 11);
    bench.write("backwards.csv", &lines.join("\n"));
    bench.write("words.csv", &text.replacen("0.04,", "0.04,oops", 1));
    let run = Run::new(1);
    let nan = vec![f64::NAN; ROWS];
    bench.write("nan.csv", &Run::csv(&[("t", &run.t), ("x", &run.x), ("u", &nan)]));
    bench.write("data.json.csv", "{\"t\": [0, 1], \"x\": [0, 1]}");
    let table: [(&str, &[&str]); 8] = [
        ("no_input.csv", &["no_input.csv", "no column 'u'"]),
        ("no_channel.csv", &["no_channel.csv", "no column measures a channel"]),
        ("no_time.csv", &["no_time.csv", "'t'", "clock"]),
        ("backwards.csv", &["backwards.csv", "line 12", "time does not increase"]),
        ("words.csv", &["words.csv", "line 4", "column 'x'", "oops"]),
        ("nan.csv", &["nan.csv", "'u'"]),
        ("data.json.csv", &["data.json.csv", "JSON"]),
        ("absent.csv", &["absent.csv"]),
    ];
    for (file, parts) in table {
        let said = bench.error(&["check", "model.toml", file]);
        for part in parts {
            assert!(said.contains(part), "{file}: {said}");
        }
    }
    for (file, parts) in [
        ("backwards.csv", ["line 12", "time does not increase"]),
        ("words.csv", ["line 4", "column 'x'"]),
        ("nan.csv", ["nan.csv", "'u'"]),
        ("data.json.csv", ["data.json.csv", "JSON"]),
        ("no_input.csv", ["--inputs", "x, v"]),
    ] {
        let said = bench.error(&["identify", file]);
        for part in parts {
            assert!(said.contains(part), "{file}: {said}");
        }
    }
    assert!(!bench.path("found").exists());
}

#[test]
fn wrong_units_and_wrong_options_are_refused() {
    let (bench, runs) = Bench::with_runs(1..=1);
    let measured = "[[measurement]]\ncolumn = \"x\"\nof = \"x\"\nunit = \"deg\"\n";
    bench.write("degrees.toml", &format!("{MODEL}\n{measured}"));
    let said = bench.error(&["check", "degrees.toml", &runs[0]]);
    assert!(said.contains("deg") && said.contains("'m'") && said.contains('x'), "{said}");
    let said = bench.error(&["check", "absent.toml", &runs[0]]);
    assert!(said.contains("absent.toml"), "{said}");
    let said = bench.error(&["identify", &runs[0], "--channels", "y"]);
    assert!(said.contains("no column 'y'"), "{said}");
    let said = bench.error(&["identify", &runs[0], "--time", "seconds"]);
    assert!(said.contains("'seconds'") && said.contains(&runs[0]), "{said}");
    let said = bench.error(&["identify", &runs[0], "--window", "1000"]);
    assert!(said.contains("--window"), "{said}");
    let said = bench.error(&["identify", &runs[0], "--window", "0.05"]);
    assert!(said.contains("at least 8 are needed"), "{said}");
    // Nothing is written when the regression fails.
    bench.error(&["identify", &runs[0], "--window", "0.05", "--out", "found"]);
    assert!(!bench.path("found").exists());
}
