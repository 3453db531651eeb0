//! What these data cannot tell apart from the truth.
//!
//! Each rival, an effect of one number, is given its best amplitude together with the best
//! parameters and initial states, by Gauss and Newton over the windows of the undisturbed motions. One
//! that then predicts them as well as the truth, to a few nats of the noise, is as good an answer:
//! no method could tell, whatever it claims.

use lacuna_effects::Law;
use lacuna_plants::Model;
use lacuna_plants::model::{ModelEffect, Uncertainty};

use super::places::{classes, places};
use super::plants::PlantSpec;
use super::scales::{ChannelScale, Scales};
use super::sealed::Name;
use super::sensor::Sensor;
use super::variants::Rival;
use super::windows::{Output, Shown, Windows};

/// Rivals within so many nats on the motions compared are as good.
const AS_GOOD: f64 = 3.0;
/// Linearised, a rival must come within this share of what no rival leaves, to be looked at.
const PROMISING: f64 = 0.5;
/// Steps of Gauss and Newton.
const STEPS: usize = 6;
/// A rival's trial amplitude, as a share of what would be a strong effect.
const TRIAL: f64 = 0.02;
/// Velocity over which the sign of a friction is smooth, as a share of the motion's.
const SMOOTH: f64 = 0.01;

/// A rival: its name, and what it is at an amplitude in units of its trial amplitude.
struct Candidate {
    name: Name,
    at: Box<dyn Fn(f64) -> Rival>,
}

/// Names of the rivals of a truth that these data cannot tell apart from it; `without` is the model
/// with the true parameters and all but the effect in question.
pub fn as_good(
    spec: &PlantSpec,
    without: &Model,
    scales: &Scales,
    shown: &[Shown],
    outputs: &[Output],
) -> Vec<Name> {
    let candidates = candidates(spec, without, scales, outputs);
    let rivals: Vec<Rival> = candidates.iter().map(|c| (c.at)(1.0)).collect();
    let Ok(windows) = Windows::linearised(without, shown, outputs, &rivals) else {
        return Vec::new();
    };
    let centred = vec![0.0; windows.parameters()];
    let nobody = windows.best(None, Some(&centred)).nats;
    let promising = candidates
        .iter()
        .enumerate()
        .filter(|(k, _)| windows.best(Some(*k), Some(&centred)).nats < PROMISING * nobody);
    let good = promising.filter(|(_, candidate)| {
        refined(candidate, without, shown, outputs).is_some_and(|nats| nats < AS_GOOD)
    });
    good.map(|(_, candidate)| candidate.name.clone()).collect()
}

/// Nats that a rival leaves at its best.
fn refined(
    candidate: &Candidate,
    without: &Model,
    shown: &[Shown],
    outputs: &[Output],
) -> Option<f64> {
    let uncertain: Vec<usize> =
        (0..without.parameters.len()).filter(|&k| without.parameters[k].std() > 0.0).collect();
    let mut offset = vec![0.0; uncertain.len()];
    let (mut amplitude, mut nats) = (0.0, f64::INFINITY);
    for _ in 0..STEPS {
        let mut believed = without.clone();
        for (k, offset) in uncertain.iter().zip(&offset) {
            let p = &mut believed.parameters[*k];
            let std = p.std();
            // The deviation stays that of the file, whatever the value.
            p.value += offset * std;
            p.uncertainty = Uncertainty::Absolute(std);
        }
        match (candidate.at)(amplitude) {
            Rival::Effect(effect) if amplitude != 0.0 => believed.effects.push(effect),
            _ => {}
        }
        let rival = [(candidate.at)(1.0)];
        let windows = Windows::linearised(&believed, shown, outputs, &rival).ok()?;
        let best = windows.best(Some(0), Some(&offset));
        nats = best.nats;
        offset.iter_mut().zip(&best.at).for_each(|(o, step)| *o += step);
        amplitude += best.at[uncertain.len()];
        if nats < AS_GOOD {
            break;
        }
        // A sensor that is wrong by a number is linear in it: one step is all.
        if let [Rival::Sensor(..)] = rival {
            break;
        }
    }
    Some(nats)
}

