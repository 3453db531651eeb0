//! Confirmation: what the screening found, fitted with the differential equation itself.
//!
//! The full comparison by likelihood (a shortlist, backward pruning, calibrated
//! probabilities) will stand here; for now the screening's choices, and rivals that lie
//! close, are fitted by multiple shooting one after the other and must earn their place again.

use super::{THRESHOLD, duration};
use crate::candidates::{Candidate, Term};
use crate::dataset::{Dataset, Observed};
use crate::prediction::{DEFAULT_WARMUP, Predictor};
use crate::screen::{Hypothesis, Screen, Screening};
use crate::shooting::{MOST_RMS, Shooting, ShootingFit, model_effect};
use lacuna_effects::Law;
use lacuna_plants::Model;
use lacuna_plants::model::{Equations, ModelEffect};
use rayon::prelude::*;

/// Share of the first effect's gain that each further one must reach.
const SHARE_OF_FIRST: f64 = 0.02;
/// Rivals that the screening leaves within this many nats are fitted by shooting.
const CLOSE: f64 = 25.0;
/// Nats by which the simpler way of writing the same law is preferred.
const SIMPLER: f64 = 3.0;
/// Shooting begins with windows of the recording's length over this.
const SHORTEST: f64 = 64.0;
/// ... but with at least this many samples.
const FEWEST_SAMPLES: f64 = 30.0;

/// What was screened, fitted with the differential equation.
pub(super) struct Confirmed {
    pub nominal: ShootingFit,
    pub calibrated: ShootingFit,
    /// The chosen model, with its terms.
    pub chosen: ShootingFit,
    pub terms: Vec<Term>,
    /// Nats each term gains, given those before it.
    pub gains: Vec<f64>,
    pub rivals: Vec<Vec<(Term, f64)>>,
}

/// Confirmation of the screened effects. The full comparison by likelihood will stand here;
/// for now the shortlist's first choices, and rivals that lie close, are fitted by multiple
/// shooting and must earn their place again.
pub(super) struct Confirmation<'a> {
    model: &'a Model,
    training: &'a Dataset,
    screen: &'a Screen<'a>,
    screening: &'a Screening,
}

impl<'a> Confirmation<'a> {
    pub(super) fn new(
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

    pub(super) fn run(&self, progress: &(dyn Fn(&str) + Sync)) -> Confirmed {
        let span = duration(self.training);
        let samples = self.training.recordings.iter().map(Observed::len).max().unwrap_or(1);
        let shortest = (span / SHORTEST).max(FEWEST_SAMPLES * span / samples as f64);
        let (mut from, _) = self.start(&self.screening.calibrated);
        let mut current = self.fit(&[], &from, shortest, span);
        let (screened, starts) = self.start(&self.screening.chosen);
        let (mut terms, mut gains, mut rivals) = (vec![], vec![], vec![]);
        for (k, (term, start)) in self.screening.chosen.terms.iter().zip(starts).enumerate() {
            if terms.iter().any(|t: &Term| t.candidate.excludes(&term.candidate)) {
                continue;
            }
            progress(&format!(
                "fitting {} with the equations of motion",
                term.candidate.effect.words
            ));
            from = if k == 0 { screened.clone() } else { current.parameters.clone() };
            let mut effects = self.added(&current).to_vec();
            effects.push(start);
            let begin = if k == 0 { shortest } else { current.horizon };
            let next = self.fit(&effects, &from, begin, span);
            let Named { terms: named, fit: next, rivals: close } = if k == 0 {
                self.siblings(term, next)
            } else {
                let rivals = self.screening.rivals[k].clone();
                Named { terms: vec![term.clone()], fit: next, rivals }
            };
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
            rivals.extend(named.iter().map(|_| close.clone()));
            terms.extend(named);
            current = next;
        }
        let horizon = current.horizon;
        let current = self.polish(self.simplify(current, &mut terms, &mut rivals));
        let better = |a: ShootingFit, b: ShootingFit| if a.chi2 <= b.chi2 { a } else { b };
        let calibrated = if terms.is_empty() {
            current.clone()
        } else {
            let (from, _) = self.start(&self.screening.calibrated);
            better(self.fit(&[], &from, horizon, horizon), self.fit_like(&[], &current))
        };
        let held = Shooting::new(self.model, self.training, vec![]).with_parameters_held();
        let values = self.model.values();
        let nominal =
            better(held.fit(&values, horizon, horizon), held.fit_like(&values, &calibrated));
        Confirmed { nominal, calibrated, chosen: current, terms, gains, rivals }
    }

    /// Friction that needs neither its asymmetry nor its peak any more, once further effects
    /// stand beside it, is written as plain dry friction.
    fn simplify(
        &self,
        mut fit: ShootingFit,
        terms: &mut [Term],
        rivals: &mut [Vec<(Term, f64)>],
    ) -> ShootingFit {
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
            let lead = nats(&fit, &without) + price * saved;
            if lead > 0.0 {
                let other = std::mem::replace(&mut terms[k], term(&simpler[k]));
                rivals[k].retain(|(t, _)| t.candidate != terms[k].candidate);
                rivals[k].push((other, lead));
                fit = without;
            }
        }
        fit
    }

