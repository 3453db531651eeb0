//! Predictions of a model.

use super::state::{self, Runner};
use super::substeps::Beginning;
use super::{Prediction, Series, first_astray, ranges, substeps};
use crate::dataset::{Dataset, Observed};
use crate::diagnosis::Integration;
use crate::trajectories::SmoothedRecording;
use lacuna_numbers::{Dual, LANES, Number};
use lacuna_plants::Substeps;
use lacuna_plants::model::{
    Measured, ModelEffect, Observation, SeriesEffect, StepInput, Strand, Workspace,
    advance_together, sensed,
};
use lacuna_plants::{Model, System};
use rayon::prelude::*;
use std::ops::Range;

/// A model, ready to predict the outputs of a dataset.
pub struct Predictor<'a> {
    model: Model,
    parameters: Vec<f64>,
    observation: Observation,
    plain: InNumbers<f64>,
    dataset: &'a Dataset,
    weights: Vec<f64>,
    integration: Integration,
}

/// A model in one kind of number.
struct InNumbers<T: Number> {
    system: System<T>,
    sensors: Vec<SeriesEffect<T>>,
}

/// A recording with the inputs that the actuators make of its commands.
struct Driven<'b> {
    observed: &'b Observed,
    effective: Vec<f64>,
}

impl<'a> Predictor<'a> {
    /// A model with its own parameters and effects.
    #[must_use]
    pub fn new(model: &Model, dataset: &'a Dataset) -> Self {
        Self::with(model, &model.values(), &model.effects, dataset)
    }

    /// A model with other parameters and effects.
    #[must_use]
    pub fn with(
        model: &Model,
        parameters: &[f64],
        effects: &[ModelEffect],
        dataset: &'a Dataset,
    ) -> Self {
        let mut this = Self::with_substeps(model, parameters, effects, dataset, Substeps::even(1));
        this.integration = this.needed_substeps(substeps::TOLERANCE, substeps::MOST);
        this.shorten_steps_where_it_diverges();
        this
    }

    /// Steps of which a run through a whole recording makes numbers that are none are halved as long as that helps: stretches
    /// do not show where everything is stiffest. What diverges in the shortest as well does so by itself.
    fn shorten_steps_where_it_diverges(&mut self) {
        let found = self.integration;
        let steps = |k: u32| Integration { steps_a_sample: found.steps_a_sample << k, ..found };
        let fewest = (0..)
            .map(steps)
            .take_while(|s| s.steps_a_sample <= substeps::MOST)
            .find(|s| !self.diverges(s.substeps()));
        self.integration = fewest.unwrap_or(found);
    }

    /// Whether a run through some recording, from what is measured at its beginning, ends in no number.
    fn diverges(&self, substeps: Substeps) -> bool {
        let ends = |o: &Observed| self.through(o, substeps).1.iter().all(|x| x.is_finite());
        !self.dataset.recordings.par_iter().all(ends)
    }

    /// The run through a whole recording from what is measured at its beginning, and the state in which it ends.
    fn through(&self, observed: &Observed, substeps: Substeps) -> (Series, Vec<f64>) {
        let mut state = self.guess(observed, 0);
        let steps = (0..observed.len(), substeps);
        (self.run(&self.plain, &self.drive(observed), steps, &mut state), state)
    }

    /// The same with given RK4 steps a sample.
    pub(crate) fn with_substeps(
        model: &Model,
        parameters: &[f64],
        effects: &[ModelEffect],
        dataset: &'a Dataset,
        substeps: Substeps,
    ) -> Self {
        let mut model = model.clone();
        model.effects = effects.to_vec();
        let measured: Vec<_> = dataset.outputs.iter().map(|o| o.of).collect();
        let observation = Observation::of(&model, &measured);
        let weights = (0..measured.len()).map(|k| 1.0 / dataset.noise_sd(k)).collect();
        let plain = InNumbers {
            system: System::with(&model, parameters, effects),
            sensors: SeriesEffect::sensors(effects),
        };
        let parameters = parameters.to_vec();
        let integration = Integration::in_steps(substeps);
        Self { model, parameters, observation, plain, dataset, weights, integration }
    }

