//! A case: files for the diagnosis, and the truth under seal.

use lacuna_excitation::{add_gaussian_noise, rng};
use lacuna_recordings::{Column, Recording};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::ConcealedError;
use super::draw::{Draft, RECORDINGS, generator};
use super::fair::Fair;
use super::machine::Files;
use super::scales::deviation;
use super::sealed::{Group, Sealed};
use super::sensor::seen;
use super::topic::{Topic, sequence, shares, shuffle};
use super::truth::{Motion, rounded};
use super::windows::{Output, WINDOWS};
use crate::StudyError;

/// Draws before a topic is given up.
const ATTEMPTS: usize = 400;
/// Fewest samples of a recording at rest: no shorter one is read.
const REST_SAMPLES: usize = 120;
/// Recordings that a machine may take to come to rest.
const SETTLING: usize = 4;

/// A case.
#[derive(Clone, Debug)]
pub struct Case {
    /// The truth.
    pub sealed: Sealed,
    /// The model as files.
    pub files: Files,
    /// Column of time in the recordings.
    pub time_column: String,
    /// Recordings for the diagnosis.
    pub recordings: Vec<Recording>,
    /// True states at the rows of these recordings.
    pub states: Vec<Recording>,
    /// Recordings for the proof.
    pub tests: Vec<Recording>,
}

/// What a case is to be: its number, family and topic.
#[derive(Clone, Debug)]
pub struct Plan {
    /// Its name, which tells nothing.
    pub id: String,
    /// Number of its random stream.
    pub stream: usize,
    /// Family.
    pub group: Group,
    /// Topic.
    pub topic: Topic,
}

/// The plans of a study: `count` cases of one group, or of all in shares, in random order.
pub fn plans(seed: u64, count: usize, group: Option<Group>) -> Vec<Plan> {
    let mut rng = rng(seed, 0);
    let shares = match group {
        Some(group) => vec![(group, count)],
        None => shares(count).to_vec(),
    };
    let mut plans = Vec::new();
    for (group, count) in shares {
        let topics = sequence(group, count, &mut rng);
        plans.extend(topics.into_iter().map(|topic| (group, topic)));
    }
    shuffle(&mut plans, &mut rng);
    let plan = |(k, (group, topic)): (usize, (Group, Topic))| {
        let id = format!("{:03}-{:06x}", k + 1, rng.random_range(0..0x0100_0000u32));
        Plan { id, stream: k, group, topic }
    };
    plans.into_iter().enumerate().map(plan).collect()
}

impl Case {
    /// Draw the case of a plan: machines are drawn until one is fair ([`Fair`]), that is
    /// until what is concealed makes a difference of at least [`super::fair::LEAST_GAP`].
    ///
    /// # Errors
    /// [`ConcealedError::NoCase`] when no draw is fair; errors of the plants' files.
    pub fn draw(seed: u64, plan: &Plan) -> Result<Self, StudyError> {
        Self::draw_with_noise(seed, plan, 0)
    }

    /// The same machine and motion with the `noise`-th noise; [`Case::draw`] has that of number 0.
    ///
    /// # Errors
    /// As [`Case::draw`].
    pub fn draw_with_noise(seed: u64, plan: &Plan, noise: u64) -> Result<Self, StudyError> {
        Ok(Self::drafted(seed, plan, noise)?.1)
    }

    /// A recording of the case's machine at rest, a second or a hundred and twenty samples; none where it does not
    /// come to rest.
    ///
    /// # Errors
    /// As [`Case::draw`].
    pub fn rest(seed: u64, plan: &Plan) -> Result<Option<Recording>, StudyError> {
        let (draft, _, mut rng) = Self::drafted(seed, plan, 0)?;
        let samples = ((1.0 / draft.spec.step) as usize).max(REST_SAMPLES);
        let Ok(motion) = draft.settling(SETTLING * draft.spec.samples) else { return Ok(None) };
        let begin = motion.times.len() - samples;
        let is_still = |o: &Output| {
            let all = &motion.series(o.entry)[begin..];
            let range = all.iter().fold((f64::MAX, f64::MIN), |r, y| (r.0.min(*y), r.1.max(*y)));
            range.1 - range.0 < 0.1 * o.sd
        };
        if !draft.outputs.iter().all(is_still) {
            return Ok(None);
        }
        let kept: Vec<usize> = (begin..motion.times.len()).collect();
        let recording = measured(&draft, &motion, &motion.times, &mut rng)?;
        Ok(Some(rows(&recording, &kept)))
    }

