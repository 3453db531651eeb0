//! The channels that an effect names.

use crate::model::Model;
use lacuna_effects::{Acts, Effect, Law};

/// Index of a force channel.
pub(super) fn force_channel(model: &Model, name: &str) -> Result<usize, String> {
    let names: Vec<_> = (0..model.channels()).map(|c| model.channel_name(c)).collect();
    let found = names.iter().position(|n| *n == name);
    found.ok_or_else(|| format!("unknown channel '{name}'; there are {}", names.join(", ")))
}

/// Index of the input that a force effect depends on.
pub(super) fn named_input(model: &Model, effect: &Effect, name: &str) -> Result<usize, String> {
    input(model, name).ok_or_else(|| {
        let names = inputs(model);
        format!("{} depends on an input; 'other' = '{name}' is none of {names}", effect.class)
    })
}

fn input(model: &Model, name: &str) -> Option<usize> {
    model.inputs.iter().position(|i| i.name == name)
}

/// The names of all inputs.
pub(super) fn inputs(model: &Model) -> String {
    model.inputs.iter().map(|i| i.name.as_str()).collect::<Vec<_>>().join(", ")
}

/// That an effect does not act on a channel.
fn acts_on(effect: &Effect, name: &str) -> String {
    let kind = match effect.acts {
        Acts::States => "first-order states",
        _ => "second-order coordinates",
    };
    format!("{} acts on {kind}, and '{name}' is none", effect.class)
}

/// Index of a link that moves, or of the base.
fn structure(model: &Model, effect: &Effect, name: &str) -> Result<usize, String> {
    let (class, names) = (effect.class, model.structures(effect));
    if let Some(found) = names.iter().position(|n| *n == name) {
        return Ok(found);
    }
    let Some(tree) = model.dynamics().tree() else {
        return Err(format!("{class} acts on a robot, and this model has no [robot]"));
    };
    let names = names.join(", ");
    let whole = tree.bodies.iter().find(|b| b.fixed.iter().any(|part| part.name == name));
    Err(match whole.filter(|_| effect.acts == Acts::Links) {
        Some(whole) => format!(
            "'{name}' is fixed to link '{0}' and part of it: say channel = \"{0}\", with places in its \
             frame",
            whole.name
        ),
        None => format!("{class} does not act on '{name}'; expected one of {names}"),
    })
}

/// Index of the channel, input, machine state or link that an effect acts on.
pub(super) fn effect_channel(model: &Model, effect: &Effect, name: &str) -> Result<usize, String> {
    match effect.law {
        Law::Force(_) => {
            let channel = force_channel(model, name)?;
            let fits = match effect.acts {
                Acts::Coordinates => model.is_coordinate(channel),
                Acts::States => !model.is_coordinate(channel),
                _ => true,
            };
            if fits { Ok(channel) } else { Err(acts_on(effect, name)) }
        }
        Law::Input(_) => input(model, name).ok_or_else(|| {
            format!("{} acts on an input; '{name}' is none of {}", effect.class, inputs(model))
        }),
        Law::Structure(_) => structure(model, effect, name),
        Law::Sensor(_) => {
            let states = 0..model.machine_states();
            let found = states.clone().find(|&i| model.state_name(i) == name);
            if found.is_some_and(|i| model.is_imposed_state(i)) {
                return Err(format!(
                    "{} acts on a sensor, and the recorded motion of an imposed coordinate is taken \
                     as it is",
                    effect.class
                ));
            }
            found.ok_or_else(|| {
                let names: Vec<_> = states.map(|i| model.state_name(i)).collect();
                format!(
                    "{} acts on a measured channel; '{name}' is none of {}",
                    effect.class,
                    names.join(", ")
                )
            })
        }
    }
}
