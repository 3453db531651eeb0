//! From the search to the diagnosis: verdict, calibration, the ladder.

use super::Outcome;
use crate::dataset::{Dataset, Observed};
use crate::diagnosis::{Calibration, DataUsed, Diagnosis, SCHEMA, Verdict};
use crate::likelihood::Problem;
use crate::search::gain::{RELEVANT, THRESHOLD, gain};
use crate::search::validate::refuted;
use crate::search::{EXPLAINED, Found};
use crate::trajectories::unmeasured;
use lacuna_effects::Acts;
use lacuna_plants::dynamics::Mass;
use lacuna_plants::model::{Augmentation, ModelEffect, NewEffect};
use std::collections::BTreeMap;

/// Share of its tolerance within which a parameter is as the model says: values are written with
/// few digits.
const ROUNDING: f64 = 0.05;

/// All that the diagnosis is made of.
pub(super) struct Ladder<'a> {
    pub problem: &'a Problem<'a>,
    pub held_out: &'a Problem<'a>,
    pub found: Found,
    /// The new effects, with standard deviations.
    pub effects: Vec<ModelEffect>,
    /// Standard deviations of the model's parameters.
    pub parameter_std: Vec<f64>,
}

impl<'a> Ladder<'a> {
    pub(super) fn new(problem: &'a Problem<'a>, held_out: &'a Problem<'a>, found: Found) -> Self {
        let chosen = &found.chosen;
        // What is correlated over c samples is worth one in c of them.
        let doubt = chosen.inflation() * chosen.colour(problem);
        let effects = chosen.effects(doubt).split_off(chosen.hypothesis.own);
        let parameter_std = chosen.parameter_std(doubt);
        Self { problem, held_out, found, effects, parameter_std }
    }

    pub(super) fn outcome(&self) -> Outcome {
        let verdict = self.verdict();
        let keep_model = verdict == Verdict::NoMismatch;
        let (fit, proofs) = self.proof(keep_model);
        let findings = self.findings();
        let location = self.location(&findings);
        let augmentation = if keep_model { Augmentation::default() } else { self.augmentation() };
        let diagnosis = Diagnosis {
            schema: SCHEMA,
            model: self.problem.model.name.clone(),
            verdict,
            findings,
            calibration: if keep_model { BTreeMap::new() } else { self.calibration() },
            location,
            fit,
            ladder: self.rungs(),
            data: self.data(),
            notes: self.notes(verdict),
        };
        Outcome { diagnosis, augmentation, proofs }
    }

    fn notes(&self, verdict: Verdict) -> Vec<String> {
        let (model, mut notes) = (self.problem.model, Vec::new());
        if verdict == Verdict::Unexplained {
            notes.push(
                "No effect of the catalogue explains what is left; the location tells in which channel."
                    .to_owned(),
            );
        }
        if model.dynamics().mass() == Mass::Unit && !model.coordinates.is_empty() {
            notes.push(
                "The model gives accelerations and no mass matrix: effects on its coordinates are accelerations."
                    .to_owned(),
            );
        }
        if let Some(error) = model.dynamics().derivative_error() {
            notes.push(format!(
                "The model gives no derivatives: they are differences, with a measured error of at most {error:.0e} of their size."
            ));
        }
        notes
    }

    fn verdict(&self) -> Verdict {
        let found = &self.found;
        // Curves of the remainder are no findings.
        let named = &self.effects[..found.named.len()];
        if !named.is_empty() {
            return if named.iter().all(|e| e.effect.acts == Acts::Sensors) {
                Verdict::SensorFault
            } else {
                Verdict::MissingPhysics
            };
        }
        // A residual above the noise that depends on nothing is noise, of another colour or size
        // than was estimated.
        let follows = found.calibrated.windowed.level == 0;
        let floor = if follows { found.floor } else { 1.0 };
        let above = found.calibrated.reduced() > EXPLAINED * floor;
        if above && found.promise > THRESHOLD {
            return Verdict::Unexplained;
        }
        let drop = found.nominal.reduced() - found.calibrated.reduced();
        let moved = gain(self.problem, &found.nominal, &found.calibrated) > THRESHOLD;
        let (nominal, calibrated) = (&found.nominal.hypothesis, &found.calibrated.hypothesis);
        let agreed = !refuted(self.held_out, nominal, calibrated);
        if moved && drop > RELEVANT && self.moves_noticeably() && agreed {
            Verdict::Miscalibrated
        } else {
            Verdict::NoMismatch
        }
    }

    /// Whether any parameter moves by more than the rounding of its nominal value.
    fn moves_noticeably(&self) -> bool {
        let values = &self.found.calibrated.hypothesis.parameters;
        let mut all = self.problem.model.parameters.iter().zip(values);
        all.any(|(p, v)| (v - p.value).abs() > ROUNDING * p.std())
    }

    fn calibration(&self) -> BTreeMap<String, Calibration> {
        let values = &self.found.chosen.hypothesis.parameters;
        let free = self.problem.model.parameters.iter().enumerate().filter(|(_, p)| p.std() > 0.0);
        free.map(|(k, p)| {
            let (nominal, value, std) = (p.value, values[k], self.parameter_std[k]);
            (p.name.clone(), Calibration { nominal, value, std, unit: p.unit.clone() })
        })
        .collect()
    }

    fn augmentation(&self) -> Augmentation {
        let parameters =
            self.calibration().into_iter().map(|(name, c)| (name, c.value, c.std)).collect();
        let effects = self.effects.iter().map(|e| self.new_effect(e)).collect();
        Augmentation { parameters, effects }
    }

    pub(super) fn new_effect(&self, e: &ModelEffect) -> NewEffect {
        NewEffect::of(self.problem.model, e)
    }

    fn data(&self) -> DataUsed {
        let names = |d: &Dataset| d.recordings.iter().map(|r| r.name.clone()).collect();
        let (model, training) = (self.problem.model, self.problem.dataset);
        DataUsed {
            training: names(training),
            held_out: names(self.held_out.dataset),
            samples: training.recordings.iter().map(Observed::len).sum(),
            dropped: training.recordings.iter().map(|r| r.dropped).sum(),
            unmeasured: unmeasured(model, training)
                .into_iter()
                .map(|state| model.state_name(state).to_owned())
                .collect(),
            version: env!("CARGO_PKG_VERSION").to_owned(),
        }
    }
}
