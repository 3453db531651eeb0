//! A damper whose motion is imposed, through every command: what `simulate` says of its force is what
//! `diagnose` is told of.

use serde_json::Value;
use std::f64::consts::TAU;
use std::fmt::Write;
use std::path::PathBuf;
use std::process::{Command, Output};

const MODEL: &str = r#"name = "damper"
[parameters]
c = { value = 60, unit = "N s/m", tolerance = 0.3 }
k = { value = 500, unit = "N/m", tolerance = 0.2 }

[[coordinate]]
name = "x"
velocity = "dx"
unit = "m"
force_unit = "N"
imposed = true

[mechanics]
mass = [["0.4"]]
force = ["-c*dx - k*x"]

[[measurement]]
column = "x_mm"
of = "x"
unit = "mm"

[[measurement]]
column = "F_kN"
of = "force on x"
unit = "kN"
"#;

const DRAG: &str = "\n[[effect]]\nclass = \"quadratic_drag\"\nchannel = \"x\"\ncoefficient = { value = 300, unit = \"N s^2/m^2\" }\n";

struct Rig(tempfile::TempDir);

impl Rig {
    fn new() -> Self {
        let rig = Self(tempfile::tempdir().unwrap());
        rig.write("model.toml", MODEL);
        rig.write("truth.toml", &format!("{MODEL}{DRAG}"));
        rig
    }

    fn path(&self, file: &str) -> PathBuf {
        self.0.path().join(file)
    }

    fn write(&self, file: &str, text: &str) {
        std::fs::write(self.path(file), text).unwrap();
    }

    fn run(&self, arguments: &[&str]) -> Output {
        let mut command = Command::new(env!("CARGO_BIN_EXE_lacuna"));
        command.args(arguments).current_dir(self.0.path()).output().unwrap()
    }

    fn says(&self, arguments: &[&str]) -> String {
        let output = self.run(arguments);
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        String::from_utf8(output.stdout).unwrap()
    }

    fn json(&self, arguments: &[&str]) -> Value {
        serde_json::from_str(&self.says(arguments)).unwrap()
    }

    fn error(&self, arguments: &[&str]) -> String {
        let output = self.run(arguments);
        assert!(!output.status.success());
        String::from_utf8(output.stderr).unwrap()
    }

    /// A recording of the machine that `truth.toml` is, along a path in steps of 5 um.
    fn record(&self, file: &str, run: u32) {
        let phase = f64::from(run);
        let position = |t: f64| {
            [(12.0, 0.6), (5.0, 1.7), (1.5, 3.9)].iter().fold(0.0, |x, (a, f)| {
                x + a * (TAU * f * t * (1.0 + 0.03 * phase) + phase * (1.0 + f)).sin()
            })
        };
        let times: Vec<f64> = (0..1000).map(|k| 0.01 * f64::from(k)).collect();
        let steps = |t: f64| 0.005 * (position(t) / 0.005).round();
        let table = |forces: &dyn Fn(usize) -> f64| {
            let mut text = "t,x_mm,F_kN\n".to_owned();
            for (k, &t) in times.iter().enumerate() {
                writeln!(text, "{t:.2},{:.3},{:.9}", steps(t), forces(k)).unwrap();
            }
            text
        };
        self.write(file, &table(&|_| 0.0));
        self.says(&["simulate", "truth.toml", "--like", file, "--out", "said.csv"]);
        let said = std::fs::read_to_string(self.path("said.csv")).unwrap();
        assert!(said.starts_with("t,F_kN\n"), "{said:.30}");
        let forces: Vec<f64> = said
            .lines()
            .skip(1)
            .map(|line| line.split(',').nth(1).unwrap().parse::<f64>().unwrap())
            .collect();
        // Newtons in the model; noise of 0.1 N that does not repeat.
        let noise = |k: usize| 0.17 * (f64::from(run) + 12.9898 * (k * k) as f64).sin();
        self.write(file, &table(&|k| 1e-3 * (forces[k] + noise(k))));
    }
}

