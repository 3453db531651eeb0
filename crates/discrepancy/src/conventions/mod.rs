//! Recordings that may not mean what the model reads: a column of the other sign or in another unit, two exchanged,
//! another clock.
//!
//! Such a mistake is no physics, and yet the catalogue has something to offer in its place, however much that leaves.
//! Where a search leaves more than noise, the model as it was given is fitted to the recordings read otherwise, one
//! mistake at a time: over the stretch that moves most, and those that leave there no more than a share of what all that was
//! found leaves, over all that was searched. What follows the recordings further, or leaves less, than all that was found is told in
//! its place: nothing is named then, since it was looked for in the wrong numbers.

mod reading;

use crate::dataset::{Dataset, Observed};
use crate::decision::Decision;
use crate::likelihood::windows::first_level;
use crate::likelihood::{Fit, Hypothesis, Problem};
use crate::search::chain;
use crate::{DiagnoseError, Watch};
use lacuna_plants::Model;
use rayon::prelude::*;
use reading::{Reading, readings};
use serde::{Deserialize, Serialize};

/// Samples in which every reading is tried: a budget. A mistake changes motion wholesale.
const MOST: usize = 500;
/// Readings that are tried in all that was searched: a budget.
const SHORTLIST: usize = 4;

/// How the recordings seem to be meant.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Otherwise {
    /// In words, after "with": the likeliest first, and others that do as well.
    pub with: Vec<String>,
    /// Root mean square residual of the model as it was given, read so, in units of the noise, over windows.
    pub leaves: f64,
    /// That of all that was found, as the recordings are; null in JSON where it does not follow them that far.
    pub found_leaves: Option<f64>,
    /// Length of the windows (s).
    pub window_s: f64,
}

/// How far a model follows recordings, and what it leaves there.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Followed {
    level: u32,
    reduced: f64,
}

impl Followed {
    /// Whether it is much better: in longer windows, or leaving no more than a share in the same.
    fn beats(self, other: Self, share: f64) -> bool {
        self.level < other.level
            || (self.level == other.level && self.reduced <= share * other.reduced)
    }
}

/// How recordings seem to be meant that a search of `problem` does not explain, which ended with `chosen`; none where the
/// model does not follow them further in any other reading.
pub(crate) fn otherwise(
    problem: &Problem,
    chosen: &Fit,
    decision: Decision,
    watch: &Watch,
) -> Option<Otherwise> {
    if explains(chosen, decision) || watch.is_late() {
        return None;
    }
    watch.tell("reading the recordings otherwise");
    let Problem { model, dataset, .. } = *problem;
    let share = 1.0 - decision.further_share;
    let own = [Hypothesis::of(model), chosen.hypothesis.clone()];
    let tried = shortlist((model, dataset), &own, share, watch);
    let read = |reading: Reading| {
        let followed = follow(model, &reading.of(dataset), Hypothesis::of(model), decision, watch)?;
        Some((reading, followed))
    };
    let mut tried: Vec<_> = tried.into_par_iter().filter_map(read).collect();
    tried.sort_by(|(_, a), (_, b)| a.level.cmp(&b.level).then(a.reduced.total_cmp(&b.reduced)));
    let (_, best) = *tried.first()?;
    let own = own.into_par_iter().map(|h| follow(model, dataset, h, decision, watch));
    let own: Vec<_> = own.flatten().collect();
    if watch.is_late() || !own.iter().all(|own| best.beats(*own, share)) {
        return None;
    }
    let alike = |(_, f): &&(Reading, Followed)| {
        f.level == best.level && f.reduced <= decision.explained * best.reduced
    };
    let with = tried.iter().filter(alike).map(|(reading, _)| reading.words.clone()).collect();
    let there = own.iter().filter(|f| f.level == best.level).map(|f| f.reduced);
    let longest = dataset.recordings.iter().map(|o| o.times[o.len() - 1] - o.times[0]);
    Some(Otherwise {
        with,
        leaves: best.reduced.sqrt(),
        found_leaves: there.min_by(f64::total_cmp).map(f64::sqrt),
        window_s: longest.fold(0.0, f64::max) / f64::from(1u32 << best.level),
    })
}

