//! `lacuna simulate` of a model that `lacuna identify` wrote.

use crate::bench::{Bench, ROWS, Run, arguments, stderr, stdout};
use lacuna::plants::Hold;
use serde_json::{Value, json};

/// A bench with the model that was identified from its first recordings.
fn identified(seeds: std::ops::RangeInclusive<u64>, more: &[&str]) -> Bench {
    let (bench, runs) = Bench::with_runs(seeds);
    let given = [&["identify", "--quiet", "--out", "found"], more].concat();
    let output = bench.lacuna(&arguments(&given, &runs));
    assert!(output.status.success(), "{}", stderr(&output));
    bench
}

fn rmse(report: &Value, channel: &str) -> f64 {
    report["channels"][channel]["rmse"].as_f64().unwrap()
}

/// The noise of the recordings' positions.
const NOISE: f64 = 1e-3;

#[test]
fn an_identified_model_runs_on_a_recording_it_has_not_seen() {
    let bench = identified(1..=6, &[]);
    bench.write("new.csv", &Run::new(8).position_only());
    let command = ["simulate", "found/model.json", "--like", "new.csv", "--json"];
    let free = bench.json(&command);
    assert_eq!((&free["mode"], &free["recording"]), (&"free_run".into(), &"new.csv".into()));
    assert_eq!((&free["model"], &free["warmup_samples"]), (&"found/model.json".into(), &50.into()));
    // A free run of eleven seconds, by a model of which nothing but recordings is known.
    assert!(free["channels"]["x"]["nrmse"].as_f64().unwrap() < 0.05, "{free}");
    assert_eq!(free["channels"]["x"]["unit"], "");
    let windowed =
        bench.json(&[&command[..], &["--horizon", "1", "--out", "new_sim.csv"]].concat());
    assert_eq!((&windowed["mode"], &windowed["horizon_s"]), (&"windowed".into(), &1.0.into()));
    // Twelve windows with two states each are fitted to 600 samples.
    assert!((rmse(&windowed, "x") / NOISE - 1.0).abs() < 0.15, "{windowed}");
    let text = std::fs::read_to_string(bench.path("new_sim.csv")).unwrap();
    assert_eq!((text.lines().next(), text.lines().count()), (Some("t,x"), ROWS + 1));
}

/// The kind of a model is told by its text, whatever its file is called.
#[test]
fn a_file_is_known_by_its_text() {
    let bench = identified(1..=2, &["--kernel", "polynomial"]);
    std::fs::copy(bench.path("found/model.json"), bench.path("model")).unwrap();
    std::fs::copy(bench.path("model.toml"), bench.path("equations.json")).unwrap();
    let text = stdout(&bench.lacuna(&["simulate", "model", "--like", "run2.csv"]));
    assert!(text.contains("running free") && text.contains("first 50 samples"), "{text}");
    let report = bench.json(&["simulate", "equations.json", "--like", "run2.csv", "--json"]);
    assert_eq!(
        (&report["model"], &report["channels"]["x"]["unit"]),
        (&"duffing".into(), &"m".into())
    );
}

/// Rates that are measured count, and a first-order model starts from its whole state.
#[test]
fn rates_and_whole_states_are_used() {
    let bench = Bench::new();
    for seed in 3..=6 {
        let run = Run::new(seed);
        let columns: [(&str, &[f64]); 4] =
            [("t", &run.t), ("x", &run.x), ("dx", &run.dx), ("u", &run.u)];
        bench.write(&format!("both{seed}.csv"), &Run::csv(&columns));
        bench.write(&format!("run{seed}.csv"), &run.position_only());
    }
    let files = [3, 4, 5, 6].map(|seed| format!("both{seed}.csv"));
    for (more, rows) in [(&["--channels", "x"][..], 2), (&[][..], 1)] {
        let given = [&["identify", "--json", "--out", "found"], more];
        let found = bench.json(&arguments(&given.concat(), &files));
        assert_eq!(found["order"], rows);
        let report = bench.json(&[
            "simulate",
            "found/model.json",
            "--like",
            "both4.csv",
            "--json",
            "--horizon",
            "1",
        ]);
        for (channel, noise) in [("x", NOISE), ("dx", 10.0 * NOISE)] {
            assert!(rmse(&report, channel) < 1.2 * noise, "order {rows}: {report}");
        }
        if rows == 2 {
            // Without the rates' column the smoother tells the rate at the start.
            let report = bench.json(&[
                "simulate",
                "found/model.json",
                "--like",
                "run4.csv",
                "--json",
                "--horizon",
                "1",
            ]);
            assert_eq!(report["channels"].as_object().unwrap().len(), 1);
            assert!(rmse(&report, "x") < 1.2 * NOISE, "{report}");
        } else {
            let said = bench.error(&["simulate", "found/model.json", "--like", "run4.csv"]);
            assert!(said.contains("run4.csv") && said.contains("no column 'dx'"), "{said}");
        }
    }
}

