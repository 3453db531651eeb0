//! What drives the machine beside what was recorded, in the model's units.

use super::outcome::Ladder;
use crate::diagnosis::{Driving, InputNoise, RandomForce};

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
        Driving { inputs: inputs.collect(), forces: forces.collect() }
    }

    /// The same in words.
    pub(super) fn says_driving(&self) -> Vec<String> {
        let Driving { inputs, forces } = self.driving();
        let inputs = inputs.iter().map(|(name, n)| {
            let InputNoise { std, share, unit } = n;
            let of_spread = match share.is_finite() {
                true => format!(" ({:.1} % of its spread)", 100.0 * share),
                false => String::new(),
            };
            let mut stated = self.problem.model.inputs.iter().filter(|i| i.noise.is_some());
            let by = match stated.any(|i| i.name == *name) {
                true => ", as the model says",
                false => "",
            };
            format!(
                "The recorded {name} is not quite what the machine got: they differ by noise of {std:.2e} {unit} a sample{of_spread}{by}."
            )
        });
        let forces = forces.iter().map(|(name, n)| {
            format!(
                "A random force on {name}, which no law explains, drives the machine: {:.2e} {}.",
                n.intensity, n.unit
            )
        });
        inputs.chain(forces).collect()
    }
}
