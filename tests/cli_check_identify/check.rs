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

/// Times and velocities that are made of a run.
type Made<'m> = dyn Fn(&Run) -> (Vec<f64>, Vec<f64>) + 'm;

/// What `check` says of a recording with its velocity and times as they are made here.
fn said_of(bench: &Bench, made: &Made<'_>) -> Vec<String> {
    let run = Run::new(1);
    let (t, dx) = made(&run);
    bench.write("run.csv", &Run::csv(&[("t", &t), ("x", &run.x), ("dx", &dx), ("u", &run.u)]));
    let report = bench.json(&["check", "model.toml", "run.csv", "--json"]);
    warnings(&report).into_iter().map(str::to_owned).collect()
}

#[test]
fn check_tells_a_velocity_that_is_not_its_coordinates_rate() {
    let bench = Bench::new();
    let times = |run: &Run, factor: f64| run.dx.iter().map(|v| factor * v).collect::<Vec<f64>>();
    let of = |made: &dyn Fn(&Run) -> Vec<f64>| said_of(&bench, &|run| (run.t.clone(), made(run)));
    assert_eq!(of(&|run| times(run, 1.0)), [""; 0]);
    // A sensor's scale is no wrong unit.
    assert_eq!(of(&|run| times(run, 1.04)), [""; 0]);
    for (factor, words) in [
        (-1.0, "with the other sign"),
        (180.0 / std::f64::consts::PI, "degrees for radians"),
        (1e3, "thousandths (mm for m), or times in ms"),
        (1.3, "the rate of 'x' is 0.76"),
    ] {
        let said = of(&|run| times(run, factor));
        assert!(said.len() == 1 && said[0].contains(words), "{factor}: {said:?}");
    }
    let late = of(&|run| [&run.dx[..1].repeat(4), &run.dx[..ROWS - 4]].concat());
    let by: f64 = late[0].split(' ').find_map(|word| word.parse().ok()).unwrap();
    assert!(
        late[0].contains("after the rate of 'x'") && (by - 4.0 * STEP).abs() < 0.1 * STEP,
        "{late:?}"
    );
    let other = of(&|_| Run::new(2).dx);
    assert!(other[0].contains("'dx' is not the rate of 'x'"), "{other:?}");
}

/// Times in another unit are a mistake until the model says which.
#[test]
fn times_may_be_in_milliseconds_and_since_1970() {
    let bench = Bench::new();
    let since = |start: f64| {
        move |run: &Run| (run.t.iter().map(|t| start + (1e3 * t).round()).collect(), run.dx.clone())
    };
    let said = said_of(&bench, &since(0.0)).join("\n");
    assert!(said.contains("times in ms: then time_unit = \"ms\""), "{said}");
    let said = said_of(&bench, &since(1.78e12)).join("\n");
    assert!(said.contains("they look like ms since 1970: state time_unit = \"ms\""), "{said}");

    let in_ms = MODEL.replace("time = \"t\"", "time = \"t\"\ntime_unit = \"ms\"");
    assert_ne!(in_ms, MODEL);
    bench.write("model.toml", &in_ms);
    assert_eq!(said_of(&bench, &since(1.78e12)), [""; 0]);
    let report = bench.json(&["check", "model.toml", "run.csv#t=1.78e9..1780000002", "--json"]);
    assert_eq!(report["recordings"][0]["rows"].as_f64().unwrap(), 2.0 / STEP);
    let simulated =
        bench.lacuna(&["simulate", "model.toml", "--like", "run.csv", "--out", "sim.csv"]);
    assert!(simulated.status.success(), "{}", stderr(&simulated));
    let firsts = |name: &str| {
        let text = std::fs::read_to_string(bench.path(name)).unwrap();
        text.lines()
            .skip(1)
            .map(|l| l.split(',').next().unwrap().parse::<f64>().unwrap())
            .collect::<Vec<_>>()
    };
    assert_eq!(firsts("sim.csv"), firsts("run.csv"));
    // The same run as in seconds.
    let error = |model: &str, made: &Made<'_>| {
        bench.write("model.toml", model);
        said_of(&bench, made);
        bench.json(&["simulate", "model.toml", "--like", "run.csv", "--json"])["channels"]["x"]["rmse"].clone()
    };
    let [a, b] = [error(MODEL, &|run| (run.t.clone(), run.dx.clone())), error(&in_ms, &since(0.0))];
    assert!((a.as_f64().unwrap() / b.as_f64().unwrap() - 1.0).abs() < 1e-9, "{a} {b}");
    bench.write("model.toml", &in_ms.replace("\"ms\"", "\"mm\""));
    let refused = stderr(&bench.lacuna(&["check", "model.toml", "run.csv"]));
    assert!(refused.contains("'mm' is no unit of time"), "{refused}");
}
