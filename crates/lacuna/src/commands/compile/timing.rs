//! How long one evaluation takes, then and there.

use lacuna::occupation::IdentifiedModel;
use lacuna::occupation::compile::Compiled;
use serde::Serialize;
use std::hint::black_box;
use std::time::{Duration, Instant};

/// Medians, in microseconds.
#[derive(Serialize)]
pub struct Times {
    pub direct: f64,
    pub compiled: f64,
}

/// Points of the box that are evaluated in turn.
const POINTS: usize = 64;
/// Longest measurement of either.
const LONGEST: Duration = Duration::from_millis(300);

/// Medians of the model's and the compiled evaluation.
pub fn measure(model: &IdentifiedModel, compiled: &Compiled) -> Times {
    let (n, m) = (model.dimension(), model.inputs());
    let (mut f, mut g) = (vec![0.0; n], vec![0.0; n * m]);
    let evaluator = compiled.evaluator();
    let (lower, upper) = (evaluator.lower(), evaluator.upper());
    // Along the box, each argument at its own pace.
    let point = |k: usize| -> Vec<f64> {
        let part = |i: usize| (k * (2 * i + 1) % POINTS) as f64 / POINTS as f64;
        (0..lower.len()).map(|i| lower[i] + part(i) * (upper[i] - lower[i])).collect()
    };
    let points: Vec<Vec<f64>> = (0..POINTS).map(point).collect();
    // Slices have the model's lengths, so that neither fails.
    let direct = median(&points, 1, |x| {
        let _ = black_box(model.evaluate(black_box(x), &mut f, &mut g));
    });
    // One evaluation is nearly as short as reading the clock: many between two readings.
    let compiled = median(&points, 16, |x| {
        let _ = black_box(evaluator.evaluate(black_box(x), &mut f, &mut g));
    });
    Times { direct, compiled }
}

fn median(points: &[Vec<f64>], batch: usize, mut evaluate: impl FnMut(&[f64])) -> f64 {
    let begin = Instant::now();
    let mut times = Vec::new();
    while times.len() < 100 || (begin.elapsed() < LONGEST && times.len() < 10_000) {
        let first = times.len() * batch;
        let start = Instant::now();
        (first..first + batch).for_each(|k| evaluate(&points[k % POINTS]));
        times.push(start.elapsed().as_secs_f64() * 1e6 / batch as f64);
    }
    times.sort_by(f64::total_cmp);
    times[times.len() / 2]
}
