//! Where: evidence for a missing force on each channel, shown by free curves whatever its name.

use super::outcome::Ladder;
use crate::diagnosis::{ChannelMismatch, Curve, Finding, Location};
use crate::screen::{Learned, Over, Screen};
use std::collections::BTreeMap;

/// A curve acts where it is larger than this many of its standard deviations ...
const SIGNIFICANT: f64 = 2.0;
/// ... and than this share of its largest force.
const QUIET: f64 = 0.1;

impl Ladder<'_> {
    /// What is missing on each channel before anything is added.
    pub(super) fn location(&self, findings: &[Finding]) -> Location {
        let model = self.problem.model;
        let screen = Screen::new(&self.found.calibrated).ok();
        let channels = (0..model.channels()).map(|c| {
            let name = model.channel_name(c).to_owned();
            let explained_by =
                findings.iter().filter(|f| f.channel == name).map(|f| f.class.clone()).collect();
            (name, self.mismatch(screen.as_ref(), c, explained_by))
        });
        Location { channels: channels.collect() }
    }

    fn mismatch(
        &self,
        screen: Option<&Screen>,
        channel: usize,
        explained_by: Vec<String>,
    ) -> ChannelMismatch {
        let model = self.problem.model;
        let overs: &[Over] = if model.is_coordinate(channel) {
            &[Over::Coordinate, Over::Velocity, Over::Time]
        } else {
            &[Over::Coordinate, Over::Time]
        };
        let learned = overs.iter().filter_map(|&o| Some((o, screen?.learn(channel, o)?)));
        let mut learned: Vec<(Over, Learned)> = learned.collect();
        learned.sort_by(|a, b| b.1.gain.total_cmp(&a.1.gain));
        let mut mismatch = ChannelMismatch {
            explained_by,
            significance: 0.0,
            depends_on: None,
            region: BTreeMap::new(),
            time: None,
            missing_force: 0.0,
            unit: model.force_unit(channel),
            curves: Vec::new(),
        };
        let Some((over, best)) = learned.first() else { return mismatch };
        let squares: f64 = best.force.iter().map(|f| f * f).sum();
        mismatch.significance = best.gain.max(0.0);
        mismatch.missing_force = (squares / best.force.len() as f64).sqrt();
        if best.gain < self.decision.prior_odds {
            return mismatch;
        }
        mismatch.curves = self.shown(channel, &learned);
        let Some((from, to)) = acts(&best.at, &best.force, &best.std) else { return mismatch };
        let variable = self.variable(channel, *over).0;
        mismatch.depends_on = Some(variable.clone());
        let length = best.at[best.at.len() - 1] - best.at[0];
        if *over == Over::Time && from - best.at[0] > QUIET * length {
            mismatch.time = Some(from);
        }
        mismatch.region.insert(variable, [from, to]);
        mismatch
    }

    /// Of learned curves, the best first, those for a picture: the best, and the one over time
    /// where the evidence supports it.
    fn shown(&self, channel: usize, learned: &[(Over, Learned)]) -> Vec<Curve> {
        let shown = learned.iter().enumerate().filter(|(rank, (over, curve))| {
            curve.gain >= self.decision.prior_odds && (*rank == 0 || *over == Over::Time)
        });
        let curve = |(_, (over, curve)): (usize, &(Over, Learned))| {
            let (variable, variable_unit) = self.variable(channel, *over);
            Curve {
                variable,
                variable_unit,
                force_unit: self.problem.model.force_unit(channel),
                at: curve.at.clone(),
                learned: curve.force.clone(),
                std: curve.std.clone(),
                law: Vec::new(),
            }
        };
        shown.map(curve).collect()
    }

    /// Name and unit of what a curve of a channel is over.
    pub(super) fn variable(&self, channel: usize, over: Over) -> (String, String) {
        let model = self.problem.model;
        let state = match over {
            Over::Coordinate => model.coordinate_index(channel),
            Over::Velocity => model.velocity_index(channel),
            Over::Time => return (model.time_column.clone(), "s".to_owned()),
        };
        (model.state_name(state).to_owned(), model.state_unit(state))
    }
}

/// First and last value of a variable at which a curve acts.
pub(super) fn acts(at: &[f64], force: &[f64], std: &[f64]) -> Option<(f64, f64)> {
    let largest = force.iter().fold(0.0f64, |a, f| a.max(f.abs()));
    let active = |k: &usize| {
        let size = force[*k].abs();
        size > SIGNIFICANT * std[*k] && size > QUIET * largest
    };
    let first = (0..at.len()).find(active)?;
    let last = (0..at.len()).rfind(active)?;
    Some((at[first], at[last]))
}
