//! What conditioning did to the recordings of a diagnosis.

use super::{Dataset, Output};
use lacuna_recordings::conditioning_notes;
use std::collections::BTreeMap;

/// The same for the notes of a diagnosis.
pub(crate) fn notes(training: &Dataset, held_out: &Dataset) -> Vec<String> {
    let leaps = total([training.leaps(), held_out.leaps()]);
    conditioning_notes(&outliers_of([training, held_out]), leaps.keys())
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
