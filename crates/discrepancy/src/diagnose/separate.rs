//! Which experiment would tell rivals apart: the one in which their predictions differ most.

use super::outcome::Ladder;
use crate::diagnosis::Experiment;
use crate::likelihood::Hypothesis;
use lacuna_plants::input::MOTION;
use lacuna_plants::model::{SeriesEffect, System, effective_inputs};
use rayon::prelude::*;

/// Frequencies that are tried, and amplitudes as shares of the largest command so far.
const FREQUENCIES: usize = 12;
const AMPLITUDES: [f64; 3] = [0.5, 1.0, 2.0];
/// Samples of one try.
const SAMPLES: usize = 1500;
/// An experiment must not drive an output beyond this share of its range so far.
const REACH: f64 = 1.5;

/// Root mean square difference of an output in units of its noise, and which output.
type Told = (f64, usize);

/// A sine on one input or imposed coordinate.
#[derive(Clone, Copy)]
struct Sine {
    drive: Driver,
    amplitude: f64,
    frequency: f64,
}

/// What an experimenter can move.
#[derive(Clone, Copy)]
enum Driver {
    Input(usize),
    Coordinate(usize),
}

/// What the recordings leave open: another hypothesis than the chosen one.
pub(super) struct Open<'h> {
    pub rival: &'h Hypothesis,
    /// The inputs that act where the two differ.
    pub inputs: Vec<usize>,
}

impl Open<'_> {
    fn is_moved_by(&self, sine: Sine) -> bool {
        match sine.drive {
            Driver::Input(j) => self.inputs.contains(&j),
            Driver::Coordinate(_) => true,
        }
    }
}

