//! Inputs on times at which they were not recorded.

use crate::sampling::Sampling;
use crate::signal::{SignalError, check_pairs};
use std::collections::HashMap;

/// What an input does between its samples.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum InputHold {
    /// It keeps the last sample until the next one.
    #[default]
    ZeroOrder,
    /// It runs along straight lines from sample to sample.
    Linear,
}

/// Recorded and wanted times that differ by less than this share of a step are the same.
const SAME_TIME: f64 = 1e-6;

/// The input recorded as `values` at `time`, at the times `grid` (in any order).
///
/// * At recorded times, and before the first and after the last one: the recorded value.
/// * Between two rows: what `hold` says.
/// * Where rows were dropped (see [`Sampling`]) or values are missing (NaN): a dropped
///   row is given the value on the straight line between its neighbours, for either
///   `hold`. The values a held input took there are lost; the line is wrong by no more
///   than the input's curvature, where keeping the last value would be late by the
///   length of the gap. A zero-order input is then held from dropped row to dropped row.
///
/// # Errors
/// [`SignalError`] if times do not increase, lengths differ or every value is missing.
pub fn resample_input(
    time: &[f64],
    values: &[f64],
    grid: &[f64],
    hold: InputHold,
) -> Result<Vec<f64>, SignalError> {
    check_pairs(time, values)?;
    let sampling = Sampling::of(time);
    let positions = sampling.positions(time.len());
    let present = (0..time.len()).filter(|&row| !values[row].is_nan());
    let samples: Vec<Sample> = present
        .map(|row| Sample { time: time[row], value: values[row], position: positions[row] })
        .collect();
    let (Some(first), Some(last)) = (samples.first(), samples.last()) else {
        return Err(SignalError::TooFewSamples { needed: 1, found: 0 });
    };
    // A lone row has no step; then only the very same time is the same time.
    let slack = if sampling.step.is_nan() { 0.0 } else { SAME_TIME * sampling.step };
    let value = |&t: &f64| {
        let next = samples.partition_point(|sample| sample.time <= t + slack);
        match (next.checked_sub(1), samples.get(next)) {
            (Some(row), Some(after)) => between(samples[row], *after, t, slack, hold),
            (Some(_), None) => last.value,
            (None, _) => first.value,
        }
    };
    Ok(grid.iter().map(value).collect())
}

/// Longest run of dropped rows whose values are told by their neighbours; in a longer one nothing is known of
/// an input but how it varies at all.
const NEAR: usize = 16;

/// How wrong [`resample_input`] may be at the times of dropped rows, on average: the mean square error of the
/// same straight line across as many rows that were recorded. 0 at recorded times.
///
/// # Errors
/// As [`resample_input`].
pub fn lost_input_variance(
    time: &[f64],
    values: &[f64],
    grid: &[f64],
) -> Result<Vec<f64>, SignalError> {
    check_pairs(time, values)?;
    let sampling = Sampling::of(time);
    let positions = sampling.positions(time.len());
    let mut all = vec![f64::NAN; positions.last().map_or(0, |last| last + 1)];
    positions.iter().zip(values).for_each(|(at, value)| all[*at] = *value);
    let mut known: HashMap<(usize, usize), f64> = HashMap::new();
    let mut variance = vec![0.0; grid.len()];
    let recorded: Vec<usize> = (0..all.len()).filter(|k| !all[*k].is_nan()).collect();
    for ends in recorded.windows(2).filter(|ends| ends[1] > ends[0] + 1) {
        let width = ends[1] - ends[0];
        for after in 1..width {
            let own = known.entry((width, after)).or_insert_with(|| line_error(&all, width, after));
            if let Some(variance) = variance.get_mut(ends[0] + after) {
                *variance = *own;
            }
        }
    }
    Ok(variance)
}

/// Mean square error, so many rows after its beginning, of a straight line across a stretch of so many steps of
/// recorded rows.
fn line_error(all: &[f64], width: usize, after: usize) -> f64 {
    if width > NEAR {
        let present: Vec<f64> = all.iter().copied().filter(|v| !v.is_nan()).collect();
        let mean = present.iter().sum::<f64>() / present.len().max(1) as f64;
        return mean_square(present.iter().map(|v| v - mean));
    }
    let share = after as f64 / width as f64;
    let error = |w: &[f64]| w[after] - w[0] - share * (w[width] - w[0]);
    mean_square(all.windows(width + 1).map(error).filter(|e| !e.is_nan()))
}

fn mean_square(values: impl Iterator<Item = f64>) -> f64 {
    let (sum, count) = values.fold((0.0, 0), |(sum, count), v| (sum + v * v, count + 1));
    sum / f64::from(count.max(1))
}

/// A recorded value, and where its row stands among all rows, dropped ones included.
#[derive(Clone, Copy)]
struct Sample {
    time: f64,
    value: f64,
    position: usize,
}

