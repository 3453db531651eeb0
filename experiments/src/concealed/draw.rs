//! Drawing a case: machine, concealed physics, motions.

use lacuna_effects::Law as CatalogueLaw;
use lacuna_excitation::rng;
use lacuna_plants::{Model, System};
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use std::collections::BTreeMap;

use super::actuator::Actuator;
use super::conceal::{Concealed, conceal};
use super::disturbance::Disturbance;
use super::drive::{Course, Drive};
use super::effects::{log_uniform, uniform};
use super::machine::{self, Files};
use super::plants::PlantSpec;
use super::scales::{Scales, deviation};
use super::sensor::{Concealment, Sensor};
use super::topic::{Hardship, Noise, Topic};
use super::truth::{Motion, Truth, run};
use super::windows::Output;
use crate::StudyError;

/// Recordings that the diagnosis is given.
pub const RECORDINGS: usize = 5;
/// Recordings for the proof.
pub const TESTS: usize = 3;
/// Runge-Kutta steps a sample of the motion from which scales are read.
const SCOUT_SUBSTEPS: usize = 4;

/// A machine with its concealed physics, before it has moved.
#[derive(Debug)]
pub struct Draft {
    /// The plant.
    pub spec: &'static PlantSpec,
    /// What the case is about.
    pub topic: Topic,
    /// The model as files.
    pub files: Files,
    /// The same, read.
    pub nominal: Model,
    /// The model with the true parameters and no effect.
    pub calibrated: Model,
    /// What is concealed.
    pub effects: Vec<Concealed>,
    /// How the recordings hide it.
    pub concealment: Concealment,
    /// What is measured, with the noise of it.
    pub outputs: Vec<Output>,
    /// How the plant is driven.
    pub drive: Drive,
    /// Course and initial state of each recording, those for the proof last.
    pub courses: Vec<(Course, Vec<f64>)>,
    /// Magnitudes without the effects.
    pub scales: Scales,
    /// A random force, where one acts.
    pub disturbance: Option<Disturbance>,
    /// A coordinate that nobody measures.
    pub hidden: Option<usize>,
}

impl Draft {
    /// Draw a machine for a topic; none where the plant drawn does not suit it.
    ///
    /// # Errors
    /// [`StudyError`] for a plant's model file or drive that is wrong.
    pub fn draw(
        topic: Topic,
        plants: &'static [PlantSpec],
        rng: &mut ChaCha8Rng,
    ) -> Result<Option<Self>, StudyError> {
        let spec = &plants[rng.random_range(0..plants.len())];
        let (files, nominal) = machine::draw(spec, rng)?;
        let drive = spec.drives[rng.random_range(0..spec.drives.len())];
        let mut courses = Vec::new();
        for _ in 0..RECORDINGS + TESTS {
            let start: Vec<f64> = spec.start.iter().map(|[a, b]| uniform(rng, *a, *b)).collect();
            courses.push((drive.draw(rng)?, start));
        }
        let calibrated = machine::miscalibrated(&nominal, topic, rng);
        let scout = run(
            &Truth::of(&calibrated),
            &System::new(&nominal),
            &courses[0].0,
            &courses[0].1,
            (spec.step, spec.samples),
            SCOUT_SUBSTEPS,
        );
        // A plant that runs away even without the effect suits no topic.
        let Ok(scout) = scout else { return Ok(None) };
        let scales = Scales::of(&calibrated, &scout);
        let Some(effects) = conceal(topic, spec, &calibrated, &scales, rng) else {
            return Ok(None);
        };
        let mut concealment = hide(topic.noise(), rng);
        let mut outputs = outputs(spec, &nominal, &concealment, &scout);
        let (mut disturbance, mut hidden) = (None, None);
        match topic.hardship() {
            Some(Hardship::NoisyInputs) => concealment.input_noise = uniform(rng, 0.01, 0.05),
            Some(Hardship::Glitches) => concealment.glitches = uniform(rng, 0.001, 0.006),
            Some(Hardship::SlowLog) => concealment.thinned = [1, 3][rng.random_range(0..2)],
            Some(Hardship::RandomForce) => {
                let share = if effects.is_empty() { [0.01, 0.1] } else { [0.005, 0.03] };
                let all = (share, RECORDINGS + TESTS);
                disturbance = Some(Disturbance::draw(spec, &scales, all, rng)?);
            }
            Some(Hardship::HiddenCoordinate) => {
                let n = nominal.coordinates.len();
                if n < 2 {
                    return Ok(None);
                }
                let coordinate = rng.random_range(0..n);
                outputs.retain(|o| o.entry != coordinate && o.entry != n + coordinate);
                hidden = Some(coordinate);
            }
            None => {}
        }
        let draft = Self {
            spec,
            topic,
            files,
            nominal,
            calibrated,
            effects,
            concealment,
            outputs,
            drive,
            courses,
            scales,
            disturbance,
            hidden,
        };
        Ok(Some(draft))
    }

