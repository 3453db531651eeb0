//! `lacuna simulate`, `lacuna diagnose` and `lacuna demo` as a user runs them.

mod arm;

use arm::{MODEL, NOISE, record};
use lacuna::discrepancy::Diagnosis;
use lacuna::discrepancy::diagnosis::Verdict;
use lacuna::excitation::{add_gaussian_noise, rng};
use lacuna::plants::Model;
use lacuna::recordings::{Column, RecordingSource, write_csv_with_time};
use serde_json::Value;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

const ROWS: usize = 700;

const FRICTION: &str = "\n[[effect]]\nclass = \"coulomb_friction\"\nchannel = \"q\"\nmagnitude = 0.06\nsmoothing_velocity = 0.02\n";

/// A folder with the model and three recordings of a machine.
struct Bench {
    folder: tempfile::TempDir,
}

impl Bench {
    /// `concealed` is added to the machine and not to the model.
    fn of(concealed: &str) -> Self {
        let bench = Self { folder: tempfile::tempdir().unwrap() };
        bench.write("model.toml", MODEL.as_bytes());
        let truth = Model::from_text(&format!("{MODEL}{concealed}"), "truth.toml").unwrap();
        for run in 0..3 {
            let path = bench.path(&format!("run{run}.csv"));
            write_csv_with_time(&path, &record(&truth, (7, run), ROWS), "t").unwrap();
        }
        bench
    }

    fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    fn write(&self, name: &str, bytes: &[u8]) {
        std::fs::write(self.path(name), bytes).unwrap();
    }

    fn text(&self, name: &str) -> String {
        std::fs::read_to_string(self.path(name)).unwrap()
    }

    fn lacuna(&self, arguments: &[&str]) -> Output {
        lacuna(self.folder.path(), arguments)
    }

    /// What a run that succeeds prints.
    fn prints(&self, arguments: &[&str]) -> String {
        let output = self.lacuna(arguments);
        assert_eq!(output.status.code(), Some(0), "{arguments:?}: {}", stderr(&output));
        String::from_utf8(output.stdout).unwrap()
    }

    fn json(&self, arguments: &[&str]) -> Value {
        serde_json::from_str(&self.prints(arguments)).unwrap()
    }

    /// The message of a run that must end with exit code 2 and without a panic.
    fn error(&self, arguments: &[&str]) -> String {
        let output = self.lacuna(arguments);
        let said = stderr(&output);
        assert_eq!(output.status.code(), Some(2), "{arguments:?}: {said}");
        assert!(said.starts_with("lacuna: "), "{said}");
        assert!(!said.contains("panicked"), "{said}");
        assert!(output.stdout.is_empty(), "an error prints no result");
        said
    }
}

fn lacuna(folder: &Path, arguments: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_lacuna"));
    command.args(arguments).current_dir(folder).output().unwrap()
}

fn stderr(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

const RUNS: [&str; 3] = ["run0.csv", "run1.csv", "run2.csv"];

fn diagnose<'a>(more: &[&'a str]) -> Vec<&'a str> {
    [&["diagnose", "model.toml"], &RUNS[..], more].concat()
}

#[test]
fn simulate_runs_free_and_tells_the_error() {
    let bench = Bench::of("");
    let said = bench.prints(&["simulate", "model.toml", "--like", "run0.csv"]);
    assert!(said.contains("running free") && said.contains("50 samples"), "{said}");
    let row = said.lines().find(|l| l.starts_with("q ")).expect("a row for the channel");
    assert!(row.contains("rad"), "{row}");

    let report = bench.json(&["simulate", "model.toml", "--like", "run0.csv", "--json"]);
    assert_eq!(report["mode"], "free_run");
    let q = report["channels"]["q"].as_object().expect("q is there");
    let keys: Vec<&str> = q.keys().map(String::as_str).collect();
    assert_eq!(keys.len(), 4, "{keys:?}");
    assert_eq!(q["unit"], "rad");
    let number = |key: &str| q[key].as_f64().expect("a number");
    // The right model, free for seven seconds from a state that fifty samples tell, misses by
    // little more than the noise.
    assert!((0.9..3.0).contains(&(number("rmse") / NOISE)), "{q:?}");
    assert!((number("fit_percent") - 100.0 * (1.0 - number("nrmse"))).abs() < 1e-9);
    assert!(number("nrmse") > 0.0 && number("nrmse") < 0.1);
}

