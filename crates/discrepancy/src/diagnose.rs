//! The ladder: condition, differ at all?, calibrate, locate, screen, confirm, prove.

use crate::DiagnoseError;
use crate::candidates::{Candidate, Term};
use crate::dataset::{Dataset, Observed};
use crate::diagnosis::{
    Alternative, Calibration, ChannelFit, ChannelMismatch, Curve, DataUsed, Diagnosis, Estimate,
    Finding, Fit, Location, Rung, SCHEMA, Verdict,
};
use crate::prediction::{DEFAULT_WARMUP, Prediction, Predictor};
use crate::screen::{Hypothesis, Over, Screen, Screening};
use crate::shooting::{MOST_RMS, Shooting, ShootingFit, model_effect};
use crate::trajectories::unmeasured;
use crate::weak::WeakForm;
use crate::words;
use lacuna_effects::{Law, Variable};
use lacuna_plants::Model;
use lacuna_plants::model::{Augmentation, Equations, ModelEffect, NewEffect};
use rayon::prelude::*;
use std::collections::BTreeMap;

/// Nats that decide: an effect, or a moved parameter, must gain this much.
const THRESHOLD: f64 = 10.0;
/// Share of the first effect's gain that each further one must reach.
const SHARE_OF_FIRST: f64 = 0.02;
/// Mean square residual, in units of the noise, up to which a model explains its data.
const EXPLAINED: f64 = 1.5;
/// Rivals that the screening leaves within this many nats are fitted by shooting.
const CLOSE: f64 = 25.0;
/// Nats by which the simpler way of writing the same law is preferred.
const SIMPLER: f64 = 3.0;
/// Shooting begins with windows of the recording's length over this.
const SHORTEST: f64 = 64.0;
/// ... but with at least this many samples.
const FEWEST_SAMPLES: f64 = 30.0;
/// Windows of the prediction error: the recording's length over this.
const WINDOWS: f64 = 12.0;

/// A diagnosis with what is needed to write and draw it.
pub struct Outcome {
    /// The result.
    pub diagnosis: Diagnosis,
    /// What to change in the model file.
    pub augmentation: Augmentation,
    /// Held-out recordings (or their stand-in) with free runs before and after.
    pub proofs: Vec<Proof>,
}

/// A held-out recording with what the model said before and says after, running free.
pub struct Proof {
    /// The recording.
    pub observed: Observed,
    /// The model as it was.
    pub before: Prediction,
    /// The augmented model.
    pub after: Prediction,
}

/// Split recordings into those that are fitted and those kept for proof: one in four, or the
/// last quarter of a single one.
#[must_use]
pub fn split(dataset: &Dataset) -> (Dataset, Dataset) {
    let all = &dataset.recordings;
    if let [only] = &all[..] {
        let cut = only.len() * 3 / 4;
        let (head, tail) = (only.part(0..cut), only.part(cut..only.len()));
        return (dataset.with_recordings(vec![head]), dataset.with_recordings(vec![tail]));
    }
    let kept = all.len().div_ceil(4);
    let (train, held) = all.split_at(all.len() - kept);
    (dataset.with_recordings(train.to_vec()), dataset.with_recordings(held.to_vec()))
}

/// Diagnose a model on training recordings, with the proof on held-out ones.
///
/// `progress` is told what is being done.
///
/// # Errors
/// [`DiagnoseError`] naming the recording or channel that cannot be used.
pub fn diagnose(
    model: &Model,
    training: &Dataset,
    held_out: &Dataset,
    progress: &(dyn Fn(&str) + Sync),
) -> Result<Outcome, DiagnoseError> {
    let hidden = unmeasured(model, training);
    if let Some(&state) = hidden.first() {
        return Err(DiagnoseError::Unmeasured { channel: model.state_name(state).to_owned() });
    }
    progress("smoothing the recordings");
    let weak = WeakForm::new(model, training)?;
    let screen = Screen::new(&weak, model.values());
    let screening = screen.search(progress)?;
    progress("fitting the findings with the equations of motion");
    let confirmed = Confirmation::new(model, training, &screen, &screening).run(progress);
    progress("proving on held-out recordings");
    Ladder { model, training, held_out, screen, screening, confirmed }.outcome()
}

/// Seconds that the longest recording spans.
fn duration(dataset: &Dataset) -> f64 {
    let span = |o: &Observed| o.times[o.len() - 1] - o.times[0];
    dataset.recordings.iter().map(span).fold(0.0, f64::max)
}

