//! What a model predicts of a recording: free runs and windows, the state at each start
//! estimated from the recording itself, never a parameter.

mod identified;
mod model;
mod state;
mod substeps;

pub use identified::{IdentifiedPredictor, simulate_identified};

pub use model::Predictor;
pub use substeps::TOLERANCE as INTEGRATION_TOLERANCE;

use crate::dataset::{Dataset, Observed};
use std::ops::Range;

/// Series of each output.
type Series = Vec<Vec<f64>>;

/// Samples that the error of a free run leaves out: they estimate the initial state.
pub const DEFAULT_WARMUP: usize = 50;

/// Samples that estimate the initial state of a free run: of a short recording at most a quarter.
#[must_use]
pub fn warmup(observed: &Observed) -> usize {
    DEFAULT_WARMUP.min(observed.len() / 4)
}

/// Predicted and measured series of one recording.
#[derive(Clone, Debug)]
pub struct Prediction {
    /// Predicted outputs, as [`Observed::outputs`]; NaN where the model diverged.
    pub outputs: Vec<Vec<f64>>,
    /// The samples that count for the error.
    pub counted: Range<usize>,
}

impl Prediction {
    /// Root mean square of measured minus predicted, over samples that were measured.
    /// Infinite where the model diverged, not a number where nothing was measured.
    #[must_use]
    pub fn rmse(&self, observed: &Observed, output: usize) -> f64 {
        let (sum, count) = self.squares(observed, output);
        (sum / count as f64).sqrt()
    }

    /// Sum of squares of measured minus predicted, and the number of samples.
    #[must_use]
    pub fn squares(&self, observed: &Observed, output: usize) -> (f64, usize) {
        self.squares_in(observed, output, self.counted.clone())
    }

    /// Whether it is somewhere off by more than an output ranges over: what runs away from a machine says how errors of
    /// its beginning grow, and nothing else.
    #[must_use]
    pub fn is_astray(&self, observed: &Observed, dataset: &Dataset) -> bool {
        first_astray((observed, self.counted.clone()), (&self.outputs, 0), &ranges(dataset))
            .is_some()
    }

    /// The same over some samples.
    #[must_use]
    pub fn squares_in(
        &self,
        observed: &Observed,
        output: usize,
        range: Range<usize>,
    ) -> (f64, usize) {
        let measured = &observed.outputs[output][range.clone()];
        let predicted = &self.outputs[output][range];
        let pairs = measured.iter().zip(predicted).filter(|(y, _)| y.is_finite());
        pairs.fold((0.0, 0), |(sum, n), (y, p)| {
            let e = y - p;
            (if e.is_finite() { sum + e * e } else { f64::INFINITY }, n + 1)
        })
    }
}

/// The first sample of a range at which some output of a run is none, or off from what was measured by more than
/// `most`; the series of the run begin at sample `begin`.
fn first_astray(
    (observed, range): (&Observed, Range<usize>),
    (run, begin): (&Series, usize),
    most: &[f64],
) -> Option<usize> {
    let astray = |((y, run), most): ((&Vec<f64>, &Vec<f64>), &f64)| {
        let follows = |k: usize| y[k].is_nan() || (y[k] - run[k - begin]).abs() <= *most;
        range.clone().find(|k| !follows(*k))
    };
    observed.outputs.iter().zip(run).zip(most).filter_map(astray).min()
}

/// What each output ranges over.
fn ranges(dataset: &Dataset) -> Vec<f64> {
    (0..dataset.outputs.len()).map(|k| 2.0 * dataset.half_range(k)).collect()
}

/// Windows of about `horizon` seconds that cover all samples; a short rest joins the last. Where a run begins anew
/// a window does.
#[must_use]
pub fn windows(observed: &Observed, horizon: f64) -> Vec<Range<usize>> {
    let of = |stretch: Range<usize>| {
        let all = cut(&observed.times[stretch.clone()], horizon).into_iter();
        all.map(move |r| stretch.start + r.start..stretch.start + r.end)
    };
    observed.stretches().flat_map(of).collect()
}

/// Windows of one stretch.
fn cut(times: &[f64], horizon: f64) -> Vec<Range<usize>> {
    let n = times.len();
    let span = times[n - 1] - times[0];
    let count = (span / horizon).round().clamp(1.0, (n / 4).max(1) as f64) as usize;
    let edge = |k: usize| {
        if k == count {
            return n;
        }
        let t = times[0] + span * k as f64 / count as f64;
        times.partition_point(|&s| s < t - 1e-9 * span)
    };
    // On uneven sampling a window may hold too little to run through: it joins its neighbour.
    let mut out: Vec<Range<usize>> = Vec::new();
    for end in (1..=count).map(edge) {
        let start = out.last().map_or(0, |r| r.end);
        match out.last_mut() {
            Some(last) if end - start < 2 => last.end = end,
            _ if end - start < 2 => {}
            _ => out.push(start..end),
        }
    }
    out
}
