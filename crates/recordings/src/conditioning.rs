//! What is done to the samples of a channel before anything is learned from them: angles that were
//! recorded within one turn are made continuous, samples of a sensor at its limit and outliers are left
//! out. Whoever reads recordings,
//! with a model or without, conditions them in this one way and says so in these words.

use crate::noise::{NoiseEstimate, estimate_noise_pooled};
use crate::outliers::find_outliers;
use crate::saturation::find_saturated;
use crate::signal::SignalError;
use crate::unwrap::unwrap_turns;
use lacuna_units::Unit;
use std::collections::BTreeMap;
use std::ops::Range;

/// What was done to the samples of one channel of one recording.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Cleaned {
    /// Samples that were left out as outliers ([`find_outliers`]), in order.
    pub outliers: Vec<usize>,
    /// Samples before which the angle leapt by whole turns ([`unwrap_turns`]), in order.
    pub leaps: Vec<usize>,
    /// Samples on which the sensor was at the end of its range ([`find_saturated`]), in order: they
    /// are treated as not measured.
    pub saturated: Vec<usize>,
}

impl Cleaned {
    /// What was done to these samples, counted from the first of them.
    #[must_use]
    pub fn part(&self, range: &Range<usize>) -> Self {
        let within = |rows: &[usize]| {
            rows.iter().filter(|row| range.contains(row)).map(|row| row - range.start).collect()
        };
        Self {
            outliers: within(&self.outliers),
            leaps: within(&self.leaps),
            saturated: within(&self.saturated),
        }
    }

    /// Whether a sample was left out.
    #[must_use]
    pub fn is_left_out(&self, row: usize) -> bool {
        [&self.outliers, &self.saturated].iter().any(|rows| rows.binary_search(&row).is_ok())
    }
}

/// Conditions one channel over several recordings, each `(time, values)`: makes it continuous
/// where its unit is one of angles, and NaN where its sensor is at its limit and where it has
/// outliers. Returns what was done to each, and the noise of what is left. An empty unit is none.
///
/// # Errors
/// As [`find_outliers`].
pub fn condition(
    recordings: &mut [(&[f64], &mut [f64])],
    unit: &str,
) -> Result<(Vec<Cleaned>, NoiseEstimate), SignalError> {
    let turn = Unit::parse(unit).ok().and_then(|unit| unit.turn());
    let mut unwrapped = |(time, values): &mut (&[f64], &mut [f64])| {
        turn.map_or_else(Vec::new, |turn| unwrap_turns(time, values, turn))
    };
    let leaps: Vec<_> = recordings.iter_mut().map(&mut unwrapped).collect();
    let saturated =
        find_saturated(&series(recordings), &estimate_noise_pooled(&series(recordings))?);
    leave_out(recordings, &saturated);
    let found = find_outliers(&series(recordings))?;
    leave_out(recordings, &found.rows);
    let each = found.rows.into_iter().zip(leaps).zip(saturated);
    let cleaned = |((outliers, leaps), saturated)| Cleaned { outliers, leaps, saturated };
    Ok((each.map(cleaned).collect(), found.noise))
}

fn series<'s>(recordings: &'s [(&[f64], &mut [f64])]) -> Vec<(&'s [f64], &'s [f64])> {
    recordings.iter().map(|(time, values)| (*time, &**values)).collect()
}

fn leave_out(recordings: &mut [(&[f64], &mut [f64])], rows: &[Vec<usize>]) {
    for ((_, values), rows) in recordings.iter_mut().zip(rows) {
        rows.iter().for_each(|&row| values[row] = f64::NAN);
    }
}

/// What conditioning did, in words: the number of outliers, and of samples at its sensor's limit,
/// of each channel that has any, and the channels that leapt by turns.
#[must_use]
pub fn conditioning_notes<'a>(
    outliers: &BTreeMap<String, usize>,
    saturated: &BTreeMap<String, usize>,
    leapt: impl IntoIterator<Item = &'a String>,
) -> Vec<String> {
    let mut notes = vec![];
    let why = [
        (outliers, "Left out as outliers, which neither noise nor motion explains"),
        (saturated, "At the end of the sensor's range, and treated as not measured"),
    ];
    for (counts, why) in why.into_iter().filter(|(counts, _)| !counts.is_empty()) {
        let each: Vec<_> =
            counts.iter().map(|(q, n)| format!("{} of {q}", in_samples(*n))).collect();
        notes.push(format!("{why}: {}.", each.join(", ")));
    }
    let names: Vec<_> = leapt.into_iter().map(String::as_str).collect();
    if !names.is_empty() {
        notes.push(format!("Recorded within one turn, and made continuous: {}.", names.join(", ")));
    }
    notes
}

/// So many samples, in words.
#[must_use]
pub fn in_samples(samples: usize) -> String {
    if samples == 1 { "1 sample".to_owned() } else { format!("{samples} samples") }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn wrapped_angles_and_glitches_of_one_channel() {
        let time: Vec<f64> = (0..2000).map(|k| 0.01 * f64::from(k)).collect();
        let truth: Vec<f64> = time.iter().map(|t| 100.0 * t + 5.0 * (3.0 * t).sin()).collect();
        let mut recorded: Vec<f64> =
            truth.iter().map(|q| q - 360.0 * (q / 360.0).floor()).collect();
        recorded[700] += 20.0;
        let (cleaned, _) = condition(&mut [(&time, &mut recorded)], "deg").unwrap();
        assert_eq!((&cleaned[0].outliers[..], cleaned[0].leaps.len()), (&[700][..], 5));
        for (k, (found, expected)) in recorded.iter().zip(&truth).enumerate() {
            assert!(k == 700 && found.is_nan() || (found - expected).abs() < 1e-9, "{k}");
        }
        assert_eq!(cleaned[0].part(&(650..800)).outliers, [50]);
        // Of a length, leaps are what they are.
        let mut lengths: Vec<f64> = truth.iter().map(|q| q - 360.0 * (q / 360.0).floor()).collect();
        let (cleaned, _) = condition(&mut [(&time, &mut lengths)], "mm").unwrap();
        assert!(cleaned[0].leaps.is_empty() && lengths[1999] < 360.0);
    }

    #[test]
    fn what_was_done_is_said() {
        let outliers = BTreeMap::from([("q".to_owned(), 1), ("x".to_owned(), 2)]);
        let saturated = BTreeMap::from([("v".to_owned(), 7)]);
        let said = conditioning_notes(&outliers, &saturated, &["q".to_owned()]);
        assert!(said[0].ends_with(": 1 sample of q, 2 samples of x."), "{said:?}");
        assert!(said[1].ends_with("treated as not measured: 7 samples of v."), "{said:?}");
        assert!(said[2].ends_with("made continuous: q."), "{said:?}");
        assert!(conditioning_notes(&BTreeMap::new(), &BTreeMap::new(), []).is_empty());
    }
}
