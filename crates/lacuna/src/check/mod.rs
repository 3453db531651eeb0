//! What `check` does: what is in the recordings, do they fit the model, is the excitation rich
//! enough.

mod channels;
mod excitation;
mod parameters;
mod velocities;
mod warnings;

use crate::discrepancy::Dataset;
use crate::plants::{Hold, Model};
use crate::recordings::{Log, Recording};
use crate::table::{Table, number};
use channels::{Channel, Input, Marks, Run};
use parameters::Parameters;
use serde::Serialize;
use velocities::Velocity;

/// All that is said of the recordings.
#[derive(Serialize)]
pub struct Report {
    model: String,
    recordings: Vec<Run>,
    input_hold: &'static str,
    channels: Vec<Channel>,
    /// Velocities that are measured with their coordinates.
    velocities: Vec<Velocity>,
    inputs: Vec<Input>,
    /// Coordinates, velocities and states that no column measures.
    not_measured: Vec<String>,
    /// Columns that are not used.
    not_used: Vec<String>,
    parameters: Parameters,
    warnings: Vec<String>,
}

impl Report {
    /// Look at the recordings with the eyes of a model.
    ///
    /// # Errors
    /// What does not fit the model, with the names of the recording and column.
    pub fn of(model: &Model, logs: Vec<Log>) -> Result<Self, Box<dyn std::error::Error>> {
        let runs = logs.iter().map(Run::of).collect();
        let (recordings, others): (Vec<Recording>, Vec<Vec<String>>) =
            logs.into_iter().map(|log| (log.recording, log.others)).unzip();
        let recordings = &recordings[..];
        let dataset = &Dataset::new(model, recordings)?;
        let mut report = Self {
            model: model.name.clone(),
            recordings: runs,
            input_hold: match model.hold {
                Hold::ZeroOrder => "zero-order",
                Hold::BandLimited => "band-limited",
                Hold::Linear => "linear",
            },
            channels: channels::channels(model, recordings, dataset)?,
            velocities: velocities::velocities(model, dataset),
            inputs: channels::inputs(model, recordings, dataset)?,
            not_measured: channels::not_measured(model, dataset),
            not_used: Vec::new(),
            parameters: Parameters::of(model, dataset),
            warnings: Vec::new(),
        };
        report.not_used = channels::not_used(model, recordings, &report.channels, &report.inputs);
        for name in others.into_iter().flatten() {
            if !report.not_used.contains(&name) {
                report.not_used.push(name);
            }
        }
        report.warnings = warnings::warnings(model, &report);
        Ok(report)
    }

    /// What to mind, the gravest first.
    pub fn warnings(&self) -> &[String] {
        &self.warnings
    }

    /// All but the warnings, as tables.
    pub fn text(&self) -> String {
        let count = self.recordings.len();
        let plural = if count == 1 { "" } else { "s" };
        let mut out = format!("{}: {count} recording{plural}\n\n", self.model);
        out += &self.recordings_text();
        out += &self.channels_text();
        out += &self.inputs_text();
        out += &self.parameters.text();
        let list = |what: &str, names: &[String]| match names {
            [] => String::new(),
            names => format!("{what}: {}\n", names.join(", ")),
        };
        out += &list("Columns that are not used", &self.not_used);
        out += &list("No column measures", &self.not_measured);
        if self.warnings.is_empty() {
            out += "The recordings fit the model; no warnings.\n";
        }
        out
    }

    fn recordings_text(&self) -> String {
        let mut table = Table::new(&[
            "recording",
            "rows",
            "from s",
            "to s",
            "step s",
            "jitter",
            "sampling",
            "gaps",
            "missing values",
        ]);
        for r in &self.recordings {
            table.row(vec![
                r.name.clone(),
                r.rows.to_string(),
                number(r.from_s),
                number(r.to_s),
                number(r.step_s),
                format!("{:.1} %", 100.0 * r.jitter),
                if r.uniform { "uniform" } else { "uneven" }.to_owned(),
                match r.gaps {
                    0 => "none".to_owned(),
                    gaps => format!("{gaps} ({} rows dropped)", r.dropped_rows),
                },
                r.missing_text(),
            ]);
        }
        table.text() + "\n" + &self.clocks_text()
    }