impl Ladder<'_> {
    /// For each rival of a fitted hypothesis the sine, among those that move what the two differ in and keep the
    /// machine near where it has been, for which they differ most in units of the noise; none where there is no
    /// rival, or no sine tells them apart.
    pub(super) fn separating(
        &self,
        chosen: &Hypothesis,
        rivals: &[Option<Open>],
    ) -> Vec<Option<Experiment>> {
        let mut sines = self.sines();
        sines.retain(|sine| rivals.iter().flatten().any(|open| open.is_moved_by(*sine)));
        let tried = sines.par_iter().map(|sine| {
            let here = self.response(chosen, *sine)?;
            let tell = |open: &Option<Open>| {
                let open = open.as_ref().filter(|open| open.is_moved_by(*sine))?;
                self.difference(&here, &self.response(open.rival, *sine)?)
            };
            Some(rivals.iter().map(tell).collect::<Vec<_>>())
        });
        let tried: Vec<Option<Vec<Option<Told>>>> = tried.collect();
        let best = |k: usize| {
            let told = tried.iter().zip(&sines);
            let told = told.filter_map(|(told, sine)| Some((told.as_ref()?[k]?, *sine)));
            let (told, sine) = told.max_by(|(x, _), (y, _)| x.0.total_cmp(&y.0))?;
            self.suggested(sine, told)
        };
        (0..rivals.len()).map(best).collect()
    }

    /// An experiment with a sine that is told by an output.
    fn suggested(&self, sine: Sine, (difference, output): Told) -> Option<Experiment> {
        let model = self.problem.model;
        let (drive, unit) = match sine.drive {
            Driver::Input(j) => (model.inputs[j].name.clone(), model.inputs[j].unit.clone()),
            Driver::Coordinate(c) => (model.state_name(c).to_owned(), model.state_unit(c)),
        };
        (difference > 1.0).then(|| Experiment {
            drive,
            amplitude: sine.amplitude,
            unit,
            frequency_hz: sine.frequency,
            watch: self.problem.dataset.outputs[output].name.clone(),
            difference_over_noise: difference,
        })
    }

    /// Sines from one period in the recordings to a tenth of the sampling rate.
    fn sines(&self) -> Vec<Sine> {
        let data = self.problem.dataset;
        let (slow, fast) = (2.0 / super::duration(data), 0.1 / self.problem.sample);
        let (problem, model) = (self.problem, self.problem.model);
        let inputs = model.actuators().map(|j| (Driver::Input(j), problem.largest_command(j)));
        let motion = model.imposed().map(|c| (Driver::Coordinate(c), problem.state_scale(c)));
        let mut out = Vec::new();
        for (drive, largest) in inputs.chain(motion) {
            for share in AMPLITUDES {
                for k in 0..FREQUENCIES {
                    let at = k as f64 / (FREQUENCIES - 1) as f64;
                    let frequency = slow * (fast / slow).powf(at);
                    out.push(Sine { drive, amplitude: share * largest, frequency });
                }
            }
        }
        out
    }

    /// Of two responses, the output that differs most.
    fn difference(&self, x: &[Vec<f64>], y: &[Vec<f64>]) -> Option<Told> {
        let rms = |k: usize| {
            let squares: f64 = x[k].iter().zip(&y[k]).map(|(p, q)| (p - q).powi(2)).sum();
            (squares / x[k].len() as f64).sqrt() * self.problem.weights[k]
        };
        (0..x.len()).map(|k| (rms(k), k)).max_by(|p, q| p.0.total_cmp(&q.0))
    }

    /// Rows of inputs in which a sine alone acts. Other imposed coordinates stay where they began, and
    /// so does what nobody commands: a recorded mass is never 0.
    fn commands(&self, times: &[f64], sine: Sine) -> Vec<f64> {
        let (model, motion) = (self.problem.model, &self.problem.smoothed[0]);
        let width = model.input_width();
        let begun = &self.problem.dataset.recordings[0].commands;
        let mut still = vec![0.0; width];
        for (j, _) in model.inputs.iter().enumerate().filter(|(_, input)| !input.actuator) {
            still[j] = begun[j];
        }
        for (c, at) in model.imposed().filter_map(|c| Some((c, model.motion_index(c)?))) {
            still[at] = motion.state(0)[c];
        }
        let mut rows = still.repeat(times.len());
        let w = std::f64::consts::TAU * sine.frequency;
        for (row, t) in rows.chunks_exact_mut(width).zip(times) {
            let (sin, cos) = (w * t).sin_cos();
            match sine.drive {
                Driver::Input(j) => row[j] = sine.amplitude * sin,
                Driver::Coordinate(c) => {
                    let Some(at) = model.motion_index(c) else { continue };
                    let motion = [sin, w * cos, -w * w * sin].map(|x| sine.amplitude * x);
                    row[at..at + MOTION].copy_from_slice(&motion);
                }
            }
        }
        rows
    }

    /// Outputs under a sine from where the first recording begins; none where they leave the
    /// range that the recordings covered.
    fn response(&self, h: &Hypothesis, sine: Sine) -> Option<Vec<Vec<f64>>> {
        let problem = self.problem;
        let model = problem.model;
        let (m, step) = (model.input_width(), problem.sample);
        let times: Vec<f64> = (0..SAMPLES).map(|k| step * k as f64).collect();
        let commands = self.commands(&times, sine);
        let inputs =
            effective_inputs(&SeriesEffect::inputs(model, &h.effects), m, &times, commands);
        let system = System::with(model, &h.parameters, &h.effects);
        let (observation, count) = (&problem.observation, problem.dataset.outputs.len());
        let path =
            model.inputs_along((&times, &inputs), 0..SAMPLES, self.found.chosen.substeps.count);
        let mut start = problem.smoothed[0].state(0).to_vec();
        system.impose(path.sample(0), &mut start);
        let mut x = system.at_rest(&start);
        let mut workspace = system.workspace();
        let mut out = vec![Vec::with_capacity(SAMPLES); count];
        let mut y = vec![0.0; count];
        let limits: Vec<f64> = (0..count).map(|k| REACH * largest(problem.dataset, k)).collect();
        for k in 0..SAMPLES - 1 {
            let u = path.sample(k);
            observation.evaluate(&system, times[k], &x, u, &mut y);
            for ((series, value), limit) in out.iter_mut().zip(&y).zip(&limits) {
                if value.is_nan() || value.abs() > *limit {
                    return None;
                }
                series.push(*value);
            }
            let substeps = self.found.chosen.substeps;
            system.advance(
                &mut workspace,
                (times[k], times[k + 1]),
                path.step(k),
                substeps,
                &mut x,
            );
        }
        Some(out)
    }
}

/// Largest absolute value of an output.
fn largest(data: &crate::Dataset, output: usize) -> f64 {
    let values = data.recordings.iter().flat_map(|o| &o.outputs[output]);
    values.filter(|v| v.is_finite()).fold(0.0f64, |a, v| a.max(v.abs()))
}
