//! What: each effect as a finding.

use super::location;
use super::outcome::Ladder;
use super::separate::Open;
use crate::against::against_one;
use crate::candidates::Candidate;
use crate::diagnosis::{Alternative, Curve, Estimate, Experiment, Finding, FormulaFit, Support};
use crate::likelihood::Fit;
use crate::missing_force::{Belief, MissingForce};
use crate::probability::{self, ProbabilityMap};
use crate::screen::Over;
use crate::search::{Named, Rival};
use crate::trajectories::SmoothedRecording;
use crate::words;
use lacuna_effects::{Acts, At, Channel, Kind, Law, Variable};
use lacuna_plants::model::ModelEffect;
use std::collections::BTreeMap;

/// Probability of a rival below which it is left out.
const WORTH_A_WORD: f64 = 1e-4;
/// Log odds (nats) below which the recordings leave open which rival it is, and an experiment is
/// suggested: 19 to 1.
const UNDECIDED: f64 = 2.944;

impl Ladder<'_> {
    pub(super) fn findings(&self) -> Vec<Finding> {
        let motion = self.motion();
        let named = self.effects.iter().zip(&self.found.named).enumerate();
        let mut findings: Vec<Finding> =
            named.map(|(k, (e, named))| self.finding(k, e, named, &motion)).collect();
        let experiments = self.experiments(&findings);
        for (finding, experiment) in findings.iter_mut().zip(experiments) {
            finding.experiment = experiment;
        }
        findings.sort_by(|a, b| b.evidence.total_cmp(&a.evidence));
        findings
    }

    fn finding(
        &self,
        k: usize,
        e: &ModelEffect,
        named: &Named,
        motion: &[SmoothedRecording],
    ) -> Finding {
        let new = self.new_effect(e);
        let chosen = &self.found.chosen;
        let at_bound = chosen.effect_at_bound(chosen.hypothesis.own + k);
        let is_fitted = chosen.effect_is_fitted(chosen.hypothesis.own + k);
        let parameters: BTreeMap<String, Estimate> = e
            .effect
            .values()
            .zip(&new.parameters)
            .zip(at_bound.iter().zip(is_fitted))
            .filter(|((p, _), _)| matches!(p.kind, Kind::Number))
            .map(|((p, (value, std, unit)), (&at_bound, is_fitted))| {
                // What the data do not determine is uncertain by all of its value; what was chosen, as the ends of
                // a learned curve are, not at all.
                let std = std.unwrap_or(if is_fitted { value.abs() } else { 0.0 });
                let (value, unit) = (*value, unit.clone());
                (p.name.to_owned(), Estimate { value, std, unit, at_bound })
            })
            .collect();
        let rivals = rivals_of(e, named);
        let support = self.support(k, named.gain, &rivals);
        let probability = ProbabilityMap::fitted().probability(&support, &self.formula());
        let alternatives = self.alternatives(probability, &rivals);
        let curve = self.curve(k, e);
        let mut says = words::says(e, &new, &at_bound, self.problem.model);
        if let (Some(curve), Some(over)) = (&curve, e.over()) {
            let over_velocity = over == Variable::Velocity;
            says = format!("{says} Its shape: {}.", words::shape::shape(curve, over_velocity));
        }
        let onset = e.effect.nature.onset.and_then(|name| parameters.get(name));
        Finding {
            class: e.effect.named_class().to_owned(),
            law: e.effect.nature.variation_of.map(|_| e.effect.class.to_owned()),
            depends_on: self.variables(e),
            region: self.region(e, curve.as_ref(), motion),
            time: onset.map(|t| t.value),
            probability,
            alternatives,
            evidence: named.gain,
            support,
            curve,
            // Suggested for all findings at once.
            experiment: None,
            channel: new.channel,
            other: new.other,
            parameters,
            says,
        }
    }

    /// Rivals of a class of a probability, with theirs: a class once, however many of its laws are rivals.
    fn alternatives(&self, probability: f64, rivals: &[&Rival]) -> Vec<Alternative> {
        let model = self.problem.model;
        let behind: Vec<f64> = rivals.iter().map(|r| r.behind).collect();
        let of_rivals = probability::rivals(probability, &behind);
        let mut alternatives: Vec<Alternative> = vec![];
        for (Rival { candidate: c, behind, .. }, probability) in rivals.iter().zip(of_rivals) {
            let (class, behind) = (c.effect.named_class(), *behind);
            let channel = model.effect_channel_name(c.effect, c.channel);
            match alternatives.iter_mut().find(|a| a.class == class && a.channel == channel) {
                Some(same) => {
                    same.probability += probability;
                    same.behind = same.behind.min(behind);
                }
                None => {
                    let (class, channel) = (class.to_owned(), channel.to_owned());
                    alternatives.push(Alternative { class, channel, probability, behind });
                }
            }
        }
        alternatives.retain(|a| a.probability > WORTH_A_WORD);
        alternatives.sort_by(|a, b| a.behind.total_cmp(&b.behind));
        alternatives
    }

    /// What speaks by the evidence alone for a class that gains so much and has these rivals.
    fn support(&self, k: usize, gain: f64, rivals: &[&Rival]) -> Support {
        let against = against_one(self.problem.model, &self.decision, &self.effects, k);
        let nothing = gain - against;
        let behind = rivals.iter().map(|r| r.behind).chain([nothing]);
        let most = self.found.named.iter().map(|n| n.gain).fold(gain, f64::max);
        let part = if most > 0.0 { (gain / most).max(0.0) } else { 1.0 };
        Support { log_odds: probability::log_odds(behind), part }
    }

    /// What the findings leave of the mismatch.
    pub(super) fn formula(&self) -> FormulaFit {
        let [before, after] = [&self.found.calibrated, &self.found.chosen].map(Fit::beyond_noise);
        let left = if before > 0.0 { (after / before).min(1.0) } else { 0.0 };
        FormulaFit { left, residual_over_noise: self.found.chosen.reduced().sqrt() }
    }

    /// What they leave of it in the middle one of the recordings that show more than noise; none of fewer than three.
    pub(super) fn left_in_middle(&self) -> Option<f64> {
        let (before, after) = (&self.found.calibrated, &self.found.chosen);
        let both = before.excess_by_recording().into_iter().zip(after.excess_by_recording());
        in_middle(both, self.decision.explained - 1.0)
    }

    /// What would tell each effect, as it was found, from its first rival, where the recordings leave that open.
    fn experiments(&self, findings: &[Finding]) -> Vec<Option<Experiment>> {
        let named = self.effects.iter().zip(&self.found.named).zip(findings);
        let rivals = named.map(|((e, named), finding)| {
            let open = finding.support.log_odds <= UNDECIDED;
            let rivals = rivals_of(e, named).into_iter().filter(|_| open);
            let first = rivals.min_by(|a, b| a.behind.total_cmp(&b.behind))?;
            Some(Open { rival: &first.hypothesis, inputs: self.actuators_near(e) })
        });
        self.separating(&self.found.chosen.hypothesis, &rivals.collect::<Vec<_>>())
    }

    /// The actuators that act where an effect does; all of them where none does.
    fn actuators_near(&self, e: &ModelEffect) -> Vec<usize> {
        let model = self.problem.model;
        let mut near = match e.effect.acts {
            Acts::Inputs => vec![e.channel],
            Acts::Sensors | Acts::Links | Acts::Base => vec![],
            _ => model.inputs_about(e.channel),
        };
        near.retain(|j| model.inputs[*j].actuator);
        if near.is_empty() { model.actuators().collect() } else { near }
    }

    /// Names of the channels that an effect depends on.
    fn variables(&self, e: &ModelEffect) -> Vec<String> {
        let model = self.problem.model;
        if let Law::Structure(_) = e.effect.law {
            let joints = model.joints_under(e.effect.acts, e.channel).into_iter();
            return joints.map(|c| model.channel_name(c).to_owned()).collect();
        }
        let state = |v: &Variable| self.state_of(e, *v).map(|i| model.state_name(i).to_owned());
        let name = |v: &Variable| match v {
            Variable::Time => model.time_column.clone(),
            Variable::Input => model.inputs[e.channel].name.clone(),
            Variable::OtherInput => {
                e.other.map_or_else(String::new, |j| model.inputs[j].name.clone())
            }
            Variable::Acceleration => format!("acceleration of {}", model.channel_name(e.channel)),
            _ => state(v).unwrap_or_default(),
        };
        let mut names: Vec<String> = e.effect.variables(&e.parameters).iter().map(name).collect();
        names.dedup();
        names
    }

    /// The entry of the machine's state that a variable of an effect is.
    fn state_of(&self, e: &ModelEffect, v: Variable) -> Option<usize> {
        let model = self.problem.model;
        if matches!(e.effect.law, Law::Sensor(_)) {
            return Some(e.channel);
        }
        let other = e.other.unwrap_or(e.channel);
        match v {
            Variable::Coordinate => Some(model.coordinate_index(e.channel)),
            Variable::Velocity => Some(model.velocity_index(e.channel)),
            Variable::OtherCoordinate => Some(model.coordinate_index(other)),
            Variable::OtherVelocity => Some(model.velocity_index(other)),
            Variable::Acceleration | Variable::Time | Variable::Input | Variable::OtherInput => {
                None
            }
        }
    }

    /// Range of each variable over the samples at which the effect's force is at least a
    /// twentieth of its largest; of a law that is nothing beyond an edge, all that lies inside.
    /// A learned curve acts where it stands out of its band.
    fn region(
        &self,
        e: &ModelEffect,
        curve: Option<&Curve>,
        motion: &[SmoothedRecording],
    ) -> BTreeMap<String, [f64; 2]> {
        let Law::Force(law) = e.effect.law else { return BTreeMap::new() };
        if let (Some(_), Some(c)) = (e.over(), curve) {
            let range = location::acts(&c.at, &c.learned, &c.std);
            return range.map(|(a, b)| (c.variable.clone(), [a, b])).into_iter().collect();
        }
        let internal = law.internal(&e.parameters);
        let (amplitudes, shape) = internal.split_at(law.amplitudes());
        let places = self.problem.model.places(e.effect, e.channel, e.other);
        let mut samples: Vec<(f64, &[f64])> = Vec::new();
        for s in motion {
            let basis = s.basis(law, shape, &places);
            for k in 0..s.len() {
                let force: f64 = amplitudes.iter().zip(&basis).map(|(a, b)| a * b[k]).sum();
                samples.push((force.abs(), s.state(k)));
            }
        }
        let largest = samples.iter().map(|s| s.0).fold(0.0, f64::max);
        let least = if e.effect.nature.edge { f64::MIN_POSITIVE } else { 0.05 * largest };
        let acts = samples.iter().filter(|s| s.0 >= least);
        let mut region = BTreeMap::new();
        for &variable in e.effect.variables(&e.parameters) {
            let Some(state) = self.state_of(e, variable) else { continue };
            let range = acts
                .clone()
                .map(|s| s.1[state])
                .fold([f64::INFINITY, f64::NEG_INFINITY], |[a, b], x| [a.min(x), b.max(x)]);
            // What acts at no sample acts in no range.
            if range[0] <= range[1] {
                region.insert(self.problem.model.state_name(state).to_owned(), range);
            }
        }
        region
    }

    /// The motion of the chosen model.
    fn motion(&self) -> Vec<SmoothedRecording> {
        // Where the chosen model diverges, the motion is what the recordings say.
        let (problem, chosen) = (self.problem, &self.found.chosen);
        let Ok(paths) = chosen.paths() else { return problem.smoothed.clone() };
        let along = |(r, path): (usize, &Vec<f64>)| problem.motion(&chosen.hypothesis, r, path);
        paths.iter().enumerate().map(along).collect()
    }

    /// The force that the recordings show beside the other effects, all else as it was fitted, and
    /// the law of the `k`-th finding, over the variable that it depends on: for laws of one
    /// variable and no memory.
    fn curve(&self, k: usize, e: &ModelEffect) -> Option<Curve> {
        let Law::Force(law) = e.effect.law else { return None };
        let over = match e.effect.variables(&e.parameters) {
            [Variable::Velocity] if self.problem.model.is_coordinate(e.channel) => Over::Velocity,
            [Variable::Velocity | Variable::Coordinate] | [] => Over::Coordinate,
            [Variable::Time] => Over::Time,
            _ => return None,
        };
        if law.memory() > 0 {
            return None;
        }
        let chosen = &self.found.chosen.hypothesis;
        let mut others = chosen.effects.clone();
        others.remove(chosen.own + k);
        // A curve that could trade with the parameters would show its doubt, not the force's.
        let belief = Belief {
            parameters: chosen.parameters.clone(),
            uncertain: vec![],
            effects: &others,
            prior_odds: self.decision.prior_odds,
        };
        let shown = MissingForce::over(self.problem, &belief, e.channel, over)?;
        let internal = law.internal(&e.parameters);
        let (amplitudes, shape) = internal.split_at(law.amplitudes());
        let mut basis = vec![0.0; law.amplitudes()];
        let channel = [Channel { si: self.problem.model.place(e.channel).si, ..Channel::ALONE[0] }];
        let force = |x: f64| {
            law.plain().along(shape, &At::new(x, &[x, x], &channel), &mut basis);
            amplitudes.iter().zip(&basis).map(|(a, b)| a * b).sum::<f64>()
        };
        let law: Vec<f64> = shown.at.iter().copied().map(force).collect();
        let (variable, variable_unit) = self.variable(e.channel, over);
        is_resolved(&law).then_some(Curve {
            variable,
            variable_unit,
            force_unit: self.problem.model.force_unit(e.channel),
            law,
            learned: shown.force,
            at: shown.at,
            std: shown.std,
        })
    }
}