    /// RK4 steps between two samples, at most so many, whose error stays below a share of the
    /// noise.
    fn needed_substeps(&self, tolerance: f64, most: usize) -> Integration {
        self.needed_along((tolerance, most), |_, series| series)
    }

    /// The same as far as the model follows the recordings: where it is off by more than an output ranges over it has
    /// run away, and how it tumbles from there no window of a fit sees.
    pub(crate) fn needed_while_following(&self, limits: (f64, usize)) -> Integration {
        let most = ranges(self.dataset);
        self.needed_along(limits, |(observed, range), mut series| {
            let begin = range.start;
            if let Some(at) = first_astray((observed, range), (&series, begin), &most) {
                series.iter_mut().for_each(|output| output.truncate(at + 1 - begin));
            }
            series
        })
    }

    /// Of runs of which only what is `told` counts, beside the outputs that were measured.
    fn needed_along(
        &self,
        (tolerance, most): (f64, usize),
        told: impl Fn((&Observed, Range<usize>), Series) -> Series,
    ) -> Integration {
        let stretches = substeps::stretches(self.dataset).into_iter();
        let driven: Vec<_> = stretches.map(|(o, ranges)| (self.drive(o), ranges)).collect();
        if driven.is_empty() {
            return self.integration;
        }
        substeps::fewest(self.dataset, (tolerance, most), |steps, beginning, budget| {
            substeps::along(substeps::each(&driven), budget, |driven, range, budget| {
                let mut state = self.guess(driven.observed, range.start);
                self.move_state(beginning, &mut state);
                let run = (range.clone(), steps);
                let (series, steps) = self.run_within(budget, &self.plain, driven, run, &mut state);
                (told((driven.observed, range), series), steps)
            })
        })
    }

    /// The same from one sample to the next alone, along a motion of the machine in the first recording: what is
    /// corrected at every sample carries its errors no further.
    pub(crate) fn needed_from_sample_to_sample(
        &self,
        motion: &SmoothedRecording,
        (tolerance, most): (f64, usize),
    ) -> Integration {
        let Some(observed) = self.dataset.recordings.first() else { return self.integration };
        let driven = self.drive(observed);
        let places = self.telling(motion);
        substeps::fewest(self.dataset, (tolerance, most), |steps, beginning, budget| {
            let steps_from = places.iter().map(|&k| (&driven, k..k + 2));
            substeps::along(steps_from, budget, |driven, range, budget| {
                let mut state = self.plain.system.at_rest(motion.state(range.start));
                self.move_state(beginning, &mut state);
                self.run_within(budget, &self.plain, driven, (range, steps), &mut state)
            })
        })
    }

    /// Whether effects remember anything.
    fn remembers(&self) -> bool {
        self.plain.system.width() > self.plain.system.machine_states()
    }

    /// A measured state as the runs begin from it that tell how errors grow. What effects remember nobody measures:
    /// that what it makes of an error is the machine's doing cannot be told.
    fn move_state(&self, beginning: Beginning, state: &mut [f64]) {
        if !self.remembers() {
            beginning.move_state(self.dataset, state);
        }
    }

    /// Samples along a motion that tell how many steps it needs: some spread evenly, and those where each
    /// coordinate is slowest, since friction is stiff where a joint turns.
    fn telling(&self, motion: &SmoothedRecording) -> Vec<usize> {
        const EVENLY: usize = 96;
        const SLOWEST: usize = 8;
        let (n, last) = (self.model.coordinates.len(), motion.len().saturating_sub(1));
        let mut places: Vec<usize> = (0..last).step_by((last / EVENLY).max(1)).collect();
        for coordinate in 0..n {
            let speed = |k: &usize| motion.state(*k)[n + coordinate].abs();
            let mut all: Vec<usize> = (0..last).collect();
            all.sort_by(|a, b| speed(a).total_cmp(&speed(b)));
            places.extend(all.iter().take(SLOWEST));
        }
        places
    }

