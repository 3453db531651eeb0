//! Which effect could act where: the catalogue spread over a model's channels and inputs.

use crate::trajectories::SmoothedRecording;
use crate::weak::{Column, WeakForm};
use lacuna_effects::{Acts, CATALOGUE, Effect, Law, Scales, Variable};
use lacuna_plants::Model;

/// An effect on a channel (or input), its shape still open.
#[derive(Clone, Copy, Debug)]
pub struct Candidate {
    /// The catalogue's entry.
    pub effect: &'static Effect,
    /// Force channel or input.
    pub channel: usize,
    /// The other force channel of a coupling.
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
    /// Shape of a force law; all parameters of an input law.
    pub shape: Vec<f64>,
}

/// Every candidate on the measured channels and the inputs of a model. Effects that the
/// model has already are left out.
#[must_use]
pub fn candidates(model: &Model, channels: &[usize]) -> Vec<Candidate> {
    let mut out = Vec::new();
    for &effect in CATALOGUE {
        match effect.law {
            Law::Force(_) => {
                for &channel in channels.iter().filter(|&&c| acts_on(effect, model, c)) {
                    out.extend(partners(effect, channel, channels).map(|other| Candidate {
                        effect,
                        channel,
                        other,
                    }));
                }
            }
            Law::Input(_) => out.extend((0..model.inputs.len()).map(|channel| Candidate {
                effect,
                channel,
                other: None,
            })),
            // What sensors do wrong shows in the prediction, not as a force.
            Law::Sensor(_) => {}
        }
    }
    let present = |c: &Candidate| {
        model.effects.iter().any(|e| {
            e.effect.class == c.effect.class && e.channel == c.channel && e.other == c.other
        })
    };
    out.retain(|c| !present(c));
    out
}

fn acts_on(effect: &Effect, model: &Model, channel: usize) -> bool {
    match effect.acts {
        Acts::Coordinates => model.is_coordinate(channel),
        Acts::States => !model.is_coordinate(channel),
        _ => true,
    }
}

/// The other channels of a coupling; a spring between two channels counts once.
fn partners(
    effect: &'static Effect,
    channel: usize,
    channels: &[usize],
) -> impl Iterator<Item = Option<usize>> {
    let couples = effect.depends_on.contains(&Variable::OtherCoordinate)
        || effect.depends_on.contains(&Variable::OtherVelocity);
    let symmetric = matches!(effect.law, Law::Force(law) if law.reacts());
    let others: Vec<_> = if couples {
        let fits = |o: &&usize| **o != channel && (!symmetric || **o > channel);
        channels.iter().filter(fits).map(|&o| Some(o)).collect()
    } else {
        vec![None]
    };
    others.into_iter()
}

/// Laws of dry friction: variants of one kind of physics, of which a channel has one.
const DRY_FRICTION: [&str; 3] = ["coulomb_friction", "stribeck_friction", "asymmetric_friction"];

impl Candidate {
    /// Whether another candidate is no addition to this one: it is the same, or a variant of
    /// the same kind of physics in the same place.
    #[must_use]
    pub fn excludes(&self, other: &Self) -> bool {
        let dry = |c: &Self| DRY_FRICTION.contains(&c.effect.class);
        self == other || (self.channel == other.channel && dry(self) && dry(other))
    }

    /// Shapes to screen on recordings of these scales.
    #[must_use]
    pub fn shapes(&self, scales: &Scales) -> Vec<Vec<f64>> {
        match self.effect.law {
            Law::Force(law) => law.shapes(scales),
            Law::Input(law) => law.shapes(scales),
            Law::Sensor(_) => vec![],
        }
    }

    /// Magnitudes of the channel or input it acts on.
    #[must_use]
    pub fn scales(&self, weak: &WeakForm) -> Scales {
        let model = weak.model();
        let recordings: Vec<_> = weak.smoothed().collect();
        let force = matches!(self.effect.law, Law::Force(_));
        let series = |value: &dyn Fn(&SmoothedRecording, usize) -> f64| -> Vec<f64> {
            recordings.iter().flat_map(|s| (0..s.len()).map(move |k| value(s, k))).collect()
        };
        let (q, v) = if force {
            (
                series(&|s, k| s.local(self.channel, None, k).q),
                series(&|s, k| s.local(self.channel, None, k).v),
            )
        } else {
            (vec![0.0], vec![0.0])
        };
        let u = if force {
            vec![0.0]
        } else {
            let m = model.inputs.len();
            series(&|s, k| s.commands[k * m + self.channel])
        };
        let largest = u.iter().fold(0.0f64, |a, b| a.max(b.abs()));
        let first = recordings[0];
        let steps = (first.len() - 1) as f64;
        let begin = recordings.iter().map(|r| r.times[0]).fold(f64::INFINITY, f64::min);
        let end = recordings.iter().map(|r| r.times[r.len() - 1]).fold(f64::NEG_INFINITY, f64::max);
        Scales {
            q: range(&q),
            v: deviation(&v),
            input: (deviation(&u), largest),
            step: (first.times[first.len() - 1] - first.times[0]) / steps,
            time: (begin, end),
        }
    }
}

impl Term {
    /// Columns of a force law, one an amplitude; none for an input law that is not linear in
    /// its parameter.
    #[must_use]
    pub fn columns(&self, weak: &WeakForm, parameters: &[f64]) -> Vec<Column> {
        let Candidate { effect, channel, other } = self.candidate;
        let Law::Force(law) = effect.law else { return vec![] };
        let reaction = other.filter(|_| law.reacts());
        (0..law.amplitudes())
            .map(|k| {
                weak.force_column(parameters, channel, reaction, |s| {
                    s.basis(law, &self.shape, channel, other).swap_remove(k)
                })
            })
            .collect()
    }

    /// Apply an input law to the inputs of a recording.
    pub fn transform(&self, times: &[f64], inputs: &mut [f64], width: usize) {
        let Law::Input(law) = self.candidate.effect.law else { return };
        let j = self.candidate.channel;
        let column: Vec<f64> = inputs.iter().skip(j).step_by(width).copied().collect();
        for (k, value) in law.transform(&self.shape, times, &column).into_iter().enumerate() {
            inputs[k * width + j] = value;
        }
    }
}

/// Smallest and largest value.
fn range(values: &[f64]) -> (f64, f64) {
    values.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), &v| (a.min(v), b.max(v)))
}

/// Standard deviation.
pub(crate) fn deviation(values: &[f64]) -> f64 {
    let n = values.len().max(1) as f64;
    let mean = values.iter().sum::<f64>() / n;
    (values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / n).sqrt()
}