/// Whether a law is nearly straight from point to point: one that is not, as an oscillation of
/// many periods over time, cannot be drawn beside what is learned on such points.
fn is_resolved(law: &[f64]) -> bool {
    const BENT: f64 = 0.25;
    let bend = |w: &[f64]| (w[1] - 0.5 * (w[0] + w[2])).powi(2);
    let bends: f64 = law.windows(3).map(bend).sum();
    bends <= BENT * law.iter().map(|f| f * f).sum::<f64>()
}

/// What is left of the mismatch in the middle one of the recordings that show more than so much of it, of what is there
/// before and after in each; none of fewer than three.
fn in_middle(both: impl Iterator<Item = (f64, f64)>, shown: f64) -> Option<f64> {
    let shown = both.filter(|(before, _)| *before > shown);
    let mut left: Vec<f64> =
        shown.map(|(before, after)| (after / before).clamp(0.0, 1.0)).collect();
    left.sort_by(f64::total_cmp);
    (left.len() >= 3).then(|| left[left.len() / 2])
}

/// Rivals of an effect that would be told as something else: another class, or another place.
fn rivals_of<'n>(e: &ModelEffect, named: &'n Named) -> Vec<&'n Rival> {
    let same = |c: &Candidate| {
        let apart = c.other.zip(e.other).is_some_and(|(a, b)| a != b);
        (c.effect.named_class(), c.channel) == (e.effect.named_class(), e.channel) && !apart
    };
    named.rivals.iter().filter(|r| !same(&r.candidate)).collect()
}

#[cfg(test)]
mod tests {
    use super::in_middle;

    #[test]
    fn one_recording_does_not_silence_the_others() {
        let all = [(400.0, 390.0), (50.0, 4.0), (30.0, 6.0)];
        assert_eq!(in_middle(all.into_iter(), 0.5), Some(0.2));
        // What shows nothing beyond noise is not asked, and two are no majority.
        let quiet = all.into_iter().chain([(0.1, 0.1), (0.2, 0.2)]);
        assert_eq!(in_middle(quiet, 0.5), Some(0.2));
        assert_eq!(in_middle(all.into_iter().take(2), 0.5), None);
    }
}
