//! Whether a finding says where or when an effect acts: F1 over the samples of the recordings.
//!
//! ```text
//! F1 = 2 |R and T| / (|R| + |T|)      R: samples that the finding claims, T: samples that are true
//! ```

use lacuna_recordings::{Recording, RecordingSource};
use std::path::PathBuf;

use super::ConcealedError;
use super::diagnosis::{Diagnosis, Finding};
use super::score::Score;
use super::sealed::{Area, Sealed};

/// F1 of each local effect of a case, by the finding that answers to it; 0 where none does.
///
/// # Errors
/// [`ConcealedError::Recording`] when the true states cannot be read.
pub fn localised(
    truth: &Sealed,
    score: &Score,
    diagnosis: &Diagnosis,
    states: &[PathBuf],
    time_column: &str,
) -> Result<Vec<f64>, ConcealedError> {
    if truth.effects.iter().all(|e| e.area.is_none()) {
        return Ok(Vec::new());
    }
    let read =
        |path: &PathBuf| lacuna_recordings::read(&RecordingSource::file(path.clone()), time_column);
    let recordings: Vec<Recording> = states.iter().map(read).collect::<Result<_, _>>()?;
    let mut out = Vec::new();
    for effect in &truth.effects {
        let Some(area) = &effect.area else { continue };
        let answer = score.matches.iter().find(|m| m.truth.as_ref() == Some(&effect.name.class));
        let name = answer.and_then(|m| m.found.as_ref());
        let finding = diagnosis.findings.iter().find(|f| Some(&f.name()) == name);
        out.push(finding.map_or(0.0, |finding| f1(area, finding, &recordings)));
    }
    Ok(out)
}

/// F1 of what a finding claims against where an effect acts.
fn f1(area: &Area, finding: &Finding, recordings: &[Recording]) -> f64 {
    let (mut both, mut claimed, mut right) = (0, 0, 0);
    for recording in recordings {
        for k in 0..recording.len() {
            let (c, r) = (claims(finding, recording, k), acts(area, recording, k));
            both += usize::from(c && r);
            claimed += usize::from(c);
            right += usize::from(r);
        }
    }
    match claimed + right {
        0 => 0.0,
        all => 2.0 * f64::from(both as u32) / all as f64,
    }
}

fn value(recording: &Recording, variable: &str, k: usize) -> Option<f64> {
    recording.columns.iter().find(|c| c.name == variable).map(|c| c.values[k])
}

fn acts(area: &Area, recording: &Recording, k: usize) -> bool {
    match area {
        Area::From(time) => recording.time[k] >= *time,
        Area::Region { variable, from, to } => value(recording, variable, k)
            .is_some_and(|x| from.is_none_or(|a| x >= a) && to.is_none_or(|b| x <= b)),
    }
}

/// A finding claims the samples within all its ranges and from its time on; without either, all.
fn claims(finding: &Finding, recording: &Recording, k: usize) -> bool {
    let begun = finding.time.is_none_or(|t| recording.time[k] >= t);
    let inside = |(variable, [from, to]): (&String, &[f64; 2])| {
        value(recording, variable, k).is_none_or(|x| (*from..=*to).contains(&x))
    };
    begun && finding.region.iter().all(inside)
}

#[cfg(test)]
mod tests {
    use super::*;
    use lacuna_recordings::Column;
    use std::collections::BTreeMap;

    fn ramp() -> Vec<Recording> {
        let time: Vec<f64> = (0..100).map(f64::from).collect();
        let columns = vec![Column { name: "q".to_owned(), values: time.clone() }];
        vec![Recording { name: String::new(), time, columns }]
    }

    fn region(from: f64, to: f64) -> Finding {
        let region = BTreeMap::from([("q".to_owned(), [from, to])]);
        Finding { region, ..Finding::default() }
    }

    #[test]
    fn f1_is_that_of_counted_samples() {
        let area = Area::Region { variable: "q".to_owned(), from: Some(80.0), to: None };
        assert_eq!(f1(&area, &region(80.0, 99.0), &ramp()), 1.0);
        assert_eq!(f1(&area, &region(0.0, 79.5), &ramp()), 0.0);
        // 10 of 20 true samples within 10 claimed: precision 1, recall 1/2.
        assert!((f1(&area, &region(90.0, 99.0), &ramp()) - 2.0 / 3.0).abs() < 1e-12);
        // No claim of a place is a claim of all: precision 1/5, recall 1.
        assert!((f1(&area, &Finding::default(), &ramp()) - 1.0 / 3.0).abs() < 1e-12);
    }

    #[test]
    fn times_are_places_too() {
        let late = Finding { time: Some(60.0), ..Finding::default() };
        assert!((f1(&Area::From(50.0), &late, &ramp()) - 80.0 / 90.0).abs() < 1e-12);
    }
}
