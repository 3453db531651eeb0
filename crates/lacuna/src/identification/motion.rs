//! Smoothed motion between gaps: what the regression is given.

use super::columns::Columns;
use crate::occupation::TrajectoryData;
use crate::recordings::{
    InputHold, Prior, Recording, Sampling, Smoother, Trajectory, resample_input,
};
use std::error::Error;
use std::ops::Range;

/// Longest run of dropped rows or missing values that smoothing bridges, in rows.
const LONGEST_GAP: usize = 10;
/// Shortest stretch without a longer gap that is used, in rows.
const FEWEST_ROWS: usize = 30;

/// Noise standard deviations of the channels and of the velocities that are measured.
#[derive(Debug)]
pub struct Noise {
    /// Of the channels.
    pub channels: Vec<f64>,
    /// Of their velocities.
    pub velocities: Vec<Option<f64>>,
}

/// A part of a recording without long gaps.
#[derive(Debug)]
pub struct Stretch {
    /// Which recording, from 1.
    pub recording: usize,
    /// The smoothed state and the inputs.
    pub data: TrajectoryData,
    /// What was measured: the identification smooths by itself.
    pub measured: crate::occupation::Motion,
    /// Smoothed s-th derivative of the channels, N x n.
    pub highest: Vec<f64>,
    /// Smoothed derivative of the order below, N x n.
    pub below: Vec<f64>,
}

/// The stretches of some recordings.
#[derive(Debug)]
pub struct Motion {
    /// Names of the recordings.
    pub names: Vec<String>,
    /// Their stretches.
    pub stretches: Vec<Stretch>,
}

impl Motion {
    /// Cut recordings at long gaps and smooth what is between.
    ///
    /// # Errors
    /// Columns that are missing or cannot be smoothed, and recordings that are nothing but gaps.
    pub fn of(
        columns: &Columns,
        noise: &Noise,
        recordings: &[Recording],
        hold: InputHold,
    ) -> Result<Self, Box<dyn Error>> {
        let mut stretches = Vec::new();
        for (index, r) in recordings.iter().enumerate() {
            let parts = unbroken(columns, r)?;
            if parts.is_empty() {
                return Err(format!(
                    "{}: no stretch of {FEWEST_ROWS} rows without a gap of more than {LONGEST_GAP}",
                    r.name
                )
                .into());
            }
            for rows in parts {
                stretches.push(stretch(columns, noise, r, rows, hold, index + 1)?);
            }
        }
        let names = recordings.iter().map(|r| r.name.clone()).collect();
        Ok(Self { names, stretches })
    }
}

/// Rows between long gaps of the rows or of any channel.
fn unbroken(columns: &Columns, r: &Recording) -> Result<Vec<Range<usize>>, Box<dyn Error>> {
    let mut lost = vec![false; r.len()];
    for column in &columns.channels {
        let values = r.column(column)?;
        for run in missing_runs(values) {
            let at_an_end = run.start == 0 || run.end == r.len();
            if at_an_end || run.len() > LONGEST_GAP {
                lost[run].fill(true);
            }
        }
    }
    let mut break_after = vec![false; r.len()];
    for gap in Sampling::of(&r.time).gaps.iter().filter(|g| g.missing > LONGEST_GAP) {
        break_after[gap.after_row] = true;
    }
    let mut parts = Vec::new();
    let mut start = 0;
    for row in 0..r.len() {
        if lost[row] {
            parts.push(start..row);
            start = row + 1;
        } else if break_after[row] {
            parts.push(start..row + 1);
            start = row + 1;
        }
    }
    parts.push(start..r.len());
    parts.retain(|p| p.len() >= FEWEST_ROWS);
    Ok(parts)
}

fn missing_runs(values: &[f64]) -> Vec<Range<usize>> {
    let mut runs: Vec<Range<usize>> = Vec::new();
    for row in (0..values.len()).filter(|&row| values[row].is_nan()) {
        match runs.last_mut() {
            Some(run) if run.end == row => run.end = row + 1,
            _ => runs.push(row..row + 1),
        }
    }
    runs
}

