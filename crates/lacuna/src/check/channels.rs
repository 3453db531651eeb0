//! What is in the recordings: rows and sampling, channels, inputs.

use super::excitation::{DELAYS, excitation};
use crate::discrepancy::{Dataset, Observed};
use crate::plants::Model;
use crate::plants::model::Measured;
use crate::recordings::{self, Log, Recording, Sampling, Unit, UnitError, convert_factor};
use crate::table::number;
use serde::Serialize;
use std::collections::BTreeMap;
use std::error::Error;

/// One recording as it was sampled.
#[derive(Serialize)]
pub struct Run {
    pub name: String,
    pub rows: usize,
    pub from_s: f64,
    pub to_s: f64,
    /// Usual step, s.
    pub step_s: f64,
    /// Standard deviation of the steps, relative.
    pub jitter: f64,
    pub uniform: bool,
    pub gaps: usize,
    pub dropped_rows: usize,
    /// Number of missing values of each column that has any.
    pub missing: BTreeMap<String, usize>,
    /// Clocks of its topics, that of the rows first; none of a file with one column of times.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub clocks: Vec<Clock>,
}

/// The clock of a topic of a log.
#[derive(Serialize)]
pub struct Clock {
    pub topic: String,
    pub samples: usize,
    /// One over the usual step; none of a single sample.
    pub rate_hz: Option<f64>,
    /// Whether times are the messages' stamps, else those at which they were logged.
    pub stamped: bool,
    /// What was added to the stamps.
    pub offset_s: f64,
    /// Median from stamp to logging.
    pub delay_s: f64,
    /// Messages that had the time of another one.
    pub repeated: usize,
}

impl From<&recordings::Clock> for Clock {
    fn from(of: &recordings::Clock) -> Self {
        Self {
            topic: of.topic.clone(),
            samples: of.samples,
            rate_hz: (of.step > 0.0).then(|| 1.0 / of.step),
            stamped: of.stamped,
            offset_s: of.offset,
            delay_s: of.delay,
            repeated: of.repeated,
        }
    }
}

impl Run {
    pub fn of(log: &Log) -> Self {
        let recording = &log.recording;
        let sampling = Sampling::of(&recording.time);
        let missing = recording.columns.iter().filter_map(|c| {
            let count = c.values.iter().filter(|v| v.is_nan()).count();
            (count > 0).then(|| (c.name.clone(), count))
        });
        Self {
            name: recording.name.clone(),
            rows: recording.len(),
            from_s: recording.time[0],
            to_s: recording.time[recording.len() - 1],
            step_s: sampling.step,
            jitter: sampling.jitter,
            uniform: sampling.uniform,
            gaps: sampling.gaps.len(),
            dropped_rows: sampling.gaps.iter().map(|g| g.missing).sum(),
            missing: missing.collect(),
            clocks: log.clocks.iter().map(Clock::from).collect(),
        }
    }

    pub fn missing_text(&self) -> String {
        if self.missing.is_empty() {
            return "none".to_owned();
        }
        let of = |(name, count): (&String, &usize)| format!("{name}: {count}");
        self.missing.iter().map(of).collect::<Vec<_>>().join(", ")
    }
}

/// How the unit of a column becomes that of the model.
#[derive(Serialize)]
pub struct Conversion {
    /// Unit of the column.
    pub column_unit: String,
    /// Unit of the channel.
    pub unit: String,
    /// Number of channel units in a column unit; none between temperature scales with
    /// different zeros.
    pub factor: Option<f64>,
}

impl Conversion {
    fn of(column_unit: &str, unit: &str) -> Result<Self, UnitError> {
        let converted = !column_unit.is_empty() && column_unit != unit;
        let column_unit = if converted { column_unit } else { unit };
        let factor = if converted {
            match convert_factor(&Unit::parse(column_unit)?, &Unit::parse(unit)?) {
                Ok(factor) => Some(factor),
                Err(UnitError::Offset { .. }) => None,
                Err(other) => return Err(other),
            }
        } else {
            Some(1.0)
        };
        Ok(Self { column_unit: column_unit.to_owned(), unit: unit.to_owned(), factor })
    }

    pub fn text(&self) -> String {
        if self.column_unit == self.unit {
            return self.unit.clone();
        }
        let factor = self.factor.map_or_else(String::new, |f| format!(" (x {})", number(f)));
        format!("{} -> {}{factor}", self.column_unit, self.unit)
    }
}

/// One channel in one recording, in the channel's unit.
#[derive(Serialize)]
pub struct Stretch {
    pub recording: String,
    pub range: [f64; 2],
    /// Standard deviation.
    pub sd: f64,
}

