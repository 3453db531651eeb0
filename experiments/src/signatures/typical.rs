//! Typical parameters of an effect, from what is believed of them before any data.

use lacuna_effects::{CATALOGUE, Effect, Kind, Law, Prior, Scales};

/// Each amplitude of a law is so much of the one before: laws of several are more than those of one.
const FADING: f64 = 0.6;
/// Turns of a curve that no formula describes.
const TURNS: f64 = 1.5;

/// Internal parameters (amplitudes, then shape) of usual size: the median of what is known by its order
/// of magnitude, one standard deviation of what may have either sign, one below the mean of what is about
/// a value, or that value where it cannot be so small.
#[must_use]
pub fn parameters(effect: &Effect, scales: &Scales) -> Vec<f64> {
    if effect.parameters.iter().any(|p| p.kind == Kind::Variable) {
        return internal(effect, &curve(effect, scales));
    }
    let amplitudes = amplitudes(effect);
    let fixed = fixed(effect, scales);
    let typical = |(k, prior): (usize, &Prior)| match *prior {
        Prior::Fixed => fixed.get(k).copied().unwrap_or_default(),
        Prior::LogNormal { median, .. } => median,
        Prior::Normal { mean, sd, .. } if k < amplitudes => mean + sd * FADING.powi(k as i32),
        Prior::Normal { mean: 0.0, sd, .. } => sd,
        Prior::Normal { mean, sd, low, .. } if mean - sd > low => mean - sd,
        Prior::Normal { mean, .. } => mean,
    };
    (effect.priors)(scales).iter().enumerate().map(typical).collect()
}

fn amplitudes(effect: &Effect) -> usize {
    match effect.law {
        Law::Force(law) => law.amplitudes(),
        Law::Structure(law) => law.amplitudes(),
        Law::Input(_) | Law::Sensor(_) => 0,
    }
}

/// Physical parameters of internal ones.
#[must_use]
pub fn physical(effect: &Effect, internal: &[f64]) -> Vec<f64> {
    match effect.law {
        Law::Force(law) => law.physical(internal),
        Law::Input(_) | Law::Sensor(_) | Law::Structure(_) => internal.to_vec(),
    }
}

/// Internal parameters of physical ones.
#[must_use]
pub fn internal(effect: &Effect, physical: &[f64]) -> Vec<f64> {
    match effect.law {
        Law::Force(law) => law.internal(physical),
        Law::Input(_) | Law::Sensor(_) | Law::Structure(_) => physical.to_vec(),
    }
}

/// Parameters among which those that are never fitted are right: the first that its search begins from,
/// or what the family's simplest law is in its place.
fn fixed(effect: &Effect, scales: &Scales) -> Vec<f64> {
    if let Some(shape) = (effect.shapes)(scales).first() {
        return [vec![0.0; amplitudes(effect)], shape.clone()].concat();
    }
    let Some(simplest) = simplest(effect) else { return vec![] };
    let in_its_place = physical(simplest, &parameters(simplest, scales));
    let written = simplest.written_as(effect, &in_its_place, scales);
    written.first().map(|p| internal(effect, p)).unwrap_or_default()
}

/// The simplest other law of an effect's family; none where it is the simplest, or has no family.
#[must_use]
pub fn simplest(effect: &Effect) -> Option<&'static Effect> {
    let first = CATALOGUE.iter().find(|e| e.is_kin_of(effect))?;
    (first.class != effect.class).then_some(first)
}

/// Physical parameters of a curve over the first of its variables.
fn curve(effect: &Effect, scales: &Scales) -> Vec<f64> {
    let mut ends = [scales.q.0, scales.q.1].into_iter();
    let value = |p: &lacuna_effects::Parameter| match p.kind {
        Kind::Numbers(count) => {
            let share = |k: usize| k as f64 / (count - 1) as f64;
            let turned = |k: usize| std::f64::consts::TAU * TURNS * share(k);
            (0..count).map(|k| scales.force * turned(k).cos() * (0.4 + share(k))).collect()
        }
        Kind::Variable => vec![0.0],
        Kind::Number | Kind::Side => vec![ends.next().unwrap_or_default()],
    };
    effect.parameters.iter().flat_map(value).collect()
}