    /// The true machine with some of its effects.
    pub fn truth(&self, which: impl Fn(usize) -> bool) -> Truth {
        let mut truth = Truth::of(&self.calibrated);
        for (_, effect) in self.effects.iter().enumerate().filter(|(k, _)| which(*k)) {
            match effect {
                Concealed::Beyond(law, channel) => truth.laws.push((*law, *channel)),
                Concealed::Known(e) => match e.effect.law {
                    CatalogueLaw::Force(_) | CatalogueLaw::Structure(_) => {
                        truth.model.effects.push(e.clone())
                    }
                    CatalogueLaw::Input(_) => {
                        truth.actuators[e.channel] = Actuator::of(e.effect.class, e.parameters[0]);
                    }
                    CatalogueLaw::Sensor(_) => {
                        truth.sensors[e.channel] = Sensor::of(e.effect.class, e.parameters[0]);
                    }
                },
            }
        }
        truth
    }

    /// Run the first `samples` of recording `k` of the true machine.
    ///
    /// # Errors
    /// [`StudyError`] when it diverges.
    pub fn motion(&self, k: usize, samples: usize, substeps: usize) -> Result<Motion, StudyError> {
        let mut truth = self.truth(|_| true);
        truth.gusts = self.disturbance.as_ref().map(|d| d.course(k));
        self.run(&truth, k, samples, substeps)
    }

    /// The same where no random force acts.
    ///
    /// # Errors
    /// [`StudyError`] when it diverges.
    pub fn calm(&self, k: usize, samples: usize, substeps: usize) -> Result<Motion, StudyError> {
        self.run(&self.truth(|_| true), k, samples, substeps)
    }

    /// Run the true machine from where recording 0 begins until it rests, driven by nothing but constants.
    ///
    /// # Errors
    /// [`StudyError`] when it diverges.
    pub fn settling(&self, samples: usize) -> Result<Motion, StudyError> {
        let (course, start) = &self.courses[0];
        let course = course.clone().quiet();
        let nominal = System::new(&self.nominal);
        let times = (self.spec.step, samples);
        run(&self.truth(|_| true), &nominal, &course, start, times, SCOUT_SUBSTEPS)
    }

    fn run(
        &self,
        truth: &Truth,
        k: usize,
        samples: usize,
        substeps: usize,
    ) -> Result<Motion, StudyError> {
        let (course, start) = &self.courses[k];
        let nominal = System::new(&self.nominal);
        run(truth, &nominal, course, start, (self.spec.step, samples), substeps)
    }

    /// True over nominal value of the parameters that are wrong.
    pub fn factors(&self) -> BTreeMap<String, f64> {
        let pairs = self.nominal.parameters.iter().zip(&self.calibrated.parameters);
        let wrong = pairs.filter(|(a, b)| a.value != b.value);
        wrong.map(|(a, b)| (a.name.clone(), b.value / a.value)).collect()
    }
}

/// The generator of a case.
pub fn generator(seed: u64, case: usize) -> ChaCha8Rng {
    rng(seed, 1 + case as u64)
}

/// Draw how the recordings hide the physics.
fn hide(noise: Noise, rng: &mut ChaCha8Rng) -> Concealment {
    let share = log_uniform(rng, 0.003, 0.02);
    let mut with = |probability: f64, low: f64, high: f64| {
        let value = uniform(rng, low, high);
        if rng.random_range(0.0..1.0) < probability { value } else { 0.0 }
    };
    Concealment {
        noise_share: share,
        quantum: with(0.3, 1.0, 3.0),
        dropped: with(0.25, 0.01, 0.06),
        velocities: with(0.25, 1.0, 1.0) > 0.0,
        inner_states: with(0.5, 1.0, 1.0) > 0.0,
        colour: with(if noise == Noise::Coloured { 1.0 } else { 0.0 }, 0.6, 0.95),
        jitter: with(if noise == Noise::Jitter { 1.0 } else { 0.0 }, 0.05, 0.25),
        ..Concealment::default()
    }
}

fn outputs(spec: &PlantSpec, model: &Model, how: &Concealment, scout: &Motion) -> Vec<Output> {
    let n = model.coordinates.len();
    let measured = |i: &usize| {
        let velocity = (n..2 * n).contains(i);
        let inner = spec.inner.contains(&model.state_name(*i));
        (how.velocities || !velocity) && (how.inner_states || !inner)
    };
    let output = |entry: usize| {
        let series = scout.series(entry);
        Output { entry, sd: how.noise_share * deviation(series.iter().copied()) }
    };
    (0..model.machine_states()).filter(measured).map(output).collect()
}