#[test]
fn simulate_restarts_with_a_horizon() {
    let bench = Bench::of(FRICTION);
    let run = ["simulate", "model.toml", "--like", "run0.csv", "--json"];
    let free = bench.json(&run);
    let windowed = bench.json(&[&run[..], &["--horizon", "0.3"]].concat());
    assert_eq!(windowed["mode"], "windowed");
    let rmse = |v: &Value| v["channels"]["q"]["rmse"].as_f64().expect("a number");
    assert!(rmse(&windowed) < 0.2 * rmse(&free), "{} {}", rmse(&windowed), rmse(&free));
    let said = bench.prints(&["simulate", "model.toml", "--like", "run0.csv", "--horizon", "0.3"]);
    assert!(said.contains("restarted every 0.3 s"), "{said}");
}

/// The file holds what was simulated: its distance from the recording is the error told.
#[test]
fn simulate_writes_what_it_simulated() {
    let bench = Bench::of(FRICTION);
    let report = bench.json(&[
        "simulate",
        "model.toml",
        "--like",
        "run1.csv",
        "--warmup",
        "80",
        "--json",
        "--out",
        "sim.csv",
    ]);
    let read = |name: &str| {
        lacuna::recordings::read(&RecordingSource::file(bench.path(name)), "t").unwrap()
    };
    let (measured, simulated) = (read("run1.csv"), read("sim.csv"));
    assert_eq!(simulated.time, measured.time);
    let pairs = measured.column("q").unwrap().iter().zip(simulated.column("q").unwrap());
    let squares: Vec<f64> = pairs.skip(80).map(|(a, b)| (a - b).powi(2)).collect();
    let rmse = (squares.iter().sum::<f64>() / squares.len() as f64).sqrt();
    let told = report["channels"]["q"]["rmse"].as_f64().expect("a number");
    assert!((rmse / told - 1.0).abs() < 1e-9, "{rmse} {told}");
    assert_eq!(report["warmup_samples"], 80);
}

