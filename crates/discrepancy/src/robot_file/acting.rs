//! The augmented model: its parameters and the effects that act on it.

use crate::diagnosis::Finding;
use crate::number::{percent, with_std};
use lacuna_effects::{Acts, Law, Quantity};
use lacuna_plants::Model;
use lacuna_plants::model::{Augmentation, NewEffect, Parameter};

/// A parameter of the augmented model.
#[derive(Clone, Copy)]
pub(super) struct Known<'m> {
    pub parameter: &'m Parameter,
    pub value: f64,
    /// Its standard deviation where it was calibrated; else 0.
    pub std: f64,
}

/// The parameters of a model with what a diagnosis makes of them.
pub(super) fn parameters<'m>(model: &'m Model, found: &Augmentation) -> Vec<Known<'m>> {
    let known = |parameter: &'m Parameter| {
        let calibrated = found.parameters.iter().find(|(name, ..)| *name == parameter.name);
        let (value, std) =
            calibrated.map_or((parameter.value, 0.0), |(_, value, std)| (*value, *std));
        Known { parameter, value, std }
    };
    model.parameters.iter().map(known).collect()
}

/// An effect of the augmented model.
pub(super) struct Acting {
    pub new: NewEffect,
    /// Of a finding.
    probability: Option<f64>,
}

/// The effects of a model and those that a diagnosis adds.
pub(super) fn effects(
    model: &Model,
    augmentation: &Augmentation,
    findings: &[Finding],
) -> Vec<Acting> {
    let own = model.effects.iter().map(|e| NewEffect::of(model, e));
    let own = own.map(|new| Acting { new, probability: None });
    let found = augmentation.effects.iter().map(|new| {
        let finding = findings.iter().find(|f| is(f, new));
        Acting { new: new.clone(), probability: finding.map(|f| f.probability) }
    });
    own.chain(found).collect()
}

fn is(finding: &Finding, new: &NewEffect) -> bool {
    finding.named_law() == new.effect.class
        && finding.channel == new.channel
        && finding.other == new.other
}

impl Acting {
    /// Its class, where it acts.
    pub fn called(&self) -> String {
        let NewEffect { effect, channel, other, .. } = &self.new;
        let other = other.as_ref().map_or_else(String::new, |other| format!(" and {other}"));
        format!("{} {}{other}", effect.class, effect.acts.at(channel))
    }

    /// Its class and how sure that is.
    pub fn by(&self) -> String {
        let class = self.new.effect.class;
        self.probability
            .map_or(class.to_owned(), |p| format!("{class}, probability {}", percent(p)))
    }

    /// Values and standard deviations of its parameters.
    fn values(&self) -> impl Iterator<Item = (f64, f64)> {
        self.new.parameters.iter().map(|(value, std, _)| (*value, std.unwrap_or(0.0)))
    }

    /// How much it is of a quantity of a channel, and the standard deviation.
    pub fn part(&self, quantity: Quantity, channel: &str) -> Option<(f64, f64)> {
        let stated = self.new.effect.nature.stated.filter(|s| s.quantity == quantity)?;
        (self.new.channel == channel).then(|| stated.of(self.values()))
    }

    /// What it is of, and its numbers, where it acts on structure.
    pub fn structure(&self) -> Option<(Acts, Vec<f64>)> {
        let Law::Structure(law) = self.new.effect.law else { return None };
        let values: Vec<f64> = self.values().map(|(value, _)| value).collect();
        Some((self.new.effect.acts, law.plain().numbers(&values)))
    }
}

/// A sum with what it is made of.
pub(super) struct Sum {
    pub value: f64,
    variance: f64,
    by: Vec<String>,
}

impl Sum {
    /// A value with its standard deviation.
    pub fn new(value: f64, std: f64) -> Self {
        Self { value, variance: std * std, by: vec![] }
    }

    /// With the parts that effects are of a quantity of a channel.
    pub fn with(mut self, acting: &[Acting], (quantity, channel): (Quantity, &str)) -> Self {
        for (a, (value, std)) in acting.iter().filter_map(|a| Some((a, a.part(quantity, channel)?)))
        {
            self.value += value;
            self.variance += std * std;
            self.by.push(a.by());
        }
        self
    }

    /// `0.43 +- 0.02 N m s/rad, was 0 (viscous_friction, probability 98 %)`.
    pub fn says(&self, was: f64, unit: &str) -> String {
        self.says_of(Some(was), unit)
    }

    /// The same of what may not have been there.
    pub fn says_of(&self, was: Option<f64>, unit: &str) -> String {
        let was = was.map_or_else(|| "not stated".to_owned(), |was| was.to_string());
        let estimate = with_std(self.value, self.variance.sqrt(), unit).replace('±', "+-");
        let by = self.by.join("; ");
        let by = if by.is_empty() { by } else { format!(" ({by})") };
        format!("{estimate}, was {was}{by}")
    }
}
