//! What all hypotheses share: the model, the recordings, the magnitudes of every channel.

use super::paths::Paths;
use super::{Hypothesis, Window, lines};
use crate::dataset::{Dataset, Observed};
use crate::diagnosis::Integration;
use crate::prediction::Predictor;
use crate::range::inner_range;
use crate::trajectories::{SmoothedRecording, unmeasured};
use crate::{DiagnoseError, Watch};
use lacuna_effects::{Acts, Effect, InServo, Law, Scales};
use lacuna_numbers::{Dual, Number};
use lacuna_plants::model::{
    Direction, ModelEffect, Observation, SeriesEffect, StepInput, System, effective_inputs,
};
use lacuna_plants::{InputPath, Model, Substeps};
use lacuna_recordings::{Sampling, estimate_noise_pooled};
use rayon::prelude::*;
use std::borrow::Cow;
use std::sync::Arc;

/// One value in so many is left out at either end of a channel's range.
const ENDS: usize = 2000;
/// Samples of a recording at which the model's forces are looked at.
const POINTS: usize = 60;
/// Most Runge-Kutta steps a sample in a search.
const MOST: usize = 16;
/// Most Runge-Kutta steps a sample, for what goes astray in fewer.
const FINEST: usize = 64;

/// Finer steps than those in which something goes astray: they are cut where slopes jump, and four times as many then.
pub(super) fn finer(steps: Substeps) -> Option<Substeps> {
    match steps.cut {
        false => Some(Substeps::cut(steps.count)),
        true => Some(Substeps::cut(4 * steps.count)).filter(|finer| finer.count <= MOST),
    }
}

/// A model and the recordings that it is compared with.
pub struct Problem<'a> {
    /// The model.
    pub model: &'a Model,
    /// The recordings.
    pub dataset: &'a Dataset,
    /// The recordings' motion as they alone tell it.
    pub smoothed: Vec<SmoothedRecording>,
    /// Usual time from sample to sample (s).
    pub sample: f64,
    /// One over the noise of each output.
    pub weights: Vec<f64>,
    /// What the recordings see of the state.
    pub observation: Observation,
    /// Noise of the coarsest output as a share of half its range.
    pub coarsest: f64,
    /// Entries of the machine's state that nothing measures, not even as a derivative.
    pub(super) hidden: Vec<usize>,
    /// Magnitudes of each force channel.
    channels: Vec<Scales>,
    /// Magnitudes of each input.
    inputs: Vec<Scales>,
    /// Of each input, magnitudes of the error and of the force of the servo that follows it.
    in_servos: Vec<(Scales, Scales)>,
    /// Magnitudes of the differences of each force channel and those before it
    /// ([`Scales::apart`]).
    apart: Vec<Vec<(f64, f64)>>,
    /// Noise that each input shows, or that the model states.
    input_noise: Vec<f64>,
    /// The recorded inputs between their samples.
    paths: Paths,
    /// Who waits for fits.
    watch: Option<&'a Watch<'a>>,
}

