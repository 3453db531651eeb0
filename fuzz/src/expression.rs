//! Expressions of model files.

use lacuna::plants::expression::{Graph, parse};

/// What is wrong in one is told with its place.
pub fn survive(text: &str) {
    let names = ["q", "dq", "u", "k"].map(str::to_owned);
    let mut graph = Graph::default();
    let known =
        |graph: &mut Graph, name: &str| (name == "q" || name == "k").then(|| graph.constant(1.0));
    if let Err(error) = parse(text, &mut graph, &names, &known) {
        assert!(error.start <= error.end && error.end <= text.len(), "{error}");
    }
}
