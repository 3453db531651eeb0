//! What sampled signals must satisfy before anything is estimated from them.

use thiserror::Error;

/// A sampled signal from which nothing can be estimated.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum SignalError {
    /// Times and values do not come in pairs.
    #[error("expected one value per time: {expected} times, {found} values")]
    LengthMismatch {
        /// Number of times.
        expected: usize,
        /// Number of values.
        found: usize,
    },
    /// Times are not finite and strictly increasing.
    #[error("expected times that increase; row {row} (from 0) has {found} s after {before} s")]
    TimeNotIncreasing {
        /// Row of the later time, from 0.
        row: usize,
        /// The earlier time, s.
        before: f64,
        /// The later time, s.
        found: f64,
    },
    /// Too few samples that are not missing.
    #[error("expected at least {needed} samples that are not missing, found {found}")]
    TooFewSamples {
        /// Samples needed.
        needed: usize,
        /// Samples found.
        found: usize,
    },
    /// A noise standard deviation that is zero, negative or not finite.
    #[error("expected a positive noise standard deviation, found {found}")]
    NoiseNotPositive {
        /// The value found.
        found: f64,
    },
    /// The numbers are too large or too small for the computation.
    #[error("the computation left the range of numbers; check the units of time and values")]
    OutOfRange,
}

/// Checks that `time` increases strictly and that `values` has its length.
pub(crate) fn check_pairs(time: &[f64], values: &[f64]) -> Result<(), SignalError> {
    if time.len() != values.len() {
        return Err(SignalError::LengthMismatch { expected: time.len(), found: values.len() });
    }
    check_times(time)
}

fn check_times(time: &[f64]) -> Result<(), SignalError> {
    let disorder = |row, before, found| SignalError::TimeNotIncreasing { row, before, found };
    match time.first() {
        Some(&first) if !first.is_finite() => return Err(disorder(0, f64::NEG_INFINITY, first)),
        _ => {}
    }
    let wrong = |pair: &[f64]| !(pair[1] > pair[0] && pair[1].is_finite());
    match time.windows(2).position(wrong) {
        Some(row) => Err(disorder(row + 1, time[row], time[row + 1])),
        None => Ok(()),
    }
}

/// The middle one of `values` in order, the mean of the middle two for an even number;
/// NaN if there is none. Reorders `values`.
pub(crate) fn median(values: &mut [f64]) -> f64 {
    if values.is_empty() {
        return f64::NAN;
    }
    let middle = values.len() / 2;
    let upper = *values.select_nth_unstable_by(middle, f64::total_cmp).1;
    if values.len() % 2 == 1 {
        return upper;
    }
    let lower = values[..middle].iter().copied().fold(f64::NEG_INFINITY, f64::max);
    0.5 * (lower + upper)
}
