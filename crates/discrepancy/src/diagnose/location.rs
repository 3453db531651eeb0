//! Where: evidence for a missing force on each channel, shown by free curves whatever its name.

use super::outcome::Ladder;
use crate::diagnosis::{ChannelMismatch, Curve, Finding, Location};
use crate::missing_force::{Belief, Channel, Learned, MissingForce};
use crate::screen::Over;
use lacuna_effects::{Effect, Law};
use std::collections::BTreeMap;

/// A curve acts where it is larger than this many of its standard deviations ...
const SIGNIFICANT: f64 = 2.0;
/// ... and than this share of its largest force.
const QUIET: f64 = 0.1;

impl Ladder<'_> {
    /// What the model misses on each channel as it is, its parameters within their tolerances.
    pub(super) fn missing_force(&self) -> MissingForce {
        let belief = Belief::of(self.problem.model, self.decision.prior_odds);
        MissingForce::of(self.problem, &belief)
    }

    /// The same in words and curves.
    pub(super) fn location(&self, missing: &MissingForce, findings: &[Finding]) -> Location {
        let model = self.problem.model;
        let channels = (0..model.channels()).map(|c| {
            let name = model.channel_name(c).to_owned();
            let explains = |f: &&Finding| f.channel == name || bears(f, &name);
            let explained_by = findings.iter().filter(explains).map(|f| f.class.clone()).collect();
            (name, self.mismatch(missing.channel(c), c, explained_by))
        });
        Location { channels: channels.collect() }
    }

    fn mismatch(
        &self,
        missing: Option<&Channel>,
        channel: usize,
        explained_by: Vec<String>,
    ) -> ChannelMismatch {
        let mut mismatch = ChannelMismatch {
            explained_by,
            significance: 0.0,
            depends_on: None,
            region: BTreeMap::new(),
            time: None,
            missing_force: 0.0,
            unit: self.problem.model.force_unit(channel),
            curves: Vec::new(),
        };
        let Some(missing) = missing else { return mismatch };
        mismatch.significance = missing.significance;
        // What the parameters can do as well is not said to be missing.
        let significant = missing.significance >= self.decision.prior_odds;
        let Some(best) = missing.curves.first().filter(|_| significant) else {
            return mismatch;
        };
        mismatch.missing_force = missing.rms;
        mismatch.curves = missing.curves.iter().map(|l| self.bare(channel, l)).collect();
        let Some((from, to)) = acts(&best.at, &best.force, &best.std) else { return mismatch };
        let variable = self.variable(channel, best.over).0;
        mismatch.depends_on = Some(variable.clone());
        let length = best.at[best.at.len() - 1] - best.at[0];
        if best.over == Over::Time && from - best.at[0] > QUIET * length {
            mismatch.time = Some(from);
        }
        mismatch.region.insert(variable, [from, to]);
        mismatch
    }

    /// A learned curve without a law.
    fn bare(&self, channel: usize, learned: &Learned) -> Curve {
        let (variable, variable_unit) = self.variable(channel, learned.over);
        Curve {
            variable,
            variable_unit,
            force_unit: self.problem.model.force_unit(channel),
            at: learned.at.clone(),
            learned: learned.force.clone(),
            std: learned.std.clone(),
            law: Vec::new(),
        }
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

/// Whether a joint bears what a finding says of a robot's structure.
fn bears(f: &Finding, joint: &str) -> bool {
    let structure = |e: &Effect| matches!(e.law, Law::Structure(_));
    lacuna_effects::find(&f.class).is_some_and(structure) && f.depends_on.iter().any(|d| d == joint)
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