    /// How its predictions are integrated.
    #[must_use]
    pub fn integration(&self) -> Integration {
        self.integration
    }

    fn drive<'b>(&self, observed: &'b Observed) -> Driven<'b> {
        let effective = self.model.effective_inputs(&observed.times, &observed.commands);
        Driven { observed, effective }
    }

    /// The model in numbers that carry derivatives.
    fn dual(&self) -> InNumbers<Dual> {
        let Self { model, parameters, .. } = self;
        InNumbers {
            system: System::along(model, parameters, &model.effects, &[], 0.0),
            sensors: SeriesEffect::sensors_along(&model.effects, &[]),
        }
    }

    /// Outputs over a range from a whole state, memory included, so many steps a sample; NaN from
    /// where the model diverges.
    fn run<T: Number>(
        &self,
        model: &InNumbers<T>,
        driven: &Driven,
        steps: (Range<usize>, Substeps),
        state: &mut [T],
    ) -> Vec<Vec<T>> {
        self.run_within(usize::MAX, model, driven, steps, state).0
    }

    /// The same as far as so many Runge-Kutta steps in all go, and how many they were.
    fn run_within<T: Number>(
        &self,
        budget: usize,
        model: &InNumbers<T>,
        driven: &Driven,
        steps: (Range<usize>, Substeps),
        state: &mut [T],
    ) -> (Vec<Vec<T>>, usize) {
        let mut alone = [Way::of(model, (self.weights.len(), steps.0.len()), state)];
        self.run_together(budget, model, driven, steps, &mut alone);
        let [Way { outputs, workspace, .. }] = alone;
        (outputs, workspace.steps())
    }

    /// Runs side by side, from states of the same values that carry different directions.
    fn run_together<T: Number>(
        &self,
        budget: usize,
        model: &InNumbers<T>,
        driven: &Driven,
        (range, substeps): (Range<usize>, Substeps),
        ways: &mut [Way<T>],
    ) {
        let Driven { observed, effective } = driven;
        let times = &observed.times[range.clone()];
        let series = (&observed.times[..], &effective[..]);
        let inputs = self.model.inputs_along(series, range, substeps.count);
        let mut u = vec![T::constant(0.0); self.model.input_width()];
        for at in 0..times.len() {
            if !ways[0].state.iter().all(|x| x.value().is_finite()) {
                break;
            }
            inputs.sample_in(at, &mut u);
            for Way { state, y, outputs, .. } in &mut *ways {
                model.system.impose(&u, state);
                self.observation.evaluate(&model.system, times[at], state, &u, y);
                outputs.iter_mut().zip(y).for_each(|(series, y)| series[at] = *y);
            }
            if at + 1 == times.len() || ways[0].workspace.steps() > budget {
                break;
            }
            let (span, input) = ((times[at], times[at + 1]), inputs.step_in(at));
            match &mut *ways {
                [alone] => advance_together(&mut [alone.strand(model, input)], span, substeps),
                ways => {
                    let strands = ways.iter_mut().map(|way| way.strand(model, input));
                    advance_together(&mut strands.collect::<Vec<_>>(), span, substeps);
                }
            }
        }
        for Way { outputs, .. } in ways {
            for (series, output) in outputs.iter_mut().zip(&self.dataset.outputs) {
                let Measured::State(entry) = output.of else { continue };
                *series = sensed(&model.sensors, entry, times, std::mem::take(series));
            }
        }
    }

    /// A first guess of the state at a sample: what is measured there, velocities as slopes
    /// over a few samples, zero for what is not measured, memory at rest.
    fn guess(&self, observed: &Observed, at: usize) -> Vec<f64> {
        let n = self.model.coordinates.len();
        let mut x = vec![0.0; self.model.machine_states()];
        let near = at..(at + 12).min(observed.len());
        for (k, output) in self.dataset.outputs.iter().enumerate() {
            let Measured::State(i) = output.of else { continue };
            let (value, slope) =
                line(&observed.times[near.clone()], &observed.outputs[k][near.clone()]);
            x[i] = value;
            if i < n && self.dataset.output_of_state(i + n).is_none() {
                x[i + n] = slope;
            }
        }
        let m = self.model.input_width();
        self.plain.system.impose(&observed.commands[at * m..(at + 1) * m], &mut x);
        self.plain.system.at_rest(&x)
    }

    /// A run to the end from the state that fits the first `warmup` samples, which do not
    /// count for the error.
    #[must_use]
    pub fn free_run(&self, observed: &Observed, warmup: usize) -> Prediction {
        state::free_run(&self.driving(&self.drive(observed)), warmup)
    }

    /// Runs of `horizon` seconds, the state at the beginning of each fitted to that window.
    #[must_use]
    pub fn windowed(&self, observed: &Observed, horizon: f64) -> Prediction {
        state::windowed(&self.driving(&self.drive(observed)), horizon)
    }

    /// Squares, in units of the noise, by which the inputs that a recording lost move what it measured, where each
    /// is off by its standard deviation.
    pub(crate) fn moved_by_lost(&self, observed: &Observed) -> f64 {
        let m = self.model.input_width();
        let mut moved = observed.clone();
        observed.lost.iter().for_each(|l| moved.commands[l.row * m + l.input] += l.sd);
        let run = |observed: &Observed| self.through(observed, self.integration.substeps()).0;
        let (here, there) = (run(observed), run(&moved));
        let squares = |k: usize| {
            let measured = observed.outputs[k].iter().zip(here[k].iter().zip(&there[k]));
            let off = measured
                .filter(|(y, _)| y.is_finite())
                .map(|(_, (a, b))| self.weights[k] * (a - b));
            off.map(|off| off * off).sum::<f64>()
        };
        (0..self.weights.len()).map(squares).sum()
    }

    fn driving<'r>(&'r self, driven: &'r Driven<'r>) -> Driving<'r, 'a> {
        Driving { predictor: self, driven, dual: self.dual() }
    }
}