    /// Fit other effects in the windows, and from the parameters and states, of a fit.
    fn fit_like(&self, new: &[ModelEffect], like: &ShootingFit) -> ShootingFit {
        Shooting::new(self.model, self.training, new.to_vec()).fit_like(&like.parameters, like)
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
    /// screening leaves close, and the other laws of dry friction. The best of all, and how
    /// far the others lie behind it.
    fn siblings(&self, first: &Term, fit: ShootingFit) -> Named {
        let rivals = &self.screening.rivals[0];
        let close = rivals.iter().filter(|(_, behind)| *behind < CLOSE).take(3);
        let mut tries: Vec<(Vec<Term>, Vec<ModelEffect>)> = close
            .filter_map(|(rival, _)| {
                let terms = vec![rival.clone()];
                let h = self.screen.hypothesis(&terms, &self.screening.chosen.tau).ok()?;
                Some((terms, self.start(&h).1))
            })
            .collect();
        tries.extend(other_friction(&self.added(&fit)[0]));
        let size = |f: &ShootingFit| {
            self.added(f).iter().map(|e| e.parameters.len()).sum::<usize>() as f64
        };
        let price = 0.5 * (fit.count as f64).ln();
        // What the data cannot tell apart is written with the simpler laws.
        let simpler = |f: &ShootingFit| if self.added(f).len() > 1 { SIMPLER } else { 0.0 };
        let lead = |f: &ShootingFit| nats(&fit, f) - price * (size(f) - size(&fit)) + simpler(f);
        let mut fitted: Vec<(f64, Vec<Term>, ShootingFit)> = tries
            .into_par_iter()
            .map(|(terms, effects)| {
                let alike = self.fit_like(&effects, &fit);
                (lead(&alike), terms, alike)
            })
            .collect();
        let others = rivals
            .iter()
            .filter(|(r, _)| !fitted.iter().any(|(_, terms, _)| terms[0].candidate == r.candidate));
        let mut behind: Vec<(Term, f64)> = others.cloned().collect();
        fitted.push((0.0, vec![first.clone()], fit));
        fitted.sort_by(|a, b| b.0.total_cmp(&a.0));
        let (best, terms, fit) = fitted.remove(0);
        // A class is named once, at its best; a pair is no class.
        for (lead, other, _) in fitted.into_iter().filter(|(_, terms, _)| terms.len() == 1) {
            let named = behind.iter().map(|(t, _)| t).chain(&terms);
            if !named.map(|t| t.candidate).any(|c| c == other[0].candidate) {
                behind.push((other[0].clone(), best - lead));
            }
        }
        Named { terms, fit, rivals: behind }
    }
}

/// An effect as it is named, with its fit and the nats that others lie behind.
struct Named {
    terms: Vec<Term>,
    fit: ShootingFit,
    rivals: Vec<(Term, f64)>,
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
pub(super) fn nats(without: &ShootingFit, with: &ShootingFit) -> f64 {
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