/// What was screened, fitted with the differential equation.
struct Confirmed {
    nominal: ShootingFit,
    calibrated: ShootingFit,
    /// The chosen model, with its terms.
    chosen: ShootingFit,
    terms: Vec<Term>,
    /// Nats each term gains, given those before it.
    gains: Vec<f64>,
    rivals: Vec<Vec<(Term, f64)>>,
}

/// Confirmation of the screened effects. The full comparison by likelihood will stand here;
/// for now the shortlist's first choices, and rivals that lie close, are fitted by multiple
/// shooting and must earn their place again.
struct Confirmation<'a> {
    model: &'a Model,
    training: &'a Dataset,
    screen: &'a Screen<'a>,
    screening: &'a Screening,
}

impl<'a> Confirmation<'a> {
    fn new(
        model: &'a Model,
        training: &'a Dataset,
        screen: &'a Screen<'a>,
        screening: &'a Screening,
    ) -> Self {
        Self { model, training, screen, screening }
    }

    /// Parameters and effects that a hypothesis of the screening stands for.
    fn start(&self, h: &Hypothesis) -> (Vec<f64>, Vec<ModelEffect>) {
        let mut parameters = self.screen.point.clone();
        let free = self.screen.free_parameters();
        for (&k, shift) in free.iter().zip(&h.evidence.coefficients) {
            parameters[k] += shift;
        }
        let mut at = free.len();
        let effects = h
            .terms
            .iter()
            .map(|t| {
                let count = t.amplitudes();
                at += count;
                model_effect(t, &h.evidence.coefficients[at - count..at])
            })
            .collect();
        (parameters, effects)
    }

    /// Fit effects on top of the model's own, from `parameters`, in windows that grow from
    /// `horizon` to `longest`.
    fn fit(&self, new: &[ModelEffect], from: &[f64], horizon: f64, longest: f64) -> ShootingFit {
        Shooting::new(self.model, self.training, new.to_vec()).fit(from, horizon, longest)
    }

