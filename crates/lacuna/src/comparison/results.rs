//! The errors of two models, for machines and for people.

use super::pair::{Channel, Named, Pair};
use crate::recordings::in_samples;
use crate::report::number::ratio;
use crate::report::{Closer, ComparedChannel, ComparedSeries, Comparison};
use crate::simulation::{ChannelError, Settings};
use crate::table::{Table, number};
use indexmap::IndexMap;
use serde::Serialize;

/// What compare.json holds. Errors are over the samples of all recordings.
#[derive(Serialize)]
pub(super) struct Results {
    channels: IndexMap<String, Compared>,
    recordings: Vec<OneRecording>,
    mode: &'static str,
    a: String,
    b: String,
    horizon_s: Option<f64>,
    warmup_samples: usize,
}

#[derive(Serialize)]
struct Compared {
    unit: String,
    noise: f64,
    /// Samples that do not count for the errors since they are outliers.
    outliers: usize,
    a: ChannelError,
    b: ChannelError,
    /// `A`, `B` or `same`.
    closer: &'static str,
}

#[derive(Serialize)]
struct OneRecording {
    name: String,
    channels: IndexMap<String, Errors>,
}

#[derive(Serialize)]
struct Errors {
    a: ChannelError,
    b: ChannelError,
}

impl Results {
    /// `pairs` have the same channels in the same order.
    pub fn of([a, b]: &[Named; 2], pairs: &[Pair], settings: Settings) -> Self {
        let first = pairs.iter().take(1).flat_map(|p| p.channels.iter());
        let channels = first.enumerate().map(|(k, c)| (c.name.clone(), pooled(pairs, k, c)));
        let errors = |p: &Pair, c: &Channel| {
            let [a, b] = p.errors(c);
            (c.name.clone(), Errors { a, b })
        };
        let recording = |p: &Pair| OneRecording {
            name: p.runs[0].observed().name.clone(),
            channels: p.channels.iter().map(|c| errors(p, c)).collect(),
        };
        Self {
            channels: channels.collect(),
            recordings: pairs.iter().map(recording).collect(),
            mode: settings.mode(),
            a: a.label.clone(),
            b: b.label.clone(),
            horizon_s: settings.horizon,
            warmup_samples: settings.warmup_samples(),
        }
    }

    /// What is drawn.
    pub fn comparison(&self, pairs: &[Pair]) -> Comparison {
        let channel = |(name, c): (&String, &Compared)| ComparedChannel {
            name: name.clone(),
            unit: c.unit.clone(),
            noise: c.noise,
            a: c.a.rmse,
            b: c.b.rmse,
        };
        let series = pairs.iter().flat_map(|p| p.channels.iter().map(move |c| series(p, c)));
        Comparison {
            a: self.a.clone(),
            b: self.b.clone(),
            how: self.how(),
            channels: self.channels.iter().map(channel).collect(),
            series: series.collect(),
        }
    }

    /// The errors as a table, and who is closer.
    pub fn text(&self, comparison: &Comparison) -> String {
        let count = self.recordings.len();
        let plural = if count == 1 { "" } else { "s" };
        let how = self.how();
        let mut out =
            format!("A is {}, B is {}, on {count} recording{plural}, {how}:\n", self.a, self.b);
        let mut table =
            Table::new(&["channel", "unit", "noise", "error of A", "error of B", "closer"]);
        for (name, c) in &self.channels {
            let cell = |e: &ChannelError| with_noise(e.rmse, c.noise);
            let unit = c.unit.clone();
            let row = [name.clone(), unit, number(c.noise), cell(&c.a), cell(&c.b)];
            table.row([&row[..], &[c.closer.to_owned()]].concat());
        }
        out += &table.text();
        for (name, c) in self.channels.iter().filter(|(_, c)| c.outliers > 0) {
            out +=
                &format!("{} of {name} left out of the errors: outliers\n", in_samples(c.outliers));
        }
        out + &comparison.headline() + ".\n"
    }

    fn how(&self) -> String {
        match self.horizon_s {
            Some(horizon) => {
                format!("restarted every {horizon} s from the state that fits each window")
            }
            None => format!(
                "running free from the state that fits the first {} samples",
                self.warmup_samples
            ),
        }
    }
}

/// Rms error, and how many times the noise it is.
fn with_noise(error: f64, noise: f64) -> String {
    match error.is_finite() {
        true => format!("{} ({} x noise)", number(error), ratio(error / noise)),
        false => "diverges".to_owned(),
    }
}

/// Errors of the `k`-th channel over all recordings.
fn pooled(pairs: &[Pair], k: usize, channel: &Channel) -> Compared {
    let of = |m: usize| {
        let runs = pairs.iter().map(|p| (&p.runs[m], p.channels[k].index[m]));
        ChannelError::pooled(&runs.collect::<Vec<_>>())
    };
    let (a, b) = (of(0), of(1));
    let noise = noise(pairs, k);
    let unit = channel.unit.clone();
    let outliers = pairs.iter().map(|p| {
        let run = &p.runs[0];
        run.observed().cleaned[p.channels[k].index[0]].outliers.len()
    });
    let outliers = outliers.sum();
    Compared { unit, noise, outliers, a, b, closer: Closer::of(a.rmse, b.rmse).word() }
}

/// Noise of a channel: the root mean square of the recordings' own, by their samples.
fn noise(pairs: &[Pair], k: usize) -> f64 {
    let each = pairs.iter().map(|p| {
        let run = &p.runs[0];
        let sd = run.dataset().noise_sd(p.channels[k].index[0]);
        (sd * sd * run.observed().len() as f64, run.observed().len() as f64)
    });
    let (sum, samples) = each.fold((0.0, 0.0), |(s, n), (s2, n2)| (s + s2, n + n2));
    (sum / samples).sqrt()
}

fn series(pair: &Pair, c: &Channel) -> ComparedSeries {
    let observed = pair.runs[0].observed();
    let [a, b] = [0, 1].map(|m| pair.runs[m].predicted()[c.index[m]].clone());
    ComparedSeries {
        recording: observed.name.clone(),
        channel: c.name.clone(),
        unit: c.unit.clone(),
        time: observed.times.clone(),
        measured: observed.outputs[c.index[0]].clone(),
        a,
        b,
        rmse: pair.errors(c).map(|e| e.rmse),
    }
}
