//! From an `[[effect]]` of a model file to a [`ModelEffect`].

use super::Reader;
use super::channel::{effect_channel, force_channel, inputs, named_input};
use super::value::{Given, RawValue};
use crate::expression::hint;
use crate::model::{Model, ModelEffect, ModelError};
use indexmap::IndexMap;
use lacuna_effects::{CATALOGUE, Effect, Kind, Parameter, Variable};
use serde::Deserialize;
use std::ops::Range;
use toml::Spanned;

/// The entries of an `[[effect]]`: its class, its channels, and what its class asks for.
#[derive(Deserialize)]
#[serde(transparent)]
pub(super) struct RawEffect(IndexMap<Spanned<String>, Spanned<RawValue>>);

/// Keys of every effect; the others are parameters.
const COMMON: [&str; 3] = ["class", "channel", "other"];

/// What is wrong, and which bytes of the file are meant; none for the whole effect.
struct Mistake {
    span: Option<Range<usize>>,
    message: String,
}

impl Mistake {
    fn whole(message: String) -> Self {
        Self { span: None, message }
    }

    fn at(span: Range<usize>) -> impl Fn(String) -> Self {
        move |message| Self { span: Some(span.clone()), message }
    }
}

impl Reader<'_> {
    pub(super) fn effect(
        &self,
        raw: &Spanned<RawEffect>,
        model: &Model,
    ) -> Result<ModelEffect, ModelError> {
        raw.get_ref().effect(model).map_err(|m| {
            let whole = || self.header(raw.span(), "[[effect]]");
            self.error(m.span.unwrap_or_else(whole), m.message)
        })
    }

    /// The line with which a table of a list begins, of its span, which may cover only its entries.
    pub(super) fn header(&self, span: Range<usize>, line: &str) -> Range<usize> {
        let before = &self.text[..span.start.min(self.text.len())];
        match before.rfind(line) {
            Some(at) if !self.text[span.clone()].starts_with(line) => at..at + line.len(),
            _ => span.start..span.start + line.len(),
        }
    }
}

impl RawEffect {
    fn effect(&self, model: &Model) -> Result<ModelEffect, Mistake> {
        let (class, place) = self.needs_text("class")?;
        let effect = find(class).map_err(Mistake::at(place))?;
        let (name, place) = self.needs_text("channel")?;
        let channel = effect_channel(model, effect, name).map_err(Mistake::at(place))?;
        let other = self.other(model, effect, channel)?;
        let mut parameters = Vec::new();
        let mut std = Vec::new();
        self.check_names(effect)?;
        let over = self.over(model, effect, channel)?;
        let mut units = model.effect_units_over(effect, (channel, other), over).into_iter();
        for p in effect.parameters {
            // The values of one parameter have one unit.
            let unit = units.by_ref().take(p.kind.values()).last().unwrap_or_default();
            let given = self.parameter(effect, p, &unit, over)?;
            parameters.extend(given.values);
            std.extend(given.std);
        }
        let new = ModelEffect { effect, channel, other, parameters, std };
        self.check_ends(&new)?;
        Ok(new)
    }

    fn get(&self, key: &str) -> Option<&Spanned<RawValue>> {
        self.0.iter().find(|(k, _)| k.get_ref() == key).map(|(_, value)| value)
    }

    /// A name that the effect gives, and its place.
    fn text(&self, key: &str) -> Result<Option<(&str, Range<usize>)>, Mistake> {
        let Some(value) = self.get(key) else { return Ok(None) };
        match value.get_ref() {
            RawValue::Text(text) => Ok(Some((text, value.span()))),
            _ => Err(Mistake::at(value.span())(format!("'{key}' is a name, in quotes"))),
        }
    }

    fn needs_text(&self, key: &str) -> Result<(&str, Range<usize>), Mistake> {
        let missing = || Mistake::whole(format!("an effect needs {key} = \"...\""));
        self.text(key)?.ok_or_else(missing)
    }

