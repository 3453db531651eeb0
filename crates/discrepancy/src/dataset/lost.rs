//! Inputs that nobody recorded, because their rows were dropped.
//!
//! The machine got `u + e` where the recording has a straight line u across the gap. What follows is then no
//! matter of physics. A run that begins anew behind it, with a state x of its own, knows nothing of e; its n
//! entries take up n squares of noise. So it begins anew where going through costs more:
//!
//! ```text
//! sum_k |y_k(u + s) - y_k(u)|^2 / sigma^2 > n
//! ```
//!
//! with s the standard deviations of the inputs that were lost, and y what the model says of the samples in the gap
//! and behind it.

use super::{Dataset, Observed};
use crate::prediction::Predictor;
use lacuna_plants::Model;
use std::ops::Range;

/// An input of a dropped row: it was on the straight line between its neighbours, or near it.
#[derive(Clone, Copy, Debug)]
pub struct LostInput {
    /// The row.
    pub row: usize,
    /// The input.
    pub input: usize,
    /// Standard deviation.
    pub sd: f64,
}

/// Samples behind a gap that are looked at: what moves them no further by then is left to be.
const BEHIND: usize = 64;

impl Dataset {
    /// The same with the samples at which runs begin anew.
    pub(super) fn begun_anew(mut self, model: &Model) -> Self {
        if self.recordings.iter().all(|o| o.lost.is_empty()) {
            return self;
        }
        let free = (0..model.machine_states()).filter(|&i| !model.is_imposed_state(i)).count();
        let predictor = Predictor::new(model, &self);
        let far = |o: &Observed, gap: &Gap| {
            predictor.moved_by_lost(&o.part(gap.before..gap.until)) > free as f64
        };
        let all: Vec<Vec<Gap>> = (self.recordings.iter())
            .map(|o| gaps(o).into_iter().filter(|gap| far(o, gap)).collect())
            .collect();
        for (observed, gaps) in self.recordings.iter_mut().zip(all) {
            observed.begin_anew_behind(&gaps, free);
        }
        self
    }
}

impl Observed {
    /// Begin anew behind some gaps, whose own samples tell nothing. Nor do stretches between them that tell less
    /// than twice what the state at their beginning takes up: they are left out.
    fn begin_anew_behind(&mut self, gaps: &[Gap], free: usize) {
        gaps.iter().for_each(|gap| self.forget(gap.before + 1..gap.behind));
        let mut anew: Vec<usize> = gaps.iter().map(|gap| gap.behind).collect();
        let mut at = 0;
        while at < anew.len() {
            let next = anew.get(at + 1).copied().unwrap_or(self.len());
            if self.measured(anew[at]..next) < 2 * free {
                self.forget(anew[at]..next);
                anew.remove(at);
            } else {
                at += 1;
            }
        }
        // Before the first of them there is no other run that it could be left to.
        if anew.first().is_some_and(|&first| self.measured(0..first) < 2 * free) {
            anew.remove(0);
        }
        self.anew = anew;
    }

    /// Take samples for not measured.
    fn forget(&mut self, range: Range<usize>) {
        self.outputs.iter_mut().for_each(|y| y[range.clone()].fill(f64::NAN));
    }

    /// Numbers that were measured in a range of samples.
    fn measured(&self, range: Range<usize>) -> usize {
        let finite = |y: &Vec<f64>| y[range.clone()].iter().filter(|v| v.is_finite()).count();
        self.outputs.iter().map(finite).sum()
    }
}

/// What a reader must know of it.
pub(crate) fn says<'d>(all: impl IntoIterator<Item = &'d Dataset>) -> Option<String> {
    let count: usize = all.into_iter().flat_map(|d| &d.recordings).map(|o| o.anew.len()).sum();
    (count > 0).then(|| format!("Rows or values are missing while an input was at work that no line between its neighbours tells: predictions begin anew behind such gaps, {count} of them."))
}

/// Rows whose inputs were lost, one after the other.
struct Gap {
    /// The last row before it.
    before: usize,
    /// The first row behind it.
    behind: usize,
    /// The rows behind it that are looked at end here, at the next gap at the latest.
    until: usize,
}

/// The gaps of a recording.
fn gaps(observed: &Observed) -> Vec<Gap> {
    let mut rows: Vec<usize> = observed.lost.iter().map(|l| l.row).collect();
    rows.sort_unstable();
    rows.dedup();
    let runs: Vec<&[usize]> = rows.chunk_by(|a, b| a + 1 == *b).collect();
    let ends = runs.iter().skip(1).map(|run| run[0]).chain([observed.len()]);
    (runs.iter().zip(ends))
        .map(|(run, end)| {
            let behind = run[run.len() - 1] + 1;
            Gap { before: run[0].saturating_sub(1), behind, until: end.min(behind + BEHIND) }
        })
        .filter(|gap| gap.behind < gap.until)
        .collect()
}
