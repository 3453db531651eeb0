//! What drives the machine beside what was recorded, in the model's units.

use super::outcome::Ladder;
use crate::diagnosis::{Driving, InputNoise, RandomForce};
use crate::likelihood::coloured::Colour;
use crate::likelihood::intensity;
use crate::number;

impl Ladder<'_> {
    /// Noise on the inputs and random forces that the likelihood found.
    pub(super) fn driving(&self) -> Driving {
        let model = self.problem.model;
        let Some(noise) = &self.found.chosen.noise else { return Driving::default() };
        let inputs = model.inputs.iter().zip(&noise.inputs).enumerate();
        let inputs = inputs.filter(|(_, (_, s))| **s > 0.0).map(|(j, (input, &std))| {
            let share = std / self.problem.input_deviation(j);
            (input.name.clone(), InputNoise { std, share, unit: input.unit.clone() })
        });
        let forces = noise.forces.iter().enumerate().filter(|(_, s)| **s > 0.0);
        let forces = forces.map(|(c, &intensity)| {
            let unit = format!("{} s^0.5", model.force_unit(c));
            let share = intensity / (self.problem.force_scale(c) * self.problem.sample.sqrt());
            (model.channel_name(c).to_owned(), RandomForce { intensity, share, unit })
        });
        let outputs = self.problem.dataset.outputs.iter().zip(&noise.outputs);
        let outputs = outputs.filter(|(_, r)| **r > 1.0).map(|(o, r)| (o.name.clone(), *r));
        Driving { inputs: inputs.collect(), forces: forces.collect(), outputs: outputs.collect() }
    }

    /// The same in words.
    pub(super) fn says_driving(&self) -> Vec<String> {
        let Driving { inputs, forces, outputs } = self.driving();
        // What rounds to nothing keeps a filter on the track of a machine that runs away, and is nothing to be told.
        let inputs = inputs.iter().filter_map(|(name, n)| {
            let InputNoise { std, share, unit } = n;
            let of_spread = match share.is_finite() {
                true => format!(" ({} % of its spread)", percent(*share)?),
                false => String::new(),
            };
            let mut stated = self.problem.model.inputs.iter().filter(|i| i.noise.is_some());
            let by = match stated.any(|i| i.name == *name) {
                true => ", as the model says",
                false => "",
            };
            Some(format!(
                "The recorded {name} is not quite what the machine got: they differ by noise of {std:.2e} {unit} a sample{of_spread}{by}."
            ))
        });
        let forces = forces.iter().filter(|(_, n)| percent(n.share).is_some()).map(|(name, n)| {
            format!(
                "A random force on {name}, which no law explains, drives the machine: {:.2e} {}.",
                n.intensity, n.unit
            )
        });
        let outputs = outputs.iter().filter(|(_, over)| format!("{over:.1}") != "1.0");
        let outputs = outputs.map(|(name, over)| {
            // More is not looked for.
            let most = if *over > intensity::LARGEST / intensity::ROUGH { "at least " } else { "" };
            let over = number::ratio(*over);
            format!(
                "What was recorded of {name} is {most}{over} times as far from the truth as it seems from sample to sample, as behind a filter."
            )
        });
        inputs.chain(forces).chain(outputs).collect()
    }

    /// Noise that samples do not show: what is correlated in time differs little from one to the next.
    pub(super) fn says_coloured(&self) -> Vec<String> {
        if !self.found.coloured {
            return vec![];
        }
        let colours = intensity::coloured(&self.found.chosen).unwrap_or_default();
        let named = self.problem.dataset.outputs.iter().zip(colours);
        let worth = named.filter(|(_, c)| c.gain > self.decision.prior_odds);
        let words = worth.map(|(output, Colour { deviation, time, .. })| {
            format!(
                "The noise of {} is {deviation:.1} times what it seems from sample to sample: it is correlated over {}.",
                output.name,
                number::plain(time, "s")
            )
        });
        words.collect()
    }
}

/// A share in percent; none where it rounds to nothing.
fn percent(share: f64) -> Option<String> {
    Some(format!("{:.1}", 100.0 * share)).filter(|rounded| rounded != "0.0")
}
