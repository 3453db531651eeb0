//! Effects of a model file in `lacuna simulate`: the model that has them follows a machine that
//! has them, and the model without does not.

use lacuna::excitation::{add_gaussian_noise, rng};
use lacuna::plants::integrate::rk4_sampled;
use lacuna::plants::{Model, System};
use lacuna::recordings::{Column, Recording, write_csv_with_time};
use std::path::Path;
use std::process::Command;

const ROWS: usize = 600;
const NOISE: f64 = 1e-3;
const SEED: u64 = 11;

const MODEL: &str = r#"
name = "arm over a tank"
[[input]]
name = "tau"
unit = "N m"
[[coordinate]]
name = "q"
velocity = "dq"
unit = "rad"
[mechanics]
mass = [["0.05"]]
force = ["tau - 0.03*dq - 0.4*sin(q)"]
[[state]]
name = "h"
unit = "m"
derivative = "0.4 + tau - 0.5*h"
"#;

/// A class, its channel and its entries.
const EFFECTS: &[(&str, &str, &str)] = &[
    (
        "unknown_function",
        "q",
        "over = \"dq\"\nfrom = { value = -3, unit = \"rad/s\" }\nto = { value = 3, unit = \"rad/s\" }\n\
         force = { values = [0.16, 0.15, 0.14, 0.13, 0.12, 0.11, 0.1, 0.09, 0.08, 0.08, 0.1, 0.06, \
         -0.06, -0.1, -0.08, -0.08, -0.09, -0.1, -0.11, -0.12, -0.13, -0.14, -0.15, -0.16], \
         unit = \"N m\" }",
    ),
    ("backlash", "q", "stiffness = 0.3\ngap = 0.3"),
    ("overflow", "h", "rate = { value = 3, unit = \"1/s\" }\nposition = 0.85"),
    ("sensor_scale", "dq", "scale = 1.2"),
    ("sensor_bias", "dq", "bias = { value = 0.1, unit = \"rad/s\" }"),
    ("sensor_bias", "h", "bias = -0.05"),
    ("sensor_delay", "dq", "delay = 0.04"),
    ("sensor_delay", "q", "delay = 0.04"),
    ("input_delay", "tau", "delay = 0.053"),
];

/// What a machine shows of all its states, with noise.
fn record(truth: &Model) -> Recording {
    let time: Vec<f64> = (0..ROWS).map(|k| 0.01 * k as f64).collect();
    let torque: Vec<f64> =
        time.iter().map(|t| 0.25 * (2.3 * t).sin() + 0.15 * (5.1 * t).cos()).collect();
    let effective = truth.effective_inputs(&time, &torque);
    let system = System::new(truth);
    let start = system.at_rest(&[0.2, 0.0, 0.7]);
    let motion = rk4_sampled(&system, &start, &time, &effective, truth.hold, 8).unwrap();
    let mut rng = rng(SEED, 0);
    let mut columns: Vec<Column> = (0..3)
        .map(|i| {
            let series = (0..ROWS).map(|k| motion.state(k)[i]).collect();
            let mut values = truth.observed(i, &time, series);
            add_gaussian_noise(&mut values, NOISE, &mut rng).unwrap();
            Column { name: truth.state_name(i).to_owned(), values }
        })
        .collect();
    columns.push(Column { name: "tau".to_owned(), values: torque });
    Recording { name: String::new(), time, columns }
}

/// Largest error of any channel, in units of the noise.
fn error(folder: &Path, model: &str) -> f64 {
    let output = Command::new(env!("CARGO_BIN_EXE_lacuna"))
        .args(["simulate", model, "--like", "run.csv", "--json"])
        .current_dir(folder)
        .output()
        .unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let report: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    let channels = report["channels"].as_object().expect("channels");
    let rmse = channels.values().map(|c| c["rmse"].as_f64().expect("a number"));
    rmse.fold(0.0, f64::max) / NOISE
}

#[test]
fn a_model_with_the_effect_follows_the_machine_and_one_without_does_not() {
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, text: &str| std::fs::write(folder.path().join(name), text).unwrap();
    write("without.toml", MODEL);
    for (class, channel, entries) in EFFECTS {
        let text = format!(
            "{MODEL}\n[[effect]]\nclass = \"{class}\"\nchannel = \"{channel}\"\n{entries}\n"
        );
        let truth = Model::from_text(&text, "truth.toml").unwrap_or_else(|e| panic!("{e}"));
        write_csv_with_time(&folder.path().join("run.csv"), &record(&truth), "t").unwrap();
        write("with.toml", &text);
        let (with, without) =
            (error(folder.path(), "with.toml"), error(folder.path(), "without.toml"));
        assert!(with < 3.0, "{class} on {channel}: off by {with} times the noise");
        assert!(without > 10.0, "{class} on {channel}: without it off by {without}");
    }
}
