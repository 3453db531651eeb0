//! `lacuna identify`.

use crate::bench::{Bench, ROWS, Run, arguments, stdout};
use lacuna::occupation::IdentifiedModel;
use lacuna::plants::Duffing;
use serde_json::{Value, json};
use std::path::Path;

#[test]
fn identify_learns_the_duffing_oscillator_from_positions() {
    let (bench, runs) = Bench::with_runs(1..=8);
    let report = bench.json(&arguments(&["identify", "--json", "--out", "found"], &runs));
    assert_eq!((&report["time"], &report["order"]), (&"t".into(), &2.into()));
    assert_eq!(report["arguments"], json!(["x", "dx"]));
    assert_eq!(report["held_out_recordings"], json!(["run7.csv", "run8.csv"]));
    let relative = |set: &str| report[set][0]["relative"].as_f64().unwrap();
    assert!(relative("training") < 0.01 && relative("held_out") < 0.01, "{report}");
    let noise = report["chosen"]["noise_sd"][0].as_f64().unwrap();
    assert!((noise / 1e-3 - 1.0).abs() < 0.15, "{noise}");
    assert!(report["own_share"][0].as_f64().unwrap() > 0.5, "{report}");
    assert_eq!(report["chosen"]["rows"][0]["blocks"][1]["depends_on"], json!([0]));
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
    let words: String = svg.split('<').filter_map(|tag| Some(tag.split_once('>')?.1)).collect();
    for (text, count) in [("median", 3), ("± 2 standard deviations", 1)] {
        assert_eq!(words.matches(text).count(), count, "{text}");
    }
    assert_eq!(svg.matches("class=\"band\"").count(), 3);
}

/// The learned drift and effectiveness against the true ones, along the recordings: near, and
/// within the standard deviations that are told.
fn learned(folder: &Path) {
    let model = IdentifiedModel::load(&folder.join("model.json")).unwrap();
    let names = model.names().unwrap();
    assert_eq!((&names.coordinates[..], &names.inputs[..]), (&["x".into()][..], &["u".into()][..]));
    let truth = Duffing::default();
    let table = |name: &str, header: &str| -> Vec<Vec<f64>> {
        let text = std::fs::read_to_string(folder.join(name)).unwrap();
        assert_eq!(text.lines().next(), Some(header));
        let row = |l: &str| l.split(',').map(|c| c.parse().unwrap()).collect();
        text.lines().skip(1).map(row).collect()
    };
    let drift = table("drift.csv", "recording,t,x,dx,f_x,f_x_sd");
    let effectiveness = table("effectiveness.csv", "recording,t,x,dx,g_x_u,g_x_u_sd");
    assert!(drift.len() <= 1000 && drift.len() > 500 && effectiveness.len() == drift.len());
    let (mut errors, mut covered) = ([0.0, 0.0], [0.0, 0.0]);
    for (f, g) in drift.iter().zip(&effectiveness) {
        let (mut own_f, mut own_g) = ([0.0], [0.0]);
        model.evaluate(&f[2..4], &mut own_f, &mut own_g).unwrap();
        assert_eq!((own_f[0], own_g[0]), (f[4], g[4]));
        let sd = model.standard_deviations(&f[2..4]).unwrap().unwrap();
        // The file holds landmarks; the basis that is built on them anew is the same up to rounding.
        let near = |a: f64, b: f64| (a / b - 1.0).abs() < 1e-4;
        assert!(near(sd.f[0], f[5]) && near(sd.g[0], g[5]), "{sd:?} {f:?} {g:?}");
        for (k, (row, true_value)) in [(f, truth.f(f[2])), (g, truth.g(g[2]))].iter().enumerate() {
            let error = row[4] - true_value;
            errors[k] += error * error / drift.len() as f64;
            covered[k] += f64::from(u8::from(error.abs() < 3.0 * row[5])) / drift.len() as f64;
        }
    }
    let [f, g] = errors.map(f64::sqrt);
    eprintln!("rms error of f {f:.4}, of g {g:.4}; within 3 sd {covered:.2?}");
    assert!(f < 0.02 && g < 0.02, "rms error of f {f}, of g {g}");
    assert!(covered.iter().all(|c| *c > 0.9), "within 3 sd: {covered:?}");
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
    assert_eq!(report["channels"], json!(["x", "dx"]));
    assert_eq!(report["inputs"], json!(["force"]));
    assert!(report["training"][0]["relative"].as_f64().unwrap() < 0.1, "{report}");
    // Positions alone with their velocities beside them are of second order, and both count.
    let report = bench.json(&["identify", "run.csv", "--json", "--channels", "x"]);
    assert_eq!((&report["order"], &report["velocities"][0]), (&2.into(), &"dx".into()));
    let noise: Vec<f64> = serde_json::from_value(report["chosen"]["noise_sd"].clone()).unwrap();
    assert!(
        (noise[0] / 1e-3 - 1.0).abs() < 0.3 && (noise[1] / 1e-2 - 1.0).abs() < 0.3,
        "{noise:?}"
    );
}