#[test]
fn diagnose_writes_a_diagnosis_a_model_and_a_page() {
    let bench = Bench::of(FRICTION);
    let said = bench.prints(&diagnose(&["--out", "found", "--figures"]));
    assert!(said.contains("ry (Coulomb) friction"), "{said}");
    assert!(said.contains("report.html"), "{said}");

    let text = bench.text("found/diagnosis.json");
    let raw: Value = serde_json::from_str(&text).unwrap();
    for key in ["schema", "model", "verdict", "findings", "calibration", "location", "fit"] {
        assert!(!raw[key].is_null(), "{key}");
    }
    assert_eq!((&raw["schema"], &raw["model"]), (&Value::from(1), &Value::from("arm")));
    assert_eq!(raw["verdict"], "missing_physics");
    let finding = &raw["findings"][0];
    assert_eq!((&finding["class"], &finding["channel"]), (&"coulomb_friction".into(), &"q".into()));
    assert_eq!(finding["depends_on"], serde_json::json!(["dq"]));
    assert!(finding["time"].is_null() && finding["says"].is_string());
    assert!(finding["region"]["dq"][0].as_f64() < finding["region"]["dq"][1].as_f64());
    let magnitude = &finding["parameters"]["magnitude"];
    let (value, std) = (magnitude["value"].as_f64().unwrap(), magnitude["std"].as_f64().unwrap());
    assert!((value - 0.06).abs() < f64::max(4.0 * std, 0.003), "{value} +- {std}");
    assert_eq!(magnitude["unit"], "N m");
    assert!((0.0..=1.0).contains(&finding["probability"].as_f64().unwrap()));
    assert!(finding["alternatives"].is_array());
    let j = &raw["calibration"]["J"];
    assert_eq!((&j["nominal"], &j["unit"]), (&Value::from(0.05), &Value::from("kg m^2")));
    assert!(raw["location"]["channels"]["q"]["significance"].is_number());
    assert_eq!(
        raw["location"]["channels"]["q"]["explained_by"],
        serde_json::json!(["coulomb_friction"])
    );
    let fit = &raw["fit"]["held_out"]["q"];
    for key in ["rmse_before", "rmse_after", "noise", "horizon_s"] {
        assert!(fit[key].as_f64().is_some_and(|v| v > 0.0), "{key}");
    }
    assert!(raw["fit"]["training"]["q"].is_object());
    // Nothing is lost on the way through the library's type.
    let diagnosis: Diagnosis = serde_json::from_str(&text).unwrap();
    assert_eq!(serde_json::to_value(&diagnosis).unwrap(), raw);
    // What was learned over the velocity is there for a picture, whatever its name.
    let learned = &raw["location"]["channels"]["q"]["curves"][0];
    assert_eq!((&learned["variable"], &learned["force_unit"]), (&"dq".into(), &"N m".into()));
    let count = |key: &str| learned[key].as_array().map(Vec::len);
    assert!(count("at").is_some_and(|n| n > 20) && count("at") == count("learned"));
    assert!(count("at") == count("std") && learned["law"].is_null());
    let page = bench.text("found/report.html");
    for words in [
        "coulomb_friction",
        "Residuals: measured minus model",
        "Autocorrelation of the residuals",
        "lacuna diagnose model.toml run0.csv run1.csv run2.csv --out found --figures",
    ] {
        assert!(page.contains(words), "{words}");
    }
    // No path but those that were typed.
    assert!(!page.contains(bench.folder.path().to_str().expect("a name in Unicode")));
    assert!(!page.contains(env!("CARGO_BIN_EXE_lacuna")));
    // Each picture of the page is a file, and nothing else is left behind.
    let files = std::fs::read_dir(bench.path("found/figures")).unwrap();
    let mut names: Vec<String> =
        files.map(|f| f.unwrap().file_name().into_string().unwrap()).collect();
    names.sort();
    assert_eq!(names.len(), page.matches("<svg ").count(), "{names:?}");
    for name in &names {
        let svg = bench.text(&format!("found/figures/{name}"));
        assert!(name.ends_with(".svg") && svg.starts_with("<svg") && svg.ends_with("</svg>\n"));
    }
    assert!(names[0].starts_with("01-errors-arm"), "{names:?}");

    // The augmented model is a model, keeps the comments, and predicts better.
    let augmented = bench.text("found/augmented.toml");
    assert!(augmented.starts_with("# A motor that turns an arm."), "{augmented}");
    let rmse = |model: &str| {
        let run = bench.json(&["simulate", model, "--like", "run2.csv", "--json"]);
        run["channels"]["q"]["rmse"].as_f64().expect("a number")
    };
    let (before, after) = (rmse("model.toml"), rmse("found/augmented.toml"));
    assert!(after < 1.5 * NOISE && before > 5.0 * after, "{before} {after}");

    // Diagnosed again, the augmented model lacks nothing.
    let again = [&["diagnose", "found/augmented.toml"], &RUNS[..], &["--json"]].concat();
    let again: Diagnosis = serde_json::from_value(bench.json(&again)).unwrap();
    assert!(again.findings.is_empty(), "{:?}", again.findings);
    assert_eq!(again.verdict, Verdict::NoMismatch);
}

