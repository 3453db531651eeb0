//! `lacuna export`: the files are compiled and run.

use crate::bench::{Bench, stderr, stdout};
use crate::{identified, identified_states};
use lacuna::occupation::IdentifiedModel;
use lacuna::occupation::compile::Compiled;
use std::process::{Command, Output};

const MODEL_JSON: &str = "found/model.json";

/// Points of the box, and last one outside.
fn points(compiled: &Compiled) -> Vec<[f64; 2]> {
    let (l, u) = (compiled.evaluator().lower(), compiled.evaluator().upper());
    let at = |a: f64, b: f64| [l[0] + a * (u[0] - l[0]), l[1] + b * (u[1] - l[1])];
    let mut points: Vec<[f64; 2]> = (0..200)
        .map(|k| at(f64::from(k * 7 % 200) / 200.0, f64::from(k * 31 % 200) / 200.0))
        .collect();
    points.push(at(1.5, 0.5));
    points
}

fn tool(bench: &Bench, program: &str, arguments: &[&str]) -> Option<Output> {
    let output = Command::new(program).args(arguments).current_dir(bench.path("")).output().ok()?;
    assert!(output.status.success(), "{program}: {}", stderr(&output));
    Some(output)
}

/// A program that prints the region, f, g, M and c at all points, in Rust.
fn rust_main(points: &[[f64; 2]], [n, m]: [usize; 2]) -> String {
    format!(
        "mod exported;
fn main() {{
    for x in {points:?} {{
        let (mut f, mut g) = ([0.0; {n}], [0.0; {nm}]);
        let inside = exported::evaluate(&x, &mut f, &mut g);
        assert_eq!(inside, exported::inside(&x));
        print!(\"{{}}\", i32::from(!inside));
        for v in f.iter().chain(&g) {{ print!(\" {{v:?}}\"); }}
        match exported::mass_and_bias(&x) {{
            Some((mass, bias, flag)) => {{
                assert_eq!(flag, inside);
                for v in mass.iter().chain(&bias) {{ print!(\" {{v:?}}\"); }}
            }}
            None => print!(\" singular\"),
        }}
        println!();
    }}
}}
",
        nm = n * m
    )
}

fn c_main(points: &[[f64; 2]], [n, m]: [usize; 2]) -> String {
    let rows: Vec<String> = points.iter().map(|x| format!("{{{:?}, {:?}}}", x[0], x[1])).collect();
    let (nm, mm) = (n * m, m * m);
    format!(
        "#include <stdio.h>
int exported_inside(const double x[2]);
int exported_evaluate(const double x[2], double f[{n}], double g[{nm}]);
int exported_mass_and_bias(const double x[2], double mass[{mm}], double bias[{m}]);
static const double points[{count}][2] = {{{rows}}};
int main(void)
{{
    for (int k = 0; k < {count}; k++) {{
        double f[{n}], g[{nm}], mass[{mm}], bias[{m}];
        const int outside = exported_evaluate(points[k], f, g);
        if (outside == exported_inside(points[k])) return 1;
        printf(\"%d\", outside);
        for (int i = 0; i < {n}; i++) printf(\" %.17g\", f[i]);
        for (int i = 0; i < {nm}; i++) printf(\" %.17g\", g[i]);
        if (exported_mass_and_bias(points[k], mass, bias) == 2) {{ printf(\" singular\\n\"); continue; }}
        for (int i = 0; i < {mm}; i++) printf(\" %.17g\", mass[i]);
        for (int i = 0; i < {m}; i++) printf(\" %.17g\", bias[i]);
        printf(\"\\n\");
    }}
    return 0;
}}
",
        count = points.len(),
        rows = rows.join(", ")
    )
}

/// Compares what a program printed with the identified model, to the bound that was stated.
fn compare(bench: &Bench, compiled: &Compiled, printed: &str) {
    let model = IdentifiedModel::load(&bench.path(MODEL_JSON)).unwrap();
    let (n, m) = (model.dimension(), model.inputs());
    let first = compiled.acceleration_rows().unwrap();
    let points = points(compiled);
    assert_eq!(printed.lines().count(), points.len());
    for (line, x) in printed.lines().zip(&points) {
        let (region, rest) = line.split_once(' ').unwrap();
        let values: Vec<f64> = rest.split(' ').map(|v| v.parse().unwrap()).collect();
        let evaluator = compiled.evaluator();
        assert_eq!(region == "0", evaluator.inside(x), "{line}");
        let nearest: Vec<f64> =
            (0..2).map(|i| x[i].clamp(evaluator.lower()[i], evaluator.upper()[i])).collect();
        let mut exact = vec![0.0; n + n * m];
        let (f, g) = exact.split_at_mut(n);
        model.evaluate(&nearest, f, g).unwrap();
        for (k, function) in compiled.functions().iter().enumerate() {
            // The bound was measured on other points.
            let bound = 1.2 * function.absolute + 1e-9 * function.magnitude;
            assert!((values[k] - exact[k]).abs() <= bound, "{x:?}: {line} {exact:?} {function:?}");
        }
        // One coordinate: M = 1 / g and c = -f / g.
        let (f, g) = (values[first], values[n + first]);
        let (mass, bias) = (values[n + n * m], values[n + n * m + 1]);
        assert!(
            (mass * g - 1.0).abs() < 1e-12 && (bias + f / g).abs() <= 1e-12 * (f / g).abs(),
            "{line}"
        );
    }
}

fn both_languages_run(bench: &Bench) {
    let compiled = Compiled::load(&bench.path("found/compiled.json")).unwrap();
    let shape = compiled.evaluator().shape();
    let size = [shape.dimension, shape.inputs];
    for target in ["rust", "c"] {
        let out = if target == "rust" { "exported.rs" } else { "exported.c" };
        let output =
            bench.lacuna(&["export", "found/compiled.json", "--target", target, "--out", out]);
        assert!(output.status.success(), "{}", stderr(&output));
        assert!(stdout(&output).contains("with M = g^-1"), "{}", stdout(&output));
    }
    bench.write("main.rs", &rust_main(&points(&compiled), size));
    bench.write("bare.rs", "#![no_std]\n#[path = \"exported.rs\"]\npub mod exported;\n");
    let flags = ["--edition", "2024", "-O", "-D", "warnings"];
    tool(bench, "rustc", &[&flags[..], &["--crate-type", "lib", "bare.rs"]].concat()).unwrap();
    tool(bench, "rustc", &[&flags[..], &["main.rs", "-o", "rust_main"]].concat()).unwrap();
    let output = tool(bench, &bench.path("rust_main").display().to_string(), &[]).unwrap();
    compare(bench, &compiled, &stdout(&output));
    bench.write("main.c", &c_main(&points(&compiled), size));
    let flags = ["-std=c99", "-O2", "-Wall", "-Wextra", "-Werror", "-pedantic"];
    let files = ["main.c", "exported.c", "-o", "c_main", "-lm"];
    match tool(bench, "cc", &[&flags[..], &files].concat()) {
        Some(_) => {
            let output = tool(bench, &bench.path("c_main").display().to_string(), &[]).unwrap();
            compare(bench, &compiled, &stdout(&output));
        }
        None => eprintln!("no C compiler here: the C file was not run"),
    }
}

#[test]
fn a_series_runs_in_both_languages() {
    let bench = identified_states(&["--kernel", "gaussian"]);
    let report = bench.json(&["compile", MODEL_JSON, "--json", "--tolerance", "1e-5"]);
    assert!(report.to_string().contains("\"series\""), "{report}");
    both_languages_run(&bench);
}

#[test]
fn sums_over_landmarks_run_in_both_languages() {
    let bench = identified(&["--kernel", "matern"]);
    let report = bench.json(&["compile", MODEL_JSON, "--json", "--tolerance", "1e-9"]);
    assert!(report.to_string().contains("\"landmarks\""), "{report}");
    both_languages_run(&bench);
}

#[test]
fn an_identified_model_is_compiled_on_the_way() {
    let bench = identified(&["--kernel", "polynomial"]);
    let given = ["export", MODEL_JSON, "--target", "c", "--box", "x=-1..1", "--tolerance", "1e-3"];
    let output = bench.lacuna(&given);
    assert!(output.status.success(), "{}", stderr(&output));
    let text = std::fs::read_to_string(bench.path("found/model.c")).unwrap();
    for part in
        ["x[0] x: -1.0 .. 1.0", "x[1] dx: ", "g[0] g_x_u", "q'' = f(x) + g(x) u", "model_evaluate"]
    {
        assert!(text.contains(part), "{part}");
    }
    assert!(!text.contains("math.h"));
}

#[test]
fn what_cannot_be_exported_is_refused() {
    let bench = identified(&["--kernel", "polynomial"]);
    bench.json(&["compile", MODEL_JSON, "--json"]);
    let said =
        bench.error(&["export", "found/compiled.json", "--target", "c", "--tolerance", "1e-3"]);
    assert!(said.contains("compiled already"), "{said}");
    let said = bench.error(&["export", "model.toml", "--target", "rust"]);
    assert!(said.contains("model.toml") && said.contains("TOML"), "{said}");
    assert!(!bench.path("found/model.c").exists() && !bench.path("found/model.rs").exists());
}
