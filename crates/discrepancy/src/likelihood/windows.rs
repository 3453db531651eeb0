//! Windows: how the recordings are cut.

use crate::dataset::{Dataset, Observed};
use std::ops::Range;

/// A stretch of a recording with an initial state of its own.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Window {
    /// The recording.
    pub recording: usize,
    /// Its samples.
    pub range: Range<usize>,
}

/// Fewest samples of a window.
const FEWEST: usize = 8;

/// `2^level` windows a recording, of equal numbers of samples; fewer in a short recording. Where a run begins anew
/// a window does, and each stretch has its share of them, at least one.
#[must_use]
pub fn windows(dataset: &Dataset, level: u32) -> Vec<Window> {
    let cut = |(recording, observed): (usize, &Observed)| {
        let of = |stretch: Range<usize>| {
            let samples = stretch.len();
            let share = (1usize << level) * samples / observed.len();
            let count = share.min(samples / FEWEST).max(1);
            let edge = move |k: usize| stretch.start + k * samples / count;
            (0..count).map(move |k| Window { recording, range: edge(k)..edge(k + 1) })
        };
        observed.stretches().flat_map(of).collect::<Vec<_>>()
    };
    dataset.recordings.iter().enumerate().flat_map(cut).collect()
}

/// The level with which a search begins: windows of about this many samples.
#[must_use]
pub(crate) fn first_level(dataset: &Dataset) -> u32 {
    const SAMPLES: f64 = 30.0;
    let shortest = dataset.recordings.iter().map(Observed::len).min();
    let level = (shortest.unwrap_or(1) as f64 / SAMPLES).max(1.0).log2().floor();
    (level as u32).clamp(2, 9)
}
