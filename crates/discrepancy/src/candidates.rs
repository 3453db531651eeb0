//! Which effect could act where: the catalogue spread over a model's channels and inputs.

use lacuna_effects::{Acts, CATALOGUE, Effect, Law, Scales, Variable};
use lacuna_plants::Model;
use lacuna_plants::model::ModelEffect;

/// An effect on a channel (or input), its shape still open.
#[derive(Clone, Copy, Debug)]
pub struct Candidate {
    /// The catalogue's entry.
    pub effect: &'static Effect,
    /// Force channel, input, state of the machine or link, whichever law it has.
    pub channel: usize,
    /// The other force channel of a coupling, or the input that a force law names.
    pub other: Option<usize>,
}

impl PartialEq for Candidate {
    fn eq(&self, other: &Self) -> bool {
        (self.effect.class, self.channel, self.other)
            == (other.effect.class, other.channel, other.other)
    }
}

/// A candidate with its shape (force laws) or its parameters (input laws).
#[derive(Clone, Debug)]
pub struct Term {
    /// What acts where.
    pub candidate: Candidate,
    /// Shape of a force law or one of structure; all parameters of an input law.
    pub shape: Vec<f64>,
}

impl Term {
    /// The effect that a law of inputs is with these parameters.
    pub(crate) fn as_effect(&self) -> ModelEffect {
        self.candidate.with(self.shape.clone())
    }
}

/// Every candidate on force channels, on the actuators and on the sensors of a model; sensors are
/// told by the entry of the machine's state that they measure. Effects that the model has
/// already are left out.
#[must_use]
pub fn candidates(model: &Model, sensors: &[usize]) -> Vec<Candidate> {
    let mut out = Vec::new();
    for &effect in CATALOGUE {
        match effect.law {
            Law::Force(_) => {
                for channel in (0..model.channels()).filter(|&c| acts_on(effect, model, c)) {
                    out.extend(partners(effect, channel, model).map(|other| Candidate {
                        effect,
                        channel,
                        other,
                    }));
                }
            }
            Law::Input(_) => {
                // What no actuator stands before reaches the machine as it was recorded.
                let all = model.actuators().filter(|&input| !model.states(effect, input));
                out.extend(all.map(|channel| Candidate { effect, channel, other: None }));
            }
            Law::Sensor(_) => out.extend(sensors.iter().map(|&channel| Candidate {
                effect,
                channel,
                other: None,
            })),
            Law::Structure(_) => {
                // A rotor's inertia says no more than is known.
                let all = 0..model.structures(effect).len();
                let all = all.filter(|&channel| model.tells_structure(effect.acts, channel));
                out.extend(all.map(|channel| Candidate { effect, channel, other: None }));
            }
        }
    }
    let present = |c: &Candidate| {
        model.effects.iter().any(|e| {
            let (here, there) = ((e.channel, e.other), (c.channel, c.other));
            let reversed = e.other.map(|o| (o, Some(e.channel))).filter(|_| e.effect.is_mutual());
            e.effect.class == c.effect.class && (here == there || reversed == Some(there))
        })
    };
    out.retain(|c| !present(c));
    out
}

fn acts_on(effect: &Effect, model: &Model, channel: usize) -> bool {
    match effect.acts {
        Acts::Coordinates => model.is_coordinate(channel),
        Acts::States => !model.is_coordinate(channel),
        Acts::CoordinatesAndSpeeds => model.may_rub(channel),
        _ => true,
    }
}

/// The other channels of a coupling, or the inputs that a law may name; a spring between two channels
/// counts once, as one of the later: models begin with what is driven.
fn partners(
    effect: &'static Effect,
    channel: usize,
    model: &Model,
) -> impl Iterator<Item = Option<usize>> {
    let others: Vec<_> = if effect.names_input() {
        model.inputs_about(channel).into_iter().map(Some).collect()
    } else if effect.couples() {
        let fits = |o: &usize| {
            *o != channel && (!effect.is_mutual() || *o < channel) && acts_on(effect, model, *o)
        };
        (0..model.channels()).filter(fits).map(Some).collect()
    } else {
        vec![None]
    };
    others.into_iter()
}

impl Candidate {
    /// That which an effect is.
    #[must_use]
    pub fn of(e: &ModelEffect) -> Self {
        Self { effect: e.effect, channel: e.channel, other: e.other }
    }