/// Whether a fit leaves nothing but noise: of the outputs, on inputs, or of forces that are a lesser share of those that
/// move their channels. What a mistake leaves is as large as these, and slow.
fn explains(fit: &Fit, decision: Decision) -> bool {
    let Problem { sample, .. } = *fit.problem;
    let forces = fit.noise.as_deref().map_or(&[][..], |noise| &noise.forces);
    let small = |(c, intensity): (usize, &f64)| {
        *intensity <= decision.further_share * fit.problem.force_scale(c) * sample.sqrt()
    };
    forces.iter().enumerate().all(small) && fit.reduced() < decision.explained
}

/// The readings in which the model leaves least over the stretch that moves most, of those that leave no more than a share of
/// what all of `own` leave there.
fn shortlist(
    (model, dataset): (&Model, &Dataset),
    own: &[Hypothesis],
    share: f64,
    watch: &Watch,
) -> Vec<Reading> {
    let Some(stretch) = liveliest(dataset) else { return vec![] };
    let as_is = |h: &Hypothesis| left(model, &stretch, h.clone(), watch);
    let Ok(as_is) = own.par_iter().map(as_is).collect::<Result<Vec<_>, _>>() else { return vec![] };
    let as_is = as_is.into_iter().fold(f64::INFINITY, f64::min);
    let read = |reading: Reading| {
        let read = reading.of(&stretch);
        Some((left(model, &read, Hypothesis::of(model), watch).ok()?, reading))
    };
    let mut all: Vec<_> = readings(model, dataset).into_par_iter().filter_map(read).collect();
    all.retain(|(left, _)| *left <= share * as_is);
    all.sort_by(|(a, _), (b, _)| a.total_cmp(b));
    all.into_iter().take(SHORTLIST).map(|(_, reading)| reading).collect()
}

/// What a hypothesis leaves in short windows with its parameters as they are.
fn left(
    model: &Model,
    dataset: &Dataset,
    h: Hypothesis,
    watch: &Watch,
) -> Result<f64, DiagnoseError> {
    let problem = Problem::new(model, dataset)?.watched_by(watch);
    let fit = Fit::begin(&problem, h.held(), first_level(dataset));
    Ok(fit.map_or(f64::INFINITY, |fit| fit.reduced()))
}

/// How far a hypothesis follows recordings.
fn follow(
    model: &Model,
    dataset: &Dataset,
    h: Hypothesis,
    decision: Decision,
    watch: &Watch,
) -> Option<Followed> {
    let problem = Problem::new(model, dataset).ok()?.watched_by(watch);
    let begun = Fit::begin(&problem, h, first_level(dataset)).ok()?;
    let fit = chain::polish(chain::lengthen(begun, decision.window_misfit));
    Some(Followed { level: fit.windowed.level, reduced: fit.reduced() })
}

/// The stretch of a recording in which the outputs move most, each in units of all that it moves.
fn liveliest(dataset: &Dataset) -> Option<Dataset> {
    let ranges: Vec<f64> = (0..dataset.outputs.len()).map(|k| dataset.half_range(k)).collect();
    let moves = |part: &Observed| -> f64 {
        let deviation = |series: &[f64]| {
            let finite: Vec<f64> = series.iter().copied().filter(|v| v.is_finite()).collect();
            let count = finite.len().max(1) as f64;
            let mean = finite.iter().sum::<f64>() / count;
            (finite.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / count).sqrt()
        };
        part.outputs.iter().zip(&ranges).map(|(y, range)| deviation(y) / range).sum()
    };
    let cut = |o: &Observed| -> Vec<Observed> {
        let starts = (0..o.len()).step_by(MOST);
        let ranges = starts.map(|from| from..(from + MOST).min(o.len()));
        let long = ranges.filter(|r| r.len() >= MOST.min(o.len()) / 2);
        long.map(|r| o.part(r)).collect()
    };
    let all = dataset.recordings.iter().flat_map(cut);
    let best = all.max_by(|a, b| moves(a).total_cmp(&moves(b)))?;
    Some(dataset.with_recordings(vec![best]))
}