/// A measured channel over all recordings, in its unit.
#[derive(Serialize)]
pub struct Channel {
    pub name: String,
    pub column: String,
    #[serde(flatten)]
    pub conversion: Conversion,
    pub range: [f64; 2],
    pub noise_sd: f64,
    /// Standard deviation of the motion over that of the noise; none where no noise is seen.
    pub signal_to_noise: Option<f64>,
    pub quantum: Option<f64>,
    /// Samples that were left out as outliers, in each recording that has any.
    pub outliers: Vec<Marks>,
    /// Leaps by a turn of an angle that was recorded within one, and made continuous.
    pub leaps: Vec<Marks>,
    /// Samples on which the sensor was at the end of its range, treated as not measured.
    pub saturated: Vec<Marks>,
    pub recordings: Vec<Stretch>,
}

/// Samples of one channel in one recording.
#[derive(Serialize)]
pub struct Marks {
    pub recording: String,
    pub count: usize,
    /// Times of the first few (s).
    pub first_s: Vec<f64>,
}

/// Times of marks that are told: enough to find them in a plot.
const TOLD: usize = 3;

impl Marks {
    fn of(data: &Dataset, rows: impl Fn(&Observed) -> &[usize]) -> Vec<Self> {
        let marks = data.recordings.iter().map(|r| Self {
            recording: r.name.clone(),
            count: rows(r).len(),
            first_s: rows(r).iter().take(TOLD).map(|&row| r.times[row]).collect(),
        });
        marks.filter(|m| m.count > 0).collect()
    }

    /// How many, in which recordings, and when.
    pub fn text(all: &[Self]) -> String {
        let one = |m: &Self| {
            let mut times: Vec<String> = m.first_s.iter().map(|&t| number(t)).collect();
            if m.count > TOLD {
                times.push("...".to_owned());
            }
            format!("{} in {} (at {} s)", m.count, m.recording, times.join(", "))
        };
        all.iter().map(one).collect::<Vec<_>>().join(", ")
    }
}

/// An input over all recordings, in its unit.
#[derive(Serialize)]
pub struct Input {
    pub name: String,
    pub column: String,
    /// Whether it is a coordinate whose motion is imposed.
    pub imposed: bool,
    #[serde(flatten)]
    pub conversion: Conversion,
    pub range: [f64; 2],
    pub rms: f64,
    /// Standard deviation.
    pub sd: f64,
    /// Order of persistent excitation.
    pub order: usize,
    pub recordings: Vec<Stretch>,
    #[serde(skip)]
    pub series: Vec<Vec<f64>>,
}

impl Input {
    pub fn excitation_text(&self) -> String {
        match self.order {
            0 => "none: never changes".to_owned(),
            DELAYS => format!("order {DELAYS} or more"),
            order => format!("order {order}"),
        }
    }
}

/// The measured channels.
pub fn channels(
    model: &Model,
    recordings: &[Recording],
    data: &Dataset,
) -> Result<Vec<Channel>, Box<dyn Error>> {
    let channel = |(k, output): (usize, &crate::discrepancy::Output)| {
        let (column, column_unit) = column_of(model, output.of, &output.name);
        let series: Vec<&[f64]> = data.recordings.iter().map(|r| r.outputs[k].as_slice()).collect();
        let stretches = stretches(recordings, &series);
        let noise = data.noise[k];
        let variance = weighted_variance(&stretches, &series) - noise.sd * noise.sd;
        let signal = variance.max(0.0).sqrt();
        Ok(Channel {
            conversion: conversion(&recordings[0], &column, &column_unit, &output.unit)?,
            name: output.name.clone(),
            column,
            range: whole(&stretches),
            noise_sd: noise.sd,
            signal_to_noise: (noise.sd > 0.0).then(|| signal / noise.sd),
            quantum: noise.quantum,
            outliers: Marks::of(data, |r| &r.cleaned[k].outliers),
            leaps: Marks::of(data, |r| &r.cleaned[k].leaps),
            saturated: Marks::of(data, |r| &r.cleaned[k].saturated),
            recordings: stretches,
        })
    };
    data.outputs.iter().enumerate().map(channel).collect()
}

/// What drives the model from outside: a name, its unit, what is recorded of it, and its column of
/// the commands.
type Driver = (String, String, Measured, usize);