    /// The effect that it is with these physical parameters.
    pub(crate) fn with(&self, parameters: Vec<f64>) -> ModelEffect {
        let Self { effect, channel, other } = *self;
        let std = vec![None; parameters.len()];
        ModelEffect { effect, channel, other, parameters, std }
    }

    /// Whether another candidate is no addition to this one: it is the same, or a variant of
    /// the same kind of physics in the same place.
    #[must_use]
    pub fn excludes(&self, other: &Self) -> bool {
        self == other || (self.channel == other.channel && self.effect.is_kin_of(other.effect))
    }

    /// Whether it is a force that depends on nothing.
    #[must_use]
    pub fn is_constant(&self) -> bool {
        matches!(self.effect.law, Law::Force(_)) && self.effect.depends_on.is_empty()
    }

    /// Whether it is a sensor that says the same too much of whatever it measures.
    #[must_use]
    pub fn is_offset(&self) -> bool {
        let Law::Sensor(law) = self.effect.law else { return false };
        let truth = [0.0, 3.0, 1.0];
        let told = law.plain().applied(&[1.0], &[0.0, 1.0, 2.0], &truth);
        let mut errors = told.iter().zip(truth).map(|(told, truth)| told - truth);
        let first = errors.next().unwrap_or(0.0);
        first != 0.0 && errors.all(|error| error == first)
    }

    /// Whether it is a force of the channel's own motion that depends on these variables alone, and remembers
    /// nothing.
    #[must_use]
    pub fn says_only(&self, variables: &[Variable]) -> bool {
        let Law::Force(law) = self.effect.law else { return false };
        let own = law.memory() == 0 && self.other.is_none();
        own && self.effect.depends_on.iter().all(|v| variables.contains(v))
    }

    /// Shapes to screen on recordings of these scales.
    #[must_use]
    pub fn shapes(&self, scales: &Scales) -> Vec<Vec<f64>> {
        (self.effect.shapes)(scales)
    }

    /// Shapes for the forces that a measured motion needs: of a law that is not screened, because along a computed
    /// path it looks like the one that it is a variation of, those of that law written as it.
    #[must_use]
    pub fn shapes_of_forces(&self, scales: &Scales) -> Vec<Vec<f64>> {
        let own = self.shapes(scales);
        let Some(plain) = self.effect.nature.variation_of.filter(|_| own.is_empty()) else {
            return own;
        };
        let (Law::Force(law), Law::Force(of)) = (plain.law, self.effect.law) else { return own };
        let unit = vec![1.0; law.amplitudes()];
        let begun = (plain.shapes)(scales).into_iter().flat_map(|shape| {
            let internal: Vec<f64> = unit.iter().copied().chain(shape).collect();
            plain.written_as(self.effect, &law.physical(&internal), scales)
        });
        begun.map(|physical| of.internal(&physical).split_off(of.amplitudes())).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::{Candidate, candidates};
    use lacuna_effects::{CATALOGUE, Law};
    use lacuna_plants::Model;

    /// A level, a speed and a state of no unit that is known.
    const STATES: &str = r#"
        name = "tank and pump"

        [parameters]
        k = { value = 1.0, unit = "1/s" }

        [[state]]
        name = "h"
        unit = "m"
        derivative = "-k * h"

        [[state]]
        name = "w"
        unit = "rpm"
        derivative = "-k * w"

        [[state]]
        name = "x"
        derivative = "-k * x"

        [[measurement]]
        column = "h"
        of = "h"
    "#;

    #[test]
    fn only_what_moves_rubs() {
        let model = Model::from_text(STATES, "model.toml").expect("a model");
        for class in ["coulomb_friction", "asymmetric_friction"] {
            let of = |c: &&super::Candidate| c.effect.class == class;
            let all = candidates(&model, &[]);
            let channels: Vec<usize> = all.iter().filter(of).map(|c| c.channel).collect();
            assert_eq!(channels, [1, 2], "{class}");
        }
    }

    #[test]
    fn an_offset_is_the_same_whatever_is_measured() {
        let sensors = CATALOGUE.iter().filter(|e| matches!(e.law, Law::Sensor(_)));
        let candidates = sensors.map(|&effect| Candidate { effect, channel: 0, other: None });
        let offsets = candidates.filter(Candidate::is_offset).map(|c| c.effect.class);
        let offsets: Vec<&str> = offsets.collect();
        assert_eq!(offsets, ["sensor_bias"]);
    }
}
