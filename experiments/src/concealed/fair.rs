//! Which drafts make a fair case: the motion is integrated finely, stays within reach, and what is
//! concealed makes a difference that can be seen.

use lacuna_effects::{Law as CatalogueLaw, Variable};
use lacuna_plants::Model;
use lacuna_plants::model::ModelEffect;
use serde_json::json;

use super::draw::{Concealed, Draft, RECORDINGS, TESTS};
use super::effects::couples;
use super::gap::{Output, Shown, WINDOWS, gap, greatest};
use super::off_formula::Law;
use super::rivals::as_good;
use super::sealed::{Area, Matter, Name, SealedEffect};
use super::sensor::seen;
use super::topic::Topic;
use super::truth::Motion;

/// Least calibrated gap of an effect, in noise standard deviations: less could be told by nobody.
pub const LEAST_GAP: f64 = 3.0;
/// Recordings that gaps are measured on.
const GAP_RECORDINGS: usize = 3;
/// Steps a sample that the truth is tried with, fewest first.
const SUBSTEPS: [usize; 4] = [8, 16, 32, 64];
/// Most that halving the step may change over two windows, in noise standard deviations.
const INTEGRATION: f64 = 0.1;
/// The motion may reach this many times as far as it does without the effects.
const REACH: f64 = 3.0;
/// Classes that a wrong parameter can stand for.
const LIKE_A_PARAMETER: [&str; 2] = ["gain_error", "sensor_scale"];

/// A draft that is fair.
#[derive(Debug)]
pub struct Fair {
    /// The motions of all recordings, those for the proof last.
    pub motions: Vec<Motion>,
    /// The effects, with their gaps.
    pub effects: Vec<SealedEffect>,
    /// What is the matter.
    pub matter: Matter,
    /// Gap of the model file, greatest output.
    pub model_gap: f64,
}

impl Fair {
    /// The draft in motion; none where it is not fair.
    pub fn of(draft: &Draft) -> Option<Self> {
        let motions = motions(draft)?;
        let some = &motions[..GAP_RECORDINGS];
        let count = draft.effects.len();
        let effects = (0..count).map(|k| sealed(draft, some, k)).collect::<Option<Vec<_>>>()?;
        let model_gap = gap(&draft.nominal, &shown(draft, some), &draft.outputs, &[]).ok()?;
        let model_gap = greatest(&model_gap.raw);
        let matter = matter(draft);
        if matter == Matter::Parameter && model_gap < LEAST_GAP {
            return None;
        }
        Some(Self { motions, effects, matter, model_gap })
    }
}

fn matter(draft: &Draft) -> Matter {
    let sensor = |e: &Concealed| match e {
        Concealed::Known(e) => matches!(e.effect.law, CatalogueLaw::Sensor(_)),
        Concealed::Beyond(..) => false,
    };
    match draft.effects.as_slice() {
        [] if matches!(draft.topic, Topic::Parameter) => Matter::Parameter,
        [] => Matter::None,
        effects if effects.iter().all(sensor) => Matter::Sensor,
        _ => Matter::MissingPhysics,
    }
}

/// The motions of all recordings; none where one diverges or leaves the reach of the plant.
fn motions(draft: &Draft) -> Option<Vec<Motion>> {
    let samples = draft.spec.samples;
    let first = draft.motion(0, samples, SUBSTEPS[0]).ok()?;
    if !within_reach(draft, &first) {
        return None;
    }
    let substeps = SUBSTEPS.into_iter().find(|&s| integrated(draft, s))?;
    let all = (0..RECORDINGS + TESTS).map(|k| draft.motion(k, samples, substeps).ok());
    let all: Vec<Motion> = all.collect::<Option<_>>()?;
    all.iter().all(|m| within_reach(draft, m)).then_some(all)
}

fn within_reach(draft: &Draft, motion: &Motion) -> bool {
    (0..draft.nominal.channels()).all(|c| {
        let scale = draft.scales.channels[c];
        let far = REACH * scale.half_range();
        let series = motion.series(draft.nominal.coordinate_index(c));
        series.iter().all(|q| (q - scale.centre()).abs() < far)
    })
}

/// Whether halving the step changes less than the noise hides.
fn integrated(draft: &Draft, substeps: usize) -> bool {
    let samples = 2 * (draft.spec.samples / WINDOWS);
    let run = |substeps| draft.motion(0, samples, substeps);
    let (Ok(coarse), Ok(fine)) = (run(substeps), run(2 * substeps)) else { return false };
    let small = |o: &Output| {
        let change = |k: usize| (fine.state(k)[o.entry] - coarse.state(k)[o.entry]).abs();
        (0..samples).all(|k| change(k) < INTEGRATION * o.sd)
    };
    draft.outputs.iter().all(small)
}

/// Motions with what the machine's sensors show of them, but for noise.
fn shown<'a>(draft: &Draft, motions: &'a [Motion]) -> Vec<Shown<'a>> {
    let sensors = draft.truth(|_| true).sensors;
    let series =
        |m: &Motion| draft.outputs.iter().map(|o| seen(m, o.entry, sensors[o.entry])).collect();
    motions.iter().map(|m| (m, series(m))).collect()
}

