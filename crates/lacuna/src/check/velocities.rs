//! Whether the column of a velocity is the rate of its coordinate's: in sign, in unit, in time.
//!
//! Over windows with a smooth phi that vanishes at their ends, `-integral(phi' q) = s integral(phi v)`: no sample is
//! differentiated. Both sides are known with an error, so that the scale s lies between the slopes of either against
//! the other.

use crate::discrepancy::{Dataset, Observed};
use crate::plants::Model;
use serde::Serialize;
use std::f64::consts::PI;

/// Samples of the shortest windows; each next length is twice as long. The best of them lets the motion
/// through, and of the noise little.
const SHORTEST: usize = 8;
const LENGTHS: usize = 9;
/// Windows that are looked at, at the most: a budget.
const MOST: usize = 2000;
/// Windows that are to be had, at the least, for a scale to mean something.
const FEWEST: usize = 30;
/// Samples by which a velocity is looked for earlier and later.
const LATEST: isize = 25;
/// A lag that leaves more than this share of what none leaves is chance.
const LEFT: f64 = 0.5;

/// A coordinate and its velocity, both measured.
#[derive(Serialize)]
pub struct Velocity {
    pub coordinate: String,
    pub velocity: String,
    /// The rate of the coordinate in units of the velocity: between the two, negative where the signs differ.
    pub scale: [f64; 2],
    /// Correlation of both.
    pub correlation: f64,
    /// How much later the velocity tells the motion, s; 0 where nothing speaks for any other.
    pub lag_s: f64,
    /// The same in samples.
    pub lag_samples: f64,
}

/// All that are measured with their coordinates, and move.
pub fn velocities(model: &Model, data: &Dataset) -> Vec<Velocity> {
    let n = model.coordinates.len();
    let pair = |c: usize| {
        let (q, v) = (data.output_of_state(c)?, data.output_of_state(n + c)?);
        let of = |length: usize| Sums::of(data, (q, v), length, 0);
        let lengths = (0..LENGTHS).map(|k| SHORTEST << k);
        let best = lengths
            .map(|length| (length, of(length)))
            .filter(|(_, sums)| sums.windows >= FEWEST && sums.correlation().is_finite())
            .max_by(|a, b| a.1.correlation().abs().total_cmp(&b.1.correlation().abs()))?;
        let (length, at_once) = best;
        let (samples, sums) = lag(data, (q, v), length, at_once);
        Some(Velocity {
            coordinate: data.outputs[q].name.clone(),
            velocity: data.outputs[v].name.clone(),
            scale: sums.scale(),
            correlation: sums.correlation(),
            lag_s: samples * step(&data.recordings[0]),
            lag_samples: samples,
        })
    };
    (0..n).filter_map(pair).collect()
}

/// By how many samples the velocity comes late, and both sides with it.
fn lag(data: &Dataset, pair: (usize, usize), length: usize, at_once: Sums) -> (f64, Sums) {
    let sums = |late: isize| Sums::of(data, pair, length, late);
    let left = |late: isize| 1.0 - sums(late).correlation().powi(2);
    let all = (-LATEST..=LATEST).filter(|late| left(*late).is_finite());
    let best = all.min_by(|a, b| left(*a).total_cmp(&left(*b))).unwrap_or(0);
    if left(best) > LEFT * left(0) {
        return (0.0, at_once);
    }
    // The lowest point of a parabola through it and its neighbours.
    let [before, here, after] = [-1, 0, 1].map(|side| left(best + side));
    let bend = before - 2.0 * here + after;
    let between = if bend > 0.0 { 0.5 * (before - after) / bend } else { 0.0 };
    (best as f64 + between.clamp(-0.5, 0.5), sums(best))
}

/// Sums over all windows of both sides' products.
#[derive(Clone, Copy, Default)]
struct Sums {
    windows: usize,
    qq: f64,
    qv: f64,
    vv: f64,
}

impl Sums {
    /// Of windows of so many samples, the velocity taken so many samples later.
    fn of(data: &Dataset, (q, v): (usize, usize), length: usize, late: isize) -> Self {
        let mut sums = Self::default();
        let samples: usize = data.recordings.iter().map(Observed::len).sum();
        let apart = (length / 2).max(samples / MOST);
        for observed in &data.recordings {
            let starts = (0..observed.len().saturating_sub(length)).step_by(apart);
            for [rate, velocity] in
                starts.filter_map(|at| sides(observed, (q, v), at, length, late))
            {
                sums.windows += 1;
                sums.qq += rate * rate;
                sums.qv += rate * velocity;
                sums.vv += velocity * velocity;
            }
        }
        sums
    }

    fn correlation(&self) -> f64 {
        self.qv / (self.qq * self.vv).sqrt()
    }

    fn scale(&self) -> [f64; 2] {
        let mut both = [self.qv / self.vv, self.qq / self.qv];
        both.sort_by(|a, b| a.abs().total_cmp(&b.abs()));
        both
    }
}

/// Both sides over one window; none where a sample is missing.
fn sides(
    observed: &Observed,
    (q, v): (usize, usize),
    at: usize,
    length: usize,
    late: isize,
) -> Option<[f64; 2]> {
    let (times, positions, velocities) =
        (&observed.times, &observed.outputs[q], &observed.outputs[v]);
    let (from, span) = (times[at], times[at + length] - times[at]);
    let mut both = [0.0; 2];
    // Of the ends, where phi and its rate are zero, nothing is needed.
    for k in at + 1..at + length {
        let weight = 0.5 * (times[k + 1] - times[k - 1]);
        let phase = PI * (times[k] - from) / span;
        let velocity = velocities.get(k.checked_add_signed(late)?)?;
        both[0] -= weight * PI / span * (2.0 * phase).sin() * positions[k];
        both[1] += weight * phase.sin().powi(2) * velocity;
    }
    both.iter().all(|side| side.is_finite()).then_some(both)
}

/// Usual step, s.
fn step(observed: &Observed) -> f64 {
    (observed.times[observed.len() - 1] - observed.times[0]) / (observed.len() - 1) as f64
}