    /// The clocks of logs of several topics.
    fn clocks_text(&self) -> String {
        let with_clocks = || self.recordings.iter().filter(|r| !r.clocks.is_empty());
        if with_clocks().next().is_none() {
            return String::new();
        }
        let mut table = Table::new(&[
            "topic",
            "recording",
            "samples",
            "rate Hz",
            "times",
            "offset s",
            "delay s",
            "same time",
        ]);
        for (run, clock) in with_clocks().flat_map(|r| r.clocks.iter().map(move |c| (r, c))) {
            table.row(vec![
                clock.topic.clone(),
                run.name.clone(),
                clock.samples.to_string(),
                clock.rate_hz.map_or_else(|| "one sample".to_owned(), number),
                if clock.stamped { "stamps of the messages" } else { "when logged" }.to_owned(),
                number(clock.offset_s),
                number(clock.delay_s),
                clock.repeated.to_string(),
            ]);
        }
        let rows = |r: &Run| r.clocks.first().map(|c| format!("{} in {}", c.topic, r.name));
        let rows: Vec<String> = with_clocks().filter_map(rows).collect();
        table.text()
            + &format!(
                "  Rows are the samples of {}; other topics are brought onto their times. Offset: what was\n  \
                 added to stamps of another clock; delay: from stamp to logging (median); same time: messages\n  \
                 that a later one of the same time replaces.\n\n",
                rows.join(", ")
            )
    }

    fn channels_text(&self) -> String {
        let mut table = Table::new(&[
            "channel",
            "column",
            "unit",
            "range",
            "noise sd",
            "signal/noise",
            "quantum",
        ]);
        for c in &self.channels {
            table.row(vec![
                c.name.clone(),
                c.column.clone(),
                c.conversion.text(),
                format!("{} .. {}", number(c.range[0]), number(c.range[1])),
                number(c.noise_sd),
                c.signal_to_noise.map_or_else(|| "no noise seen".to_owned(), number),
                c.quantum.map_or_else(|| "none seen".to_owned(), number),
            ]);
        }
        table.text() + &self.samples_text() + "\n"
    }

    /// What is particular of the channels' samples.
    fn samples_text(&self) -> String {
        let mut out = String::new();
        for c in &self.channels {
            let (name, unit) = (&c.name, &c.conversion.unit);
            if let Some(quantum) = c.quantum {
                let ratio = number(quantum / c.noise_sd);
                let quantum = number(quantum);
                out += &format!(
                    "  {name} is quantised in steps of {quantum} {unit}, {ratio} times its noise.\n"
                );
            }
            if !c.leaps.is_empty() {
                let leaps = Marks::text(&c.leaps);
                out += &format!(
                    "  {name} is an angle recorded within one turn, and made continuous. Leaps: \
                     {leaps}.\n"
                );
            }
            if !c.saturated.is_empty() {
                let saturated = Marks::text(&c.saturated);
                out += &format!(
                    "  {name}: the sensor is at the end of its range; these samples are treated as not \
                     measured: {saturated}.\n"
                );
            }
            if !c.outliers.is_empty() {
                let outliers = Marks::text(&c.outliers);
                out += &format!(
                    "  {name}: outliers, which neither noise nor motion explains, are left out: \
                     {outliers}.\n"
                );
            }
        }
        out
    }

    fn inputs_text(&self) -> String {
        if self.inputs.is_empty() {
            return "The model has no input.\n\n".to_owned();
        }
        let mut table = Table::new(&["input", "column", "unit", "range", "rms", "excitation"]);
        for u in &self.inputs {
            table.row(vec![
                u.name.clone(),
                u.column.clone(),
                u.conversion.text(),
                format!("{} .. {}", number(u.range[0]), number(u.range[1])),
                number(u.rms),
                u.excitation_text(),
            ]);
        }
        let most = excitation::DELAYS;
        table.text()
            + &self.between_samples()
            + &format!(
                "  Order of persistent excitation: how many of {most} delayed copies are\n  \
                 independent; a sum of k sinusoids has 2k, a constant none.\n\n"
            )
    }

    /// What inputs and imposed coordinates do between samples.
    fn between_samples(&self) -> String {
        let held = format!("  Held {} between samples.\n", self.input_hold);
        let imposed: Vec<_> =
            self.inputs.iter().filter(|u| u.imposed).map(|u| u.name.as_str()).collect();
        let all = imposed.len() == self.inputs.len();
        let smooth = format!(
            "  Imposed motion, along its smoothed path between samples: {}.\n",
            imposed.join(", ")
        );
        match (all, imposed.is_empty()) {
            (true, _) => smooth,
            (false, true) => held,
            (false, false) => held + &smooth,
        }
    }
}
