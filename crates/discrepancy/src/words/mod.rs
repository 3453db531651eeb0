//! Findings in an engineer's words.

pub(crate) mod shape;

use crate::number;
use lacuna_effects::Kind;
use lacuna_plants::Model;
use lacuna_plants::model::{ModelEffect, NewEffect};

/// The numbers of an effect, in words. Which of its values lie at the edge of what was tried is said.
pub(crate) fn numbers(new: &NewEffect, at_bound: &[bool]) -> String {
    let at_bound = at_bound.iter().chain(std::iter::repeat(&false));
    let numbers: Vec<String> = new
        .effect
        .values()
        .zip(&new.parameters)
        .zip(at_bound)
        .filter(|((p, _), _)| p.kind == Kind::Number && p.physical)
        .map(|((p, (value, std, unit)), &at_bound)| {
            let estimate = number::estimate(*value, std.unwrap_or(0.0), unit, at_bound);
            format!("{} {}", p.name.replace('_', " "), estimate.replace('±', "+-"))
        })
        .collect();
    numbers.join(", ")
}

/// One sentence: what, where, how much.
pub(crate) fn says(e: &ModelEffect, new: &NewEffect, at_bound: &[bool], model: &Model) -> String {
    let mut what = e.effect.words.to_owned();
    if let Some(first) = what.get_mut(0..1) {
        first.make_ascii_uppercase();
    }
    let joined = if e.effect.names_input() { "by" } else { "and" };
    let other = new.other.as_ref().map_or_else(String::new, |o| format!(" {joined} {o}"));
    let (at, model) = (e.effect.acts.at(&new.channel), &model.name);
    format!("{what} {at}{other} is missing from {model}: {}.", numbers(new, at_bound))
}