/// Effect `k` of a draft under seal; none where it makes too little difference.
fn sealed(draft: &Draft, motions: &[Motion], k: usize) -> Option<SealedEffect> {
    let others = draft.effects.iter().enumerate().filter(|(i, _)| *i != k);
    let known = others.filter_map(|(_, e)| match e {
        Concealed::Known(e) => Some(e.clone()),
        Concealed::Beyond(..) => None,
    });
    let mut without = draft.calibrated.clone();
    without.effects = known.collect();
    let shown = shown(draft, motions);
    let found = gap(&without, &shown, &draft.outputs, &[]).ok()?;
    let (raw, calibrated) = (greatest(&found.raw), greatest(&found.calibrated));
    let mut effect = match &draft.effects[k] {
        Concealed::Known(e) => catalogued(draft, e),
        Concealed::Beyond(law, channel) => beyond(&draft.nominal, law, *channel),
    };
    effect.gap_over_noise = calibrated;
    // What other parameters would explain down to the noise, far off or not, may be called so.
    if greatest(&found.free) < 1.0 {
        effect.accept.push(Name::new("parameter_error", ""));
    }
    if calibrated >= LEAST_GAP {
        let known = std::iter::once(&effect.name).chain(&effect.accept).cloned();
        let known: Vec<Name> = known.collect();
        let rivals = as_good(draft.spec, &without, &draft.scales, &shown, &draft.outputs);
        effect.accept.extend(rivals.into_iter().filter(|r| !known.contains(r)));
        return Some(effect);
    }
    if raw < LEAST_GAP || !LIKE_A_PARAMETER.contains(&effect.name.class.as_str()) {
        return None;
    }
    effect.gap_over_noise = raw;
    let inputs = draft.nominal.inputs.iter().map(|i| Name::new("gain_error", &i.name));
    effect.accept.extend(inputs.filter(|n| *n != effect.name));
    Some(effect)
}

/// An effect of the catalogue under seal.
fn catalogued(draft: &Draft, e: &ModelEffect) -> SealedEffect {
    let model = &draft.nominal;
    let class = e.effect.class;
    let channel = model.effect_channel_name(e.effect, e.channel).to_owned();
    let other = e.other.map(|o| model.channel_name(o).to_owned());
    let depends_on = match e.effect.law {
        CatalogueLaw::Force(_) => {
            e.effect.depends_on.iter().map(|v| variable(model, e, *v)).collect()
        }
        CatalogueLaw::Input(_) | CatalogueLaw::Sensor(_) => vec![channel.clone()],
    };
    let parameters = e.effect.parameters.iter().zip(&e.parameters);
    let parameters: serde_json::Map<_, _> =
        parameters.map(|(p, v)| (p.name.to_owned(), json!(v))).collect();
    let mut accept = Vec::new();
    // Coulomb friction and a constant force are the same law.
    if class == "asymmetric_friction" {
        accept.push(Name::new("coulomb_friction", &channel));
    }
    if let (true, Some(other)) = (couples(e.effect), &other) {
        accept.push(Name::new(class, other));
    }
    // One measured channel that lags behind one input: nobody can say which of them is late.
    if let ("sensor_delay" | "input_delay", [one], [input]) =
        (class, draft.outputs.as_slice(), model.inputs.as_slice())
    {
        accept.push(Name::new("sensor_delay", model.state_name(one.entry)));
        accept.push(Name::new("input_delay", &input.name));
    }
    accept.retain(|n| n.class != class || n.channel != channel);
    SealedEffect {
        area: area(model, e),
        name: Name::new(class, &channel),
        other,
        depends_on,
        parameters: parameters.into(),
        accept,
        catalogue: true,
        gap_over_noise: 0.0,
    }
}

fn variable(model: &Model, e: &ModelEffect, v: Variable) -> String {
    let other = e.other.unwrap_or(e.channel);
    match v {
        Variable::Coordinate => model.state_name(model.coordinate_index(e.channel)).to_owned(),
        Variable::Velocity => model.state_name(model.velocity_index(e.channel)).to_owned(),
        Variable::OtherCoordinate => model.state_name(model.coordinate_index(other)).to_owned(),
        Variable::OtherVelocity => model.state_name(model.velocity_index(other)).to_owned(),
        // Laws on inputs name their input themselves.
        Variable::Time | Variable::Input => model.time_column.clone(),
    }
}

/// Where or when an effect of the catalogue acts, for those that do not always.
fn area(model: &Model, e: &ModelEffect) -> Option<Area> {
    let number = |name: &str| {
        let place = e.effect.parameters.iter().position(|p| p.name == name);
        place.map(|k| e.parameters[k])
    };
    match e.effect.class {
        "step_change" => number("time").map(Area::From),
        "end_stop" => {
            let variable = model.state_name(model.coordinate_index(e.channel)).to_owned();
            let (position, upper) = (number("position"), number("side")? > 0.0);
            let (from, to) = if upper { (position, None) } else { (None, position) };
            Some(Area::Region { variable, from, to })
        }
        _ => None,
    }
}

/// A law beyond the catalogue under seal.
fn beyond(model: &Model, law: &Law, channel: usize) -> SealedEffect {
    let name = model.channel_name(channel);
    let coordinate = model.state_name(model.coordinate_index(channel)).to_owned();
    let velocity = model.state_name(model.velocity_index(channel)).to_owned();
    let (on_coordinate, on_velocity) = law.depends_on();
    let mut depends_on = Vec::new();
    if on_coordinate {
        depends_on.push(coordinate.clone());
    }
    if on_velocity && (!on_coordinate || velocity != coordinate) {
        depends_on.push(velocity);
    }
    let nearest = law.nearest().iter().chain(&["unknown_function"]);
    let finite = |x: f64| x.is_finite().then_some(x);
    SealedEffect {
        name: Name::new(law.class(), name),
        other: None,
        depends_on,
        parameters: json!(format!("{law:?}")),
        accept: nearest.map(|class| Name::new(class, name)).collect(),
        catalogue: false,
        area: law.region().map(|[from, to]| Area::Region {
            variable: coordinate,
            from: finite(from),
            to: finite(to),
        }),
        gap_over_noise: 0.0,
    }
}
