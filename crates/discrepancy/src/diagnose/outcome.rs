//! From the search to the diagnosis: verdict, calibration, the ladder.

use super::Outcome;
use super::proof::{Proved, Proving};
use crate::conventions::Otherwise;
use crate::dataset::{Dataset, Observed, clean, lost};
use crate::decision::Decision;
use crate::diagnosis::{
    Calibration, ChannelFit, DataUsed, Diagnosis, Finding, Integration, ProofOutcome, Robot,
    SCHEMA, Verdict,
};
use crate::likelihood::{End, Fit, Problem};
use crate::search::Found;
use crate::trajectories::unmeasured;
use lacuna_effects::Acts;
use lacuna_plants::dynamics::Mass;
use lacuna_plants::model::{Augmentation, ModelEffect, NewEffect};
use std::collections::BTreeMap;

/// Share of its tolerance within which a parameter is as the model says: values are written with
/// few digits.
const ROUNDING: f64 = 0.05;

/// Share of the mismatch beyond which findings leave more than they explain.
const MOST: f64 = 0.5;

/// All that the diagnosis is made of.
pub(super) struct Ladder<'a> {
    pub problem: &'a Problem<'a>,
    pub held_out: &'a Dataset,
    pub decision: Decision,
    pub found: Found<'a>,
    /// How the recordings seem to be meant, where that says more than what was found.
    pub otherwise: Option<Otherwise>,
    /// The new effects, with standard deviations.
    pub effects: Vec<ModelEffect>,
    /// Standard deviations of the model's parameters.
    pub parameter_std: Vec<f64>,
    /// Which of them lie at the edge of what was tried.
    pub parameter_at_bound: Vec<bool>,
}

/// What is to be handed back.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Handed {
    /// The model as it was given.
    Given,
    /// The chosen one: calibrated, with its effects.
    Chosen,
}

impl<'a> Ladder<'a> {
    pub(super) fn new(
        problem: &'a Problem<'a>,
        held_out: &'a Dataset,
        decision: Decision,
        found: Found<'a>,
        otherwise: Option<Otherwise>,
    ) -> Self {
        let chosen = &found.chosen;
        // What is correlated over c samples is worth one in c of them.
        let temperature = chosen.temperature();
        let effects = chosen.effects(temperature).split_off(chosen.hypothesis.own);
        let parameter_std = chosen.parameter_std(temperature);
        let parameter_at_bound = chosen.parameters_at_bound();
        Self {
            problem,
            held_out,
            decision,
            found,
            otherwise,
            effects,
            parameter_std,
            parameter_at_bound,
        }
    }

    /// Decide, then open the recordings that are held out, then tell both.
    pub(super) fn outcome(&self) -> Outcome {
        let selected = self.verdict();
        let findings = self.findings();
        let mut notes = self.notes(selected);
        let ((handed, proved), (missing, ladder)) = rayon::join(
            || self.proved(selected),
            || rayon::join(|| self.missing_force(), || self.rungs()),
        );
        // Parameters alone are no finding that stands without a proof.
        let refused =
            proved.outcome == ProofOutcome::Worse || (proved.harms && findings.is_empty());
        let verdict = if refused { self.verdict_without(&proved) } else { selected };
        let doubted = !refused && self.doubts_sensors();
        if refused {
            notes.push(refusal(selected, &findings));
        } else if doubted {
            notes.push(doubt(&findings));
        } else if handed == Handed::Given && !findings.is_empty() {
            notes.push(
                "What was found leaves most of the mismatch: the model is handed back unchanged."
                    .to_owned(),
            );
        } else if proved.harms {
            notes.push(
                "With what was found the errors on held-out recordings do not fall: the model is handed back unchanged."
                    .to_owned(),
            );
        }
        let keep = proved.harms || handed == Handed::Given;
        let proved = if proved.harms { self.proved_as_given(proved) } else { proved };
        // The location tells what is missing; nothing explains it where the findings are refused.
        let findings = if refused || doubted { vec![] } else { findings };
        notes.extend(inexact(proved.integration));
        let diagnosis = Diagnosis {
            schema: SCHEMA,
            model: self.problem.model.name.clone(),
            robot: Robot::of(self.problem.model),
            verdict,
            otherwise: self.otherwise.clone(),
            location: self.location(&missing, &findings),
            formula: (!findings.is_empty()).then(|| self.formula()),
            findings,
            calibration: if keep { BTreeMap::new() } else { self.calibration() },
            proof: proved.outcome,
            fit: proved.fit,
            ladder,
            driving: self.driving(),
            integration: proved.integration,
            data: self.data(),
            notes,
        };
        let augmentation = if keep { Augmentation::default() } else { self.augmentation() };
        Outcome { diagnosis, augmentation, proofs: proved.proofs }
    }