impl<'a> Problem<'a> {
    /// Smooth the recordings and measure the magnitudes of every channel.
    ///
    /// # Errors
    /// A channel that cannot be smoothed.
    pub fn new(model: &'a Model, dataset: &'a Dataset) -> Result<Self, DiagnoseError> {
        let smoothed = dataset
            .recordings
            .par_iter()
            .map(|o| SmoothedRecording::new(model, dataset, o))
            .collect::<Result<Vec<_>, _>>()?;
        let sample = Sampling::of(&smoothed[0].times).step;
        let n = model.coordinates.len();
        let unmeasured = unmeasured(model, dataset);
        let hidden = (0..model.machine_states())
            .filter(|i| unmeasured.contains(&if (n..2 * n).contains(i) { i - n } else { *i }));
        let measured: Vec<_> = dataset.outputs.iter().map(|o| o.of).collect();
        let share = |k: usize| dataset.noise_sd(k) / dataset.half_range(k);
        let mut this = Self {
            model,
            dataset,
            smoothed,
            sample,
            weights: (0..dataset.outputs.len()).map(|k| 1.0 / dataset.noise_sd(k)).collect(),
            observation: Observation::of(model, &measured),
            coarsest: (0..dataset.outputs.len()).map(share).fold(0.0, f64::max),
            hidden: hidden.collect(),
            channels: vec![],
            inputs: vec![],
            in_servos: vec![],
            apart: vec![],
            input_noise: input_noise(model, dataset),
            paths: Paths::default(),
            watch: None,
        };
        super::hidden::fill(&mut this)?;
        this.channels = this.channel_scales();
        let before = |c: usize| (0..c).map(|o| this.differences(c, o)).collect();
        this.apart = (0..model.channels()).map(before).collect();
        this.inputs = (0..model.inputs.len()).map(|j| this.input_scales(j)).collect();
        this.in_servos = (0..model.inputs.len()).map(|j| this.servo_scales(j)).collect();
        Ok(this)
    }

    /// The same, its fits to be given up as soon as nobody waits for them any more.
    #[must_use]
    pub fn watched_by(self, watch: &'a Watch<'a>) -> Self {
        Self { watch: Some(watch), ..self }
    }

    /// Whether fits are to be given up.
    #[must_use]
    pub fn is_cancelled(&self) -> bool {
        self.watch.is_some_and(|watch| watch.is_cancelled() || watch.is_late())
    }

    /// Magnitudes that an effect on a channel (or input, or sensor) is judged by.
    #[must_use]
    pub fn scales(&self, effect: &Effect, channel: usize, other: Option<usize>) -> Scales {
        match (effect.law, effect.acts) {
            (Law::Input(_), _) => match self.model.in_servo(effect, channel) {
                Some(InServo::Error) => self.in_servos[channel].0,
                Some(InServo::Force) => self.in_servos[channel].1,
                None => self.inputs[channel],
            },
            (Law::Structure(_), _) => self.structure_scales(effect.acts, channel),
            (Law::Sensor(_), _) | (_, Acts::Sensors) => self.sensor_scales(channel),
            (Law::Force(_), _) => {
                let mut scales = self.channels[channel];
                match other {
                    Some(input) if effect.names_input() => scales.input = self.inputs[input].input,
                    Some(o) => {
                        let s = &self.channels[o];
                        scales.other = (s.half_range(), s.v, s.force);
                        scales.apart = self.apart[channel.max(o)][channel.min(o)];
                    }
                    None => {}
                }
                scales
            }
        }
    }

    /// Magnitudes that a given effect is judged by.
    #[must_use]
    pub fn scales_of(&self, e: &ModelEffect) -> Scales {
        self.scales(e.effect, e.channel, e.other)
    }

    /// Entries of the machine's state that nothing measures.
    #[must_use]
    pub fn hidden(&self) -> &[usize] {
        &self.hidden
    }

