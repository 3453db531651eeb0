//! The numbers by which machines are compared.
//!
//! | quantity | of which machines |
//! | --- | --- |
//! | how much there is of a kind of physics on a channel ([`Effect::size`]) | all: 0 where it was not found, known as well as where it was |
//! | every other number of an effect | those with the effect |
//! | a calibrated parameter of the model | all |
//!
//! A machine whose mismatch nobody could explain says nothing. One that may have a kind of physics by another name
//! (the kind is among the rivals of what was found) has the probability of that rival as its p-value at least, for
//! the kind and for the name that was given to it.
//!
//! [`Effect::size`]: crate::effects::Effect::size

use super::collected::Diagnosed;
use super::population::{Number, Population, median};
use crate::discrepancy::Diagnosis;
use crate::discrepancy::diagnosis::{Estimate, Finding, Verdict};
use crate::effects::{Effect, Kind, find};
use serde::Serialize;
use std::collections::{BTreeMap, BTreeSet};

/// A rival that is less likely than this is none.
const RIVAL: f64 = 1e-6;

/// What a quantity is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Sort {
    /// How much there is of a kind of physics; 0 where there is none.
    Size,
    /// A number of an effect, of machines that have it.
    Parameter,
    /// A calibrated parameter of the model.
    Calibration,
}

/// The value of one machine.
#[derive(Clone, Debug, Serialize)]
pub struct Value {
    /// The machine.
    pub machine: String,
    /// Value.
    pub value: f64,
    /// Standard deviation; of what was not found, the median of those machines where it was.
    pub std: f64,
    /// Whether it was found in this machine.
    pub found: bool,
    /// Probability that a typical machine lies as far out; none of too few machines.
    pub p: Option<f64>,
}

/// A number of many machines.
#[derive(Clone, Debug, Serialize)]
pub struct Quantity {
    /// What it is of.
    pub sort: Sort,
    /// What it is, in words: `dry friction on q`, `stribeck velocity of Stribeck friction on q`, `J`.
    pub name: String,
    /// Its unit; of a kind of physics that of its size.
    pub unit: String,
    /// Mean over typical machines; none of too few.
    pub mean: Option<f64>,
    /// Standard deviation of the mean.
    pub mean_std: Option<f64>,
    /// Standard deviation of typical machines about it, beyond that of their estimates.
    pub spread: Option<f64>,
    /// The machines, by their names.
    pub values: Vec<Value>,
}

/// All numbers that machines can be compared by.
pub(super) fn quantities(machines: &[Diagnosed]) -> Vec<Quantity> {
    let told: Vec<&Diagnosed> =
        machines.iter().filter(|m| m.diagnosis.verdict != Verdict::Unexplained).collect();
    let mut all: Vec<Quantity> = sizes(&told);
    all.extend(parameters(&told));
    all.extend(calibrations(&told));
    all
}

