//! What conditioning did to the recordings of a diagnosis.

use super::{Dataset, Output};
use lacuna_recordings::{NoiseEstimate, conditioning_notes};
use std::collections::BTreeMap;

/// The same for the notes of a diagnosis.
pub(crate) fn notes(training: &Dataset, held_out: &Dataset) -> Vec<String> {
    let leaps = total([training.leaps(), held_out.leaps()]);
    let saturated = total([training.saturated(), held_out.saturated()]);
    let outliers = outliers_of([training, held_out]);
    let mut notes = conditioning_notes(&outliers, &saturated, leaps.keys());
    notes.extend(quantised(training));
    notes
}

/// Outputs that are read in steps, and how much of their noise is the rounding.
fn quantised(data: &Dataset) -> Option<String> {
    let of = |(output, noise): (&Output, &NoiseEstimate)| {
        let quantum = noise.quantum?;
        let (name, unit) = (&output.name, &output.unit);
        let ratio = quantum / noise.sd;
        Some(format!("{name} in steps of {quantum:.3e} {unit}, {ratio:.2} times its noise"))
    };
    let all: Vec<String> = data.outputs.iter().zip(&data.noise).filter_map(of).collect();
    (!all.is_empty()).then(|| {
        let rounding = "rounding alone makes a noise of a step over the square root of 12";
        format!("Quantised, where {rounding}: {}.", all.join("; "))
    })
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