#[test]
fn diagnose_answers_scripts() {
    let bench = Bench::of(FRICTION);
    let output = bench.lacuna(&diagnose(&["--exit-code", "--quiet"]));
    assert_eq!(output.status.code(), Some(1), "{}", stderr(&output));
    assert!(output.stdout.is_empty() && output.stderr.is_empty(), "{}", stderr(&output));
    // Recordings named for proof are used for proof.
    let run =
        ["diagnose", "model.toml", "run0.csv", "run1.csv", "--held-out", "run2.csv", "--json"];
    let diagnosis: Diagnosis = serde_json::from_value(bench.json(&run)).unwrap();
    assert_eq!(diagnosis.data.training, ["run0.csv", "run1.csv"]);
    assert_eq!(diagnosis.data.held_out, ["run2.csv"]);

    let bench = Bench::of("");
    let output = bench.lacuna(&diagnose(&["--exit-code", "--out", "none"]));
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    // A page for nothing found, and no pictures as files unless they are asked for.
    let page = bench.text("none/report.html");
    assert!(page.contains("No effect of the catalogue") && page.contains("Autocorrelation"));
    assert!(!bench.path("none/figures").exists());
}

#[test]
fn the_demo_unseals_what_it_concealed() {
    for seed in ["1", "2"] {
        let folder = tempfile::tempdir().unwrap();
        let output = lacuna(folder.path(), &["demo", "--seed", seed, "--out", "demo"]);
        let said = String::from_utf8_lossy(&output.stdout).into_owned();
        assert_eq!(output.status.code(), Some(0), "{said}{}", stderr(&output));
        assert!(said.contains("Unsealed: ") && said.contains("The finding is right."), "{said}");
        for file in ["model.toml", "diagnosis.json", "augmented.toml", "report.html"] {
            assert!(folder.path().join("demo").join(file).is_file(), "{file}");
        }
        let run = ["simulate", "demo/augmented.toml", "--like", "demo/recordings/run04.csv"];
        assert!(lacuna(folder.path(), &run).status.success());
    }
}

#[test]
fn recordings_that_cannot_be_used_are_refused_with_their_place() {
    let bench = Bench::of("");
    let good = bench.text("run0.csv");
    let lines: Vec<&str> = good.lines().collect();

    bench.write("noinput.csv", good.replace("tau", "torque").as_bytes());
    for command in [
        &["simulate", "model.toml", "--like", "noinput.csv"][..],
        &["diagnose", "model.toml", "noinput.csv"],
    ] {
        let said = bench.error(command);
        assert!(said.contains("noinput.csv") && said.contains("'tau'"), "{said}");
        assert!(said.contains("torque"), "the columns there are: {said}");
    }

    bench.write("nothing.csv", good.replace("q,", "angle,").as_bytes());
    let said = bench.error(&["diagnose", "model.toml", "nothing.csv"]);
    assert!(said.contains("nothing.csv"), "{said}");

    let mut backwards = lines.clone();
    backwards.swap(300, 301);
    bench.write("backwards.csv", backwards.join("\n").as_bytes());
    let said = bench.error(&["diagnose", "model.toml", "backwards.csv"]);
    assert!(said.contains("backwards.csv") && said.contains("line 302"), "{said}");

    let mut words = lines.clone();
    let broken = lines[17].replacen(',', ",fast", 1);
    words[17] = &broken;
    bench.write("words.csv", words.join("\n").as_bytes());
    let said = bench.error(&["simulate", "model.toml", "--like", "words.csv"]);
    assert!(said.contains("words.csv, line 18, column 'q'") && said.contains("fast"), "{said}");

    bench.write("short.csv", lines[..40].join("\n").as_bytes());
    let said = bench.error(&["diagnose", "model.toml", "short.csv"]);
    assert!(said.contains("short.csv") && said.contains("39 samples"), "{said}");

    let noise: Vec<u8> =
        (0..4000u32).map(|k| (k.wrapping_mul(2_654_435_761) >> 13) as u8).collect();
    bench.write("binary.csv", &noise);
    bench.write("elf.csv", b"\x7fELF\x02\x01\x01\0\0\0\0\0\0\0\0\0\x03\0\x3e\0");
    for file in ["binary.csv", "elf.csv"] {
        let said = bench.error(&["diagnose", "model.toml", file]);
        assert!(said.contains(file), "{said}");
    }
    let said = bench.error(&["diagnose", "model.toml", "absent.csv"]);
    assert!(said.contains("absent.csv"), "{said}");
    // A mistake in one of many recordings names that one.
    let said = bench.error(&["diagnose", "model.toml", "run0.csv", "run1.csv", "words.csv"]);
    assert!(said.contains("words.csv, line 18"), "{said}");
    let said = bench.error(&["diagnose", "model.toml", "run0.csv", "--held-out", "noinput.csv"]);
    assert!(said.contains("noinput.csv"), "{said}");
}