/// A kind of physics and where it acts.
type Place = (&'static str, String);

fn place(class: &str, channel: &str, other: Option<&str>) -> Option<Place> {
    let effect = find(class)?;
    let at = effect.acts.at(channel);
    let other = other.map_or_else(String::new, |o| format!(" and {o}"));
    Some((effect.kind_words(), format!("{at}{other}")))
}

/// The law of a finding and its numbers, in their order.
fn numbers(finding: &Finding) -> Option<(&'static Effect, Vec<(f64, f64)>)> {
    let effect = find(finding.named_law())?;
    // What a diagnosis does not tell, such as the width of a smooth edge, plays no part in sizes.
    let number = |p: &str| finding.parameters.get(p).map_or((0.0, 0.0), |e| (e.value, e.std));
    Some((effect, effect.parameters.iter().map(|p| number(p.name)).collect()))
}

/// Size and unit of a finding, where it is an estimate.
fn size(finding: &Finding) -> Option<(Place, Number, String)> {
    let (effect, numbers) = numbers(finding)?;
    let first = finding.parameters.get(effect.parameters.first()?.name)?;
    let (value, std) = effect.size(&numbers)?;
    let known = value.is_finite() && std.is_finite() && !first.at_bound;
    let unit = if effect.nature.absent.is_finite() {
        first.unit.clone()
    } else {
        format!("1/({})", first.unit)
    };
    let place = place(effect.class, &finding.channel, finding.other.as_deref())?;
    known.then_some((place, Number { value, std }, unit))
}

fn sizes(machines: &[&Diagnosed]) -> Vec<Quantity> {
    let mut found: BTreeMap<Place, (String, BTreeMap<usize, Number>)> = BTreeMap::new();
    // Where something was found that says no number, as at a bound, nothing is compared.
    let mut silent: BTreeSet<(Place, usize)> = BTreeSet::new();
    for (m, machine) in machines.iter().enumerate() {
        for f in &machine.diagnosis.findings {
            match size(f) {
                Some((place, number, unit)) => {
                    let of_place = found.entry(place).or_insert_with(|| (unit, BTreeMap::new()));
                    let sum = of_place.1.entry(m).or_insert(Number { value: 0.0, std: 0.0 });
                    *sum =
                        Number { value: sum.value + number.value, std: sum.std.hypot(number.std) };
                }
                None => {
                    silent.extend(place(&f.class, &f.channel, f.other.as_deref()).map(|p| (p, m)))
                }
            }
        }
    }
    let quantity = |(place, (unit, found)): (Place, (String, BTreeMap<usize, Number>))| {
        let std = median(found.values().map(|n| n.std));
        let one = |m: usize| {
            let known = !silent.contains(&(place.clone(), m));
            let number = found.get(&m).copied();
            known.then(|| (m, number.unwrap_or(Number { value: 0.0, std }), number.is_some()))
        };
        let values: Vec<_> = (0..machines.len()).filter_map(one).collect();
        let doubt = |m: usize, has: bool| doubt(machines, &place, m, has);
        compared(machines, (Sort::Size, format!("{} {}", place.0, place.1), unit), &values, doubt)
    };
    found.into_iter().map(quantity).collect()
}

/// Probability that what was found in a machine is another kind, or that what was not found is there by another
/// name, of what is usual in the others.
fn doubt(machines: &[&Diagnosed], at: &Place, machine: usize, has: bool) -> f64 {
    let is = |f: &Finding| place(&f.class, &f.channel, f.other.as_deref()).as_ref() == Some(at);
    let has_kind = |m: &Diagnosed, kind: &Place| {
        m.diagnosis
            .findings
            .iter()
            .any(|f| place(&f.class, &f.channel, f.other.as_deref()).as_ref() == Some(kind))
    };
    let usual = |kind: &Place| {
        let others = machines.iter().enumerate().filter(|(k, _)| *k != machine);
        others.filter(|(_, m)| has_kind(m, kind)).count() * 2 >= machines.len() - 1
    };
    let findings = &machines[machine].diagnosis.findings;
    let rivals = |f: &Finding| -> Vec<(Place, f64)> {
        let rivals = f.alternatives.iter().filter(|r| r.probability > RIVAL);
        rivals.filter_map(|r| Some((place(&r.class, &r.channel, None)?, r.probability))).collect()
    };
    let of = |f: &Finding| -> f64 {
        let counts = |(kind, p): &(Place, f64)| {
            let other = match has {
                true => is(f) && kind != at && usual(kind) && !has_kind(machines[machine], kind),
                false => kind == at && usual(kind),
            };
            if other { *p } else { 0.0 }
        };
        rivals(f).iter().map(counts).sum()
    };
    findings.iter().map(of).fold(0.0, f64::max)
}

/// The numbers of effects beside their sizes, of machines that have them.
fn parameters(machines: &[&Diagnosed]) -> Vec<Quantity> {
    let mut all: BTreeMap<String, (String, BTreeMap<usize, Number>)> = BTreeMap::new();
    for (m, machine) in machines.iter().enumerate() {
        for f in &machine.diagnosis.findings {
            let (Some((effect, _)), Some((_, at))) =
                (numbers(f), place(&f.class, &f.channel, f.other.as_deref()))
            else {
                continue;
            };
            let size = size_alone(effect);
            let others = effect.parameters.iter().enumerate().filter(|(k, _)| Some(*k) != size);
            for p in others.map(|(_, p)| p).filter(|p| p.physical && p.kind == Kind::Number) {
                let Some(number) = f.parameters.get(p.name).and_then(known) else { continue };
                let name = format!("{} of {} {at}", p.name.replace('_', " "), effect.words);
                let unit = f.parameters[p.name].unit.clone();
                all.entry(name).or_insert_with(|| (unit, BTreeMap::new())).1.insert(m, number);
            }
        }
    }
    let quantity = |(name, (unit, found)): (String, (String, BTreeMap<usize, Number>))| {
        let values: Vec<_> = found.into_iter().map(|(m, n)| (m, n, true)).collect();
        compared(machines, (Sort::Parameter, name, unit), &values, |_, _| 0.0)
    };
    all.into_iter().map(quantity).collect()
}

/// The parameter that alone is an effect's size, if one is.
fn size_alone(effect: &Effect) -> Option<usize> {
    let Some(stated) = effect.nature.stated else { return Some(0) };
    let mut counted = (0..stated.weights.len()).filter(|k| stated.weights[*k] != 0.0);
    counted.next().filter(|_| counted.next().is_none())
}

fn calibrations(machines: &[&Diagnosed]) -> Vec<Quantity> {
    let of = |d: &Diagnosis, name: &str| {
        let c = d.calibration.get(name)?;
        let usable = c.value.is_finite() && c.std.is_finite() && !c.at_bound;
        usable.then_some(Number { value: c.value, std: c.std })
    };
    let names: BTreeMap<&str, &str> = machines
        .iter()
        .flat_map(|m| m.diagnosis.calibration.iter().map(|(name, c)| (&**name, &*c.unit)))
        .collect();
    let quantity = |(name, unit): (&str, &str)| {
        let found = machines
            .iter()
            .enumerate()
            .filter_map(|(m, d)| Some((m, of(&d.diagnosis, name)?, true)));
        let what = (Sort::Calibration, name.to_owned(), unit.to_owned());
        compared(machines, what, &found.collect::<Vec<_>>(), |_, _| 0.0)
    };
    names.into_iter().map(quantity).collect()
}

fn known(e: &Estimate) -> Option<Number> {
    let usable = e.value.is_finite() && e.std.is_finite() && !e.at_bound;
    usable.then_some(Number { value: e.value, std: e.std })
}

/// A quantity of these machines; `doubt` is the least p-value of one.
fn compared(
    machines: &[&Diagnosed],
    (sort, name, unit): (Sort, String, String),
    values: &[(usize, Number, bool)],
    doubt: impl Fn(usize, bool) -> f64,
) -> Quantity {
    let population = Population::of(&values.iter().map(|v| v.1).collect::<Vec<_>>());
    let value = |(k, &(m, number, found)): (usize, &(usize, Number, bool))| Value {
        machine: machines[m].name.clone(),
        value: number.value,
        std: number.std,
        found,
        p: population.as_ref().map(|all| all.p[k].max(doubt(m, found))),
    };
    Quantity {
        sort,
        name,
        unit,
        mean: population.as_ref().map(|p| p.mean),
        mean_std: population.as_ref().map(|p| p.mean_std),
        spread: population.as_ref().map(|p| p.spread),
        values: values.iter().enumerate().map(value).collect(),
    }
}
