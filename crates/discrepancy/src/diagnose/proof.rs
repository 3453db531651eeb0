//! The proof: errors of the model before and after, on recordings that nothing was fitted to.

use super::outcome::Ladder;
use super::{Proof, duration};
use crate::dataset::{Dataset, Observed};
use crate::diagnosis::{ChannelFit, Fit};
use crate::prediction::{DEFAULT_WARMUP, Prediction, Predictor};
use rayon::prelude::*;
use std::collections::BTreeMap;

/// Windows of the prediction error: the recording's length over this.
const WINDOWS: f64 = 12.0;

impl Ladder<'_> {
    pub(super) fn proof(&self, keep_model: bool) -> (Fit, Vec<Proof>) {
        let model = self.problem.model;
        let h = &self.found.chosen.hypothesis;
        let nominal = model.values();
        let (parameters, effects) =
            if keep_model { (&nominal, &model.effects) } else { (&h.parameters, &h.effects) };
        let horizon = duration(self.held_out.dataset) / WINDOWS;
        let errors = |data: &Dataset| -> Vec<Runs> {
            let before = Predictor::new(model, data);
            let after = Predictor::with(model, parameters, effects, data);
            data.recordings
                .par_iter()
                .map(|o| {
                    let windows = (before.windowed(o, horizon), after.windowed(o, horizon));
                    let free = (before.free_run(o, warmup(o)), after.free_run(o, warmup(o)));
                    (windows, free)
                })
                .collect()
        };
        let (held, train) = (errors(self.held_out.dataset), errors(self.problem.dataset));
        let fit = Fit {
            held_out: channel_fits(self.held_out.dataset, &held, horizon),
            training: channel_fits(self.problem.dataset, &train, horizon),
        };
        let proofs = self
            .held_out
            .dataset
            .recordings
            .iter()
            .zip(held)
            .map(|(o, (_, (before, after)))| Proof { observed: o.clone(), before, after })
            .collect();
        (fit, proofs)
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
