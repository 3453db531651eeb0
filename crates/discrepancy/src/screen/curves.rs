//! Forces learned without a formula, as curves over one variable.

use super::{Scored, Screen};
use crate::candidates::{Candidate, Term};
use crate::range::inner_range;
use lacuna_effects::curve;
use rayon::prelude::*;

/// The variable that a curve is over, by its number in the law's `over`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Over {
    /// The channel's coordinate or first-order state.
    Coordinate,
    /// The channel's velocity.
    Velocity,
    /// Time.
    Time,
}

impl Screen<'_> {
    /// Curves over the coordinate and over the velocity of every measured channel, the one that
    /// gains most first.
    #[must_use]
    pub fn curves(&self) -> Vec<Scored> {
        let model = self.problem.model;
        let pairs: Vec<(usize, Over)> = (0..model.channels())
            .flat_map(|c| {
                let over = if model.is_coordinate(c) {
                    &[Over::Coordinate, Over::Velocity][..]
                } else {
                    &[Over::Coordinate][..]
                };
                over.iter().map(move |&o| (c, o))
            })
            .collect();
        let mut scored: Vec<Scored> = pairs
            .into_par_iter()
            .filter_map(|(c, over)| self.gain(self.curve(c, over)?))
            .filter(|s| s.gain.is_finite())
            .collect();
        scored.sort_by(|a, b| b.gain.total_cmp(&a.gain));
        scored
    }

    /// A curve over the range that its variable has along the trajectory.
    #[must_use]
    pub fn curve(&self, channel: usize, over: Over) -> Option<Term> {
        let (from, to) = self.range(channel, over);
        let candidate = Candidate { effect: curve(), channel, other: None };
        (to > from).then(|| Term { candidate, shape: vec![from, to, f64::from(over as u8)] })
    }

    /// The range that a variable has along the trajectory, without its outliers.
    pub(super) fn range(&self, channel: usize, over: Over) -> (f64, f64) {
        let place = self.problem.model.place(channel);
        let mut values: Vec<f64> = Vec::new();
        for a in &self.recordings {
            for k in 0..a.motion.len() {
                values.push(match over {
                    Over::Coordinate => a.motion.state(k)[place.q],
                    Over::Velocity => a.motion.state(k)[place.v],
                    Over::Time => a.motion.times[k],
                });
            }
        }
        inner_range(values, 1000)
    }
}
