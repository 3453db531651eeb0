//! What is refused, and how it is said.

use crate::bench::{Bench, MODEL, ROWS, Run};

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
    assert!(said.contains("--window: 0.05 s hold 3 samples, at least 24 are needed"), "{said}");
    let said = bench.error(&["identify", &runs[0], "--widths", "1,2,3"]);
    assert!(said.contains("expected 2, one for each of x, dx; found 3"), "{said}");
    // Nothing is written when the regression fails.
    bench.error(&["identify", &runs[0], "--window", "0.05", "--out", "found"]);
    assert!(!bench.path("found").exists());
}
