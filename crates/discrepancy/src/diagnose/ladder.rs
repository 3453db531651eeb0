//! From the fits to the diagnosis: verdict, findings, location, proof.

use super::confirm::{Confirmed, nats};
use super::{Outcome, Proof, THRESHOLD, duration};
use crate::DiagnoseError;
use crate::candidates::Term;
use crate::dataset::{Dataset, Observed};
use crate::diagnosis::{
    Alternative, Calibration, ChannelFit, ChannelMismatch, Curve, DataUsed, Diagnosis, Estimate,
    Finding, Fit, Location, Rung, SCHEMA, Verdict,
};
use crate::evidence::Normal;
use crate::prediction::{DEFAULT_WARMUP, Prediction, Predictor};
use crate::screen::{Over, Screen, Screening};
use crate::shooting::ShootingFit;
use crate::words;
use lacuna_effects::{Law, Variable};
use lacuna_plants::Model;
use lacuna_plants::model::{Augmentation, Equations, ModelEffect, NewEffect};
use rayon::prelude::*;
use std::collections::BTreeMap;

/// Mean square residual, in units of the noise, up to which a model explains its data.
const EXPLAINED: f64 = 1.5;
/// Windows of the prediction error: the recording's length over this.
const WINDOWS: f64 = 12.0;

/// Odds that no class of the catalogue is the right one, however far all rivals lie behind.
const NONE_OF_THESE: f64 = 1e-3;

/// All that the diagnosis is made of.
pub(super) struct Ladder<'a> {
    pub model: &'a Model,
    pub training: &'a Dataset,
    pub held_out: &'a Dataset,
    pub screen: Screen<'a>,
    pub screening: Screening,
    pub confirmed: Confirmed,
}