#[test]
fn identify_keeps_what_is_given() {
    let (bench, runs) = Bench::with_runs(1..=4);
    let blocks = |more: &[&str]| -> Vec<Value> {
        let report = bench.json(&arguments(&[&["identify", "--json"], more].concat(), &runs));
        report["chosen"]["rows"][0]["blocks"].as_array().unwrap().clone()
    };
    for (kernel, family) in [
        ("gaussian", json!("gaussian")),
        ("matern", json!("matern")),
        ("exponential", json!("exponential")),
        ("polynomial", json!({"polynomial": 3})),
    ] {
        for block in blocks(&["--kernel", kernel]) {
            assert_eq!(block["kernel"]["family"], family);
        }
    }
    for block in blocks(&["--kernel", "polynomial", "--widths", "1,5"]) {
        assert_eq!(block["kernel"]["widths"], json!([1.0, 5.0]));
    }
    let report = bench.json(&arguments(&["identify", "--json", "--window", "1.5"], &runs));
    // Recordings are cut into equal windows about as long.
    let longest = report["chosen"]["window_seconds"].as_f64().unwrap();
    assert!((longest / 1.5 - 1.0).abs() < 0.25, "{longest}");
    assert_eq!(report["window_s"], 1.5);
    let text = stdout(&bench.lacuna(&arguments(&["identify", "--kernel", "polynomial"], &runs)));
    for part in ["polynomial of degree 3", "g of x by u", "noise: x", "Residuals in windows of"] {
        assert!(text.contains(part), "{part}: {text}");
    }
}

#[test]
fn identify_warns_of_an_input_that_does_not_move() {
    let bench = Bench::new();
    let still = vec![0.3; ROWS];
    let nearly: Vec<f64> = (0..ROWS).map(|k| 1e-4 * (0.1 * k as f64).sin()).collect();
    let write = |name: &str, second: &[f64]| {
        let run = Run::new(2);
        let columns: [(&str, &[f64]); 4] =
            [("t", &run.t), ("x", &run.x), ("u1", &run.u), ("u2", second)];
        bench.write(name, &Run::csv(&columns));
    };
    write("still.csv", &still);
    let text = stdout(&bench.lacuna(&["identify", "still.csv"]));
    assert!(text.contains("the effectiveness of 'u2' cannot be told"), "{text}");
    write("nearly.csv", &nearly);
    let text = stdout(&bench.lacuna(&["identify", "nearly.csv"]));
    // Which of the two notes it is depends on how wide the prior was.
    let doubted = |input: &str| {
        text.contains(&format!("'{input}' may have no effect on 'x'"))
            || text.contains(&format!("hardly tell what '{input}' does to 'x'"))
    };
    assert!(doubted("u2") && !doubted("u1"), "{text}");
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

/// Glitches and turns in the recordings are left out and made continuous, and it is said.
#[test]
fn identify_conditions_recordings_as_check_does() {
    let bench = Bench::new();
    let mut runs = Vec::new();
    for seed in 1..=3 {
        let mut run = Run::new(seed);
        // In degrees, within one turn: all begin in the same one, and leave it on their way.
        let turn = |x: f64| 360.0 * (x / 360.0 - (x / 360.0).floor());
        run.x.iter_mut().for_each(|x| *x = turn(180.0 + 120.0 * *x));
        for row in [80, 200] {
            run.x[row] = turn(run.x[row] + 20.0);
        }
        let name = format!("run{seed}.csv");
        bench.write(&name, &run.position_only());
        runs.push(name);
    }
    let report = bench.json(&arguments(&["identify", "--json", "--units", "x=deg"], &runs));
    assert_eq!(report["outliers"], json!({ "x": 6 }), "{report}");
    assert!(report["leaps"]["x"].as_u64().unwrap() >= 3, "{report}");
    let notes = report["notes"].to_string();
    assert!(notes.contains("Left out as outliers") && notes.contains("6 samples of x"), "{notes}");
    assert!(notes.contains("made continuous: x"), "{notes}");
    // Without a unit nothing is assumed, and what to say is told.
    let report = bench.json(&arguments(&["identify", "--json"], &runs));
    assert_eq!(report["leaps"], json!({}), "{report}");
    assert!(report["notes"].to_string().contains("--units x=deg"), "{report}");
    let said = bench.error(&arguments(&["identify", "--units", "y=deg"], &runs));
    assert!(said.contains("'y'"), "{said}");
}