#[test]
fn models_that_cannot_be_used_are_refused_with_their_place() {
    let bench = Bench::of("");
    let with = |name: &str, text: String| {
        bench.write(name, text.as_bytes());
        let simulate = bench.error(&["simulate", name, "--like", "run0.csv"]);
        assert_eq!(simulate, bench.error(&["diagnose", name, "run0.csv"]));
        simulate
    };
    let said = with("unknown.toml", MODEL.replace("mgl*sin(q)", "mgl*sin(qq)"));
    // The line and column of `qq` itself.
    assert!(said.contains("unknown.toml:20:32:"), "{said}");
    assert!(said.contains("'qq'") && said.contains("did you mean 'q'"), "{said}");

    let said = with("syntax.toml", MODEL.replace("b*dq -", "b*dq - *"));
    assert!(said.contains("syntax.toml:20:"), "{said}");

    let effect = "\n[[effect]]\nclass = \"coulomb_friction\"\nchannel = \"q\"\nmagnitude = { value = 1.0, unit = \"N\" }\n";
    let said = with("unit.toml", format!("{MODEL}{effect}"));
    // The entry that is wrong.
    assert!(said.contains("unit.toml:25:13:") && said.contains("N m"), "{said}");

    let measurement = "\n[[measurement]]\ncolumn = \"q\"\nof = \"q\"\nunit = \"kg\"\n";
    let said = with("mass.toml", format!("{MODEL}{measurement}"));
    assert!(said.contains("'q'") && said.contains("kg"), "{said}");

    bench.write("binary.toml", &[0xff, 0xfe, 0, 1, 2, 3, 0x80, 0x81]);
    let said = bench.error(&["simulate", "binary.toml", "--like", "run0.csv"]);
    assert!(said.contains("binary.toml"), "{said}");
    let said = bench.error(&["simulate", "absent.toml", "--like", "run0.csv"]);
    assert!(said.contains("absent.toml"), "{said}");
}

#[test]
fn arguments_that_make_no_sense_are_refused() {
    let bench = Bench::of("");
    for horizon in ["0", "-1", "nan", "soon"] {
        let horizon = format!("--horizon={horizon}");
        let output = bench.lacuna(&["simulate", "model.toml", "--like", "run0.csv", &horizon]);
        assert_eq!(output.status.code(), Some(2));
        assert!(stderr(&output).contains("positive number of seconds"), "{}", stderr(&output));
    }
    let output = bench.lacuna(&["diagnose", "model.toml"]);
    assert_eq!(output.status.code(), Some(2));
    assert!(stderr(&output).contains("RECORDINGS"), "{}", stderr(&output));
    // Pictures without a folder to put them in.
    let output = bench.lacuna(&diagnose(&["--figures"]));
    assert_eq!(output.status.code(), Some(2));
    assert!(stderr(&output).contains("--out <OUT>"), "{}", stderr(&output));
    // A warm-up without samples has no state to begin from; one as long as the recording would
    // count the error on the very samples that were fitted.
    for warmup in ["0", "1", "700", "100000"] {
        let said =
            bench.error(&["simulate", "model.toml", "--like", "run0.csv", "--warmup", warmup]);
        assert!(said.contains(&format!("--warmup {warmup}")) && said.contains("700"), "{said}");
    }
}

fn notes(diagnosis: &Value) -> String {
    let notes = diagnosis["notes"].as_array().expect("notes");
    notes.iter().filter_map(Value::as_str).collect::<Vec<_>>().join("\n")
}