fn stretch(
    columns: &Columns,
    noise: &Noise,
    r: &Recording,
    rows: Range<usize>,
    hold: InputHold,
    recording: usize,
) -> Result<Stretch, Box<dyn Error>> {
    let in_column = |column: &str, e: &dyn std::fmt::Display| -> Box<dyn Error> {
        format!("{}: column '{column}': {e}", r.name).into()
    };
    let time = &r.time[rows.clone()];
    let sampling = Sampling::of(time);
    let times = sampling.filled_times(time);
    let positions = sampling.positions(time.len());
    let filled = |column: &str| -> Result<Vec<f64>, Box<dyn Error>> {
        let mut series = vec![f64::NAN; times.len()];
        for (&at, &value) in positions.iter().zip(&r.column(column)?[rows.clone()]) {
            series[at] = value;
        }
        Ok(series)
    };
    let (n, m, order) = (columns.channels.len(), columns.inputs.len(), columns.order);
    let mut measured = vec![0.0; times.len() * n];
    let mut raw = vec![0.0; times.len() * n];
    let mut rates = vec![0.0; times.len() * n];
    let mut paths: Vec<Trajectory> = Vec::with_capacity(n);
    for (i, column) in columns.channels.iter().enumerate() {
        let values = filled(column)?;
        let rate = match &columns.velocities[i] {
            Some(velocity) => Some(filled(velocity)?),
            None => None,
        };
        let mut smoother = Smoother::new(Prior::WhiteJerk);
        if let (Some(rate), Some(sd)) = (&rate, noise.velocities[i]) {
            smoother = smoother.with_derivative(rate, sd);
        }
        let smoothed = smoother
            .smooth(&times, &values, noise.channels[i])
            .map_err(|e| in_column(column, &e))?;
        let path = smoothed.at(&times);
        for (k, value) in values.iter().enumerate() {
            raw[k * n + i] = *value;
            rates[k * n + i] = rate.as_ref().map_or(f64::NAN, |rate| rate[k]);
            measured[k * n + i] = if value.is_nan() { path.value[k] } else { *value };
        }
        paths.push(path);
    }
    let mut inputs = vec![0.0; times.len() * m];
    for (j, column) in columns.inputs.iter().enumerate() {
        let values = &r.column(column)?[rows.clone()];
        let held = resample_input(time, values, &times, hold).map_err(|e| in_column(column, &e))?;
        held.iter().enumerate().for_each(|(k, value)| inputs[k * m + j] = *value);
    }
    let in_recording = |e: crate::occupation::IdentificationError| format!("{}: {e}", r.name);
    let mut motion =
        crate::occupation::Motion::new(times.clone(), raw, inputs.clone()).map_err(in_recording)?;
    if order == 2 && columns.velocities.iter().all(Option::is_some) {
        motion = motion.with_rates(rates).map_err(in_recording)?;
    }
    if hold == InputHold::ZeroOrder {
        centre(&mut inputs, m);
    }
    let by_rows = |of: &dyn Fn(&Trajectory) -> &Vec<f64>| -> Vec<f64> {
        (0..times.len())
            .flat_map(|k| paths.iter().map(move |p| (k, p)))
            .map(|(k, p)| of(p)[k])
            .collect()
    };
    let value = by_rows(&|p| &p.value);
    let first = by_rows(&|p| &p.first);
    let (arguments, below, highest) = if order == 1 {
        (value.clone(), value, first)
    } else {
        let pairs = value.chunks_exact(n).zip(first.chunks_exact(n));
        let arguments = pairs.flat_map(|(q, v)| q.iter().chain(v).copied()).collect();
        (arguments, first, by_rows(&|p| &p.second))
    };
    let data = TrajectoryData::new(times.clone(), arguments, inputs, measured)
        .map_err(|e| format!("{}: {e}", r.name))?;
    Ok(Stretch { recording, data, measured: motion, highest, below })
}

/// A held input as quadrature on the samples must see it: half a step around each sample belongs
/// to the value before it. Without this every held input looks half a step early.
fn centre(inputs: &mut [f64], m: usize) {
    for k in (m..inputs.len()).rev() {
        inputs[k] = 0.5 * (inputs[k] + inputs[k - m]);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn runs_of_missing_values() {
        let nan = f64::NAN;
        assert_eq!(missing_runs(&[nan, 1.0, nan, nan, 2.0, nan]), [0..1, 2..4, 5..6]);
        assert!(missing_runs(&[1.0, 2.0]).is_empty());
    }

    #[test]
    fn a_held_input_is_seen_half_a_step_late() {
        // Two inputs, row after row: a step at the third sample, and a ramp.
        let mut inputs = [0.0, 0.0, 0.0, 1.0, 1.0, 2.0, 1.0, 3.0];
        centre(&mut inputs, 2);
        assert_eq!(inputs, [0.0, 0.0, 0.0, 0.5, 0.5, 1.5, 1.0, 2.5]);
    }
}