    /// What the input effects among `effects` make of a recording's commands: those themselves
    /// where there are none.
    #[must_use]
    pub fn effective_inputs<'o>(
        &self,
        effects: &[ModelEffect],
        observed: &'o Observed,
    ) -> Cow<'o, [f64]> {
        let on_inputs = SeriesEffect::inputs(self.model, effects);
        if on_inputs.is_empty() {
            return Cow::Borrowed(&observed.commands);
        }
        let (m, commands) = (self.model.input_width(), observed.commands.clone());
        Cow::Owned(effective_inputs(&on_inputs, m, &observed.times, commands))
    }

    /// Effective inputs of a recording along one of its windows and the step that leaves it.
    pub(super) fn inputs_along<'s>(
        &self,
        w: &Window,
        inputs: &'s [f64],
        substeps: usize,
    ) -> Arc<InputPath<'s, f64>> {
        let Observed { times, commands, .. } = &self.dataset.recordings[w.recording];
        let range = w.range.start..w.range.end + 1;
        let make = || self.model.inputs_along((times, inputs), range, substeps);
        // Those that were recorded are the same for all fits.
        if std::ptr::eq(inputs, &commands[..]) {
            self.paths.along(w, substeps, make)
        } else {
            Arc::new(make())
        }
    }

    /// The motion of a hypothesis on a recording, given its path (rows of the whole state).
    #[must_use]
    pub fn motion(&self, h: &Hypothesis, r: usize, path: &[f64]) -> SmoothedRecording {
        let system = System::with(self.model, &h.parameters, &h.effects);
        self.measured_motion(&h.effects, r).along(&system, path)
    }

    /// The measured motion of a recording, its inputs as actuators with some effects apply them.
    #[must_use]
    pub fn measured_motion(&self, effects: &[ModelEffect], r: usize) -> SmoothedRecording {
        let inputs = self.effective_inputs(effects, &self.dataset.recordings[r]);
        self.smoothed[r].driven_by(inputs.into_owned())
    }

    /// Largest absolute command to an actuator.
    #[must_use]
    pub fn largest_command(&self, input: usize) -> f64 {
        self.inputs[input].input.1
    }

    /// Standard deviation of the commands to an actuator.
    #[must_use]
    pub fn input_deviation(&self, input: usize) -> f64 {
        self.inputs[input].input.0
    }

    /// The noise of a recorded input as the model states it; where it does not, that which the input
    /// shows itself: it cannot differ from what the machine got by more.
    #[must_use]
    pub fn input_noise(&self, input: usize) -> f64 {
        self.input_noise[input]
    }

    /// Magnitude of the force that moves a channel.
    #[must_use]
    pub fn force_scale(&self, channel: usize) -> f64 {
        self.channels[channel].force
    }

    /// Runge-Kutta steps a sample that a model needs: fewer where it is `corrected` at every sample, as a filter
    /// does.
    #[must_use]
    pub fn substeps(
        &self,
        parameters: &[f64],
        effects: &[ModelEffect],
        corrected: bool,
    ) -> Substeps {
        // A twentieth of the noise: a search need not be finer.
        self.steps_within(parameters, effects, corrected, (0.05, MOST)).substeps()
    }

    /// The same for a model that goes astray in as many as a search takes: what errs by more than the noise there
    /// oscillates from step to step, and its derivatives say nothing. None where they are enough.
    #[must_use]
    pub fn finer_substeps(
        &self,
        parameters: &[f64],
        effects: &[ModelEffect],
        corrected: bool,
    ) -> Option<Substeps> {
        let needed = self.steps_within(parameters, effects, corrected, (1.0, FINEST)).substeps();
        Some(needed).filter(|steps| steps.count > MOST)
    }

    fn steps_within(
        &self,
        parameters: &[f64],
        effects: &[ModelEffect],
        corrected: bool,
        (tolerance, most): (f64, usize),
    ) -> Integration {
        let once = Substeps::even(1);
        let p = Predictor::with_substeps(self.model, parameters, effects, self.dataset, once);
        match corrected && self.is_robot() {
            true => p.needed_from_sample_to_sample(&self.smoothed[0], (tolerance, most)),
            false => p.needed_while_following((tolerance, most)),
        }
    }

    /// Half the range of an entry of the machine's state.
    #[must_use]
    pub fn state_scale(&self, state: usize) -> f64 {
        let n = self.model.coordinates.len();
        let scale = if state < n {
            self.channels[state].half_range()
        } else if state < 2 * n {
            self.channels[state - n].v
        } else {
            self.channels[state - n].half_range()
        };
        if scale > 0.0 { scale } else { 1.0 }
    }

    /// How much a robot moves, and how far one of its links reaches.
    fn structure_scales(&self, acts: Acts, channel: usize) -> Scales {
        // Of a robot of rotors and points nothing is known: a kilogram and a metre.
        let or_one = |x: f64| if x > 0.0 { x } else { 1.0 };
        let link = match self.model.dynamics().tree().filter(|_| acts == Acts::Links) {
            Some(tree) => (or_one(tree.mass()), or_one(tree.reach(channel))),
            None => (1.0, 1.0),
        };
        Scales { link, step: self.sample, time: self.times(), ..Scales::default() }
    }

    fn sensor_scales(&self, state: usize) -> Scales {
        let n = self.model.coordinates.len();
        let channel = if state < n { state } else { state - n };
        let mut scales = self.channels[channel];
        if (n..2 * n).contains(&state) {
            scales.q = (-2.0 * scales.v, 2.0 * scales.v);
        }
        scales
    }

    fn times(&self) -> (f64, f64) {
        let begin = self.smoothed.iter().map(|s| s.times[0]).fold(f64::INFINITY, f64::min);
        let last = |s: &SmoothedRecording| s.times[s.len() - 1];
        (begin, self.smoothed.iter().map(last).fold(f64::NEG_INFINITY, f64::max))
    }

    fn channel_scales(&self) -> Vec<Scales> {
        let mobility = self.mobility();
        let lines = lines::of_channels(self, self.times());
        let scale = |c: usize| {
            let place = self.model.place(c);
            let q = self.series(|x| x[place.q]);
            let v = self.series(|x| x[place.v]);
            let acceleration = deviation(&self.accelerations(c));
            Scales {
                q: inner_range(q, ENDS),
                si: place.si,
                stroke: self.stroke(c),
                v: deviation(&v),
                acceleration,
                force: self
                    .measured_force(c)
                    .unwrap_or_else(|| (acceleration / mobility[c]).max(self.balanced(c))),
                inertia: mobility[c].recip(),
                other: (1.0, 1.0, 1.0),
                apart: (1.0, 1.0),
                input: (0.0, 0.0),
                link: (0.0, 0.0),
                step: self.sample,
                time: self.times(),
                lines: lines[c].rates,
                pitches: lines[c].pitches,
            }
        };
        (0..self.model.channels()).map(scale).collect()
    }

    /// Whether the equations of motion are those of a robot's tree of links.
    #[must_use]
    pub fn is_robot(&self) -> bool {
        self.model.dynamics().tree().is_some()
    }

    /// The force of the inputs on a joint of a robot, which friction may balance: links of a wrist that weigh next
    /// to nothing say nothing of it.
    fn balanced(&self, channel: usize) -> f64 {
        if self.is_robot() { self.applied(channel) } else { 0.0 }
    }

    /// Standard deviation of the force that the inputs exert on a channel: where most of it is balanced by what
    /// the model does not know, nothing moves.
    fn applied(&self, channel: usize) -> f64 {
        let (model, n) = (self.model, self.model.coordinates.len());
        let (states, m) = (model.machine_states(), model.inputs.len());
        let parameters = model.with_structure(&model.values(), &model.effects);
        let dynamics = model.dynamics();
        let bound = dynamics.bind(&parameters);
        let mut room = bound.room();
        let mut rates = vec![0.0; dynamics.sizes().rates()];
        let mut all = vec![];
        for s in &self.smoothed {
            for k in (0..s.len()).step_by(s.len().div_ceil(POINTS)) {
                let width = model.input_width();
                let mut variables = s.state(k).to_vec();
                variables.extend_from_slice(&s.inputs[k * width..k * width + m]);
                variables.push(s.times[k]);
                bound.evaluate(&mut room, &variables, &mut rates);
                let with = rates[n * n + channel];
                variables[states..states + m].fill(0.0);
                bound.evaluate(&mut room, &variables, &mut rates);
                all.push(with - rates[n * n + channel]);
            }
        }
        let applied = deviation(&all);
        if applied.is_finite() { applied } else { 0.0 }
    }

    /// What the smoothed states of all recordings say of something.
    pub(super) fn series(&self, of: impl Fn(&[f64]) -> f64) -> Vec<f64> {
        let states = |s| (0..SmoothedRecording::len(s)).map(move |k| s.state(k));
        self.smoothed.iter().flat_map(states).map(of).collect()
    }

    /// Half the range of the difference of two channels' coordinates, and the standard deviation
    /// of its rate.
    fn differences(&self, channel: usize, other: usize) -> (f64, f64) {
        let (a, b) = (self.model.place(channel), self.model.place(other));
        let (low, high) = inner_range(self.series(|x| x[b.q] - x[a.q]), ENDS);
        let rate = deviation(&self.series(|x| x[b.v] - x[a.v]));
        (0.5 * (high - low).max(f64::MIN_POSITIVE), rate.max(f64::MIN_POSITIVE))
    }

    /// Rate of change of a channel's velocity, or of a first-order state.
    pub(super) fn accelerations(&self, channel: usize) -> Vec<f64> {
        let place = self.model.place(channel);
        let at = |s: &SmoothedRecording, k: usize| s.state(k)[place.v];
        let slopes = |s: &'_ SmoothedRecording| -> Vec<f64> {
            // Over a few samples: what is left of the noise must not count.
            let gap = (s.len() / 200).clamp(1, 5);
            (gap..s.len())
                .map(|k| (at(s, k) - at(s, k - gap)) / (s.times[k] - s.times[k - gap]))
                .collect()
        };
        self.smoothed.iter().flat_map(slopes).collect()
    }

    /// Acceleration per unit of force on each channel, in the mean along the recordings.
    pub(super) fn mobility(&self) -> Vec<f64> {
        let (model, n) = (self.model, self.model.coordinates.len());
        let at = |c: usize| {
            let push = [(Direction::Force(c), 0)];
            let system = System::along(model, &model.values(), &model.effects, &push, self.sample);
            let mut w = system.workspace();
            let mut sum = 0.0;
            let mut count = 0.0;
            for s in &self.smoothed {
                for k in (0..s.len()).step_by(s.len().div_ceil(POINTS)) {
                    let x = system.at_rest(s.state(k));
                    let mut x: Vec<Dual> = x.into_iter().map(Dual::constant).collect();
                    let m = model.input_width();
                    let u: Vec<Dual> =
                        s.inputs[k * m..(k + 1) * m].iter().map(|&u| Dual::constant(u)).collect();
                    let h = 1e-3 * self.sample;
                    system.advance(
                        &mut w,
                        (s.times[k], s.times[k] + h),
                        StepInput::Line(&u, &u),
                        Substeps::even(1),
                        &mut x,
                    );
                    let slope = x[c + n].tangent[0] / h;
                    if slope.is_finite() {
                        sum += slope;
                        count += 1.0;
                    }
                }
            }
            if sum > 0.0 { sum / count } else { 1.0 }
        };
        (0..model.channels()).map(at).collect()
    }

    /// Standard deviation of the measured force on an imposed coordinate; none of a free one, and
    /// where nothing shows it.
    fn measured_force(&self, channel: usize) -> Option<f64> {
        let output = self.outputs_of_force(channel).next()?;
        let all = self.dataset.recordings.iter().flat_map(|o| &o.outputs[output.0]);
        let measured: Vec<f64> = all.copied().filter(|y| y.is_finite()).collect();
        Some(deviation(&measured) / output.1.abs())
    }

    /// Outputs that show a force on a channel at once, and by how much of it they change: those of
    /// the force on an imposed coordinate.
    pub(crate) fn outputs_of_force(&self, channel: usize) -> impl Iterator<Item = (usize, f64)> {
        let (model, motion) = (self.model, &self.smoothed[0]);
        let slopes: Vec<f64> = if model.is_imposed(channel) {
            let push = [(Direction::Force(channel), 0)];
            let system = System::along(model, &model.values(), &model.effects, &push, self.sample);
            let constants =
                |x: &[f64]| -> Vec<Dual> { x.iter().map(|&x| Dual::constant(x)).collect() };
            // Outputs are linear in forces, so that any sample will do.
            let k = motion.len() / 2;
            let m = model.input_width();
            let x = constants(&system.at_rest(motion.state(k)));
            let u = constants(&motion.inputs[k * m..(k + 1) * m]);
            let mut y = vec![Dual::constant(0.0); self.dataset.outputs.len()];
            self.observation.evaluate(&system, motion.times[k], &x, &u, &mut y);
            y.iter().map(|y| y.tangent[0]).collect()
        } else {
            vec![]
        };
        slopes.into_iter().enumerate().filter(|(_, slope)| *slope != 0.0 && slope.is_finite())
    }

    /// Half the range that a channel covers within an eighth of a recording, in the median.
    fn stroke(&self, channel: usize) -> f64 {
        let place = self.model.place(channel);
        let mut strokes: Vec<f64> = Vec::new();
        for s in &self.smoothed {
            let q: Vec<f64> = (0..s.len()).map(|k| s.state(k)[place.q]).collect();
            strokes.extend(q.chunks(q.len().div_ceil(8)).map(|part| {
                let (low, high) = inner_range(part.to_vec(), ENDS);
                0.5 * (high - low)
            }));
        }
        strokes.sort_by(f64::total_cmp);
        strokes[strokes.len() / 2].max(f64::MIN_POSITIVE)
    }

    fn input_scales(&self, j: usize) -> Scales {
        let m = self.model.input_width();
        let inputs = self.smoothed.iter().flat_map(|s| s.inputs.iter().skip(j).step_by(m));
        self.scales_of_input(&inputs.copied().collect::<Vec<_>>())
    }

    /// Those of the error and of the force of the servo that follows an input, along the measured motion.
    fn servo_scales(&self, j: usize) -> (Scales, Scales) {
        let (model, m) = (self.model, self.model.input_width());
        let servos = model.servos(&model.values(), &model.effects);
        let (mut errors, mut forces) = (vec![], vec![]);
        if let Some((servo, _)) = model.servo_of(j) {
            for motion in &self.smoothed {
                for (k, u) in motion.inputs.chunks_exact(m).enumerate() {
                    errors.push(servos.error(servo, motion.state(k), u));
                    forces.push(servos.force(servo, motion.state(k), u));
                }
            }
        }
        (self.scales_of_input(&errors), self.scales_of_input(&forces))
    }

    /// Magnitudes of what an effect on inputs acts on.
    fn scales_of_input(&self, u: &[f64]) -> Scales {
        let largest = u.iter().fold(0.0f64, |a, b| a.max(b.abs()));
        Scales {
            input: (deviation(u), largest),
            step: self.sample,
            time: self.times(),
            ..Scales::default()
        }
    }
}

/// Noise of each input: stated, or shown.
fn input_noise(model: &Model, dataset: &Dataset) -> Vec<f64> {
    let inputs = model.inputs.iter().enumerate();
    inputs.map(|(j, input)| input.noise.unwrap_or_else(|| shown_noise(dataset, j))).collect()
}

/// Noise that the commands to an actuator show; none where it cannot be told.
fn shown_noise(dataset: &Dataset, input: usize) -> f64 {
    let all: Vec<Vec<f64>> = dataset.recordings.iter().map(|o| o.command(input)).collect();
    let times = dataset.recordings.iter().map(|o| &o.times[..]);
    let pairs: Vec<(&[f64], &[f64])> = times.zip(all.iter().map(Vec::as_slice)).collect();
    estimate_noise_pooled(&pairs).map_or(0.0, |n| n.sd)
}

/// Standard deviation.
pub(super) fn deviation(values: &[f64]) -> f64 {
    let n = values.len().max(1) as f64;
    let mean = values.iter().sum::<f64>() / n;
    (values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / n).sqrt()
}
