//! `lacuna identify`.

use crate::bench::{Bench, Run, arguments, stdout};
use lacuna::occupation::IdentifiedModel;
use lacuna::plants::Duffing;
use std::path::Path;

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
