//! A function of one variable by its values at knots, and its occupation by a motion.

use crate::range::{between_knots, inner_range};
use crate::screen::Over;
use crate::trajectories::SmoothedRecording;
use std::ops::Range;

/// Knots of a function.
pub(super) const KNOTS: usize = 48;
/// One value in so many is left out at either end of a variable's range.
const ENDS: usize = 1000;
/// Points at which a variable is looked at between two samples.
const WITHIN: usize = 4;

/// A variable along the recordings, with even knots on its range.
pub(super) struct Knots {
    pub over: Over,
    pub from: f64,
    pub to: f64,
    /// Its values at the samples of each recording.
    pub series: Vec<Vec<f64>>,
    /// Share of all samples at each knot.
    pub visits: Vec<f64>,
}

impl Knots {
    /// The variable `over` of a channel; none where it does not move.
    pub(super) fn new(motions: &[SmoothedRecording], channel: usize, over: Over) -> Option<Self> {
        let of = |m: &SmoothedRecording| -> Vec<f64> {
            (0..m.len()).map(|k| value(m, channel, over, k)).collect()
        };
        let series: Vec<Vec<f64>> = motions.iter().map(of).collect();
        let (from, to) = inner_range(series.concat(), ENDS);
        if to <= from {
            return None;
        }
        let mut this = Self { over, from, to, series, visits: vec![] };
        this.visits = this.counted();
        Some(this)
    }

    /// The two knots about a value, by the first, and the share of the second: a function
    /// between knots is on a straight line.
    pub(super) fn place(&self, x: f64) -> (usize, f64) {
        between_knots(x, (self.from, self.to), KNOTS)
    }

    /// A function of such values at the knots.
    pub(super) fn at(&self, values: &[f64], x: f64) -> f64 {
        let (knot, share) = self.place(x);
        values[knot] + share * (values[knot + 1] - values[knot])
    }

    /// From knot to knot.
    pub(super) fn spacing(&self) -> f64 {
        (self.to - self.from) / (KNOTS - 1) as f64
    }

    /// Add `weight` times what knots have to say about the mean over the step around sample `k`
    /// of a recording; the variable moves on straight lines from sample to sample.
    pub(super) fn occupy(&self, recording: usize, k: usize, weight: f64, row: &mut [f64]) {
        let series = &self.series[recording];
        let side = |neighbour: Option<&f64>, other: Option<&f64>| match (neighbour, other) {
            (Some(x), _) => x - series[k],
            (None, Some(x)) => series[k] - x,
            (None, None) => 0.0,
        };
        let before = k.checked_sub(1).and_then(|k| series.get(k));
        let after = series.get(k + 1);
        for part in 0..WITHIN {
            let share = (part as f64 + 0.5) / WITHIN as f64 - 0.5;
            let step = if share < 0.0 { side(before, after) } else { side(after, before) };
            let (knot, second) = self.place(series[k] + share.abs() * step);
            row[knot] += weight * (1.0 - second) / WITHIN as f64;
            row[knot + 1] += weight * second / WITHIN as f64;
        }
    }

    /// Share of all samples at each knot.
    fn counted(&self) -> Vec<f64> {
        let mut visits = vec![0.0; KNOTS];
        let count: usize = self.series.iter().map(Vec::len).sum();
        for &x in self.series.iter().flatten() {
            let (knot, second) = self.place(x);
            visits[knot] += (1.0 - second) / count as f64;
            visits[knot + 1] += second / count as f64;
        }
        visits
    }

    /// Indices of the `points` even points on the range that the motion came within half a
    /// point's distance of.
    pub(super) fn visited(&self, points: usize) -> Vec<usize> {
        let spacing = (self.to - self.from) / (points - 1) as f64;
        let mut seen = vec![false; points];
        let cell = |x: f64| ((x - self.from) / spacing).round();
        let inside = 0.0..points as f64;
        for series in &self.series {
            let cells = series.iter().map(|&x| cell(x)).filter(|c| inside.contains(c));
            cells.for_each(|c| seen[c as usize] = true);
            // What it moves across between two samples it visits as well.
            for pair in series.windows(2) {
                let ends = [cell(pair[0]), cell(pair[1])];
                let across: Range<usize> = ends[0].min(ends[1]).max(0.0) as usize
                    ..(ends[0].max(ends[1]).max(0.0) as usize).min(points);
                across.for_each(|c| seen[c] = true);
            }
        }
        (0..points).filter(|&c| seen[c]).collect()
    }
}

/// A variable of a channel at sample `k`.
pub(super) fn value(motion: &SmoothedRecording, channel: usize, over: Over, k: usize) -> f64 {
    let (n, state) = (motion.coordinates(), motion.state(k));
    match over {
        Over::Coordinate => state[if channel < n { channel } else { channel + n }],
        Over::Velocity => state[channel + n],
        Over::Time => motion.times[k],
    }
}
