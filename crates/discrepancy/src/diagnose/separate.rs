//! Which experiment would tell rivals apart: the one in which their predictions differ most.

use super::outcome::Ladder;
use crate::diagnosis::Experiment;
use crate::likelihood::Hypothesis;
use lacuna_plants::model::{SeriesEffect, StepInput, System, effective_inputs};
use rayon::prelude::*;

/// Frequencies that are tried, and amplitudes as shares of the largest command so far.
const FREQUENCIES: usize = 12;
const AMPLITUDES: [f64; 3] = [0.5, 1.0, 2.0];
/// Samples of one try.
const SAMPLES: usize = 1500;
/// An experiment must not drive an output beyond this share of its range so far.
const REACH: f64 = 1.5;

/// A sine on one input.
#[derive(Clone, Copy)]
struct Sine {
    input: usize,
    amplitude: f64,
    frequency: f64,
}

impl Ladder<'_> {
    /// The sine, among those that keep the machine near where it has been, for which two fitted
    /// hypotheses differ most in units of the noise; none where no sine tells them apart.
    pub(super) fn separating(&self, a: &Hypothesis, b: &Hypothesis) -> Option<Experiment> {
        let tried: Vec<(f64, usize, Sine)> = self
            .sines()
            .into_par_iter()
            .filter_map(|sine| {
                let (difference, output) = self.difference(a, b, sine)?;
                Some((difference, output, sine))
            })
            .collect();
        let best = tried.into_iter().max_by(|x, y| x.0.total_cmp(&y.0))?;
        let (difference, output, sine) = best;
        let model = self.problem.model;
        (difference > 1.0).then(|| Experiment {
            drive: model.inputs[sine.input].name.clone(),
            amplitude: sine.amplitude,
            unit: model.inputs[sine.input].unit.clone(),
            frequency_hz: sine.frequency,
            watch: self.problem.dataset.outputs[output].name.clone(),
            difference_over_noise: difference,
        })
    }

    /// Sines from one period in the recordings to a tenth of the sampling rate.
    fn sines(&self) -> Vec<Sine> {
        let data = self.problem.dataset;
        let (slow, fast) = (2.0 / super::duration(data), 0.1 / self.problem.sample);
        let mut out = Vec::new();
        let actuators = self.problem.model.inputs.iter().enumerate().filter(|(_, i)| i.actuator);
        for (input, _) in actuators {
            for share in AMPLITUDES {
                for k in 0..FREQUENCIES {
                    let at = k as f64 / (FREQUENCIES - 1) as f64;
                    let frequency = slow * (fast / slow).powf(at);
                    out.push(Sine {
                        input,
                        amplitude: share * self.problem.largest_command(input),
                        frequency,
                    });
                }
            }
        }
        out
    }

    /// Greatest root mean square difference of an output in units of its noise, and the output.
    fn difference(&self, a: &Hypothesis, b: &Hypothesis, sine: Sine) -> Option<(f64, usize)> {
        let (x, y) = (self.response(a, sine)?, self.response(b, sine)?);
        let rms = |k: usize| {
            let squares: f64 = x[k].iter().zip(&y[k]).map(|(p, q)| (p - q).powi(2)).sum();
            (squares / x[k].len() as f64).sqrt() * self.problem.weights[k]
        };
        (0..x.len()).map(|k| (rms(k), k)).max_by(|p, q| p.0.total_cmp(&q.0))
    }

    /// Outputs under a sine from where the first recording begins; none where they leave the
    /// range that the recordings covered.
    fn response(&self, h: &Hypothesis, sine: Sine) -> Option<Vec<Vec<f64>>> {
        let problem = self.problem;
        let model = problem.model;
        let (m, step) = (model.inputs.len(), problem.sample);
        let times: Vec<f64> = (0..SAMPLES).map(|k| step * k as f64).collect();
        // What nobody commands stays as the recordings began: a recorded mass is never 0.
        let begun = &problem.dataset.recordings[0].commands;
        let still: Vec<f64> =
            (0..m).map(|j| if model.inputs[j].actuator { 0.0 } else { begun[j] }).collect();
        let mut commands = still.repeat(SAMPLES);
        for (k, t) in times.iter().enumerate() {
            commands[k * m + sine.input] =
                sine.amplitude * (std::f64::consts::TAU * sine.frequency * t).sin();
        }
        let inputs = effective_inputs(&SeriesEffect::inputs(&h.effects), m, &times, commands);
        let system = System::with(model, &h.parameters, &h.effects);
        let (observation, count) = (&problem.observation, problem.dataset.outputs.len());
        let bound = observation.bind(&h.parameters);
        let mut x = system.at_rest(problem.smoothed[0].state(0));
        let mut workspace = system.workspace();
        let mut out = vec![Vec::with_capacity(SAMPLES); count];
        let mut y = vec![0.0; count];
        let limits: Vec<f64> = (0..count).map(|k| REACH * largest(problem.dataset, k)).collect();
        for k in 0..SAMPLES - 1 {
            let u = &inputs[k * m..(k + 1) * m];
            observation.evaluate(&bound, times[k], &x, u, &mut y);
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
                StepInput::Line(u, u),
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
