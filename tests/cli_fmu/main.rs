//! FMUs in the place of model files, as a user has them: compiled here, where there is a C compiler.
#![cfg(unix)]

mod bench;
mod refused;

use bench::{BESIDE, Bench, Kind, RUNS, TEXT};
use lacuna::numbers::{Dual, Number};
use lacuna::plants::Model;
use lacuna::plants::dynamics::Mass;
use serde_json::Value;

/// All kinds of FMU that are supported.
fn kinds() -> [Kind; 4] {
    [(2, false), (2, true), (3, false), (3, true)].map(|(v, d)| Kind::new(v, d))
}

#[test]
fn an_fmu_has_the_rates_and_derivatives_of_its_text() {
    let bench = Bench::new();
    lacuna::fmu::evaluate_with(env!("CARGO_BIN_EXE_lacuna"), ["evaluate-fmu"]);
    let text = Model::from_text(TEXT, "arm.toml").unwrap();
    for kind in kinds() {
        let Some(()) = bench.fmu("plant.fmu", kind, str::to_owned) else { return };
        let model = Model::read(&bench.path("plant.fmu")).unwrap();
        assert_eq!((model.name.as_str(), model.dynamics().mass()), ("plant", Mass::Unit));
        let names = [model.state_name(0), model.state_name(1), &model.inputs[0].name];
        assert_eq!(names, ["q", "dq", "tau"]);
        assert_eq!(model.coordinates[0].unit, "rad");
        let parameters: Vec<_> = model.parameters.iter().map(|p| (&*p.name, p.value)).collect();
        assert_eq!(parameters, [("J", 0.05), ("b", 0.03), ("mgl", 0.4)]);

        let variables: Vec<Dual> = [0.7, -1.3, 0.2, 5.0]
            .iter()
            .enumerate()
            .map(|(k, &x)| if k < 3 { Dual::among(x, k + 3, 0) } else { Dual::constant(x) })
            .collect();
        let rates = |model: &Model| {
            let mut rates = vec![Dual::constant(0.0); 2];
            let bound = model.dynamics().bind_along(&[0.06, 0.02, 0.5], 0);
            bound.evaluate_once(&variables, &mut rates);
            rates
        };
        let (own, expected) = (rates(&model), rates(&text));
        for (own, expected) in own.iter().zip(&expected) {
            assert!((own.value - expected.value).abs() < 1e-12 * expected.value.abs());
            for (own, expected) in own.tangent.iter().zip(&expected.tangent) {
                assert!((own - expected).abs() < 1e-6 * (1.0 + expected.abs()), "{own} {expected}");
            }
        }
        let stated = model.dynamics().derivative_error().expect("those by parameters");
        assert!(stated < 1e-6 && model.dynamics().trouble().is_none(), "{stated}");
    }
}

#[test]
fn a_crash_is_a_point_that_cannot_be_evaluated() {
    let bench = Bench::new();
    lacuna::fmu::evaluate_with(env!("CARGO_BIN_EXE_lacuna"), ["evaluate-fmu"]);
    let kind = Kind { define: "-DCRASH_AT=1.0", ..Kind::new(2, false) };
    let Some(()) = bench.fmu("plant.fmu", kind, str::to_owned) else { return };
    let model = Model::read(&bench.path("plant.fmu")).unwrap();
    let at = |q: f64| {
        let mut rates = [0.0; 2];
        model.dynamics().bind(&model.values()).evaluate_once(&[q, 0.0, 0.1, 0.0], &mut rates);
        rates[1]
    };
    let before = at(0.5);
    assert!(before.is_finite() && at(2.0).is_nan());
    assert_eq!(at(0.5), before);
    let trouble = model.dynamics().trouble().expect("it is told");
    assert!(trouble.contains("1 times") && trouble.contains("SIGABRT"), "{trouble}");
}