    /// The effects of a fit beyond the model's own.
    fn added<'f>(&self, fit: &'f ShootingFit) -> &'f [ModelEffect] {
        &fit.effects[self.model.effects.len()..]
    }

    fn run(&self, progress: &(dyn Fn(&str) + Sync)) -> Confirmed {
        let span = duration(self.training);
        let samples = self.training.recordings.iter().map(Observed::len).max().unwrap_or(1);
        let shortest = (span / SHORTEST).max(FEWEST_SAMPLES * span / samples as f64);
        let (mut from, _) = self.start(&self.screening.calibrated);
        let mut current = self.fit(&[], &from, shortest, span);
        let (screened, starts) = self.start(&self.screening.chosen);
        let (mut terms, mut gains, mut rivals) = (vec![], vec![], vec![]);
        for (k, (term, start)) in self.screening.chosen.terms.iter().zip(starts).enumerate() {
            progress(&format!(
                "fitting {} with the equations of motion",
                term.candidate.effect.words
            ));
            from = if k == 0 { screened.clone() } else { current.parameters.clone() };
            let mut effects = self.added(&current).to_vec();
            effects.push(start);
            let begin = if k == 0 { shortest } else { current.horizon };
            let mut next = self.fit(&effects, &from, begin, span);
            let mut named = vec![term.clone()];
            if k == 0 {
                (named, next) = self.siblings(term, next);
            }
            // The same windows with and without; from the longer windows of the richer model,
            // or from its own, whichever fits better.
            let effects = self.added(&current);
            let same = if next.horizon == current.horizon {
                current.clone()
            } else {
                let alike = self.fit_like(effects, &next);
                let own = self.fit(effects, &current.parameters, next.horizon, next.horizon);
                if alike.chi2 < own.chi2 { alike } else { own }
            };
            let gain = nats(&same, &next);
            let first = gains.first().copied().unwrap_or(0.0);
            if gain < THRESHOLD.max(SHARE_OF_FIRST * first) {
                break;
            }
            // Two terms that are one way of writing one gain share it.
            gains.extend(named.iter().map(|_| gain / named.len() as f64));
            let same_term = named.len() == 1 && named[0].candidate == term.candidate;
            let close = if same_term { self.screening.rivals[k].clone() } else { vec![] };
            rivals.extend(named.iter().map(|_| close.clone()));
            terms.extend(named);
            current = next;
        }
        let horizon = current.horizon;
        let current = self.polish(self.simplify(current, &mut terms));
        let calibrated = if terms.is_empty() {
            current.clone()
        } else {
            let (from, _) = self.start(&self.screening.calibrated);
            self.fit(&[], &from, horizon, horizon)
        };
        let nominal = Shooting::new(self.model, self.training, vec![]).with_parameters_held().fit(
            &self.model.values(),
            horizon,
            horizon,
        );
        Confirmed { nominal, calibrated, chosen: current, terms, gains, rivals }
    }

    /// Friction that needs neither its asymmetry nor its peak any more, once further effects
    /// stand beside it, is written as plain dry friction.
    fn simplify(&self, mut fit: ShootingFit, terms: &mut [Term]) -> ShootingFit {
        let price = 0.5 * (fit.count as f64).ln();
        for k in 0..terms.len() {
            let effects = self.added(&fit);
            let plain = other_friction(&effects[k])
                .into_iter()
                .map(|(_, e)| e)
                .find(|e| e.len() == 1 && e[0].effect.class == "coulomb_friction");
            let Some(plain) = plain else { continue };
            let saved = (effects[k].parameters.len() - plain[0].parameters.len()) as f64;
            let mut simpler = effects.to_vec();
            simpler[k] = plain[0].clone();
            let without = self.fit_like(&simpler, &fit);
            if nats(&fit, &without) + price * saved > 0.0 {
                terms[k] = term(&simpler[k]);
                fit = without;
            }
        }
        fit
    }

    /// Fit other effects in the windows, and from the parameters and states, of a fit.
    fn fit_like(&self, new: &[ModelEffect], like: &ShootingFit) -> ShootingFit {
        Shooting::new(self.model, self.training, new.to_vec()).fit_like(like)
    }

    /// The final fit. Where the model reaches the noise, all windows agree and the longest are
    /// best. Where it does not, its formulas are not exact, and each length of windows weighs
    /// their remainder differently; the one whose fit predicts free runs of the training
    /// recordings best is kept.
    fn polish(&self, fit: ShootingFit) -> ShootingFit {
        if fit.reduced().sqrt() < MOST_RMS {
            return fit;
        }
        let error = |f: &ShootingFit| {
            let equations = Equations::of(self.model);
            let (p, e) = (&f.parameters, &f.effects);
            let predictor = Predictor::with(self.model, &equations, p, e, self.training);
            let squares = |o: &Observed| {
                let run = predictor.free_run(o, DEFAULT_WARMUP);
                let of = |k: usize| run.squares(o, k).0 / self.training.half_range(k).powi(2);
                (0..self.training.outputs.len()).map(of).sum::<f64>()
            };
            self.training.recordings.iter().map(squares).sum::<f64>()
        };
        let own = self.added(&fit).to_vec();
        let others: Vec<ShootingFit> = [0.25, 0.5, 2.0, 4.0]
            .into_par_iter()
            .map(|share| {
                let horizon = share * fit.horizon;
                self.fit(&own, &fit.parameters, horizon, horizon)
            })
            .collect();
        let candidates = std::iter::once(fit).chain(others).map(|f| (error(&f), f));
        let best = candidates.min_by(|a, b| a.0.total_cmp(&b.0));
        best.expect("there is at least the fit itself").1
    }

    /// Other ways to name what the first effect does, fitted in its place: rivals that the
    /// screening leaves close, and the other laws of dry friction. The best of all.
    fn siblings(&self, first: &Term, best: ShootingFit) -> (Vec<Term>, ShootingFit) {
        let rivals = self.screening.rivals[0].iter();
        let close = rivals.filter(|(_, behind)| *behind < CLOSE).take(3);
        let mut tries: Vec<(Vec<Term>, Vec<ModelEffect>)> = close
            .filter_map(|(rival, _)| {
                let terms = vec![rival.clone()];
                let h = self.screen.hypothesis(&terms, &self.screening.chosen.tau).ok()?;
                Some((terms, self.start(&h).1))
            })
            .collect();
        tries.extend(other_friction(&self.added(&best)[0]));
        let fitted: Vec<_> = tries
            .into_par_iter()
            .map(|(terms, effects)| (terms, self.fit_like(&effects, &best)))
            .collect();
        let size = |f: &ShootingFit| {
            self.added(f).iter().map(|e| e.parameters.len()).sum::<usize>() as f64
        };
        let price = 0.5 * (best.count as f64).ln();
        // What the data cannot tell apart is written with the simpler laws.
        let simpler = |f: &ShootingFit| if self.added(f).len() > 1 { SIMPLER } else { 0.0 };
        let lead = |f: &ShootingFit| nats(&best, f) - price * (size(f) - size(&best)) + simpler(f);
        let winner = fitted
            .into_iter()
            .filter(|(_, f)| lead(f) > 0.0)
            .max_by(|(_, a), (_, b)| lead(a).total_cmp(&lead(b)));
        winner.unwrap_or_else(|| (vec![first.clone()], best))
    }
}

