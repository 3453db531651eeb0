//! The proof: the model as it was and the one to be handed back, on recordings that nothing was
//! fitted to and nothing was chosen by. They are opened here, when everything is decided, and what
//! they say is told whatever it is.
//!
//! Let e_b and e_a be the squares of the prediction errors before and after, in units of the noise,
//! summed over the channels and over each window b of the horizon. The model to be handed back is
//! refused where the windows say that it predicts worse:
//!
//! ```text
//! D = sum_b (e_a - e_b) > sqrt(sum_b (e_a - e_b)^2),   D / n > relevant
//! ```
//!
//! the first being one standard error of the sum under the hypothesis that neither is better. Where `D / n > relevant`
//! alone holds they do not agree, and it is not handed back as an improvement either. Where windows see no change at all,
//! what adds up over whole recordings decides by the same `D / n`, of those through which either model finds its way: what
//! is real shows in the one or in the other.

use super::{Proof, duration};
use crate::dataset::{Dataset, Observed};
use crate::decision::Decision;
use crate::diagnosis::{ChannelFit, Fit, Integration, ProofOutcome};
use crate::prediction::{Prediction, Predictor, warmup, windows};
use lacuna_plants::Model;
use lacuna_plants::model::ModelEffect;
use rayon::prelude::*;
use std::collections::BTreeMap;
use std::ops::Range;

/// Windows of the prediction error: the recording's length over this.
const WINDOWS: f64 = 12.0;

/// What a model says: its parameters and effects.
pub(super) type Says<'a> = (&'a [f64], &'a [ModelEffect]);

/// Two models on the same recordings.
pub(super) struct Proving<'a> {
    pub model: &'a Model,
    pub training: &'a Dataset,
    pub held_out: &'a Dataset,
    pub decision: Decision,
}

/// What the recordings say of them.
pub(super) struct Proved {
    pub outcome: ProofOutcome,
    /// Whether predictions became worse all in all, though windows need not agree that they did.
    pub harms: bool,
    pub fit: Fit,
    pub proofs: Vec<Proof>,
    pub integration: Integration,
}

/// Predictions of one recording, over windows and running free.
#[derive(Clone)]
struct Runs {
    windows: Prediction,
    free: Prediction,
}

impl Proving<'_> {
    /// The model as it was against `after`, or against itself where it is handed back unchanged.
    pub(super) fn prove(&self, after: Option<Says>) -> Proved {
        let horizon = duration(self.held_out) / WINDOWS;
        let values = self.model.values();
        let before = (&values[..], &self.model.effects[..]);
        let runs = |data| -> (Vec<(Runs, Runs)>, Integration) {
            let changed = || after.map(|says| self.runs(data, horizon, says));
            let (before, after) = rayon::join(|| self.runs(data, horizon, before), changed);
            let after = after.unwrap_or_else(|| before.clone());
            (before.0.into_iter().zip(after.0).collect(), after.1)
        };
        let ((held, integration), (train, _)) =
            rayon::join(|| runs(self.held_out), || runs(self.training));
        let all = |data: &Dataset, runs| channel_fits(data, &data.recordings, runs, horizon);
        let fit = Fit {
            held_out: all(self.held_out, &held),
            training: all(self.training, &train),
            by_recording: self.by_recording(&held, horizon),
        };
        let (outcome, change) = self.judge(&held, horizon);
        let relevant = self.decision.relevant;
        let outcome = match outcome {
            ProofOutcome::Same if change.abs() <= relevant && self.adds_up(&held) => {
                ProofOutcome::Worse
            }
            outcome => outcome,
        };
        let harms = outcome == ProofOutcome::Worse || change > relevant;
        let recordings = self.held_out.recordings.iter().zip(held);
        let proofs = recordings
            .map(|(o, (b, a))| Proof { observed: o.clone(), before: b.free, after: a.free })
            .collect();
        Proved { outcome, harms, fit, proofs, integration }
    }

    /// The errors on each held-out recording, where there are several.
    fn by_recording(
        &self,
        runs: &[(Runs, Runs)],
        horizon: f64,
    ) -> BTreeMap<String, BTreeMap<String, ChannelFit>> {
        let recordings = &self.held_out.recordings;
        if recordings.len() < 2 {
            return BTreeMap::new();
        }
        let one = |(o, run): (&Observed, &(Runs, Runs))| {
            let (o, run) = (std::slice::from_ref(o), std::slice::from_ref(run));
            (o[0].name.clone(), channel_fits(self.held_out, o, run, horizon))
        };
        recordings.iter().zip(runs).map(one).collect()
    }

    /// A model on some recordings, and how it was integrated there.
    fn runs(
        &self,
        data: &Dataset,
        horizon: f64,
        (parameters, effects): Says,
    ) -> (Vec<Runs>, Integration) {
        let predictor = Predictor::with(self.model, parameters, effects, data);
        let run = |o: &Observed| {
            let windows = || predictor.windowed(o, horizon);
            let (windows, free) = rayon::join(windows, || predictor.free_run(o, warmup(o)));
            Runs { windows, free }
        };
        (data.recordings.par_iter().map(run).collect(), predictor.integration())
    }

    /// Whether predictions became better or worse, window by window; and by how much a sample.
    fn judge(&self, runs: &[(Runs, Runs)], horizon: f64) -> (ProofOutcome, f64) {
        let (changes, samples) = self.changes(runs, |r| &r.windows, |o, _| windows(o, horizon));
        outcome(&changes, samples, self.decision.relevant)
    }

    /// Whether what changes adds up to worse free runs through whole recordings. Where both models run away how far they
    /// are off says nothing of either.
    fn adds_up(&self, runs: &[(Runs, Runs)]) -> bool {
        let whole = |o: &Observed, runs: [&Prediction; 2]| {
            let tells = runs.iter().any(|run| !run.is_astray(o, self.held_out));
            if tells { vec![runs[0].counted.clone()] } else { vec![] }
        };
        let (changes, samples) = self.changes(runs, |r| &r.free, whole);
        outcome(&changes, samples, self.decision.relevant).1 > self.decision.relevant
    }

    /// By how much the weighted squares of some predictions grew in each of their ranges, and of how many samples.
    fn changes(
        &self,
        runs: &[(Runs, Runs)],
        of: fn(&Runs) -> &Prediction,
        ranges: impl Fn(&Observed, [&Prediction; 2]) -> Vec<Range<usize>>,
    ) -> (Vec<f64>, usize) {
        let data = self.held_out;
        let weights: Vec<f64> = (0..data.outputs.len()).map(|k| data.noise_sd(k).recip()).collect();
        let mut changes: Vec<f64> = vec![];
        let mut samples = 0;
        for (o, (before, after)) in data.recordings.iter().zip(runs) {
            let (before, after) = (of(before), of(after));
            for range in ranges(o, [before, after]) {
                let mut change = 0.0;
                for (k, weight) in weights.iter().enumerate() {
                    let squares = |p: &Prediction| p.squares_in(o, k, range.clone());
                    let ((b, count), (a, _)) = (squares(before), squares(after));
                    samples += count;
                    // Where both diverge neither is better.
                    let worse = if a.is_finite() || b.is_finite() { a - b } else { 0.0 };
                    change += worse * weight * weight;
                }
                changes.push(change);
            }
        }
        (changes, samples)
    }
}

