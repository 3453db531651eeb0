//! Angles made continuous, outliers and samples of sensors at their limits left out, as every command
//! does it
//! ([`crate::recordings::condition`]).

use super::columns::{ColumnUnit, Columns};
use super::motion::Noise;
use crate::recordings::{Recording, Unit, condition, conditioning_notes, unwrap_turns};
use serde::Serialize;
use std::collections::{BTreeMap, BTreeSet};
use std::error::Error;

/// Noise is never taken for smaller than this share of a channel's largest value: a noise-free
/// simulation has rounding errors too.
const ROUNDING: f64 = 1e-7;
/// Units of angles in which a column without a unit may have been recorded within one turn.
const ANGLES: [&str; 2] = ["rad", "deg"];

/// What conditioning did, by column.
#[derive(Debug, Default, Serialize)]
pub struct Conditioning {
    /// Samples that were left out as outliers.
    outliers: BTreeMap<String, usize>,
    /// How often angles leapt by whole turns.
    leaps: BTreeMap<String, usize>,
    /// Samples on which a sensor was at the end of its range.
    saturated: BTreeMap<String, usize>,
    /// Columns without a unit that leap as an angle in this unit would.
    #[serde(skip)]
    unsaid: BTreeMap<String, &'static str>,
}

impl Conditioning {
    /// Conditions the channels and velocities of some recordings; returns their noise.
    ///
    /// # Errors
    /// Columns that are missing or cannot be conditioned.
    pub fn condition(
        &mut self,
        columns: &Columns,
        units: &[ColumnUnit],
        recordings: &mut [Recording],
    ) -> Result<Noise, Box<dyn Error>> {
        let velocities = columns.velocities.iter().flatten();
        let used: BTreeSet<&String> = columns.channels.iter().chain(velocities).collect();
        let mut sd = BTreeMap::new();
        for name in used {
            let unit = units.iter().find(|u| u.column == *name).map_or("", |u| &u.unit);
            sd.insert(name, self.column(name, unit, recordings)?);
        }
        let channels = columns.channels.iter().map(|name| sd[name]).collect();
        let velocities = columns.velocities.iter().map(|v| v.as_ref().map(|v| sd[v])).collect();
        Ok(Noise { channels, velocities })
    }

    /// The same of one column; its noise standard deviation.
    fn column(
        &mut self,
        name: &str,
        unit: &str,
        recordings: &mut [Recording],
    ) -> Result<f64, Box<dyn Error>> {
        let first = recordings[0].name.clone();
        let mut series = Vec::new();
        for r in recordings {
            r.column(name)?;
            let columns = r.columns.iter_mut().filter(|c| c.name == name);
            series.extend(columns.map(|c| (&r.time[..], &mut c.values[..])));
        }
        if unit.is_empty()
            && let Some(angle) = angle(&series)
        {
            self.unsaid.insert(name.to_owned(), angle);
        }
        let (cleaned, noise) =
            condition(&mut series, unit).map_err(|e| format!("{first}: column '{name}': {e}"))?;
        let outliers = cleaned.iter().map(|c| c.outliers.len());
        let leaps = cleaned.iter().map(|c| c.leaps.len());
        let saturated = cleaned.iter().map(|c| c.saturated.len());
        add(&mut self.outliers, name, outliers.sum());
        add(&mut self.leaps, name, leaps.sum());
        add(&mut self.saturated, name, saturated.sum());
        let values = series.iter().flat_map(|(_, values)| values.iter());
        let largest = values.filter(|v| v.is_finite()).fold(0.0f64, |m, v| m.max(v.abs()));
        Ok(noise.sd.max(ROUNDING * largest).max(f64::MIN_POSITIVE))
    }

    /// What was done, in words.
    pub fn notes(&self) -> Vec<String> {
        let mut notes = conditioning_notes(&self.outliers, &self.saturated, self.leaps.keys());
        for (name, unit) in &self.unsaid {
            notes.push(format!(
                "column '{name}' leaps as an angle in {unit} does that is recorded within one turn; with \
                 --units {name}={unit} it is made continuous"
            ));
        }
        notes
    }
}

fn add(counts: &mut BTreeMap<String, usize>, name: &str, count: usize) {
    if count > 0 {
        *counts.entry(name.to_owned()).or_default() += count;
    }
}

/// The unit of angles in which these series would leap by whole turns.
fn angle(series: &[(&[f64], &mut [f64])]) -> Option<&'static str> {
    ANGLES.into_iter().find(|unit| {
        let turn = Unit::parse(unit).ok().and_then(|unit| unit.turn());
        let leaps = |turn: f64| {
            series
                .iter()
                .any(|(time, values)| !unwrap_turns(time, &mut values.to_vec(), turn).is_empty())
        };
        turn.is_some_and(leaps)
    })
}