impl Ladder<'_> {
    pub(super) fn outcome(&self) -> Result<Outcome, DiagnoseError> {
        let verdict = self.verdict();
        let keep_model = verdict == Verdict::NoMismatch;
        let chosen = &self.confirmed.chosen;
        let parameters = if keep_model { self.model.values() } else { chosen.parameters.clone() };
        let effects = if keep_model { &self.model.effects } else { &chosen.effects };
        let equations = Equations::of(self.model);
        let (fit, proofs) = self.fit(&equations, &parameters, effects);
        let findings = self.findings()?;
        let location = self.location(&findings)?;
        let mut notes = Vec::new();
        if verdict == Verdict::Unexplained {
            notes.push(
                "No effect of the catalogue explains what is left; the location tells in which channel."
                    .to_owned(),
            );
        }
        let augmentation = if keep_model { Augmentation::default() } else { self.augmentation() };
        let diagnosis = Diagnosis {
            schema: SCHEMA,
            model: self.model.name.clone(),
            verdict,
            findings,
            calibration: if keep_model { BTreeMap::new() } else { self.calibration() },
            location,
            fit,
            ladder: self.ladder(),
            data: self.data(),
            notes,
        };
        Ok(Outcome { diagnosis, augmentation, proofs })
    }

    fn verdict(&self) -> Verdict {
        let c = &self.confirmed;
        if !c.terms.is_empty() {
            return Verdict::MissingPhysics;
        }
        if c.calibrated.reduced() > EXPLAINED {
            return Verdict::Unexplained;
        }
        if nats(&c.nominal, &c.calibrated) > THRESHOLD {
            Verdict::Miscalibrated
        } else {
            Verdict::NoMismatch
        }
    }

    fn calibration(&self) -> BTreeMap<String, Calibration> {
        let chosen = &self.confirmed.chosen;
        let free = self.model.parameters.iter().enumerate().filter(|(_, p)| p.std() > 0.0);
        free.map(|(k, p)| {
            let calibration = Calibration {
                nominal: p.value,
                value: chosen.parameters[k],
                std: chosen.parameter_std[k],
                unit: p.unit.clone(),
            };
            (p.name.clone(), calibration)
        })
        .collect()
    }

    fn augmentation(&self) -> Augmentation {
        let chosen = &self.confirmed.chosen;
        let parameters = self.model.parameters.iter().enumerate().filter(|(_, p)| p.std() > 0.0);
        let parameters = parameters
            .map(|(k, p)| (p.name.clone(), chosen.parameters[k], chosen.parameter_std[k]))
            .collect();
        let effects = self.new_effects().iter().map(|e| self.new_effect(e)).collect();
        Augmentation { parameters, effects }
    }

    fn new_effects(&self) -> &[ModelEffect] {
        &self.confirmed.chosen.effects[self.model.effects.len()..]
    }

    fn new_effect(&self, e: &ModelEffect) -> NewEffect {
        let units = self.model.effect_units(e.effect, e.channel);
        let values = e.parameters.iter().zip(&e.std).zip(units);
        NewEffect {
            effect: e.effect,
            channel: self.model.effect_channel_name(e.effect, e.channel).to_owned(),
            other: e.other.map(|o| self.model.channel_name(o).to_owned()),
            parameters: values.map(|((value, std), unit)| (*value, *std, unit)).collect(),
        }
    }

    fn findings(&self) -> Result<Vec<Finding>, DiagnoseError> {
        let effects = self.new_effects();
        let mut findings = (0..effects.len())
            .map(|k| self.finding(k, &effects[k]))
            .collect::<Result<Vec<_>, _>>()?;
        findings.sort_by(|a, b| b.evidence.total_cmp(&a.evidence));
        Ok(findings)
    }

    fn finding(&self, k: usize, e: &ModelEffect) -> Result<Finding, DiagnoseError> {
        let new = self.new_effect(e);
        let parameters: BTreeMap<String, Estimate> = e
            .effect
            .parameters
            .iter()
            .zip(&new.parameters)
            .filter(|(p, _)| p.name != "side")
            .map(|(p, (value, std, unit))| {
                // What the data do not determine is uncertain by all of its value.
                let std = std.unwrap_or(value.abs());
                (p.name.to_owned(), Estimate { value: *value, std, unit: unit.clone() })
            })
            .collect();
        let rivals = self.confirmed.rivals.get(k).map_or(&[][..], Vec::as_slice);
        let weights: Vec<f64> = rivals.iter().map(|(_, behind)| (-behind).exp()).collect();
        let total = 1.0 + weights.iter().sum::<f64>() + NONE_OF_THESE;
        let mut alternatives: Vec<Alternative> = rivals
            .iter()
            .zip(&weights)
            .map(|((Term { candidate: c, .. }, _), w)| Alternative {
                class: c.effect.class.to_owned(),
                channel: self.model.effect_channel_name(c.effect, c.channel).to_owned(),
                probability: w / total,
            })
            .filter(|a| a.probability > 1e-4)
            .collect();
        alternatives.sort_by(|a, b| b.probability.total_cmp(&a.probability));
        let says = words::says(e, &new, self.model);
        let step = parameters.get("time").filter(|_| e.effect.class == "step_change");
        Ok(Finding {
            class: e.effect.class.to_owned(),
            depends_on: self.variables(e),
            region: self.region(e),
            time: step.map(|t| t.value),
            probability: 1.0 / total,
            alternatives,
            evidence: self.confirmed.gains[k],
            curve: self.curve(k, e)?,
            channel: new.channel,
            other: new.other,
            parameters,
            says,
        })
    }

    /// Names of the channels that an effect depends on.
    fn variables(&self, e: &ModelEffect) -> Vec<String> {
        let name = |v: &Variable| match v {
            Variable::Coordinate => {
                self.model.state_name(self.model.coordinate_index(e.channel)).to_owned()
            }
            Variable::Velocity => {
                self.model.state_name(self.model.velocity_index(e.channel)).to_owned()
            }
            Variable::OtherCoordinate | Variable::OtherVelocity => {
                let other = e.other.unwrap_or(e.channel);
                let index = if *v == Variable::OtherCoordinate {
                    self.model.coordinate_index(other)
                } else {
                    self.model.velocity_index(other)
                };
                self.model.state_name(index).to_owned()
            }
            Variable::Time => self.model.time_column.clone(),
            Variable::Input => self.model.inputs[e.channel].name.clone(),
        };
        let mut names: Vec<String> = e.effect.depends_on.iter().map(name).collect();
        names.dedup();
        names
    }

    /// Range of each variable over the samples at which the effect's force is at least a
    /// tenth of its largest.
    fn region(&self, e: &ModelEffect) -> BTreeMap<String, [f64; 2]> {
        let Law::Force(law) = e.effect.law else { return BTreeMap::new() };
        let internal = law.internal(&e.parameters);
        let (amplitudes, shape) = internal.split_at(law.amplitudes());
        let mut samples: Vec<(f64, [f64; 4])> = Vec::new();
        for s in self.screen.smoothed() {
            let basis = s.basis(law, shape, e.channel, e.other);
            for k in 0..s.len() {
                let force: f64 = amplitudes.iter().zip(&basis).map(|(a, b)| a * b[k]).sum();
                let at = s.local(e.channel, e.other, k);
                samples.push((force.abs(), [at.q, at.v, at.other_q, at.other_v]));
            }
        }
        let largest = samples.iter().map(|s| s.0).fold(0.0, f64::max);
        let acts = samples.iter().filter(|s| s.0 >= 0.1 * largest);
        let mut region = BTreeMap::new();
        let (q, v) = (self.model.coordinate_index(e.channel), self.model.velocity_index(e.channel));
        for variable in e.effect.depends_on {
            let (slot, state) = match variable {
                Variable::Coordinate => (0, q),
                Variable::Velocity => (1, v),
                Variable::OtherCoordinate => {
                    (2, e.other.map_or(q, |o| self.model.coordinate_index(o)))
                }
                Variable::OtherVelocity => (3, e.other.map_or(v, |o| self.model.velocity_index(o))),
                Variable::Time | Variable::Input => continue,
            };
            let values = acts.clone().map(|s| s.1[slot]);
            let range =
                values.fold([f64::INFINITY, f64::NEG_INFINITY], |[a, b], x| [a.min(x), b.max(x)]);
            region.insert(self.model.state_name(state).to_owned(), range);
        }
        region
    }

    /// The learned force and the law over the variable that it depends on, for laws of one
    /// variable and no memory.
    fn curve(&self, k: usize, e: &ModelEffect) -> Result<Option<Curve>, DiagnoseError> {
        let Law::Force(law) = e.effect.law else { return Ok(None) };
        let over = match e.effect.depends_on {
            [Variable::Velocity] => Over::Velocity,
            [Variable::Coordinate] | [] => Over::Coordinate,
            [Variable::Time] => Over::Time,
            _ => return Ok(None),
        };
        if law.memory() > 0 {
            return Ok(None);
        }
        let mut others = self.confirmed.terms.clone();
        others.remove(k);
        let tau = &self.screening.chosen.tau;
        let learned = self.screen.learn(&others, tau, self.known(k), e.channel, over)?;
        let internal = law.internal(&e.parameters);
        let (amplitudes, shape) = internal.split_at(law.amplitudes());
        let mut basis = vec![0.0; law.amplitudes()];
        let mut force = |x: f64| {
            let mut at = lacuna_effects::Local::default();
            match over {
                Over::Velocity => at.v = x,
                Over::Coordinate => at.q = x,
                Over::Time => at.t = x,
            }
            law.basis(shape, &at, &[], &mut basis);
            amplitudes.iter().zip(&basis).map(|(a, b)| a * b).sum::<f64>()
        };
        let state = match over {
            Over::Velocity => Some(self.model.velocity_index(e.channel)),
            Over::Coordinate => Some(self.model.coordinate_index(e.channel)),
            Over::Time => None,
        };
        Ok(Some(Curve {
            variable: state
                .map_or(self.model.time_column.clone(), |i| self.model.state_name(i).to_owned()),
            variable_unit: state.map_or("s".to_owned(), |i| self.model.state_unit(i)),
            force_unit: self.model.force_unit(e.channel),
            law: learned.at.iter().map(|&x| force(x)).collect(),
            at: learned.at,
            learned: learned.force,
            std: learned.std,
        }))
    }

    /// What is known of the parameters, and of the amplitudes of all findings but one, once
    /// they are fitted: without it a curve could trade with them and would show their doubt,
    /// not the force's.
    fn known(&self, but: usize) -> Vec<Normal> {
        let chosen = &self.confirmed.chosen;
        let parameter = |k: usize| Normal {
            mean: chosen.parameters[k] - self.screen.point[k],
            sd: chosen.parameter_std[k].max(1e-6 * self.model.parameters[k].std()),
        };
        let mut known: Vec<Normal> =
            self.screen.free_parameters().into_iter().map(parameter).collect();
        for (_, e) in self.new_effects().iter().enumerate().filter(|(k, _)| *k != but) {
            let Law::Force(law) = e.effect.law else { continue };
            let internal = law.internal(&e.parameters);
            known.extend((0..law.amplitudes()).map(|j| {
                let std = e.std[j].unwrap_or(0.0);
                Normal { mean: internal[j], sd: std.max(1e-6 * internal[j].abs()).max(1e-300) }
            }));
        }
        known
    }

    /// Evidence for a missing force on each channel, shown by free curves over its velocity
    /// or coordinate, whatever its name.
    fn location(&self, findings: &[Finding]) -> Result<Location, DiagnoseError> {
        let mut channels = BTreeMap::new();
        let tau = &self.screening.calibrated.tau;
        for c in 0..self.model.channels() {
            let name = self.model.channel_name(c).to_owned();
            let learned = [Over::Coordinate, Over::Velocity].map(|over| {
                let known = self.screen.parameter_priors();
                self.screen.learn(&[], tau, known, c, over)
            });
            let mut best: Option<(f64, f64)> = None;
            for curve in learned {
                let curve = curve?;
                let n = curve.force.len() as f64;
                let mean = curve.force.iter().sum::<f64>() / n;
                let spread = curve.force.iter().map(|f| (f - mean).powi(2)).sum::<f64>() / n;
                let size = (spread + mean * mean).sqrt();
                if best.is_none_or(|b| curve.gain > b.0) {
                    best = Some((curve.gain, size));
                }
            }
            let (significance, missing_force) = best.unwrap_or((0.0, 0.0));
            let explained_by =
                findings.iter().filter(|f| f.channel == name).map(|f| f.class.clone()).collect();
            let unit = self.model.force_unit(c);
            let mismatch = ChannelMismatch {
                explained_by,
                significance: significance.max(0.0),
                missing_force,
                unit,
            };
            channels.insert(name, mismatch);
        }
        Ok(Location { channels })
    }

    /// Shares of the misfit that each rung takes away, in the order of the ladder.
    fn ladder(&self) -> Vec<Rung> {
        let c = &self.confirmed;
        let total = (c.nominal.reduced() - 1.0).max(1e-12);
        let excess = |f: &ShootingFit| ((f.reduced() - 1.0) / total).clamp(0.0, 1.0);
        let mut rungs = Vec::new();
        let after_calibration = excess(&c.calibrated);
        let calibration = (1.0 - after_calibration).max(0.0);
        rungs.push(Rung { what: "calibration".to_owned(), share: calibration });
        let named = (after_calibration - excess(&c.chosen)).max(0.0);
        let gains: f64 = c.gains.iter().filter(|g| g.is_finite()).sum();
        for (k, term) in c.terms.iter().enumerate() {
            let share = if gains > 0.0 { named * c.gains[k].min(gains) / gains } else { named };
            let what = format!(
                "{} on {}",
                term.candidate.effect.words,
                self.model.effect_channel_name(term.candidate.effect, term.candidate.channel)
            );
            rungs.push(Rung { what, share });
        }
        rungs.push(Rung { what: "unexplained".to_owned(), share: excess(&c.chosen) });
        rungs
    }

    fn fit(
        &self,
        equations: &Equations,
        parameters: &[f64],
        effects: &[ModelEffect],
    ) -> (Fit, Vec<Proof>) {
        let horizon = duration(self.held_out) / WINDOWS;
        let errors = |data: &Dataset| {
            let before = Predictor::new(self.model, data);
            let after = Predictor::with(self.model, equations, parameters, effects, data);
            let runs: Vec<_> = data
                .recordings
                .par_iter()
                .map(|o| {
                    let windows = (before.windowed(o, horizon), after.windowed(o, horizon));
                    let free = (before.free_run(o, warmup(o)), after.free_run(o, warmup(o)));
                    (windows, free)
                })
                .collect();
            runs
        };
        let (held, train) = (errors(self.held_out), errors(self.training));
        let fit = Fit {
            held_out: channel_fits(self.held_out, &held, horizon),
            training: channel_fits(self.training, &train, horizon),
        };
        let proofs = self
            .held_out
            .recordings
            .iter()
            .zip(held)
            .map(|(o, (_, (before, after)))| Proof { observed: o.clone(), before, after })
            .collect();
        (fit, proofs)
    }

    fn data(&self) -> DataUsed {
        let names = |d: &Dataset| d.recordings.iter().map(|r| r.name.clone()).collect();
        DataUsed {
            training: names(self.training),
            held_out: names(self.held_out),
            samples: self.training.recordings.iter().map(Observed::len).sum(),
            dropped: self.training.recordings.iter().map(|r| r.dropped).sum(),
            version: env!("CARGO_PKG_VERSION").to_owned(),
        }
    }
}

