//! `lacuna compare`: two models against the same recordings.

use crate::bench::{Bench, MODEL, ROWS, Run, arguments, stderr, stdout};
use serde_json::{Value, json};

/// The noise of the recordings' positions.
const NOISE: f64 = 1e-3;

/// The machine's own model, and one whose input is too weak.
fn bench() -> (Bench, Vec<String>) {
    let (bench, runs) = Bench::with_runs(1..=2);
    bench.write("weak.toml", &MODEL.replace("value = 2,", "value = 1.6,"));
    (bench, runs)
}

fn rmse(errors: &Value, model: &str) -> f64 {
    errors[model]["rmse"].as_f64().unwrap()
}

#[test]
fn errors_are_those_of_simulate_and_pool_over_recordings() {
    let (bench, runs) = bench();
    for more in [&[][..], &["--horizon", "1"], &["--warmup", "80"]] {
        let command = [&["compare", "weak.toml", "model.toml", "--json"], more].concat();
        let found = bench.json(&arguments(&command, &runs));
        let mode = if more.first() == Some(&"--horizon") { "windowed" } else { "free_run" };
        assert_eq!((&found["mode"], &found["a"]), (&mode.into(), &"weak.toml".into()));
        for (k, model) in [("a", "weak.toml"), ("b", "model.toml")] {
            let mut squares = 0.0;
            for (run, one) in runs.iter().zip(found["recordings"].as_array().unwrap()) {
                let command = [&["simulate", model, "--json", "--like", run], more].concat();
                let mut alone = bench.json(&command)["channels"]["x"].clone();
                assert_eq!(alone.as_object_mut().unwrap().remove("unit"), Some("m".into()));
                assert_eq!(one["channels"]["x"][k], alone, "{more:?} {run} {model}");
                assert_eq!(&one["name"], run);
                squares += rmse(&one["channels"]["x"], k).powi(2);
            }
            // The recordings are as long as each other.
            let pooled = (squares / 2.0).sqrt();
            let told = rmse(&found["channels"]["x"], k);
            assert!((told / pooled - 1.0).abs() < 1e-9, "{told} {pooled}");
        }
        let x = &found["channels"]["x"];
        assert_eq!((&x["unit"], &x["closer"]), (&"m".into(), &"B".into()));
        let noise = x["noise"].as_f64().unwrap();
        assert!((noise / NOISE - 1.0).abs() < 0.15, "{noise}");
        assert!(rmse(x, "b") < 3.0 * NOISE && rmse(x, "a") > 5.0 * rmse(x, "b"), "{x}");
    }
}

#[test]
fn a_page_and_its_numbers_are_written() {
    let (bench, runs) = bench();
    let command = ["compare", "weak.toml", "model.toml", "--out", "found"];
    let said = stdout(&bench.lacuna(&arguments(&command, &runs)));
    assert!(said.contains("A is weak.toml, B is model.toml, on 2 recordings"), "{said}");
    assert!(said.contains("model.toml is closer in x."), "{said}");
    assert!(said.contains("Written: found/compare.html"), "{said}");
    let row = said.lines().find(|l| l.trim_start().starts_with("x ")).expect("a row of x");
    assert!(row.contains("noise") && row.ends_with('B'), "{row}");

    let page = std::fs::read_to_string(bench.path("found/compare.html")).unwrap();
    for word in ["weak.toml", "model.toml", "run1.csv", "run2.csv", "measured"] {
        assert!(page.contains(word), "{word}");
    }
    assert_eq!(page.matches("<svg class=").count(), 2, "one figure for each recording");
    for elsewhere in ["src=", "<link", "@import"] {
        assert!(!page.contains(elsewhere), "the page needs nothing else: {elsewhere}");
    }
    let written = std::fs::read_to_string(bench.path("found/compare.json")).unwrap();
    let printed = bench.json(&arguments(&[&command[..3], &["--json"]].concat(), &runs));
    assert_eq!(serde_json::from_str::<Value>(&written).unwrap(), printed);
    let mut files: Vec<_> = std::fs::read_dir(bench.path("found"))
        .unwrap()
        .map(|f| f.unwrap().file_name().into_string().unwrap())
        .collect();
    files.sort();
    assert_eq!(files, ["compare.html", "compare.json"]);

    let quiet = bench.lacuna(&arguments(&[&command[..3], &["--quiet"]].concat(), &runs));
    assert!(quiet.status.success() && quiet.stdout.is_empty() && quiet.stderr.is_empty());
}