    /// The other channel of a coupling, or the input that the effect depends on.
    fn other(
        &self,
        model: &Model,
        effect: &Effect,
        channel: usize,
    ) -> Result<Option<usize>, Mistake> {
        let class = effect.class;
        let Some((name, place)) = self.text("other")? else {
            let missing = if effect.names_input() {
                format!("{class} depends on an input, one of {}", inputs(model))
            } else if effect.couples() {
                format!("{class} couples two channels")
            } else {
                return Ok(None);
            };
            return Err(Mistake::whole(format!("{missing}: say other = \"...\"")));
        };
        let at = Mistake::at(place);
        if effect.names_input() {
            return named_input(model, effect, name).map(Some).map_err(at);
        }
        if !effect.couples() {
            return Err(at(format!("{class} acts on one channel alone and has no 'other'")));
        }
        let other = force_channel(model, name).map_err(&at)?;
        if other == channel {
            return Err(at(format!("{class} couples two channels; '{name}' is named twice")));
        }
        Ok(Some(other))
    }

    fn check_names(&self, effect: &Effect) -> Result<(), Mistake> {
        let known: Vec<_> = effect.parameters.iter().map(|p| p.name).collect();
        let stranger = |key: &str| !COMMON.contains(&key) && !known.contains(&key);
        match self.0.keys().find(|key| stranger(key.get_ref())) {
            Some(key) => Err(Mistake::at(key.span())(format!(
                "{} has no parameter '{}'; it has {}",
                effect.class,
                key.get_ref(),
                known.join(", ")
            ))),
            None => Ok(()),
        }
    }

    /// The variable that a curve is over; the coordinate for everything else.
    fn over(&self, model: &Model, effect: &Effect, channel: usize) -> Result<Variable, Mistake> {
        let Some(p) = effect.parameters.iter().find(|p| p.kind == Kind::Variable) else {
            return Ok(Variable::Coordinate);
        };
        let choices: Vec<_> = effect
            .depends_on
            .iter()
            .filter_map(|&v| Some((v, model.variable_name(channel, v)?)))
            .collect();
        let names = choices.iter().map(|(_, name)| *name).collect::<Vec<_>>().join(", ");
        let Some((found, place)) = self.text(p.name)? else {
            let message = format!("{} needs '{}', one of {names}", effect.class, p.name);
            return Err(Mistake::whole(message));
        };
        let choice = choices.iter().find(|(_, name)| *name == found).map(|(v, _)| *v);
        choice.ok_or_else(|| {
            let message = format!("unknown variable '{found}'; '{}' is one of {names}", p.name);
            Mistake::at(place)(message)
        })
    }

    fn parameter(
        &self,
        effect: &Effect,
        p: &Parameter,
        unit: &str,
        over: Variable,
    ) -> Result<Given, Mistake> {
        if p.kind == Kind::Variable {
            let index = effect.depends_on.iter().position(|v| *v == over).unwrap_or(0);
            return Ok(Given { values: vec![index as f64], std: vec![None] });
        }
        match self.get(p.name) {
            Some(value) => value.get_ref().given(p, unit).map_err(Mistake::at(value.span())),
            None => {
                let missing = || format!("{} needs '{}' ({unit})", effect.class, p.name);
                let value = p.default.ok_or_else(missing).map_err(Mistake::whole)?;
                Ok(Given { values: vec![value], std: vec![None] })
            }
        }
    }

    /// A curve must begin before it ends.
    fn check_ends(&self, new: &ModelEffect) -> Result<(), Mistake> {
        if new.over().is_none() {
            return Ok(());
        }
        let end =
            |name| new.effect.values().position(|p| p.name == name).map(|k| new.parameters[k]);
        match (end("from"), end("to"), self.get("to")) {
            (Some(from), Some(to), Some(place)) if to <= from => Err(Mistake::at(place.span())(
                format!("a curve runs upwards: 'to' must be more than 'from' ({from}); found {to}"),
            )),
            _ => Ok(()),
        }
    }
}

fn find(class: &str) -> Result<&'static Effect, String> {
    lacuna_effects::find(class).ok_or_else(|| {
        let classes: Vec<_> = CATALOGUE.iter().map(|e| e.class.to_owned()).collect();
        let hint = hint(class, &classes);
        format!("unknown effect class '{class}'{hint}; there are {}", classes.join(", "))
    })
}
