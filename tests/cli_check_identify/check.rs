//! `lacuna check`.

use crate::bench::{Bench, MODEL, ROWS, Run, STEP, arguments, stderr, stdout};
use serde_json::Value;

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

/// A state that nobody measures is told by what depends on it: parameters are assessed, as they would be fitted.
#[test]
fn check_assesses_parameters_beside_a_state_that_is_not_measured() {
    let model = "name = \"heater\"\n[parameters]\nslow = { value = 0.6, unit = \"s\", tolerance = 0.1 }\n\
        fast = { value = 0.1, unit = \"s\", tolerance = 0.1 }\n[[input]]\nname = \"u\"\nunit = \"K\"\n\
        [[state]]\nname = \"air\"\nunit = \"K\"\nderivative = \"(u - air)/slow\"\n\
        [[state]]\nname = \"bead\"\nunit = \"K\"\nderivative = \"(air - bead)/fast\"\n";
    let bench = Bench::new();
    bench.write("model.toml", model);
    let run = Run::new(1);
    // Exact within a held input but for the order of its steps.
    let (mut air, mut bead, mut seen) = (0.0, 0.0, vec![]);
    for (k, u) in run.u.iter().enumerate() {
        seen.push(bead + 1e-4 * ((k * k * 7 % 11) as f64 - 5.0));
        for _ in 0..20 {
            let step = STEP / 20.0;
            (air, bead) = (air + step * (u - air) / 0.6, bead + step * (air - bead) / 0.1);
        }
    }
    bench.write("run.csv", &Run::csv(&[("t", &run.t), ("bead", &seen), ("u", &run.u)]));
    let report = bench.json(&["check", "model.toml", "run.csv", "--json"]);
    assert_eq!(warnings(&report), [""; 0]);
    assert_eq!(report["not_measured"], serde_json::json!(["air"]));
    let list = report["parameters"]["list"].as_array().unwrap();
    assert_eq!(list.len(), 2);
    assert!(list.iter().all(|p| p["excited"] == true), "{list:?}");
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
fn check_tells_outliers_and_steps_of_encoders() {
    let bench = Bench::new();
    let run = Run::new(1);
    let mut x: Vec<f64> = run.x.iter().map(|x| (x / 0.05).round() * 0.05).collect();
    for row in [100, 250, 251, 420, 510] {
        x[row] += 1.0;
    }
    bench.write("run.csv", &Run::csv(&[("t", &run.t), ("x", &x), ("u", &run.u)]));
    let report = bench.json(&["check", "model.toml", "run.csv", "--json"]);
    let outliers = &report["channels"][0]["outliers"][0];
    assert_eq!(outliers["count"], 5, "{outliers}");
    assert_eq!(outliers["first_s"], serde_json::json!([run.t[100], run.t[250], run.t[251]]));
    let text = stdout(&bench.lacuna(&["check", "model.toml", "run.csv"]));
    assert!(text.contains("x is quantised in steps of 0.05 m, "), "{text}");
    assert!(text.contains("are left out: 5 in run.csv (at 2, 5, 5.02, ... s)"), "{text}");
    // They do not count for errors.
    let of = |file: &str| {
        bench.json(&["simulate", "model.toml", "--like", file, "--json"])["channels"]["x"].clone()
    };
    let with = of("run.csv");
    assert_eq!(with["outliers"], 5);
    assert!(with["rmse"].as_f64().unwrap() < 0.05, "{with}");
}

#[test]
fn check_tells_of_sensors_at_their_limits() {
    let bench = Bench::new();
    bench.write("model.toml", MODEL);
    let run = Run::new(1);
    let limit = 0.6 * run.x.iter().fold(0.0f64, |a, x| a.max(*x));
    let x: Vec<f64> = run.x.iter().map(|x| x.min(limit)).collect();
    bench.write("run.csv", &Run::csv(&[("t", &run.t), ("x", &x), ("u", &run.u)]));
    let report = bench.json(&["check", "model.toml", "run.csv", "--json"]);
    let channel = &report["channels"][0];
    let expected = x.iter().filter(|x| **x == limit).count();
    assert!(expected > 20);
    assert_eq!(channel["saturated"][0]["count"], expected, "{channel}");
    assert!(channel["outliers"].as_array().unwrap().is_empty(), "{channel}");
    let text = stdout(&bench.lacuna(&["check", "model.toml", "run.csv"]));
    assert!(text.contains("x: the sensor is at the end of its range"), "{text}");
    assert!(text.contains(&format!("not measured: {expected} in run.csv")), "{text}");
}

#[test]
fn check_tells_of_wrapped_angles() {
    let bench = Bench::new();
    bench.write("model.toml", &MODEL.replace("unit = \"m\"", "unit = \"rad\""));
    let run = Run::new(1);
    let turn = std::f64::consts::TAU;
    // The middle of the motion is where the sensor wraps.
    let (low, high) = run.x.iter().fold((0.0f64, 0.0f64), |(a, b), x| (a.min(*x), b.max(*x)));
    let edge = 0.5 * (low + high);
    let x: Vec<f64> = run.x.iter().map(|x| if *x < edge { x + turn } else { *x }).collect();
    bench.write("run.csv", &Run::csv(&[("t", &run.t), ("x", &x), ("u", &run.u)]));
    let report = bench.json(&["check", "model.toml", "run.csv", "--json"]);
    let channel = &report["channels"][0];
    assert!(channel["leaps"][0]["count"].as_u64().unwrap() > 0, "{channel}");
    let range = &channel["range"];
    let moves = range[1].as_f64().unwrap() - range[0].as_f64().unwrap();
    assert!((moves - (high - low)).abs() < 0.05, "{range}");
    let text = stdout(&bench.lacuna(&["check", "model.toml", "run.csv"]));
    assert!(text.contains("x is an angle recorded within one turn"), "{text}");
}