/// Inputs run between samples as they did when the model was identified.
#[test]
fn inputs_keep_their_path() {
    let bench = Bench::new();
    // Straight lines over four of these steps are nearly what passed between each fourth
    // sample. The third recording is held out: here the path counts, not what is beyond the others.
    for seed in 1..=3 {
        let run = Run::driven(seed, Hold::Linear);
        let some = |v: &Vec<f64>| v.iter().step_by(4).copied().collect::<Vec<f64>>();
        let (t, x, u) = (some(&run.t), some(&run.x), some(&run.u));
        bench.write(&format!("run{seed}.csv"), &Run::csv(&[("t", &t), ("x", &x), ("u", &u)]));
    }
    let files = [1, 2, 3].map(|seed| format!("run{seed}.csv"));
    let error = |hold: &str| {
        let given =
            ["identify", "--quiet", "--out", "found", "--kernel", "gaussian", "--input-hold", hold];
        bench.lacuna(&arguments(&given, &files));
        let free =
            ["simulate", "found/model.json", "--like", "run2.csv", "--json", "--horizon", "1"];
        rmse(&bench.json(&free), "x")
    };
    let (smooth, linear, held) = (error("smooth"), error("linear"), error("zero-order"));
    eprintln!("rms error: smooth {smooth}, linear {linear}, held {held}");
    // What was measured is noisy too: the right paths leave that noise alone.
    assert!(smooth.max(linear) < 1.1 * NOISE, "{smooth} {linear}");
    assert!(held > 1.25 * NOISE, "{held}");
}

/// The model file with something changed.
fn changed(bench: &Bench, name: &str, change: impl Fn(&mut Value)) {
    let text = std::fs::read_to_string(bench.path("found/model.json")).unwrap();
    let mut model: Value = serde_json::from_str(&text).unwrap();
    change(&mut model);
    bench.write(name, &model.to_string());
}

#[test]
fn what_cannot_be_run_is_refused() {
    let bench = identified(1..=2, &["--kernel", "polynomial"]);
    bench.write("other.json", "{\"a\": 1}");
    bench.write(
        "half.json",
        &std::fs::read_to_string(bench.path("found/model.json")).unwrap()[..300],
    );
    bench.write("list.json", "[1, 2]");
    changed(&bench, "unnamed.json", |m| drop(m.as_object_mut().unwrap().remove("names")));
    changed(&bench, "old.json", |m| m["version"] = json!(1));
    changed(&bench, "third.json", |m| m["order"] = json!(3));
    changed(&bench, "renamed.json", |m| m["names"]["inputs"] = json!(["u", "v"]));
    // A drift so strong that no step from sample to sample follows it.
    changed(&bench, "explosive.json", |m| {
        for w in m["expansions"][0]["weights"].as_array_mut().unwrap() {
            *w = json!(1e12 * w.as_f64().unwrap());
        }
    });
    let other = Run::new(2);
    bench.write("no_input.csv", &Run::csv(&[("t", &other.t), ("x", &other.x), ("v", &other.u)]));
    bench.write("no_channel.csv", &Run::csv(&[("t", &other.t), ("y", &other.x), ("u", &other.u)]));
    bench.write("no_time.csv", &Run::csv(&[("clock", &other.t), ("x", &other.x), ("u", &other.u)]));
    bench.write("short.csv", "t,x,u\n0,0,0\n0.1,0.2,0\n");
    let nan = vec![f64::NAN; ROWS];
    bench.write("nan.csv", &Run::csv(&[("t", &other.t), ("x", &nan), ("u", &other.u)]));
    for (model, recording, parts) in [
        ("other.json", "run1.csv", ["other.json", "no model that `lacuna identify` wrote"]),
        ("half.json", "run1.csv", ["half.json", "no model that `lacuna identify` wrote"]),
        ("list.json", "run1.csv", ["list.json:1", "unclosed table"]),
        ("unnamed.json", "run1.csv", ["unnamed.json", "does not name its columns"]),
        ("old.json", "run1.csv", ["old.json", "expected version 3"]),
        ("third.json", "run1.csv", ["third.json", "found order 3"]),
        ("renamed.json", "run1.csv", ["renamed.json", "expected 1 values, found 2"]),
        ("explosive.json", "run1.csv", ["explosive.json: the model diverges", "shorter --horizon"]),
        ("absent.json", "run1.csv", ["absent.json", "No such file"]),
        ("found", "run1.csv", ["found", "directory"]),
        ("found/model.json", "no_input.csv", ["no_input.csv", "no column 'u'"]),
        ("found/model.json", "no_channel.csv", ["no_channel.csv", "no column 'x'"]),
        ("found/model.json", "no_time.csv", ["no_time.csv", "clock"]),
        ("found/model.json", "short.csv", ["short.csv", "at least 100 are needed"]),
        ("found/model.json", "nan.csv", ["nan.csv", "'x'"]),
        ("found/model.json", "absent.csv", ["absent.csv", "No such file"]),
    ] {
        let said = bench.error(&["simulate", model, "--like", recording]);
        for part in parts {
            assert!(said.contains(part), "{model} {recording}: {said}");
        }
    }
    let said =
        bench.error(&["simulate", "found/model.json", "--like", "run1.csv", "--warmup", "600"]);
    assert!(said.contains("--warmup 600"), "{said}");
}

#[test]
fn other_commands_say_what_an_identified_model_is_for() {
    let bench = identified(1..=2, &["--kernel", "polynomial"]);
    for command in ["check", "diagnose"] {
        let said = bench.error(&[command, "found/model.json", "run1.csv"]);
        assert!(said.contains("found/model.json: a JSON file"), "{said}");
        assert!(said.contains("expected a model of equations"), "{said}");
    }
}
