//! `lacuna compile` and `lacuna export`, as a user runs them.

#[path = "../cli_check_identify/bench.rs"]
mod bench;
mod compile;
mod export;

use bench::{Bench, Run, arguments, stderr};

/// A bench with a model of second order that was identified from positions.
fn identified(more: &[&str]) -> Bench {
    let (bench, runs) = Bench::with_runs(1..=3);
    let given = [&["identify", "--quiet", "--out", "found"], more].concat();
    let output = bench.lacuna(&arguments(&given, &runs));
    assert!(output.status.success(), "{}", stderr(&output));
    bench
}

/// The same of first order, from the whole state.
fn identified_states(more: &[&str]) -> Bench {
    let bench = Bench::new();
    let files = [1, 2, 3].map(|seed| format!("run{seed}.csv"));
    for (seed, file) in (1..).zip(&files) {
        let run = Run::new(seed);
        let columns: [(&str, &[f64]); 4] =
            [("t", &run.t), ("x", &run.x), ("dx", &run.dx), ("u", &run.u)];
        bench.write(file, &Run::csv(&columns));
    }
    let given = [&["identify", "--quiet", "--out", "found"], more].concat();
    let output = bench.lacuna(&arguments(&given, &files));
    assert!(output.status.success(), "{}", stderr(&output));
    bench
}