#[test]
fn a_damper_in_a_rig_is_diagnosed_by_its_force() {
    let rig = Rig::new();
    for (run, file) in ["a.csv", "b.csv", "c.csv"].iter().enumerate() {
        rig.record(file, run as u32 + 1);
    }
    let check = rig.says(&["check", "model.toml", "a.csv", "b.csv"]);
    assert!(check.contains("Imposed motion, along its smoothed path between samples: x."));
    assert!(check.contains("kN -> N (x 1000)") && check.contains("no warnings"), "{check}");
    assert!(!check.contains("No column measures"), "{check}");

    let d = rig.json(&[
        "diagnose",
        "model.toml",
        "a.csv",
        "b.csv",
        "--held-out",
        "c.csv",
        "--out",
        "found",
        "--json",
    ]);
    assert_eq!(d["verdict"], "missing_physics", "{d:#}");
    assert_eq!(d["findings"][0]["class"], "quadratic_drag", "{d:#}");
    assert_eq!(d["findings"][0]["channel"], "x");
    assert_eq!(d["findings"].as_array().unwrap().len(), 1, "{d:#}");
    let fit = &d["fit"]["held_out"]["F_kN"];
    assert_eq!(fit["unit"], "N");
    assert!(fit["rmse_after"].as_f64() < Some(0.2) && fit["rmse_before"].as_f64() > Some(1.0));
    // The motion is no channel that could be predicted; the force that is missing is told.
    assert_eq!(d["fit"]["held_out"].as_object().unwrap().len(), 1);
    assert!(d["location"]["channels"]["x"]["significance"].as_f64() > Some(20.0), "{d:#}");

    let page = std::fs::read_to_string(rig.path("found/report.html")).unwrap();
    for over in ["F_kN against x", "F_kN against dx"] {
        assert!(page.contains(over), "no picture of {over}");
    }
    let error = |model: &str| {
        let run = rig.json(&["simulate", model, "--like", "c.csv", "--json"]);
        run["channels"]["F_kN"]["rmse"].as_f64().unwrap()
    };
    let (before, after) = (error("model.toml"), error("found/augmented.toml"));
    assert!(after < 0.2 && before > 5.0 * after, "{before} {after}");
    let both = rig.json(&["compare", "model.toml", "found/augmented.toml", "c.csv", "--json"]);
    assert!(both.to_string().contains("F_kN"), "{both:#}");
}

#[test]
fn what_does_not_fit_together_is_told() {
    let rig = Rig::new();
    rig.record("a.csv", 1);
    let text = std::fs::read_to_string(rig.path("a.csv")).unwrap();
    rig.write("unrecorded.csv", &text.replacen("x_mm", "s_mm", 1));
    let models = [
        ("velocity.toml", MODEL.replacen("of = \"x\"", "of = \"dx\"", 1)),
        ("silent.toml", MODEL.replacen("of = \"force on x\"", "of = \"x\"", 1)),
        ("stranger.toml", MODEL.replacen("force on x", "force on z", 1)),
        ("undeclared.toml", MODEL.replacen("of = \"x\"", "of = \"2*x\"", 1)),
    ];
    for (file, text) in &models {
        rig.write(file, text);
    }
    let table: [(&str, &str, &[&str]); 5] = [
        ("velocity.toml", "a.csv", &["velocity.toml", "19:6", "'dx'", "measurement of 'x'"]),
        ("silent.toml", "a.csv", &["silent.toml", "11:11", "force on"]),
        ("stranger.toml", "a.csv", &["stranger.toml", "24:16", "'force on z'", "there are x"]),
        ("model.toml", "unrecorded.csv", &["unrecorded.csv", "'x_mm'"]),
        ("undeclared.toml", "a.csv", &["a.csv", "'x' is imposed", "x_mm, F_kN"]),
    ];
    for (model, recording, parts) in table {
        let said = rig.error(&["check", model, recording]);
        for part in parts {
            assert!(said.contains(part), "{model}: {part}: {said}");
        }
    }
}
