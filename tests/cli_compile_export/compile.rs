//! `lacuna compile`.

use crate::bench::{MODEL, stdout};
use crate::{identified, identified_states};
use lacuna::occupation::IdentifiedModel;
use lacuna::occupation::compile::Compiled;
use lacuna::realtime::Region;
use serde_json::json;

const MODEL_JSON: &str = "found/model.json";

#[test]
fn a_model_is_compiled_on_a_box_to_the_tolerance() {
    let bench = identified(&["--kernel", "gaussian"]);
    let report =
        bench.json(&["compile", MODEL_JSON, "--box", "x=-1..1", "--json", "--tolerance", "1e-4"]);
    let sides = report["box"].as_array().unwrap();
    assert_eq!(sides[0], json!({"argument": "x", "lower": -1.0, "upper": 1.0, "given": true}));
    assert_eq!((&sides[1]["argument"], &sides[1]["given"]), (&json!("dx"), &json!(false)));
    let names: Vec<&str> = report["functions"]
        .as_array()
        .unwrap()
        .iter()
        .map(|f| f["function"].as_str().unwrap())
        .collect();
    assert_eq!(names, ["f_x", "g_x_u"]);
    assert!(report["relative_error"].as_f64().unwrap() <= 1e-4, "{report}");
    assert!(report["median_us"]["compiled"].as_f64().unwrap() > 0.0);
    // What was written is what was reported, and near the model it was made of.
    let model = IdentifiedModel::load(&bench.path(MODEL_JSON)).unwrap();
    let compiled = Compiled::load(&bench.path("found/compiled.json")).unwrap();
    let evaluator = compiled.evaluator();
    for k in 0..=40 {
        let part = f64::from(k) / 40.0;
        let x =
            [-1.0 + 2.0 * part, evaluator.lower()[1] * part + evaluator.upper()[1] * (1.0 - part)];
        let (mut f, mut g, mut near_f, mut near_g) = ([0.0], [0.0], [0.0], [0.0]);
        model.evaluate(&x, &mut f, &mut g).unwrap();
        assert_eq!(evaluator.evaluate(&x, &mut near_f, &mut near_g), Ok(Region::Inside));
        for (exact, near, function) in [(f, near_f, 0), (g, near_g, 1)] {
            let bound = compiled.functions()[function].magnitude * 1e-4;
            assert!((exact[0] - near[0]).abs() <= bound, "{x:?}: {exact:?} {near:?}");
        }
    }
}

#[test]
fn the_text_says_what_was_done() {
    let bench = identified(&["--kernel", "polynomial"]);
    let text = stdout(&bench.lacuna(&["compile", MODEL_JSON, "--out", "small.json"]));
    for part in [
        "(asked for: 1e-6)",
        "x from",
        "range of the data",
        "g_x_u",
        "series",
        "One evaluation",
        "wrote small.json",
    ] {
        assert!(text.contains(part), "{part}: {text}");
    }
    assert!(bench.path("small.json").exists() && !bench.path("found/compiled.json").exists());
}

#[test]
fn what_cannot_be_compiled_is_refused() {
    let bench = identified_states(&["--kernel", "polynomial"]);
    bench.write("equations.toml", MODEL);
    bench.write("other.json", "{\"a\": 1}");
    bench.write("half.json", "{\"version\": 2, \"or");
    bench.write("wrong.json", "{\"compiled\": 9}");
    let table: [(&[&str], &[&str]); 13] = [
        (&[MODEL_JSON, "--box", "q=1..2"], &["--box q=1..2", "no argument 'q'", "x, dx"]),
        (&[MODEL_JSON, "--box", "x=2..1"], &["--box x=2..1", "below", "2 and 1"]),
        (&[MODEL_JSON, "--box", "x=1..1"], &["below", "1 and 1"]),
        (&[MODEL_JSON, "--box", "x=1"], &["expected NAME=LOW..HIGH"]),
        (&[MODEL_JSON, "--box", "x=a..1"], &["'a' is no finite number"]),
        (&[MODEL_JSON, "--box", "x=0..inf"], &["'inf' is no finite number"]),
        (&[MODEL_JSON, "--box", "x=0..1", "--box", "x=0..2"], &["second range of 'x'"]),
        (&[MODEL_JSON, "--tolerance", "0.5"], &["model.json", "tolerance", "0.5"]),
        (&["equations.toml"], &["equations.toml", "lacuna identify", "TOML"]),
        (&["other.json"], &["other.json", "no model that `lacuna identify` wrote"]),
        (&["half.json"], &["half.json"]),
        (&["wrong.json"], &["wrong.json", "version 1", "9"]),
        (&["absent.json"], &["absent.json"]),
    ];
    for (given, parts) in table {
        let said = bench.error(&[&["compile"], given].concat());
        for part in parts {
            assert!(said.contains(part), "{given:?}: {said}");
        }
    }
    assert!(!bench.path("found/compiled.json").exists());
    bench.json(&["compile", MODEL_JSON, "--json"]);
    let said = bench.error(&["compile", "found/compiled.json"]);
    assert!(said.contains("compiled model already"), "{said}");
}
