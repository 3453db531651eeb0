//! Two models run on one recording, channel by channel.

use crate::models::AnyModel;
use crate::recordings::Recording;
use crate::simulation::{ChannelError, Settings, Simulation};
use std::error::Error;

/// A model, where it comes from and what it is called.
pub struct Named {
    /// The model.
    pub model: AnyModel,
    /// What errors call it: its file.
    pub file: String,
    /// What results call it.
    pub label: String,
}

/// A channel that both models have.
pub(super) struct Channel {
    pub name: String,
    pub unit: String,
    /// Index in each model's outputs.
    pub index: [usize; 2],
}

/// Both models on one recording.
pub struct Pair {
    pub(super) runs: [Simulation; 2],
    pub(super) channels: Vec<Channel>,
}

impl Pair {
    /// Run two models on one recording, with the column of time of each.
    ///
    /// # Errors
    /// What is wrong with the recording, or the channel that one of the models lacks or measures
    /// otherwise.
    pub fn of(
        models: &[Named; 2],
        like: [&Recording; 2],
        settings: Settings,
    ) -> Result<Self, Box<dyn Error>> {
        let [a, b] = models;
        let run = |m: &Named, like| Simulation::of((&m.model, &m.file), like, settings);
        let runs = [run(a, like[0])?, run(b, like[1])?];
        lacks((b, &runs[1]), (a, &runs[0]))?;
        lacks((a, &runs[0]), (b, &runs[1]))?;
        let channels = runs[0].dataset().outputs.iter().enumerate();
        let channels = channels
            .filter_map(|(i, output)| {
                let (name, j) = (output.name.clone(), runs[1].channel(&output.name)?);
                let units = [&output.unit, &runs[1].dataset().outputs[j].unit];
                // What was identified has the units of its columns, and does not name them.
                let unit = units.into_iter().find(|u| !u.is_empty()).cloned().unwrap_or_default();
                Some(Channel { name, unit, index: [i, j] })
            })
            .collect();
        let pair = Self { runs, channels };
        pair.channels.iter().try_for_each(|c| pair.measured_alike(models, c))?;
        Ok(pair)
    }

    /// Both models must read the same series, or their errors do not compare.
    fn measured_alike(&self, models: &[Named; 2], c: &Channel) -> Result<(), Box<dyn Error>> {
        let series = [0, 1].map(|m| &self.runs[m].observed().outputs[c.index[m]]);
        let size = series[0].iter().filter(|v| v.is_finite()).fold(0.0, |s: f64, v| s.max(v.abs()));
        let same = |(x, y): (&f64, &f64)| x.is_nan() && y.is_nan() || (x - y).abs() <= 1e-9 * size;
        let units = [0, 1].map(|m| &self.runs[m].dataset().outputs[c.index[m]].unit);
        let named = units.iter().all(|u| !u.is_empty());
        let alike = series[0].len() == series[1].len()
            && series[0].iter().zip(series[1]).all(same)
            && (!named || units[0] == units[1]);
        if alike {
            return Ok(());
        }
        let unit = |u: &str| match u {
            "" => "in the recording's unit".to_owned(),
            u => format!("in '{u}'"),
        };
        Err(format!(
            "channel '{}' of {}: {} ({}) and {} ({}) read different values; look at their units \
             and measurements",
            c.name,
            self.runs[0].observed().name,
            models[0].file,
            unit(units[0]),
            models[1].file,
            unit(units[1]),
        )
        .into())
    }

    /// The error of each model in a channel.
    pub(super) fn errors(&self, channel: &Channel) -> [ChannelError; 2] {
        [0, 1].map(|m| ChannelError::pooled(&[(&self.runs[m], channel.index[m])]))
    }
}

/// The same channels in every recording: errors over all of them are of all of them.
///
/// # Errors
/// The recording without a channel of the first.
pub(super) fn same_channels(pairs: &[Pair]) -> Result<(), Box<dyn Error>> {
    let names = |p: &Pair| p.channels.iter().map(|c| c.name.clone()).collect::<Vec<_>>();
    let Some(first) = pairs.first() else { return Ok(()) };
    match pairs.iter().find(|p| names(p) != names(first)) {
        None => Ok(()),
        Some(other) => Err(format!(
            "{} has the channels {}, but {} has {}: all recordings must measure the same",
            first.runs[0].observed().name,
            names(first).join(", "),
            other.runs[0].observed().name,
            names(other).join(", ")
        )
        .into()),
    }
}

/// Complain of a channel that the model `without` lacks and the other has.
fn lacks(
    (without, run): (&Named, &Simulation),
    (with, other): (&Named, &Simulation),
) -> Result<(), Box<dyn Error>> {
    let Some(missing) = other.dataset().outputs.iter().find(|o| run.channel(&o.name).is_none())
    else {
        return Ok(());
    };
    let has: Vec<&str> = run.dataset().outputs.iter().map(|o| o.name.as_str()).collect();
    Err(format!(
        "{}: no channel '{}', which {} compares with {}; it has {}",
        without.file,
        missing.name,
        with.file,
        run.observed().name,
        has.join(", ")
    )
    .into())
}