/// A model on a recording.
struct Driving<'r, 'a> {
    predictor: &'r Predictor<'a>,
    driven: &'r Driven<'r>,
    dual: InNumbers<Dual>,
}

impl Runner for Driving<'_, '_> {
    fn observed(&self) -> &Observed {
        self.driven.observed
    }

    fn weights(&self) -> &[f64] {
        &self.predictor.weights
    }

    fn guess(&self, at: usize) -> Vec<f64> {
        self.predictor.guess(self.driven.observed, at)
    }

    fn remembers(&self) -> bool {
        self.predictor.remembers()
    }

    fn remember(&self, range: Range<usize>, x0: &[f64], guess: &mut [f64]) {
        let Predictor { model, plain, integration, .. } = self.predictor;
        let machine = model.machine_states();
        let mut state = x0.to_vec();
        self.predictor.run(plain, self.driven, (range, integration.substeps()), &mut state);
        if state.iter().all(|x| x.is_finite()) {
            guess[machine..].copy_from_slice(&state[machine..]);
        }
    }

    fn run(&self, range: Range<usize>, x0: &[f64]) -> Series {
        let Predictor { plain, integration, .. } = self.predictor;
        let steps = (range, integration.substeps());
        self.predictor.run(plain, self.driven, steps, &mut x0.to_vec())
    }

