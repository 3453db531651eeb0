//! Where: evidence for a missing force on each channel, shown by free curves whatever its name.

use super::outcome::Ladder;
use crate::diagnosis::{ChannelMismatch, Finding, Location};
use crate::screen::{Over, Screen};
use crate::search::gain::THRESHOLD;
use std::collections::BTreeMap;

/// A curve acts where it is larger than this many of its standard deviations ...
const SIGNIFICANT: f64 = 2.0;
/// ... and than this share of its largest force.
const QUIET: f64 = 0.1;

impl Ladder<'_> {
    /// What is missing on each channel before anything is added.
    pub(super) fn location(&self, findings: &[Finding]) -> Location {
        let model = self.problem.model;
        let screen = Screen::new(self.problem, &self.found.calibrated);
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
        let mut mismatch = ChannelMismatch {
            explained_by,
            significance: 0.0,
            depends_on: None,
            region: BTreeMap::new(),
            time: None,
            missing_force: 0.0,
            unit: model.force_unit(channel),
        };
        let Some((over, curve)) = learned.max_by(|a, b| a.1.gain.total_cmp(&b.1.gain)) else {
            return mismatch;
        };
        let squares: f64 = curve.force.iter().map(|f| f * f).sum();
        mismatch.significance = curve.gain.max(0.0);
        mismatch.missing_force = (squares / curve.force.len() as f64).sqrt();
        if curve.gain < THRESHOLD {
            return mismatch;
        }
        let Some((from, to)) = acts(&curve.at, &curve.force, &curve.std) else { return mismatch };
        let variable = match over {
            Over::Coordinate => model.state_name(model.coordinate_index(channel)),
            Over::Velocity => model.state_name(model.velocity_index(channel)),
            Over::Time => &model.time_column,
        };
        mismatch.depends_on = Some(variable.to_owned());
        let length = curve.at[curve.at.len() - 1] - curve.at[0];
        if over == Over::Time && from - curve.at[0] > QUIET * length {
            mismatch.time = Some(from);
        }
        mismatch.region.insert(variable.to_owned(), [from, to]);
        mismatch
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
