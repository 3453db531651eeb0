//! Which drafts make a fair case: the motion is integrated finely, stays within reach, and what is
//! concealed makes a difference that can be seen.

use lacuna_effects::Law as CatalogueLaw;

use super::conceal::Concealed;
use super::draw::{Draft, RECORDINGS, TESTS};
use super::gap::{Gap, gap};
use super::rivals::as_good;
use super::seal::{beyond, catalogued};
use super::sealed::{Matter, Name, SealedEffect};
use super::sensor::seen;
use super::topic::Topic;
use super::truth::Motion;
use super::windows::{Output, Shown, WINDOWS};
use lacuna_plants::{Hold, System, rk4_sampled};

/// Least calibrated gap of an effect, in noise standard deviations: less could be told by nobody.
pub const LEAST_GAP: f64 = 3.0;
/// Recordings that gaps are measured on.
const GAP_RECORDINGS: usize = 3;
/// Steps a sample that the truth is tried with, fewest first.
const SUBSTEPS: [usize; 4] = [8, 16, 32, 64];
/// Most that halving the step may change over two windows, in noise standard deviations.
const INTEGRATION: f64 = 0.1;
/// A change of a hidden coordinate, as a share of its half range, that must show.
const HIDDEN_STEP: f64 = 0.2;
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
        // What is concealed must show without the help of a random force.
        let calm = match draft.disturbance {
            Some(_) => calm(draft, motions[0].substeps)?,
            None => vec![],
        };
        let some = if calm.is_empty() { &motions[..GAP_RECORDINGS] } else { &calm[..] };
        if !draft.hidden.is_none_or(|coordinate| shows(draft, &some[0], coordinate)) {
            return None;
        }
        let count = draft.effects.len();
        let effects = (0..count).map(|k| sealed(draft, some, k)).collect::<Option<Vec<_>>>()?;
        let model_gap = gap(&draft.nominal, &shown(draft, some), &draft.outputs).ok()?.raw;
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
        [] if draft.disturbance.is_some() => Matter::Disturbed,
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

/// Whether what is measured depends on where a coordinate that nobody measures begins.
fn shows(draft: &Draft, motion: &Motion, coordinate: usize) -> bool {
    let model = System::new(&draft.calibrated);
    let run = |start: &[f64]| {
        let (times, hold) = (&motion.times, Hold::ZeroOrder);
        rk4_sampled(&model, &model.at_rest(start), times, &motion.commands, hold, 2)
    };
    let here = motion.state(0).to_vec();
    let mut moved = here.clone();
    moved[coordinate] += HIDDEN_STEP * draft.scales.channels[coordinate].half_range();
    let (Ok(a), Ok(b)) = (run(&here), run(&moved)) else { return false };
    draft.outputs.iter().any(|o| {
        let change = |k: usize| (a.state(k)[o.entry] - b.state(k)[o.entry]).abs();
        (0..motion.times.len()).any(|k| change(k) > LEAST_GAP * o.sd)
    })
}

/// The first motions, where no random force acts.
fn calm(draft: &Draft, substeps: usize) -> Option<Vec<Motion>> {
    (0..GAP_RECORDINGS).map(|k| draft.calm(k, draft.spec.samples, substeps).ok()).collect()
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
    let Gap { raw, calibrated, free } = gap(&without, &shown, &draft.outputs).ok()?;
    let mut effect = match &draft.effects[k] {
        Concealed::Known(e) => catalogued(draft, e),
        Concealed::Beyond(law, channel) => beyond(&draft.nominal, law, *channel),
    };
    effect.gap_over_noise = calibrated;
    // What other parameters would explain down to the noise, far off or not, may be called so.
    if free < 1.0 {
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
