//! Which part of long recordings is searched: what tells effects apart shows in a few thousand
//! samples, and a search of all would cost as much more as the recordings are longer. Everything
//! that is found is fitted to all of them in the end.

use crate::dataset::{Dataset, Observed};
use std::ops::Range;

/// Samples that are searched, about: those of a minute at 200 Hz. A budget.
pub(super) const MOST: usize = 12_000;
/// Samples of a stretch: long enough for what is slow, short enough for six of them.
const STRETCH: usize = 2_000;

/// A stretch of a recording.
#[derive(Clone, Debug, PartialEq, Eq)]
struct Stretch {
    recording: usize,
    range: Range<usize>,
}

/// Stretches of the recordings as recordings of their own: those in which a channel is at an end
/// of its range, and others evenly among them; none where the recordings are no longer than that.
#[must_use]
pub(super) fn stretches(dataset: &Dataset) -> Option<Dataset> {
    let total: usize = dataset.recordings.iter().map(Observed::len).sum();
    if total <= MOST + STRETCH {
        return None;
    }
    let all = cut(dataset);
    let mut chosen = extremes(dataset, &all);
    let wanted = (MOST / STRETCH).max(chosen.len());
    // Evenly among those that are not yet there.
    let rest: Vec<usize> = (0..all.len()).filter(|k| !chosen.contains(k)).collect();
    let more = (wanted - chosen.len()).min(rest.len());
    chosen.extend((0..more).map(|i| rest[(2 * i + 1) * rest.len() / (2 * more)]));
    chosen.sort_unstable();
    let part = |&k: &usize| dataset.recordings[all[k].recording].part(all[k].range.clone());
    Some(dataset.with_recordings(chosen.iter().map(part).collect()))
}

/// All stretches, of equal length within each recording.
fn cut(dataset: &Dataset) -> Vec<Stretch> {
    let of = |(recording, o): (usize, &Observed)| {
        let (samples, count) = (o.len(), (o.len() / STRETCH).max(1));
        let edge = move |k: usize| k * samples / count;
        (0..count).map(move |k| Stretch { recording, range: edge(k)..edge(k + 1) })
    };
    dataset.recordings.iter().enumerate().flat_map(of).collect()
}

/// The stretches that hold the smallest or the largest value of an output, each once; at most half
/// of those that are wanted.
fn extremes(dataset: &Dataset, all: &[Stretch]) -> Vec<usize> {
    let mut chosen = vec![];
    for output in 0..dataset.outputs.len() {
        let values = |s: &Stretch| {
            let series = &dataset.recordings[s.recording].outputs[output][s.range.clone()];
            let finite = series.iter().filter(|v| v.is_finite());
            finite.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), v| (a.min(*v), b.max(*v)))
        };
        let ends: Vec<(f64, f64)> = all.iter().map(values).collect();
        let lowest = (0..all.len()).min_by(|&a, &b| ends[a].0.total_cmp(&ends[b].0));
        let highest = (0..all.len()).max_by(|&a, &b| ends[a].1.total_cmp(&ends[b].1));
        for k in lowest.into_iter().chain(highest) {
            if !chosen.contains(&k) && 2 * chosen.len() < MOST / STRETCH {
                chosen.push(k);
            }
        }
    }
    chosen
}

#[cfg(test)]
mod tests {
    use super::{MOST, STRETCH, stretches};
    use crate::dataset::{Dataset, Observed, Output};
    use lacuna_plants::model::Measured;
    use lacuna_recordings::NoiseEstimate;

    fn recording(samples: usize, peak: usize) -> Observed {
        let times: Vec<f64> = (0..samples).map(|k| k as f64).collect();
        let mut series: Vec<f64> = times.iter().map(|t| t.sin()).collect();
        series[peak] = 9.0;
        let (name, commands) = ("run".to_owned(), vec![0.0; samples]);
        let (lost, anew, cleaned) = (vec![], vec![], vec![]);
        let outputs = vec![series];
        Observed { name, times, commands, outputs, dropped: 0, lost, anew, cleaned }
    }

    fn dataset(recordings: Vec<Observed>) -> Dataset {
        let output = Output { name: "q".into(), unit: "rad".into(), of: Measured::State(0) };
        let noise = vec![NoiseEstimate { sd: 0.01, quantum: None }];
        Dataset { outputs: vec![output], recordings, noise, notes: vec![] }
    }

    #[test]
    fn long_recordings_are_searched_in_stretches_that_hold_the_extremes() {
        let all = dataset(vec![recording(70_000, 50_500), recording(30_000, 10)]);
        let few = stretches(&all).expect("too much to search whole");
        let total: usize = few.recordings.iter().map(Observed::len).sum();
        assert!((MOST - STRETCH..=MOST + STRETCH).contains(&total), "{total}");
        let peaks = few.recordings.iter().filter(|o| o.outputs[0].contains(&9.0)).count();
        assert!(peaks >= 1, "the largest value is searched");
        // From both recordings, in order.
        let begins: Vec<f64> = few.recordings.iter().map(|o| o.times[0]).collect();
        assert!(begins.windows(2).filter(|b| b[1] <= b[0]).count() <= 1, "{begins:?}");
        assert!(stretches(&dataset(vec![recording(9_000, 1)])).is_none());
    }
}