/// Models of different names and kinds are compared on what both measure.
#[test]
fn equations_stand_beside_what_was_identified() {
    let (bench, runs) = Bench::with_runs(1..=4);
    bench.write("other.toml", &MODEL.replace("\"duffing\"", "\"spring\"").replace("k3*x^3", "x^3"));
    let given = ["identify", "--quiet", "--kernel", "gaussian", "--out", "found"];
    assert!(bench.lacuna(&arguments(&given, &runs)).status.success());
    let command =
        ["compare", "found/model.json", "other.toml", "run1.csv", "--horizon", "1", "--json"];
    let found = bench.json(&command);
    assert_eq!((&found["a"], &found["b"]), (&"model.json".into(), &"other.toml".into()));
    let x = &found["channels"]["x"];
    assert_eq!(x["unit"], "m", "of the one that names it: {x}");
    assert!(rmse(x, "a") < 1.5 * NOISE && rmse(x, "b") < 1.5 * NOISE, "{x}");
    assert_eq!(x["closer"], "same");
}

#[test]
fn a_model_that_diverges_has_no_error() {
    let (bench, runs) = bench();
    bench.write("explosive.toml", &MODEL.replace("- k3*x^3", "+ 500*x^3"));
    let command = ["compare", "model.toml", "explosive.toml", "--out", "found", "--json"];
    let found = bench.json(&arguments(&command, &runs));
    let x = &found["channels"]["x"];
    let none = json!({"rmse": null, "nrmse": null, "fit_percent": null});
    assert_eq!((&x["b"], &x["closer"]), (&none, &"A".into()));
    let page = std::fs::read_to_string(bench.path("found/compare.html")).unwrap();
    assert!(page.contains("diverges"));
    let said = stdout(&bench.lacuna(&arguments(&command[..3], &runs)));
    assert!(said.contains("diverges") && said.contains("model.toml is closer in x"), "{said}");
}

#[test]
fn what_cannot_be_compared_is_refused() {
    let (bench, _) = bench();
    let run = Run::new(3);
    let both: [(&str, &[f64]); 4] = [("t", &run.t), ("x", &run.x), ("dx", &run.dx), ("u", &run.u)];
    bench.write("both.csv", &Run::csv(&both));
    bench.write("no_input.csv", &Run::csv(&[("t", &run.t), ("x", &run.x), ("v", &run.u)]));
    bench.write("renamed.toml", &MODEL.replace("velocity = \"dx\"", "velocity = \"v\""));
    let measurement = "\n[[measurement]]\ncolumn = \"x\"\nof = \"x\"\nunit = \"mm\"\n";
    bench.write("mm.toml", &format!("{MODEL}{measurement}"));
    for (models, recordings, parts) in [
        (
            ["model.toml", "renamed.toml"],
            &["both.csv"][..],
            ["renamed.toml: no channel 'dx'", "both.csv"],
        ),
        (
            ["renamed.toml", "model.toml"],
            &["both.csv"],
            ["renamed.toml: no channel 'dx'", "model.toml"],
        ),
        (["model.toml", "mm.toml"], &["run1.csv"], ["channel 'x' of run1.csv", "mm.toml"]),
        (
            ["model.toml", "weak.toml"],
            &["run1.csv", "both.csv"],
            ["run1.csv has the channels x,", "both.csv"],
        ),
        (["model.toml", "weak.toml"], &["no_input.csv"], ["no_input.csv", "'u'"]),
        (["model.toml", "weak.toml"], &["run1.csv", "absent.csv"], ["absent.csv", "No such file"]),
        (["model.toml", "absent.toml"], &["run1.csv"], ["absent.toml", "No such file"]),
    ] {
        let command = [&["compare"], &models[..], recordings, &["--out", "found"]].concat();
        let said = bench.error(&command);
        for part in parts {
            assert!(said.contains(part), "{command:?}: {said}");
        }
        assert!(!bench.path("found").exists(), "an error writes nothing");
    }
    let long = ROWS.to_string();
    let said = bench.error(&["compare", "model.toml", "weak.toml", "run1.csv", "--warmup", &long]);
    assert!(said.contains("--warmup 600"), "{said}");
    let output = bench.lacuna(&["compare", "model.toml", "weak.toml"]);
    assert!(stderr(&output).contains("RECORDINGS"), "{}", stderr(&output));
}