    fn proving(&self) -> Proving<'_> {
        let Problem { model, dataset, .. } = self.problem;
        Proving { model, training: dataset, held_out: self.held_out, decision: self.decision }
    }

    /// What is to be handed back after this verdict, and what the held-out recordings say of it.
    fn proved(&self, verdict: Verdict) -> (Handed, Proved) {
        if self.handed(verdict) == Handed::Given {
            return (Handed::Given, self.proving().prove(None));
        }
        let h = &self.found.chosen.hypothesis;
        (Handed::Chosen, self.proving().prove(Some((&h.parameters, &h.effects))))
    }

    /// A model is changed by what is more likely right than wrong. Where the chosen one leaves most
    /// of the mismatch, it takes up what it does not describe: it may predict motion like that of
    /// the recordings better, and any other worse.
    fn handed(&self, verdict: Verdict) -> Handed {
        match verdict {
            Verdict::NoMismatch => Handed::Given,
            Verdict::Miscalibrated => Handed::Chosen,
            Verdict::MissingPhysics | Verdict::SensorFault | Verdict::Unexplained => {
                if self.leaves_most() { Handed::Given } else { Handed::Chosen }
            }
        }
    }

    /// Whether findings leave most of the mismatch, in all recordings together and in most of them: where something
    /// else shows in one alone, it says nothing of the others.
    fn leaves_most(&self) -> bool {
        self.formula().left > MOST && self.left_in_middle().is_none_or(|left| left > MOST)
    }

    /// What is to be said where that is so in all recordings together and not in most of them.
    fn says_elsewhere(&self) -> Option<String> {
        let middle = self.left_in_middle().filter(|_| !self.found.named.is_empty())?;
        let all = self.formula().left;
        (all > MOST && middle <= MOST).then(|| {
            format!(
                "Something else shows in some of the recordings: what was found leaves {:.0} % of the mismatch in all of them, {:.0} % in the middle one.",
                100.0 * all,
                100.0 * middle
            )
        })
    }

    /// The proof of the model as it was given, in place of one that failed; its outcome is kept.
    fn proved_as_given(&self, failed: Proved) -> Proved {
        let given = self.proving().prove(None);
        Proved { outcome: failed.outcome, ..given }
    }

    fn notes(&self, verdict: Verdict) -> Vec<String> {
        let model = self.problem.model;
        let mut notes = model.assumptions.clone();
        if verdict == Verdict::Unexplained && self.otherwise.is_none() {
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
        notes.extend(model.dynamics().trouble());
        notes.extend(self.says_elsewhere());
        notes.extend(self.says_driving());
        notes.extend(self.says_coloured());
        notes.extend(self.held_out.notes.iter().cloned());
        notes.extend(lost::says([self.problem.dataset, self.held_out]));
        notes.extend(clean::notes(self.problem.dataset, self.held_out));
        let end = self.found.chosen.end;
        if end == End::OutOfSteps {
            notes.push(format!("The last fit was {end}: its numbers may still move a little."));
        }
        notes
    }

    /// What the training recordings say.
    fn verdict(&self) -> Verdict {
        let (found, decision) = (&self.found, &self.decision);
        if self.otherwise.is_some() {
            return Verdict::Unexplained;
        }
        if !found.named.is_empty() {
            return match self.names_sensors_alone() {
                true if self.doubts_sensors() => Verdict::Unexplained,
                true => Verdict::SensorFault,
                false => Verdict::MissingPhysics,
            };
        }
        // A residual above the noise that depends on nothing is noise, of another colour or size
        // than was estimated.
        let above = found.calibrated.reduced() > decision.explained * self.floor();
        if above && found.promise > decision.prior_odds && !found.coloured {
            return Verdict::Unexplained;
        }
        // A random force is a name for what is not understood; noise on a recorded input is not.
        let random = !self.driving().forces.is_empty();
        if random && found.undriven > decision.explained * self.floor() {
            return Verdict::Unexplained;
        }
        let drop = found.nominal.reduced() - found.calibrated.reduced();
        let moved = found.calibrated.gain_over(&found.nominal) > decision.prior_odds;
        let agreed = !found.calibration_refuted;
        if moved && drop > decision.relevant && self.moves_noticeably() && agreed {
            Verdict::Miscalibrated
        } else {
            Verdict::NoMismatch
        }
    }

    /// Whether nothing but sensors is named.
    fn names_sensors_alone(&self) -> bool {
        // Curves of the remainder are no findings.
        let named = &self.effects[..self.found.named.len()];
        !named.is_empty() && named.iter().all(|e| e.effect.acts == Acts::Sensors)
    }

    /// Whether sensors alone are named, and leave most of the mismatch: that the physics is right is then not
    /// shown, and what is wrong in it passes for a wrong sensor.
    fn doubts_sensors(&self) -> bool {
        self.names_sensors_alone() && self.leaves_most()
    }

    /// The mean square residual, in units of the noise, of a model that explains its data: what
    /// the shortest windows leave, where the model follows the recordings from end to end. One that is corrected by what
    /// is measured follows whatever it leaves out.
    fn floor(&self) -> f64 {
        let Fit { windowed, noise, .. } = &self.found.calibrated;
        let follows = windowed.level == 0 && noise.is_none();
        if follows { self.found.floor } else { 1.0 }
    }

    /// What is left of a verdict whose model is refused: the model as it was given explains the
    /// held-out recordings and those that it was looked for in, or noise on the recorded inputs says what it leaves of
    /// these, or nothing does. What a machine meets in some recordings alone it need not meet in those that are held out.
    fn verdict_without(&self, refused: &Proved) -> Verdict {
        let explains = |f: &ChannelFit| (f.rmse_before / f.noise).powi(2) < self.decision.explained;
        let mut errors = refused.fit.held_out.values().chain(refused.fit.training.values());
        let all = errors.all(explains);
        let random = !self.driving().forces.is_empty();
        let missing = random && self.found.undriven > self.decision.explained * self.floor();
        let nominal = &self.found.nominal;
        let noisy = nominal.noise.is_some() && nominal.reduced() < self.decision.explained;
        if all && !missing || noisy && !random { Verdict::NoMismatch } else { Verdict::Unexplained }
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
            let at_bound = self.parameter_at_bound[k];
            (p.name.clone(), Calibration { nominal, value, std, unit: p.unit.clone(), at_bound })
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
        // Their order says nothing, so it is that of their names.
        let names = |d: &Dataset| -> Vec<String> {
            let mut names: Vec<_> = d.recordings.iter().map(|r| r.name.clone()).collect();
            names.sort();
            names
        };
        let (model, training) = (self.problem.model, self.problem.dataset);
        DataUsed {
            training: names(training),
            held_out: names(self.held_out),
            samples: training.recordings.iter().map(Observed::len).sum(),
            dropped: training.recordings.iter().map(|r| r.dropped).sum(),
            outliers: clean::outliers_of([training, self.held_out]),
            unmeasured: unmeasured(model, training)
                .into_iter()
                .map(|state| model.state_name(state).to_owned())
                .collect(),
            version: env!("CARGO_PKG_VERSION").to_owned(),
        }
    }
}