#[test]
fn what_is_excluded_is_not_named_and_the_reader_knows() {
    let bench = Bench::of(FRICTION);
    let named = |d: &Value| -> Vec<String> {
        let findings = d["findings"].as_array().expect("findings");
        findings.iter().map(|f| f["class"].as_str().expect("a class").to_owned()).collect()
    };
    let asked = ["--exclude", "coulomb_friction@q", "stribeck_friction", "--json"];
    let d = bench.json(&diagnose(&asked));
    assert!(!named(&d).iter().any(|c| c == "coulomb_friction" || c == "stribeck_friction"), "{d}");
    assert!(notes(&d).contains("as was asked: coulomb_friction@q, stribeck_friction"), "{d}");

    // What may not be named is missing all the same.
    let d = bench.json(&diagnose(&["--only", "cubic_stiffness", "--exact", "tau", "--json"]));
    assert!(named(&d).iter().all(|c| c == "cubic_stiffness"), "{d}");
    assert_ne!(d["verdict"], "no_mismatch", "{d}");
    let notes = notes(&d);
    assert!(notes.contains("Nothing but cubic_stiffness was looked for"), "{notes}");
    assert!(notes.contains("the recorded tau was taken for exactly"), "{notes}");
    assert!(d["driving"]["inputs"].as_object().expect("inputs").is_empty(), "{d}");
}

#[test]
fn names_that_do_not_exist_are_told_with_those_that_are_near() {
    let bench = Bench::of("");
    for (asked, expected) in [
        (
            ["--exclude", "coulomb_fricton"],
            "'coulomb_fricton' (did you mean 'coulomb_friction'?); there are",
        ),
        (["--only", "dead_zone@taw"], "there is no channel 'taw' (did you mean 'tau'?); there are"),
        (["--exact", "torque"], "there is no input 'torque'; there are tau"),
    ] {
        let said = bench.error(&diagnose(&asked));
        assert!(said.contains(expected), "{said}");
    }
}

#[test]
fn a_budget_ends_the_search_with_a_whole_diagnosis() {
    let bench = Bench::of(FRICTION);
    let begun = std::time::Instant::now();
    let hurried = bench.json(&diagnose(&["--time-budget", "0.001", "--json", "--out", "hurried"]));
    let hurried_s = begun.elapsed().as_secs_f64();
    assert_eq!(hurried["verdict"], "unexplained", "{hurried}");
    assert!(notes(&hurried).contains("The time budget of 0.001 s ended the search"), "{hurried}");
    assert!(notes(&hurried).contains("the effects of the catalogue"), "{hurried}");
    assert!(hurried["fit"]["held_out"]["q"]["rmse_after"].is_f64(), "{hurried}");
    let read: Diagnosis = serde_json::from_value(hurried.clone()).expect("the schema");
    assert_eq!(read.verdict, Verdict::Unexplained);
    assert!(bench.text("hurried/report.html").contains("The time budget"));
    Model::read(&bench.path("hurried/augmented.toml")).expect("a model");

    // A budget that is not reached changes nothing.
    let begun = std::time::Instant::now();
    let free = bench.json(&diagnose(&["--json"]));
    let free_s = begun.elapsed().as_secs_f64();
    assert_eq!(bench.json(&diagnose(&["--time-budget", "36000", "--json"])), free);
    assert_eq!(free["findings"][0]["class"], "coulomb_friction", "{free}");
    assert!(hurried_s < free_s, "{hurried_s} s of {free_s} s");
}

/// Every number that JSON cannot hold becomes null: there is none but where the schema says so.
fn assert_finite(value: &Value, at: &str) {
    const MAY_BE_NULL: [&str; 1] = ["time"];
    match value {
        Value::Null => {
            assert!(MAY_BE_NULL.iter().any(|name| at.ends_with(&format!(".{name}"))), "{at}");
        }
        Value::Array(all) => all.iter().for_each(|v| assert_finite(v, at)),
        Value::Object(all) => {
            all.iter().for_each(|(name, v)| assert_finite(v, &format!("{at}.{name}")));
        }
        _ => {}
    }
}