/// A dry friction written with the other laws of dry friction, their parameters taken over
/// as far as they correspond; friction that differs between the directions is also written
/// as plain friction with a constant force.
fn other_friction(fitted: &ModelEffect) -> Vec<(Vec<Term>, Vec<ModelEffect>)> {
    let p = &fitted.parameters;
    let (magnitude, offset, smoothing) = match fitted.effect.class {
        "coulomb_friction" => (p[0], 0.0, p[1]),
        "asymmetric_friction" => (0.5 * (p[0] + p[1]), 0.5 * (p[1] - p[0]), p[2]),
        "stribeck_friction" => (p[0], 0.0, p[3]),
        _ => return vec![],
    };
    let on = |class: &str, parameters: Vec<f64>| {
        let effect = lacuna_effects::find(class)?;
        let std = vec![None; parameters.len()];
        Some(ModelEffect { effect, parameters, std, ..*fitted })
    };
    let dry = on("coulomb_friction", vec![magnitude, smoothing]);
    let mut tries = vec![
        vec![dry.clone()],
        vec![on("asymmetric_friction", vec![magnitude - offset, magnitude + offset, smoothing])],
        vec![dry, on("constant_force", vec![offset])],
    ];
    // The Stribeck peak may be anywhere between creeping and full speed.
    for speed in [10.0, 40.0, 160.0] {
        let parameters = vec![magnitude, 1.3 * magnitude, speed * smoothing, smoothing];
        tries.push(vec![on("stribeck_friction", parameters)]);
    }
    let complete = tries.into_iter().filter_map(|t| t.into_iter().collect::<Option<Vec<_>>>());
    let other = complete.filter(|t| t.len() > 1 || t[0].effect.class != fitted.effect.class);
    other.map(|effects| (effects.iter().map(term).collect(), effects)).collect()
}

/// A force effect as a term of the screening.
fn term(e: &ModelEffect) -> Term {
    let shape = match e.effect.law {
        Law::Force(law) => law.internal(&e.parameters).split_off(law.amplitudes()),
        _ => e.parameters.clone(),
    };
    Term { candidate: Candidate { effect: e.effect, channel: e.channel, other: e.other }, shape }
}

/// Log evidence that `with` gains over `without` on the same windows, in nats; a residual
/// above the noise or slower than white noise counts less.
fn nats(without: &ShootingFit, with: &ShootingFit) -> f64 {
    let n = with.count as f64;
    let (a, b) = (without.reduced(), with.reduced());
    if !a.is_finite() {
        return f64::INFINITY;
    }
    // Below the noise nothing is left to gain: likelihood with the noise variance known, and
    // estimated where the residual exceeds it.
    let log = |r: f64| if r > 1.0 { 0.5 * (1.0 + r.ln()) } else { 0.5 * r };
    n * (log(a) - log(b)) / with.colour
}

struct Ladder<'a> {
    model: &'a Model,
    training: &'a Dataset,
    held_out: &'a Dataset,
    screen: Screen<'a>,
    screening: Screening,
    confirmed: Confirmed,
}

impl Ladder<'_> {
    fn outcome(&self) -> Result<Outcome, DiagnoseError> {
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
                "No effect of the catalogue explains what is left; the learned forces show where it acts."
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
        (0..effects.len()).map(|k| self.finding(k, &effects[k])).collect()
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
                let std = std.unwrap_or(0.0);
                (p.name.to_owned(), Estimate { value: *value, std, unit: unit.clone() })
            })
            .collect();
        let rivals = self.confirmed.rivals.get(k).map_or(&[][..], Vec::as_slice);
        let weights: Vec<f64> = rivals.iter().map(|(_, behind)| (-behind).exp()).collect();
        let total = 1.0 + weights.iter().sum::<f64>();
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
        let learned = self.screen.learn(&others, tau, e.channel, over)?;
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

    /// Evidence for a missing force on each channel, shown by free curves over its velocity
    /// or coordinate, whatever its name.
    fn location(&self, findings: &[Finding]) -> Result<Location, DiagnoseError> {
        let mut channels = BTreeMap::new();
        let tau = &self.screening.calibrated.tau;
        for c in 0..self.model.channels() {
            let name = self.model.channel_name(c).to_owned();
            let learned =
                [Over::Coordinate, Over::Velocity].map(|over| self.screen.learn(&[], tau, c, over));
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
                    let free =
                        (before.free_run(o, DEFAULT_WARMUP), after.free_run(o, DEFAULT_WARMUP));
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
