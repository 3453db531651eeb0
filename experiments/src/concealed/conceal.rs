//! What is concealed in a machine: drawn for a topic, on a plant that suits it.

use lacuna_effects::{Effect, Law as CatalogueLaw};
use lacuna_plants::Model;
use lacuna_plants::model::ModelEffect;
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use std::collections::BTreeSet;

use super::beyond::Kind;
use super::effects;
use super::off_formula::Law;
use super::places::{classes, places, robots_classes};
use super::plants::PlantSpec;
use super::scales::Scales;
use super::topic::Topic;

/// One concealed effect.
#[derive(Clone, Debug)]
pub enum Concealed {
    /// Of the catalogue.
    Known(ModelEffect),
    /// A law beyond it, on a force channel.
    Beyond(Law, usize),
}

/// Draw what is concealed; none where the plant does not suit the topic.
pub fn conceal(
    topic: Topic,
    spec: &PlantSpec,
    model: &Model,
    scales: &Scales,
    rng: &mut ChaCha8Rng,
) -> Option<Vec<Concealed>> {
    let any = |rng: &mut ChaCha8Rng| {
        let classes: Vec<_> =
            if spec.joints > 0 { robots_classes().collect() } else { classes().collect() };
        classes[rng.random_range(0..classes.len())]
    };
    match topic {
        Topic::Nothing(_) | Topic::Parameter | Topic::Only(_) => Some(Vec::new()),
        Topic::Amid(_) => {
            let effect = any(rng);
            let force = matches!(effect.law, CatalogueLaw::Force(_));
            Some(vec![known(effect, spec, model, scales, rng).filter(|_| force)?])
        }
        Topic::Effect(effect) => Some(vec![known(effect, spec, model, scales, rng)?]),
        Topic::Under(_) => Some(vec![known(any(rng), spec, model, scales, rng)?]),
        Topic::Pair | Topic::Three => {
            let count = if matches!(topic, Topic::Pair) { 2 } else { 3 };
            let drawn = (0..count).map(|_| known(any(rng), spec, model, scales, rng));
            drawn.collect::<Option<Vec<_>>>().filter(|several| suit(several))
        }
        Topic::Friction => {
            let dry_and_viscous = ["coulomb_friction", "viscous_friction"];
            let found = dry_and_viscous.map(lacuna_effects::find);
            let mut all = vec![];
            for effect in found.into_iter().flatten() {
                for joint in 0..model.coordinates.len() {
                    all.push(at(effect, joint, model, scales, rng)?);
                }
            }
            Some(all)
        }
        Topic::Beyond(kind) => {
            let channels = channels(kind, spec, model);
            if channels.is_empty() {
                return None;
            }
            let channel = channels[rng.random_range(0..channels.len())];
            Some(vec![Concealed::Beyond(kind.draw(scales.channels[channel], rng), channel)])
        }
    }
}

/// Whether effects can be told apart in principle: of different classes, at most one on an
/// actuator, none of them a sensor's (which moves the truth of the others) and none with memory
/// (which a model that starts anew in each window does not know).
fn suit(several: &[Concealed]) -> bool {
    let known: Vec<&ModelEffect> = several
        .iter()
        .filter_map(|e| match e {
            Concealed::Known(e) => Some(e),
            Concealed::Beyond(..) => None,
        })
        .collect();
    let simple = |e: &ModelEffect| match e.effect.law {
        CatalogueLaw::Force(law) => law.memory() == 0,
        CatalogueLaw::Input(_) | CatalogueLaw::Structure(_) => true,
        CatalogueLaw::Sensor(_) => false,
    };
    let inputs = known.iter().filter(|e| matches!(e.effect.law, CatalogueLaw::Input(_))).count();
    let classes: BTreeSet<&str> = known.iter().map(|e| e.effect.class).collect();
    // Together the law of one asymmetric friction.
    let one = classes.contains("constant_force")
        && (classes.contains("coulomb_friction") || classes.contains("asymmetric_friction"));
    classes.len() == several.len() && !one && known.iter().all(|e| simple(e)) && inputs < 2
}

fn known(
    effect: &'static Effect,
    spec: &PlantSpec,
    model: &Model,
    scales: &Scales,
    rng: &mut ChaCha8Rng,
) -> Option<Concealed> {
    let places = places(spec, model, effect);
    if places.is_empty() {
        return None;
    }
    at(effect, places[rng.random_range(0..places.len())], model, scales, rng)
}

/// An effect at a place.
fn at(
    effect: &'static Effect,
    channel: usize,
    model: &Model,
    scales: &Scales,
    rng: &mut ChaCha8Rng,
) -> Option<Concealed> {
    let other = effect.couples().then(|| (channel + 1) % model.coordinates.len());
    let numbers = effects::draw(effect, model, scales, channel, other, rng);
    let parameters = effects::in_order(effect, &numbers);
    let std = vec![None; parameters.len()];
    let sound = effect.parameters.iter().zip(&parameters).all(|(p, v)| p.range.contains(*v));
    sound.then_some(Concealed::Known(ModelEffect { effect, channel, other, parameters, std }))
}

fn channels(kind: Kind, spec: &PlantSpec, model: &Model) -> Vec<usize> {
    let [coordinates, rotors, levels] = kind.acts();
    let n = model.coordinates.len();
    let of_states = |class: &str| -> Vec<usize> {
        let has = |s: &usize| {
            let name = model.states[*s].name.as_str();
            spec.on_states.iter().any(|(state, known)| *state == name && known.contains(&class))
        };
        (0..model.states.len()).filter(has).map(|s| n + s).collect()
    };
    let mut channels: Vec<usize> = if coordinates { (0..n).collect() } else { Vec::new() };
    if rotors {
        channels.extend(of_states("coulomb_friction"));
    }
    if levels {
        channels.extend(of_states("linear_loss"));
    }
    channels
}