/// Effects of one number, on every channel, input and sensor.
fn candidates(
    spec: &PlantSpec,
    model: &Model,
    scales: &Scales,
    outputs: &[Output],
) -> Vec<Candidate> {
    let mut all = Vec::new();
    for effect in classes().filter(|e| !e.couples()) {
        for place in places(spec, model, effect) {
            let name = Name::new(effect.class, model.effect_channel_name(effect, place));
            let parameters: Option<Box<dyn Fn(f64) -> Vec<f64>>> = match effect.law {
                Law::Force(_) => force(effect.class, scales.channels[place]),
                Law::Input(_) => match effect.class {
                    "gain_error" => Some(Box::new(|a| vec![1.0 + TRIAL * a])),
                    _ => None,
                },
                Law::Sensor(_) | Law::Structure(_) => None,
            };
            if let Some(parameters) = parameters {
                let at = move |amplitude: f64| {
                    let parameters = parameters(amplitude);
                    let std = vec![None; parameters.len()];
                    let other = None;
                    Rival::Effect(ModelEffect { effect, channel: place, other, parameters, std })
                };
                all.push(Candidate { name, at: Box::new(at) });
            }
        }
    }
    for (k, output) in outputs.iter().enumerate() {
        let channel = model.state_name(output.entry);
        let mut add = |class: &str, at: Box<dyn Fn(f64) -> Rival>| {
            all.push(Candidate { name: Name::new(class, channel), at });
        };
        let unit = output.sd;
        add("sensor_scale", Box::new(move |a| Rival::Sensor(k, Sensor::Scale(1.0 + TRIAL * a))));
        add("sensor_bias", Box::new(move |a| Rival::Sensor(k, Sensor::Bias(a * unit))));
    }
    all
}

/// Parameters of a force effect of one amplitude.
fn force(class: &str, c: ChannelScale) -> Option<Box<dyn Fn(f64) -> Vec<f64>>> {
    let (half, v) = (c.half_range(), c.velocity);
    let unit = TRIAL * c.force;
    let unit = match class {
        "constant_force" | "coulomb_friction" | "gravity_torque" => unit,
        "viscous_friction" | "linear_loss" => unit / v,
        "quadratic_drag" | "quadratic_loss" => unit / (v * v),
        "linear_stiffness" => unit / half,
        "cubic_stiffness" => unit / half.powi(3),
        _ => return None,
    };
    let smooth = SMOOTH * v;
    Some(match class {
        "coulomb_friction" => Box::new(move |a| vec![a * unit, smooth]),
        _ => Box::new(move |a| vec![a * unit]),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::concealed::conceal::Concealed;
    use crate::concealed::draw::{Draft, generator};
    use crate::concealed::plants::PLANTS;
    use crate::concealed::sensor::seen;
    use crate::concealed::topic::Topic;

    /// The truth's own class is always as good as the truth: Gauss and Newton find its amplitude.
    #[test]
    fn the_truth_is_among_its_rivals() {
        for (class, stream) in
            [("quadratic_drag", 1), ("constant_force", 2), ("cubic_stiffness", 3)]
        {
            let effect = lacuna_effects::find(class).unwrap();
            let mut rng = generator(11, stream);
            let draft = loop {
                let drawn = Draft::draw(Topic::Effect(effect), PLANTS, &mut rng).unwrap();
                if let Some(draft) = drawn.filter(|d| d.nominal.name == "gantry") {
                    break draft;
                }
            };
            let motions = [0, 1].map(|k| draft.motion(k, draft.spec.samples, 8).unwrap());
            let series = |m| draft.outputs.iter().map(|o| seen(m, o.entry, None)).collect();
            let shown: Vec<Shown> = motions.iter().map(|m| (m, series(m))).collect();
            let without = &draft.calibrated;
            let good = as_good(draft.spec, without, &draft.scales, &shown, &draft.outputs);
            let [Concealed::Known(e)] = draft.effects.as_slice() else { panic!("{draft:?}") };
            let name = Name::new(class, without.effect_channel_name(effect, e.channel));
            assert!(good.contains(&name), "{name:?} is not among {good:?}");
            assert!(good.len() <= 3, "{good:?}");
        }
    }
}