/// The inputs, then the imposed coordinates.
pub fn inputs(
    model: &Model,
    recordings: &[Recording],
    data: &Dataset,
) -> Result<Vec<Input>, Box<dyn Error>> {
    let commanded = model.inputs.iter().enumerate().map(|(j, input)| -> Driver {
        (input.name.clone(), input.unit.clone(), Measured::Input(j), j)
    });
    let imposed = model.imposed().filter_map(|c| -> Option<Driver> {
        let (name, unit) = (model.state_name(c).to_owned(), model.state_unit(c));
        Some((name, unit, Measured::State(c), model.motion_index(c)?))
    });
    let input = |(name, unit, of, at): Driver| {
        let (column, column_unit) = column_of(model, of, &name);
        let series: Vec<Vec<f64>> = data.recordings.iter().map(|r| r.command(at)).collect();
        let slices: Vec<&[f64]> = series.iter().map(Vec::as_slice).collect();
        let stretches = stretches(recordings, &slices);
        let excitation = excitation(&series);
        Ok(Input {
            conversion: conversion(&recordings[0], &column, &column_unit, &unit)?,
            name,
            column,
            imposed: matches!(of, Measured::State(_)),
            range: whole(&stretches),
            rms: excitation.rms,
            sd: excitation.sd,
            order: excitation.order,
            recordings: stretches,
            series,
        })
    };
    commanded.chain(imposed).map(input).collect()
}

/// Coordinates, velocities and states that no column measures directly and nothing imposes.
pub fn not_measured(model: &Model, data: &Dataset) -> Vec<String> {
    (0..model.machine_states())
        .filter(|&i| data.output_of_state(i).is_none() && !model.is_imposed_state(i))
        .map(|i| model.state_name(i).to_owned())
        .collect()
}

/// Columns of any recording that are neither time nor a channel nor an input.
pub fn not_used(
    model: &Model,
    recordings: &[Recording],
    channels: &[Channel],
    inputs: &[Input],
) -> Vec<String> {
    let declared = model.measurements.iter().map(|m| &m.column);
    let found = channels.iter().map(|c| &c.column).chain(inputs.iter().map(|u| &u.column));
    let used: Vec<&String> = declared.chain(found).collect();
    let mut names: Vec<String> = Vec::new();
    for column in recordings.iter().flat_map(|r| &r.columns) {
        if !used.contains(&&column.name) && !names.contains(&column.name) {
            names.push(column.name.clone());
        }
    }
    names
}

/// The column that measures a quantity, and its unit where the model states one.
fn column_of(model: &Model, of: Measured, name: &str) -> (String, String) {
    // Several columns may show one channel, or hold expressions: each carries its column's name.
    let by_column = matches!(of, Measured::Force(_) | Measured::Output(_));
    let mut all = model.measurements.iter().filter(|m| by_column || m.of == of);
    let own = all.clone().find(|m| m.column == name);
    match own.or_else(|| all.next().filter(|_| !by_column)) {
        Some(m) => (m.column.clone(), m.unit.clone()),
        None => (name.to_owned(), String::new()),
    }
}

fn conversion(
    recording: &Recording,
    column: &str,
    column_unit: &str,
    unit: &str,
) -> Result<Conversion, Box<dyn Error>> {
    Conversion::of(column_unit, unit)
        .map_err(|e| format!("{}: column '{column}': {e}", recording.name).into())
}

fn stretches(recordings: &[Recording], series: &[&[f64]]) -> Vec<Stretch> {
    recordings
        .iter()
        .zip(series)
        .map(|(r, values)| {
            let present = || values.iter().copied().filter(|v| v.is_finite());
            let count = present().count().max(1) as f64;
            let mean = present().sum::<f64>() / count;
            Stretch {
                recording: r.name.clone(),
                range: [
                    present().fold(f64::INFINITY, f64::min),
                    present().fold(f64::NEG_INFINITY, f64::max),
                ],
                sd: (present().map(|v| (v - mean).powi(2)).sum::<f64>() / count).sqrt(),
            }
        })
        .collect()
}

fn whole(stretches: &[Stretch]) -> [f64; 2] {
    let low = stretches.iter().map(|s| s.range[0]).fold(f64::INFINITY, f64::min);
    let high = stretches.iter().map(|s| s.range[1]).fold(f64::NEG_INFINITY, f64::max);
    [low, high]
}

/// Mean over the samples of the variance within each recording.
fn weighted_variance(stretches: &[Stretch], series: &[&[f64]]) -> f64 {
    let counts = series.iter().map(|s| s.iter().filter(|v| v.is_finite()).count() as f64);
    let (sum, count) = stretches
        .iter()
        .zip(counts)
        .fold((0.0, 0.0), |(sum, n), (s, count)| (sum + count * s.sd * s.sd, n + count));
    sum / f64::max(count, 1.0)
}
