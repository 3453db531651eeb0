//! What is wrong with samples whatever the model says: wrapped angles, lost counts, glitches.

use super::{Cleaned, Dataset, Observed, Output};
use lacuna_recordings::{NoiseEstimate, SignalError, Unit, find_outliers, unwrap_turns};
use std::collections::BTreeMap;
use std::ops::Range;

/// Makes an output of this unit continuous where it is an angle that was recorded within one
/// turn; returns how often it leapt.
pub(super) fn unwrapped(times: &[f64], series: &mut [f64], unit: &str) -> Vec<usize> {
    let turn = Unit::parse(unit).ok().and_then(|unit| unit.turn());
    turn.map_or_else(Vec::new, |turn| unwrap_turns(times, series, turn))
}

/// Leaves the outliers of an output out, in all recordings; returns its noise without them.
pub(super) fn leave_out(
    observed: &mut [Observed],
    output: usize,
) -> Result<NoiseEstimate, SignalError> {
    let series: Vec<_> =
        observed.iter().map(|o| (o.times.as_slice(), o.outputs[output].as_slice())).collect();
    let found = find_outliers(&series)?;
    for (observed, rows) in observed.iter_mut().zip(found.rows) {
        rows.iter().for_each(|&row| observed.outputs[output][row] = f64::NAN);
        observed.cleaned[output].outliers = rows;
    }
    Ok(found.noise)
}

impl Cleaned {
    /// What was done to these samples.
    pub(super) fn part(&self, range: &Range<usize>) -> Self {
        let within = |rows: &[usize]| {
            rows.iter().filter(|row| range.contains(row)).map(|row| row - range.start).collect()
        };
        Self { outliers: within(&self.outliers), leaps: within(&self.leaps) }
    }
}

/// What conditioning did to the recordings of a diagnosis, for its notes.
pub(crate) fn notes(training: &Dataset, held_out: &Dataset) -> Vec<String> {
    let mut notes = vec![];
    let samples = |n: usize| if n == 1 { "1 sample".to_owned() } else { format!("{n} samples") };
    let outliers = outliers_of([training, held_out]);
    if !outliers.is_empty() {
        let each: Vec<_> =
            outliers.iter().map(|(q, n)| format!("{} of {q}", samples(*n))).collect();
        notes.push(format!(
            "Left out as outliers, which neither noise nor motion explains: {}.",
            each.join(", ")
        ));
    }
    let leaps = total([training.leaps(), held_out.leaps()]);
    if !leaps.is_empty() {
        let names: Vec<_> = leaps.into_keys().collect();
        notes.push(format!("Recorded within one turn, and made continuous: {}.", names.join(", ")));
    }
    notes
}

/// Number of outliers of each channel that has any, in all these recordings.
pub(crate) fn outliers_of(datasets: [&Dataset; 2]) -> BTreeMap<String, usize> {
    total(datasets.map(Dataset::outliers))
}

fn total<'a, I: Iterator<Item = (&'a Output, usize)>>(all: [I; 2]) -> BTreeMap<String, usize> {
    let mut counts = BTreeMap::new();
    for (output, count) in all.into_iter().flatten() {
        *counts.entry(output.name.clone()).or_default() += count;
    }
    counts
}