    /// Exact: the entries of the state in the lanes of dual numbers, strands of them side by side.
    fn run_along(&self, range: Range<usize>, x0: &[f64], _here: &Series) -> Vec<Series> {
        let Self { predictor, driven, dual } = self;
        let seeded = |first: usize| -> Vec<Dual> {
            x0.iter().enumerate().map(|(i, x)| Dual::among(*x, i, first)).collect()
        };
        let mut states: Vec<_> = (0..x0.len()).step_by(LANES).map(seeded).collect();
        let size = (predictor.weights.len(), range.len());
        let mut ways: Vec<_> = states.iter_mut().map(|x| Way::of(dual, size, x)).collect();
        let steps = (range, predictor.integration.substeps());
        predictor.run_together(usize::MAX, dual, driven, steps, &mut ways);
        let along = |i: usize| -> Series {
            let lane = |series: &Vec<Dual>| series.iter().map(|y| y.tangent[i % LANES]).collect();
            ways[i / LANES].outputs.iter().map(lane).collect()
        };
        (0..x0.len()).map(along).collect()
    }
}

/// A run on its way.
struct Way<'s, T: Number> {
    state: &'s mut [T],
    workspace: Workspace<T>,
    /// The outputs at a sample.
    y: Vec<T>,
    /// Their series; NaN from where the run has diverged.
    outputs: Vec<Vec<T>>,
}

impl<'s, T: Number> Way<'s, T> {
    /// From a state, of so many outputs over so many samples.
    fn of(model: &InNumbers<T>, (outputs, samples): (usize, usize), state: &'s mut [T]) -> Self {
        Self {
            state,
            workspace: model.system.workspace(),
            y: vec![T::constant(0.0); outputs],
            outputs: vec![vec![T::constant(f64::NAN); samples]; outputs],
        }
    }

    /// The step that leaves a sample.
    fn strand<'w>(
        &'w mut self,
        model: &'w InNumbers<T>,
        inputs: StepInput<'w, T>,
    ) -> Strand<'w, T> {
        Strand { system: &model.system, workspace: &mut self.workspace, inputs, state: self.state }
    }
}

/// Value at the first time and slope of the least-squares line through the finite samples.
fn line(times: &[f64], values: &[f64]) -> (f64, f64) {
    let points: Vec<_> = times
        .iter()
        .zip(values)
        .filter(|(_, y)| y.is_finite())
        .map(|(t, y)| (t - times[0], *y))
        .collect();
    let n = points.len() as f64;
    if points.is_empty() {
        return (0.0, 0.0);
    }
    let (mt, my) =
        (points.iter().map(|p| p.0).sum::<f64>() / n, points.iter().map(|p| p.1).sum::<f64>() / n);
    let stt: f64 = points.iter().map(|p| (p.0 - mt).powi(2)).sum();
    let sty: f64 = points.iter().map(|p| (p.0 - mt) * (p.1 - my)).sum();
    let slope = if stt > 0.0 { sty / stt } else { 0.0 };
    (my - slope * mt, slope)
}

#[cfg(test)]
mod tests {
    use super::super::state::Runner;
    use super::{Driving, LANES, Predictor, Range, Series};
    use crate::dataset::{Dataset, Observed};
    use lacuna_plants::{Model, Substeps};
    use lacuna_recordings::{Column, Recording};