/// What changes of the weighted squares in each window say, and how large they are a sample.
fn outcome(changes: &[f64], samples: usize, relevant: f64) -> (ProofOutcome, f64) {
    let sum: f64 = changes.iter().sum();
    let error = changes.iter().map(|c| c * c).sum::<f64>().sqrt();
    let change = sum / samples.max(1) as f64;
    // A divergence is worse than any number, and one that ends better.
    let agreed = sum.is_infinite() || (sum.abs() > error && change.abs() > relevant);
    let outcome = match (agreed, sum > 0.0) {
        _ if sum.is_nan() => ProofOutcome::Worse,
        (true, true) => ProofOutcome::Worse,
        (true, false) => ProofOutcome::Better,
        (false, _) => ProofOutcome::Same,
    };
    (outcome, change)
}

/// Errors on some recordings of a data set, by channel.
fn channel_fits(
    data: &Dataset,
    recordings: &[Observed],
    runs: &[(Runs, Runs)],
    horizon: f64,
) -> BTreeMap<String, ChannelFit> {
    let pooled = |k: usize, of: fn(&(Runs, Runs)) -> &Prediction| {
        let (sum, n) = recordings
            .iter()
            .zip(runs)
            .map(|(o, r)| of(r).squares(o, k))
            .fold((0.0, 0), |(s, n), (a, b)| (s + a, n + b));
        (sum / n.max(1) as f64).sqrt()
    };
    data.outputs
        .iter()
        .enumerate()
        // A channel without a sample there proves nothing and is left out.
        .filter(|(k, _)| recordings.iter().any(|o| o.outputs[*k].iter().any(|v| !v.is_nan())))
        .map(|(k, output)| {
            let fit = ChannelFit {
                unit: output.unit.clone(),
                rmse_before: pooled(k, |r| &r.0.windows),
                rmse_after: pooled(k, |r| &r.1.windows),
                noise: data.noise[k].sd,
                horizon_s: horizon,
                free_run_before: pooled(k, |r| &r.0.free),
                free_run_after: pooled(k, |r| &r.1.free),
            };
            (output.name.clone(), fit)
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::{ProofOutcome, outcome};

    #[test]
    fn a_model_is_refused_where_windows_agree_that_it_is_worse() {
        let judge = |changes: &[f64]| outcome(changes, 1000, 0.0025).0;
        assert_eq!(judge(&[30.0, 20.0, 25.0]), ProofOutcome::Worse);
        assert_eq!(judge(&[-30.0, -20.0, -25.0]), ProofOutcome::Better);
        // One window in three says so, the others do not.
        assert_eq!(judge(&[30.0, -20.0, -5.0]), ProofOutcome::Same);
        // They agree, about nothing: a thousandth of the noise.
        assert_eq!(judge(&[0.3, 0.3, 0.3]), ProofOutcome::Same);
        assert_eq!(judge(&[f64::INFINITY, -20.0]), ProofOutcome::Worse);
        assert_eq!(judge(&[f64::NEG_INFINITY, 20.0]), ProofOutcome::Better);
        assert_eq!(judge(&[f64::NEG_INFINITY, f64::INFINITY]), ProofOutcome::Worse);
        assert_eq!(outcome(&[30.0, -20.0, -5.0], 1000, 0.0025).1, 0.005);
    }
}
