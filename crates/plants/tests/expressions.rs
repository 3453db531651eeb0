//! Expressions: values, precedence, and errors with their places.

use lacuna_plants::expression::{Graph, Problem, Program, parse};
use proptest::prelude::*;

const NAMES: [&str; 3] = ["p", "x", "y"];

/// Value of `text` at p (a parameter), x and y.
fn value(text: &str, p: f64, x: f64, y: f64) -> f64 {
    let mut graph = Graph::default();
    let names: Vec<String> = NAMES.iter().map(|n| (*n).to_owned()).collect();
    let lookup = |graph: &mut Graph, name: &str| {
        NAMES.iter().position(|n| *n == name).map(|slot| graph.variable(slot))
    };
    let node = parse(text, &mut graph, &names, &lookup).unwrap_or_else(|e| panic!("{text}: {e}"));
    let program = Program::compile(&graph, 1, &[node]);
    let mut out = [0.0];
    program.evaluate(&program.bind(&[p]), &[x, y], &mut out);
    out[0]
}

fn problem(text: &str) -> (Problem, usize, usize) {
    let names: Vec<String> = NAMES.iter().map(|n| (*n).to_owned()).collect();
    let lookup = |graph: &mut Graph, name: &str| {
        NAMES.iter().position(|n| *n == name).map(|slot| graph.variable(slot))
    };
    let e = parse(text, &mut Graph::default(), &names, &lookup).expect_err(text);
    (e.problem, e.start, e.end)
}

#[test]
fn precedence_and_associativity_are_those_of_mathematics() {
    let (p, x, y) = (2.0, 3.0, 5.0);
    let cases = [
        ("1 + 2*3", 7.0),
        ("-x^2", -9.0),
        ("(-x)^2", 9.0),
        ("2^3^2", 512.0),
        ("2^-1", 0.5),
        ("y - x - p", 0.0),
        ("y / x / p", 5.0 / 6.0),
        ("-x*-y", 15.0),
        ("--x", 3.0),
        ("1e-3 + 2.5E2", 250.001),
        (".5*x", 1.5),
        ("p*x + x*p - 2*p*x", 0.0),
    ];
    for (text, expected) in cases {
        assert_eq!(value(text, p, x, y), expected, "{text}");
    }
}

#[test]
fn every_function_agrees_with_the_standard_library() {
    let (x, y): (f64, f64) = (0.3, -0.7);
    let cases = [
        ("sin(x)", x.sin()),
        ("cos(x)", x.cos()),
        ("tan(x)", x.tan()),
        ("asin(x)", x.asin()),
        ("acos(x)", x.acos()),
        ("atan(x)", x.atan()),
        ("atan2(x, y)", x.atan2(y)),
        ("sinh(x)", x.sinh()),
        ("cosh(x)", x.cosh()),
        ("tanh(x)", x.tanh()),
        ("exp(x)", x.exp()),
        ("log(x)", x.ln()),
        ("sqrt(x)", x.sqrt()),
        ("abs(y)", 0.7),
        ("sign(y)", -1.0),
        ("sign(0*x)", 0.0),
        ("min(x, y)", y),
        ("max(x, y)", x),
        ("pi", std::f64::consts::PI),
        ("x^1.7", x.powf(1.7)),
    ];
    for (text, expected) in cases {
        assert_eq!(value(text, 1.0, x, y), expected, "{text}");
    }
}

#[test]
fn errors_point_at_the_offending_text() {
    let (what, start, end) = problem("x + dq");
    assert_eq!((start, end), (4, 6));
    assert_eq!(what, Problem::UnknownName { name: "dq".into(), suggestion: None });
    let (what, start, _) = problem("x + X");
    assert_eq!(start, 4);
    assert_eq!(what, Problem::UnknownName { name: "X".into(), suggestion: Some("x".into()) });
    let (what, start, end) = problem("2*sine(x)");
    assert_eq!((start, end), (2, 6));
    assert_eq!(what, Problem::UnknownFunction { name: "sine".into() });
    let (what, ..) = problem("max(x)");
    assert_eq!(what, Problem::Arguments { name: "max".into(), expected: 2, found: 1 });
    assert!(matches!(problem("x +"), (Problem::Expected { .. }, 3, 3)));
    assert!(matches!(problem("(x"), (Problem::Expected { .. }, 2, 2)));
    assert!(matches!(problem("x y"), (Problem::Expected { .. }, 2, 3)));
    assert!(matches!(problem("1.2.3"), (Problem::Number { .. }, 0, 5)));
    assert!(matches!(problem("x · y"), (Problem::Character { found: '·' }, 2, 4)));
    assert!(matches!(problem(&"(".repeat(100_000)), (Problem::TooDeep { .. }, ..)));
    assert!(matches!(problem(&"2^".repeat(100_000)), (Problem::TooDeep { .. }, ..)));
}

proptest! {
    #[test]
    fn no_text_makes_the_parser_panic(text in ".{0,40}") {
        let _ = parse(&text, &mut Graph::default(), &[], &|_, _| None);
    }

    /// Sharing and simplification do not change values.
    #[test]
    fn compiled_sums_agree_with_plain_arithmetic(p in -3.0..3.0f64, x in -3.0..3.0f64, y in -3.0..3.0f64) {
        let compiled = value("p*x + (x*y - p)*(x*y - p) + 0*y + x/(1 + y^2) - (p*x)*1 + abs(x*y)", p, x, y);
        let plain = (x * y - p).powi(2) + x / (1.0 + y * y) + (x * y).abs();
        prop_assert!((compiled - plain).abs() <= 1e-12 * (1.0 + plain.abs() + (p * x).abs()));
    }
}