/// The input at `t`, from `before` on and before `after`.
fn between(before: Sample, after: Sample, t: f64, slack: f64, hold: InputHold) -> f64 {
    let elapsed = t - before.time;
    if elapsed <= slack {
        return before.value;
    }
    let width = after.time - before.time;
    let slot = width / (after.position - before.position) as f64;
    let run = match hold {
        InputHold::Linear => elapsed,
        InputHold::ZeroOrder => ((elapsed + slack) / slot).floor() * slot,
    };
    before.value + run / width * (after.value - before.value)
}

#[cfg(test)]
mod tests {
    use super::*;

    const TIME: [f64; 6] = [0.0, 0.1, 0.2, 0.5, 0.6, 0.7];
    const VALUES: [f64; 6] = [1.0, 3.0, 2.0, 5.0, 4.0, 0.0];

    fn at_times(grid: &[f64], hold: InputHold) -> Vec<f64> {
        resample_input(&TIME, &VALUES, grid, hold).unwrap()
    }

    #[test]
    fn recorded_times_keep_their_values() {
        for hold in [InputHold::ZeroOrder, InputHold::Linear] {
            assert_eq!(at_times(&TIME, hold), VALUES);
            assert_eq!(at_times(&[-1.0, 9.0], hold), [1.0, 0.0]);
            // Times computed as k * step fall a rounding error beside the recorded ones.
            assert_eq!(at_times(&[3.0 * 0.1 * 2.0 - 1e-16], hold), [4.0]);
        }
    }

    #[test]
    fn dropped_rows_lie_on_the_line_between_their_neighbours() {
        for hold in [InputHold::ZeroOrder, InputHold::Linear] {
            for (found, expected) in at_times(&[0.3, 0.4], hold).iter().zip([3.0, 4.0]) {
                assert!((found - expected).abs() < 1e-12);
            }
        }
    }

    #[test]
    fn between_rows_the_input_is_held_or_drawn() {
        let held = at_times(&[0.05, 0.25, 0.35, 0.55], InputHold::ZeroOrder);
        let drawn = at_times(&[0.05, 0.25, 0.35, 0.55], InputHold::Linear);
        for (found, expected) in held.iter().zip([1.0, 2.0, 3.0, 5.0]) {
            assert!((found - expected).abs() < 1e-12);
        }
        for (found, expected) in drawn.iter().zip([2.0, 2.5, 3.5, 4.5]) {
            assert!((found - expected).abs() < 1e-12);
        }
    }

    /// Of white noise of variance 1 a line between two neighbours misses the value between them by a
    /// variance of 1 + 1/2; of a straight line it misses nothing.
    #[test]
    fn what_is_lost_is_as_uncertain_as_it_is_elsewhere() {
        let rows: Vec<usize> = (0..4000).filter(|k| k % 50 != 7).collect();
        let time: Vec<f64> = rows.iter().map(|k| *k as f64).collect();
        let grid: Vec<f64> = (0..4000).map(f64::from).collect();
        // The golden ratio's multiples are spread evenly, and neighbours far apart.
        let even = |k: usize| (k as f64 * k as f64 * 0.618_033_988_749_895).fract() - 0.5;
        let noise: Vec<f64> = rows.iter().map(|k| even(*k) * 12f64.sqrt()).collect();
        let variance = lost_input_variance(&time, &noise, &grid).unwrap();
        for (k, v) in variance.iter().enumerate() {
            if k % 50 == 7 {
                assert!((v - 1.5).abs() < 0.1, "{k}: {v}");
            } else {
                assert_eq!(*v, 0.0);
            }
        }
        let straight = lost_input_variance(&time, &time, &grid).unwrap();
        assert!(straight.iter().all(|v| *v < 1e-20));
        // Of a long gap nothing is known.
        let rows: Vec<usize> = (0..4000).filter(|k| !(100..200).contains(k)).collect();
        let time: Vec<f64> = rows.iter().map(|k| *k as f64).collect();
        let noise: Vec<f64> = rows.iter().map(|k| even(*k) * 12f64.sqrt()).collect();
        let variance = lost_input_variance(&time, &noise, &grid).unwrap();
        assert!((variance[150] - 1.0).abs() < 0.1 && variance[99] == 0.0 && variance[200] == 0.0);
    }

    #[test]
    fn missing_values_are_dropped_rows() {
        let time = [0.0, 1.0, 2.0, 3.0];
        let values = [0.0, f64::NAN, 4.0, 5.0];
        let filled = resample_input(&time, &values, &time, InputHold::ZeroOrder).unwrap();
        assert_eq!(filled, [0.0, 2.0, 4.0, 5.0]);
        let all = resample_input(&time, &[f64::NAN; 4], &time, InputHold::Linear);
        assert_eq!(all, Err(SignalError::TooFewSamples { needed: 1, found: 0 }));
    }
}