    /// The same runs, which know of no derivatives.
    struct Differences<'d>(&'d Driving<'d, 'd>);

    impl Runner for Differences<'_> {
        fn observed(&self) -> &Observed {
            self.0.observed()
        }

        fn weights(&self) -> &[f64] {
            self.0.weights()
        }

        fn guess(&self, at: usize) -> Vec<f64> {
            self.0.guess(at)
        }

        fn run(&self, range: Range<usize>, x0: &[f64]) -> Series {
            self.0.run(range, x0)
        }
    }

    /// Five masses, each on a hard spring to the one before it: more entries of the state than a number has lanes.
    fn masses() -> Model {
        let coordinate = |k| format!("[[coordinate]]\nname = \"q{k}\"\nvelocity = \"v{k}\"\n");
        let row =
            |k| (0..5).map(|j| if j == k { "\"1\", " } else { "\"0\", " }).collect::<String>();
        let force = |k: usize| match k {
            0 => "\"-q0 - q0^3\", ".into(),
            k => format!("\"-2 * (q{k} - q{j})^3 - 0.1 * v{k}\", ", j = k - 1),
        };
        let all = |of: &dyn Fn(usize) -> String| (0..5).map(of).collect::<String>();
        let mass = all(&|k| format!("[{}], ", row(k)));
        let text = format!(
            "name = \"masses\"\n{}[mechanics]\nmass = [{mass}]\nforce = [{}]\n",
            all(&coordinate),
            all(&force)
        );
        Model::from_text(&text, "model.toml").expect("a model")
    }

    /// Runge-Kutta steps are stable up to 2.78 of a time constant, here three a sample; what grows by itself diverges in any.
    #[test]
    fn steps_in_which_a_recording_diverges_are_shortened() {
        let time: Vec<f64> = (0..600).map(|k| 0.002 * f64::from(k)).collect();
        let values = time.iter().map(|t| (9.0 * t).sin()).collect();
        let columns = vec![Column { name: "q".into(), values }];
        let recording = Recording { name: "run".into(), columns, time };
        let shortened = |force: &str| {
            let text = format!(
                "name = \"mass\"\n[[coordinate]]\nname = \"q\"\nvelocity = \"v\"\n\
                 [mechanics]\nmass = [[\"1\"]]\nforce = [\"{force}\"]\n"
            );
            let model = Model::from_text(&text, "model.toml").expect("a model");
            let dataset = Dataset::new(&model, std::slice::from_ref(&recording));
            let dataset = dataset.expect("a dataset");
            let steps = Substeps::even(1);
            let mut predictor =
                Predictor::with_substeps(&model, &model.values(), &[], &dataset, steps);
            predictor.shorten_steps_where_it_diverges();
            predictor.integration().steps_a_sample
        };
        assert_eq!(shortened("-q - 0.5 * v"), 1);
        assert_eq!(shortened("-q - 4500 * v"), 4);
        assert_eq!(shortened("9000 * v^3 + q + 1"), 1);
    }

    #[test]
    fn derivatives_of_runs_are_those_by_every_entry_of_the_state() {
        let model = masses();
        let time: Vec<f64> = (0..120).map(|k| 0.02 * f64::from(k)).collect();
        let column = |k: usize| Column {
            name: format!("q{k}"),
            values: time.iter().map(|t| (t * (1.0 + k as f64)).sin()).collect(),
        };
        let columns = (0..5).map(column).collect();
        let recording = Recording { name: "run".into(), columns, time };
        let dataset = Dataset::new(&model, &[recording]).expect("a dataset");
        let predictor = Predictor::new(&model, &dataset);
        let driven = predictor.drive(&dataset.recordings[0]);
        let driving = predictor.driving(&driven);
        let x0: Vec<f64> = (0..10).map(|i| 0.3 + 0.1 * f64::from(i)).collect();
        assert!(x0.len() > LANES);
        let here = driving.run(0..60, &x0);
        let exact = driving.run_along(0..60, &x0, &here);
        let differences = Differences(&driving).run_along(0..60, &x0, &here);
        assert_eq!((exact.len(), exact[0].len(), exact[0][0].len()), (10, 5, 60));
        let values = |all: &[Series]| all.iter().flatten().flatten().copied().collect::<Vec<_>>();
        for (exact, difference) in values(&exact).iter().zip(values(&differences)) {
            assert!((exact - difference).abs() < 1e-4, "{exact} {difference}");
        }
        // Each entry moves something.
        assert!(exact.iter().all(|by| by.iter().flatten().any(|d| d.abs() > 0.1)));
    }
}