#[test]
fn it_runs_as_its_text_does() {
    let Some(bench) = Bench::with_runs() else { return };
    let run = |model: &str, out: &str| {
        bench.prints(&["simulate", model, "--like", "run0.csv", "--out", out]);
        bench.column(out, "q")
    };
    let expected = run("model.toml", "text.csv");
    for kind in kinds() {
        bench.fmu("plant.fmu", kind, str::to_owned).unwrap();
        let own = run("plant.fmu", "fmu.csv");
        assert_eq!(own.len(), expected.len());
        let off = own.iter().zip(&expected).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        assert!(off < 1e-8, "version {}: off by {off:e}", kind.version);
    }
    let said = bench.prints(&["check", "plant.fmu", "run0.csv"]);
    assert!(said.contains('q') && said.contains("tau"), "{said}");
    let both = bench.prints(&["compare", "plant.fmu", "model.toml", "run0.csv"]);
    assert!(both.contains('q'), "{both}");
}

#[test]
fn an_output_can_be_what_is_measured() {
    let Some(bench) = Bench::with_runs() else { return };
    bench.fmu("plant.fmu", Kind::new(2, false), str::to_owned).unwrap();
    let column = |of: &str| format!("[[measurement]]\ncolumn = \"q\"\nof = \"{of}\"\n");
    // The output is q + dq/10; another is q itself by another name.
    bench.write("turn.toml", format!("{TEXT}{}", column("q + 0.1*dq")).as_bytes());
    let fmu = "name = \"arm\"\n[fmu]\nfile = \"plant.fmu\"\n";
    bench.write("fmu.toml", format!("{fmu}{}", column("turn")).as_bytes());
    bench.write("angle.toml", format!("{fmu}{}", column("angle")).as_bytes());
    let error = |model: &str| {
        let said = bench.json(&["simulate", model, "--like", "run0.csv", "--json"]);
        said["channels"]["q"]["rmse"].as_f64().expect("a number")
    };
    let (own, text) = (error("fmu.toml"), error("turn.toml"));
    assert!((own - text).abs() < 1e-6 * text, "{own} {text}");
    let (own, text) = (error("angle.toml"), error("model.toml"));
    assert!((own - text).abs() < 1e-6 * text, "{own} {text}");
}

#[test]
fn what_an_fmu_lacks_is_found_as_in_its_text() {
    let Some(bench) = Bench::with_runs() else { return };
    let diagnosis = |model: &str| {
        let arguments = [&["diagnose", model], &RUNS[..], &["--json", "--quiet", "--out", "found"]];
        bench.json(&arguments.concat())
    };
    let text = diagnosis("model.toml");
    for kind in [Kind::new(2, true), Kind::new(3, false)] {
        bench.fmu("plant.fmu", kind, str::to_owned).unwrap();
        bench.write(
            "fmu.toml",
            format!("name = \"arm\"\n[fmu]\nfile = \"plant.fmu\"\n{BESIDE}").as_bytes(),
        );
        let own = diagnosis("fmu.toml");
        same_finding(&own, &text);
        // What was found can be run: the augmented model names the FMU.
        let again = ["simulate", "found/augmented.toml", "--like", "run0.csv"];
        let said = bench.json(&[&again[..], &["--horizon", "0.5", "--json"]].concat());
        let error = said["channels"]["q"]["rmse"].as_f64().expect("a number");
        assert!(error < 1.2e-3, "{error}");
    }
}

/// Class, channel, verdict and numbers are the same, these to a twentieth of their standard deviations.
fn same_finding(own: &Value, text: &Value) {
    assert_eq!(own["verdict"], text["verdict"]);
    let (a, b) = (&own["findings"], &text["findings"]);
    assert_eq!((a.as_array().unwrap().len(), b.as_array().unwrap().len()), (1, 1), "{a} {b}");
    let (a, b) = (&a[0], &b[0]);
    assert_eq!((&a["class"], &a["channel"]), (&b["class"], &b["channel"]));
    assert_eq!((a["class"].as_str(), a["channel"].as_str()), (Some("coulomb_friction"), Some("q")));
    assert_eq!(a["parameters"]["magnitude"]["unit"], "rad/s^2");
    for (name, found) in a["parameters"].as_object().unwrap() {
        let same = &b["parameters"][name];
        let (own, text) = (found["value"].as_f64().unwrap(), same["value"].as_f64().unwrap());
        let std = same["std"].as_f64().unwrap();
        assert!((own - text).abs() < 0.05 * std, "{name}: {found} {same}");
    }
    let magnitude = a["parameters"]["magnitude"]["value"].as_f64().unwrap();
    assert!((magnitude - 1.2).abs() < 0.2, "{magnitude}");
}
