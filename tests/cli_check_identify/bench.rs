//! A folder with a model and recordings of the paper's Duffing oscillator, and the command in it.

use lacuna::excitation::{SinusoidRanges, SumOfSinusoids, add_gaussian_noise, rng};
use lacuna::plants::integrate::rk4_sampled;
use lacuna::plants::{Duffing, Hold};
use serde_json::Value;
use std::fmt::Write;
use std::path::PathBuf;
use std::process::{Command, Output};

pub const STEP: f64 = 0.02;
pub const ROWS: usize = 600;

pub const MODEL: &str = r#"
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
pub struct Bench {
    folder: tempfile::TempDir,
}

/// One simulated run: times, positions, velocities, held inputs.
pub struct Run {
    pub t: Vec<f64>,
    pub x: Vec<f64>,
    pub dx: Vec<f64>,
    pub u: Vec<f64>,
}

impl Run {
    /// Driven by an input that is held from sample to sample.
    pub fn new(seed: u64) -> Self {
        Self::driven(seed, Hold::ZeroOrder)
    }

    pub fn driven(seed: u64, hold: Hold) -> Self {
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
        let path = rk4_sampled(&plant, &x0, &t, &u, hold, 2).unwrap();
        let column = |i: usize| (0..ROWS).map(|k| path.state(k)[i]).collect::<Vec<f64>>();
        let (mut x, mut dx) = (column(0), column(1));
        add_gaussian_noise(&mut x, 1e-3, &mut rng).unwrap();
        add_gaussian_noise(&mut dx, 1e-2, &mut rng).unwrap();
        Self { t, x, dx, u }
    }

    /// The run as CSV, with these columns of numbers.
    pub fn csv(columns: &[(&str, &[f64])]) -> String {
        let names: Vec<&str> = columns.iter().map(|c| c.0).collect();
        let mut text = names.join(",") + "\n";
        for k in 0..columns[0].1.len() {
            let cells: Vec<String> = columns.iter().map(|c| c.1[k].to_string()).collect();
            writeln!(text, "{}", cells.join(",")).unwrap();
        }
        text
    }

    pub fn position_only(&self) -> String {
        Self::csv(&[("t", &self.t), ("x", &self.x), ("u", &self.u)])
    }
}

impl Bench {
    pub fn new() -> Self {
        let bench = Self { folder: tempfile::tempdir().unwrap() };
        bench.write("model.toml", MODEL);
        bench
    }

    pub fn with_runs(seeds: std::ops::RangeInclusive<u64>) -> (Self, Vec<String>) {
        let bench = Self::new();
        let write = |seed| {
            let name = format!("run{seed}.csv");
            bench.write(&name, &Run::new(seed).position_only());
            name
        };
        let names = seeds.map(write).collect();
        (bench, names)
    }

    pub fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    pub fn write(&self, name: &str, text: &str) {
        std::fs::write(self.path(name), text).unwrap();
    }

    pub fn lacuna(&self, arguments: &[&str]) -> Output {
        Command::new(env!("CARGO_BIN_EXE_lacuna"))
            .args(arguments)
            .current_dir(self.folder.path())
            .output()
            .unwrap()
    }

    pub fn json(&self, arguments: &[&str]) -> Value {
        let output = self.lacuna(arguments);
        assert!(output.status.success(), "{}", stderr(&output));
        serde_json::from_slice(&output.stdout).unwrap()
    }

    /// The message of a run that must end with exit code 2, on one line, without a panic.
    pub fn error(&self, arguments: &[&str]) -> String {
        let output = self.lacuna(arguments);
        let said = stderr(&output);
        assert_eq!(output.status.code(), Some(2), "{said}");
        assert!(said.starts_with("lacuna: "), "{said}");
        assert!(!said.contains("panicked"), "{said}");
        said
    }
}

pub fn stderr(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

pub fn stdout(output: &Output) -> String {
    String::from_utf8_lossy(&output.stdout).into_owned()
}

pub fn arguments<'a>(command: &[&'a str], files: &'a [String]) -> Vec<&'a str> {
    command.iter().copied().chain(files.iter().map(String::as_str)).collect()
}
