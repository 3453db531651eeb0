//! Expressions of model files.
#![no_main]

use lacuna::plants::expression::{Graph, parse};
use libfuzzer_sys::fuzz_target;

fuzz_target!(|text: &str| {
    let names = ["q", "dq", "u", "k"].map(str::to_owned);
    let mut graph = Graph::default();
    let known = |graph: &mut Graph, name: &str| {
        (name == "q" || name == "k").then(|| graph.constant(1.0))
    };
    if let Err(error) = parse(text, &mut graph, &names, &known) {
        assert!(error.start <= error.end && error.end <= text.len(), "{error}");
    }
});