/// Samples that estimate the initial state: of a short recording at most a quarter.
fn warmup(observed: &Observed) -> usize {
    DEFAULT_WARMUP.min(observed.len() / 4)
}

type Runs = ((Prediction, Prediction), (Prediction, Prediction));

fn channel_fits(data: &Dataset, runs: &[Runs], horizon: f64) -> BTreeMap<String, ChannelFit> {
    let pooled = |k: usize, of: &dyn Fn(&Runs) -> &Prediction| {
        let (sum, n) = data
            .recordings
            .iter()
            .zip(runs)
            .map(|(o, r)| of(r).squares(o, k))
            .fold((0.0, 0), |(s, n), (a, b)| (s + a, n + b));
        let rms = (sum / n.max(1) as f64).sqrt();
        // JSON has no infinity: a model that diverges is told by the largest number.
        if rms.is_finite() { rms } else { f64::MAX }
    };
    data.outputs
        .iter()
        .enumerate()
        // A channel without a sample there proves nothing and is left out.
        .filter(|(k, _)| data.recordings.iter().any(|o| o.outputs[*k].iter().any(|v| !v.is_nan())))
        .map(|(k, output)| {
            let fit = ChannelFit {
                unit: output.unit.clone(),
                rmse_before: pooled(k, &|r| &r.0.0),
                rmse_after: pooled(k, &|r| &r.0.1),
                noise: data.noise[k].sd,
                horizon_s: horizon,
                free_run_before: pooled(k, &|r| &r.1.0),
                free_run_after: pooled(k, &|r| &r.1.1),
            };
            (output.name.clone(), fit)
        })
        .collect()
}