/// What is to be said of predictions that more steps would still change.
fn inexact(integration: Integration) -> Option<String> {
    let Integration { steps_a_sample, error_over_noise, .. } = integration;
    (error_over_noise > crate::prediction::INTEGRATION_TOLERANCE).then(|| {
        let change = match error_over_noise.is_finite() {
            true => format!("changed them by {error_over_noise:.2} of the noise"),
            false => "kept them from running away".to_owned(),
        };
        format!(
            "Predictions are integrated in {steps_a_sample} steps a sample, and the last halving of the steps still {change}: the model is stiff, or sampled slowly."
        )
    })
}

/// What is told of sensors that leave most of the mismatch.
fn doubt(findings: &[Finding]) -> String {
    let names = findings.iter().map(|f| format!("{} on {}", f.class, f.channel));
    format!(
        "{} would explain a part of the mismatch and leave most of it: whether a sensor is wrong cannot be told before what else is missing is known.",
        names.collect::<Vec<_>>().join(" with ")
    )
}

/// What is told where the proof fails.
fn refusal(refused: Verdict, findings: &[Finding]) -> String {
    let what = match refused {
        Verdict::Miscalibrated => "The calibrated parameters were".to_owned(),
        Verdict::Unexplained | Verdict::NoMismatch => "Moved parameters were".to_owned(),
        Verdict::MissingPhysics | Verdict::SensorFault => {
            let names = findings.iter().map(|f| format!("{} on {}", f.class, f.channel));
            format!("{} was", names.collect::<Vec<_>>().join(" with "))
        }
    };
    format!(
        "The proof failed: {what} what fits the training recordings best, but the model that was \
         given predicts the held-out recordings better. It is handed back unchanged."
    )
}
