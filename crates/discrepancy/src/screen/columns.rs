//! What each amplitude of a term changes in the outputs.

use super::local::{Along, Local};
use super::{Drive, Screen};
use crate::candidates::{Candidate, Term};
use crate::likelihood::sweep;
use lacuna_effects::{AnySeriesLaw, Law};
use lacuna_numbers::{Dual, LANES, Number};
use lacuna_plants::model::Measured;

/// What drives the linearised motion: where, the series, its sign.
pub(super) type Drives = Vec<(Drive, Vec<f64>, f64)>;

/// The value of a drive at a sample of the recording.
type Value = fn(usize) -> f64;
/// Where nothing drives the motion, and only its outputs are seen otherwise.
const UNDRIVEN: [(Drive, Value); 0] = [];

impl Screen<'_> {
    /// What drives the linearised motion for each amplitude of a term.
    pub(super) fn drives(&self, term: &Term, along: &Along) -> Vec<Drives> {
        let Candidate { effect, channel, other } = term.candidate;
        match effect.law {
            Law::Force(law) => {
                let series = along.motion.basis(
                    law,
                    &term.shape,
                    &self.problem.model.places(channel, other),
                );
                let reaction = other.filter(|_| law.reacts());
                let passed_on = law.plain().passed_on(&term.shape);
                series
                    .into_iter()
                    .map(|s| {
                        let s = centred(&s);
                        let mut drives = vec![(Drive::Force(channel), s.clone(), 1.0)];
                        drives.extend(reaction.map(|o| (Drive::Force(o), s, -passed_on)));
                        drives
                    })
                    .collect()
            }
            Law::Input(law) => {
                let m = self.problem.model.inputs.len();
                let u: Vec<f64> =
                    along.maps.inputs.iter().skip(channel).step_by(m).copied().collect();
                let made = law.plain().applied(&term.shape, &along.motion.times, &u);
                let change = made.iter().zip(&u).map(|(a, b)| a - b).collect();
                vec![vec![(Drive::Input(channel), change, 1.0)]]
            }
            Law::Sensor(_) => vec![],
        }
    }

    /// Weighted change of the measured samples of a window under each of several drives, which act
    /// in the same places.
    pub(super) fn driven(&self, along: &Along, local: &Local, all: &[Drives]) -> Vec<Vec<f64>> {
        let range = &local.window.range;
        let outputs = self.problem.dataset.outputs.len();
        let filter = along.maps.filters.get(local.number);
        let side_by_side = |some: &[Drives]| -> Vec<Vec<f64>> {
            let mut out = vec![vec![Dual::constant(0.0); range.len()]; outputs];
            let place = |p: usize| {
                let value = move |k: usize| {
                    let mut value = Dual::constant(0.0);
                    for (lane, drives) in value.tangent.iter_mut().zip(some) {
                        *lane = drives[p].1[k] * drives[p].2;
                    }
                    value
                };
                (some[0][p].0, value)
            };
            let drives: Vec<_> = (0..some[0].len()).map(place).collect();
            along.maps.propagate(range, filter, &drives, &mut out);
            let lane = |l: usize| {
                let of = |series: &Vec<Dual>| series.iter().map(|y| y.tangent[l]).collect();
                self.rows(along, local, &out.iter().map(of).collect::<Vec<_>>())
            };
            (0..some.len()).map(lane).collect()
        };
        all.chunks(LANES).flat_map(side_by_side).collect()
    }

    /// Weighted change of the measured samples of a window per unit of a sensor's parameter.
    pub(super) fn sensed(
        &self,
        law: &dyn AnySeriesLaw,
        term: &Term,
        along: &Along,
        local: &Local,
    ) -> Vec<f64> {
        let range = &local.window.range;
        let times = &along.motion.times[range.clone()];
        let state = term.candidate.channel;
        let value = |k: usize| Dual::constant(along.motion.state(k)[state]);
        let truth: Vec<Dual> = range.clone().map(value).collect();
        let ideal = Dual::direction(term.candidate.effect.nature.ideal[0], 0);
        let moved = law.dual().applied(&[ideal], times, &truth);
        let change: Vec<f64> = moved.iter().map(|y| y.tangent[0]).collect();
        let is = |o: &crate::Output| matches!(o.of, Measured::State(i) if i == state);
        let zero = || vec![0.0; range.len()];
        let outputs = &self.problem.dataset.outputs;
        let mut out: Vec<Vec<f64>> =
            outputs.iter().map(|o| if is(o) { change.clone() } else { zero() }).collect();
        if let Some(filter) = along.maps.filters.get(local.number) {
            along.maps.propagate(range, Some(filter), &UNDRIVEN, &mut out);
        }
        self.rows(along, local, &out)
    }

    /// The measured samples of a window, weighted, output by output.
    fn rows(&self, along: &Along, local: &Local, out: &[Vec<f64>]) -> Vec<f64> {
        let (w, mut rows) = (&local.window, Vec::with_capacity(local.columns.residual.len()));
        sweep::scan(self.problem, w, out, |_, d, weight| rows.push(d * weight));
        if let Some(filter) = along.maps.filters.get(local.number) {
            let observed = &self.problem.dataset.recordings[w.recording];
            filter.whiten(observed, w, std::iter::once(&mut rows));
        }
        rows
    }
}

/// Over each step the mean of both ends; over what follows the last sample nothing is known.
fn centred(series: &[f64]) -> Vec<f64> {
    let last = series.len() - 1;
    (0..series.len()).map(|k| 0.5 * (series[k] + series[(k + 1).min(last)])).collect()
}