    /// A fair draft with its case, and the generator as it is then.
    fn drafted(
        seed: u64,
        plan: &Plan,
        noise: u64,
    ) -> Result<(Draft, Self, ChaCha8Rng), StudyError> {
        let mut rng = generator(seed, plan.stream);
        for _ in 0..ATTEMPTS {
            let Some(draft) = Draft::draw(plan.topic, plan.group.plants(), &mut rng)? else {
                continue;
            };
            if let Some(case) = Self::of(plan, &draft, (&mut rng, noise))? {
                return Ok((draft, case, rng));
            }
        }
        Err(ConcealedError::NoCase { topic: plan.topic.words(), attempts: ATTEMPTS }.into())
    }

    /// The case of a draft; none where the draft is not fair.
    fn of(
        plan: &Plan,
        draft: &Draft,
        (rng, noise): (&mut ChaCha8Rng, u64),
    ) -> Result<Option<Self>, StudyError> {
        let Some(fair) = Fair::of(draft) else { return Ok(None) };
        // Whatever follows from the generator now is noise and lost rows.
        (0..noise).for_each(|_| *rng = ChaCha8Rng::from_rng(rng));
        let Fair { motions, effects, matter, model_gap } = fair;
        let how = draft.concealment;
        let noise = |o: &Output| (draft.nominal.state_name(o.entry).to_owned(), how.total(o.sd));
        let length = motions[0].times.len();
        let sealed = Sealed {
            case: plan.id.clone(),
            plant: draft.nominal.name.clone(),
            group: plan.group,
            topic: plan.topic.words(),
            matter,
            drive: draft.drive.word().to_owned(),
            effects,
            miscalibrated: draft.factors(),
            noise_sd: draft.outputs.iter().map(noise).collect(),
            model_gap_over_noise: model_gap,
            concealment: how,
            horizon_s: (length / WINDOWS) as f64 * draft.spec.step,
        };
        let mut case = Self {
            sealed,
            files: draft.files.clone(),
            time_column: draft.nominal.time_column.clone(),
            recordings: Vec::new(),
            states: Vec::new(),
            tests: Vec::new(),
        };
        for (k, motion) in motions.iter().enumerate() {
            let stamps = how.stamps(&motion.times, rng)?;
            let mut recording = measured(draft, motion, &stamps, rng)?;
            let logged = how.logged(motion.times.len());
            if k < RECORDINGS {
                for (column, output) in recording.columns.iter_mut().zip(&draft.outputs) {
                    how.glitch(&mut column.values, output.sd, rng);
                }
                let kept = how.kept(logged.len(), rng);
                let kept: Vec<usize> = kept.into_iter().map(|row| logged[row]).collect();
                case.recordings.push(rows(&recording, &kept));
                case.states.push(rows(&states(draft, motion, &stamps), &kept));
            } else {
                case.tests.push(rows(&recording, &logged));
            }
        }
        Ok(Some(case))
    }
}

/// What the sensors and the logger make of a motion.
fn measured(
    draft: &Draft,
    motion: &Motion,
    stamps: &[f64],
    rng: &mut ChaCha8Rng,
) -> Result<Recording, StudyError> {
    let model = &draft.nominal;
    let sensors = draft.truth(|_| true).sensors;
    let mut columns = Vec::new();
    for output in &draft.outputs {
        let shown = seen(motion, output.entry, sensors[output.entry]);
        let values = draft.concealment.measure(shown, output.sd, rng)?;
        columns.push(column(model.state_name(output.entry), &values));
    }
    let m = model.inputs.len();
    for (j, input) in model.inputs.iter().enumerate() {
        let mut values: Vec<f64> = motion.commands.iter().skip(j).step_by(m).copied().collect();
        let noise = draft.concealment.input_noise * deviation(values.iter().copied());
        add_gaussian_noise(&mut values, noise, rng)?;
        columns.push(column(&input.name, &values));
    }
    Ok(recording(stamps, columns))
}

/// The true states of a motion.
fn states(draft: &Draft, motion: &Motion, stamps: &[f64]) -> Recording {
    let model = &draft.nominal;
    let entry = |i: usize| column(model.state_name(i), &motion.series(i));
    recording(stamps, (0..model.machine_states()).map(entry).collect())
}

fn recording(stamps: &[f64], columns: Vec<Column>) -> Recording {
    // Time stamps are on a grid of a thousandth of a step or finer.
    let time = stamps.iter().map(|t| (t * 1e9).round() / 1e9).collect();
    Recording { name: String::new(), time, columns }
}

fn column(name: &str, values: &[f64]) -> Column {
    Column { name: name.to_owned(), values: values.iter().copied().map(rounded).collect() }
}

/// Some rows of a recording.
fn rows(recording: &Recording, kept: &[usize]) -> Recording {
    let pick = |values: &[f64]| kept.iter().map(|&k| values[k]).collect();
    let columns = recording
        .columns
        .iter()
        .map(|c| Column { name: c.name.clone(), values: pick(&c.values) })
        .collect();
    Recording { name: recording.name.clone(), time: pick(&recording.time), columns }
}