#[test]
fn two_sensors_of_one_channel_and_two_recordings_are_told_apart() {
    let bench = Bench::of(FRICTION);
    let sensors = "[[measurement]]\ncolumn = \"q\"\nof = \"q\"\n[[measurement]]\ncolumn = \"camera\"\nof = \"q\"\nunit = \"deg\"\n";
    bench.write("two.toml", format!("{MODEL}{sensors}").as_bytes());
    for run in 0..3u64 {
        let source = RecordingSource::file(bench.path(&format!("run{run}.csv")));
        let mut recording = lacuna::recordings::read(&source, "t").unwrap();
        let mut camera = recording.column("q").unwrap().to_vec();
        camera.iter_mut().for_each(|q| *q = q.to_degrees());
        add_gaussian_noise(&mut camera, 0.3, &mut rng(8, run)).unwrap();
        recording.columns.push(Column { name: "camera".to_owned(), values: camera });
        write_csv_with_time(&bench.path(&format!("two{run}.csv")), &recording, "t").unwrap();
    }
    let checked = bench.json(&["check", "two.toml", "two0.csv", "--json"]);
    let columns =
        |k: usize| (&checked["channels"][k]["column"], &checked["channels"][k]["column_unit"]);
    assert_eq!(columns(0), (&Value::from("q"), &Value::from("rad")), "{checked}");
    assert_eq!(columns(1), (&Value::from("camera"), &Value::from("deg")), "{checked}");
    let asked = ["diagnose", "two.toml", "two0.csv", "--held-out", "two1.csv", "two2.csv"];
    let d = bench.json(&[&asked[..], &["--json", "--out", "found"]].concat());
    assert_finite(&d, "");
    assert_eq!(d["findings"][0]["class"], "coulomb_friction", "{d}");
    let held = |name: &str, key: &str| d["fit"]["held_out"][name][key].as_f64().expect("a number");
    assert!((held("camera", "noise") / 0.3_f64.to_radians() - 1.0).abs() < 0.2, "{d}");
    assert!((held("q", "noise") / NOISE - 1.0).abs() < 0.2, "{d}");
    let by = d["fit"]["by_recording"].as_object().expect("two recordings");
    let names: Vec<&String> = by.keys().collect();
    assert!(
        names.len() == 2 && names[0].contains("two1") && names[1].contains("two2"),
        "{names:?}"
    );
    let squares: f64 =
        by.values().map(|r| r["q"]["rmse_after"].as_f64().expect("a number").powi(2)).sum();
    assert!(((squares / 2.0).sqrt() / held("q", "rmse_after") - 1.0).abs() < 1e-3, "{d}");
    assert!(bench.text("found/report.html").contains("by recording, before → after"));
    let read: Diagnosis = serde_json::from_value(d).expect("the schema");
    assert!(!read.findings[0].parameters["magnitude"].at_bound);
}

/// A parameter that the recordings want beyond four of its standard deviations.
#[test]
fn what_lies_at_the_edge_of_what_was_tried_is_no_estimate() {
    let bench = Bench::of(FRICTION);
    let wrong = MODEL.replace("b = { value = 0.03", "b = { value = 0.02");
    bench.write(
        "model.toml",
        wrong.replace("rad\", tolerance = 0.1", "rad\", std = 0.0005").as_bytes(),
    );
    let d = bench.json(&diagnose(&["--only", "coulomb_friction", "--json"]));
    let b = &d["calibration"]["b"];
    assert_eq!(b["at_bound"], true, "{d}");
    assert!((b["value"].as_f64().expect("a number") - 0.022).abs() < 1e-9, "{d}");
    assert_eq!(d["calibration"]["J"]["at_bound"], false, "{d}");
    let said = bench.prints(&diagnose(&["--only", "coulomb_friction", "--out", "found"]));
    let page = bench.text("found/report.html");
    for text in [said.split_whitespace().collect::<Vec<_>>().join(" "), page] {
        assert!(text.contains("0.0220 N m s/rad (at the edge of what was tried)"), "{text}");
    }
}
