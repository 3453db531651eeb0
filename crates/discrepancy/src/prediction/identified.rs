//! Predictions of an identified model.
//!
//! ```text
//! q^(s) = f(x) + g(x) u,   state (q, ..., q^(s-1)),   x = q or the state
//! ```

use super::state::{self, Runner};
use super::{Prediction, Series, substeps};
use crate::DiagnoseError;
use crate::dataset::{Dataset, Observed};
use lacuna_occupation::{IdentifiedModel, InputPath};
use lacuna_plants::model::Measured;
use lacuna_plants::{
    Hold, Input, Plant, SampledInput, SimulationError, SmoothInput, Trajectory, rk4,
};
use lacuna_recordings::{Prior, Sampling, Smoother};
use std::ops::Range;

/// Samples further apart than this many usual steps take more RK4 steps.
const SLACK: f64 = 1.05;

/// An identified model, ready to predict the outputs of a dataset
/// ([`Dataset::of_identified`]).
pub struct IdentifiedPredictor<'a> {
    plant: IdentifiedPlant<'a>,
    path: InputPath,
    dataset: &'a Dataset,
    weights: Vec<f64>,
    substeps: usize,
}

impl<'a> IdentifiedPredictor<'a> {
    /// A model on the recordings of a dataset.
    ///
    /// # Errors
    /// A model without names or of another form, and channels that cannot be smoothed.
    pub fn new(model: &'a IdentifiedModel, dataset: &'a Dataset) -> Result<Self, DiagnoseError> {
        let path = model.names().ok_or(DiagnoseError::Unnamed)?.input_path;
        let plant = IdentifiedPlant::new(model)?;
        let weights = (0..dataset.outputs.len()).map(|k| 1.0 / dataset.noise_sd(k)).collect();
        let mut this = Self { plant, path, dataset, weights, substeps: 1 };
        let driving = |(observed, ranges)| Ok((this.on(observed)?, ranges));
        let driving: Result<Vec<_>, DiagnoseError> =
            substeps::stretches(dataset).into_iter().map(driving).collect();
        let driving = driving?;
        let limits = (substeps::TOLERANCE, substeps::MOST);
        let needed = substeps::fewest(dataset, limits, |steps, beginning, budget| {
            // What is learned is smooth.
            if steps.cut {
                return None;
            }
            substeps::along(substeps::each(&driving), budget, |driving, range, _| {
                let mut start = driving.guess(range.start);
                beginning.move_state(dataset, &mut start);
                let run = driving.run_with(range.clone(), &start, steps.count);
                (run, steps.count * range.len())
            })
        });
        drop(driving);
        this.substeps = needed.steps_a_sample;
        Ok(this)
    }

    /// A run to the end from the state that fits the first `warmup` samples, which do not
    /// count for the error.
    ///
    /// # Errors
    /// A channel that cannot be smoothed.
    pub fn free_run(
        &self,
        observed: &Observed,
        warmup: usize,
    ) -> Result<Prediction, DiagnoseError> {
        Ok(state::free_run(&self.on(observed)?, warmup))
    }

    /// Runs of `horizon` seconds, the state at the beginning of each fitted to that window.
    ///
    /// # Errors
    /// A channel that cannot be smoothed.
    pub fn windowed(&self, observed: &Observed, horizon: f64) -> Result<Prediction, DiagnoseError> {
        Ok(state::windowed(&self.on(observed)?, horizon))
    }

    fn on<'r>(&'r self, observed: &'r Observed) -> Result<Driving<'r>, DiagnoseError> {
        Ok(Driving {
            predictor: self,
            observed,
            step: Sampling::of(&observed.times).step,
            smoothed: self.smoothed(observed)?,
        })
    }

    /// The state at every sample as the recording alone tells it: from the smoother, with the
    /// rates where they are measured.
    fn smoothed(&self, observed: &Observed) -> Result<Vec<f64>, DiagnoseError> {
        let (n, width) = (self.plant.dimension(), self.plant.states());
        let mut states = vec![0.0; observed.len() * width];
        for i in 0..n {
            let Some(k) = self.dataset.output_of_state(i) else { continue };
            let mut smoother = Smoother::new(Prior::WhiteJerk);
            if let Some(rate) = self.dataset.output_of_state(n + i) {
                smoother =
                    smoother.with_derivative(&observed.outputs[rate], self.dataset.noise_sd(rate));
            }
            let path = smoother
                .smooth(&observed.times, &observed.outputs[k], self.dataset.noise_sd(k))
                .map_err(|source| DiagnoseError::Signal {
                    recording: observed.name.clone(),
                    channel: self.dataset.outputs[k].name.clone(),
                    source,
                })?
                .at(&observed.times);
            for (row, state) in states.chunks_exact_mut(width).enumerate() {
                state[i] = path.value[row];
                if let Some(rate) = state.get_mut(n + i) {
                    *rate = path.first[row];
                }
            }
        }
        Ok(states)
    }
}

/// A model on a recording.
struct Driving<'r> {
    predictor: &'r IdentifiedPredictor<'r>,
    observed: &'r Observed,
    /// Usual time from sample to sample.
    step: f64,
    /// State at each sample as the recording alone tells it.
    smoothed: Vec<f64>,
}

impl Driving<'_> {
    fn run_with(&self, range: Range<usize>, x0: &[f64], substeps: usize) -> Series {
        let (plant, observed) = (&self.predictor.plant, self.observed);
        let (all, values) = (&observed.times[..], &observed.commands[..]);
        let input = &*path_of((all, values), self.predictor.path);
        let times = &all[range];
        let longest = SLACK * self.step / substeps as f64;
        let (states, reached) =
            until_diverged(times, |count| rk4(plant, x0, input, &times[..count], longest));
        let series = |of: Measured| {
            let Measured::State(i) = of else { return vec![f64::NAN; times.len()] };
            let reached = states.iter().skip(i).step_by(plant.states()).take(reached).copied();
            reached.chain(std::iter::repeat(f64::NAN)).take(times.len()).collect()
        };
        self.predictor.dataset.outputs.iter().map(|o| series(o.of)).collect()
    }
}

/// Sampled inputs, row after row, as what they do between samples.
fn path_of<'s>((times, values): (&'s [f64], &'s [f64]), path: InputPath) -> Box<dyn Input + 's> {
    match path {
        InputPath::Held => Box::new(SampledInput { times, values, hold: Hold::ZeroOrder }),
        InputPath::Linear => Box::new(SampledInput { times, values, hold: Hold::Linear }),
        InputPath::Smooth => Box::new(SmoothInput { times, values }),
    }
}

/// Steps of a simulation are halved until that changes no state by more than this share of its largest
/// value.
const STEPS_TELL: f64 = 1e-6;

/// Simulate an identified model from the state `x0` along inputs that are sampled at `times` (row-major
/// `times.len() x m`); the states at these times.
///
/// # Errors
/// A model of another form, and [`SimulationError`].
pub fn simulate_identified(
    model: &IdentifiedModel,
    x0: &[f64],
    (times, inputs): (&[f64], &[f64]),
    path: InputPath,
) -> Result<Trajectory, DiagnoseError> {
    let plant = IdentifiedPlant::new(model)?;
    let input = path_of((times, inputs), path);
    let longest = times.windows(2).map(|pair| pair[1] - pair[0]).fold(f64::MIN_POSITIVE, f64::max);
    let run = |substeps: usize| rk4(&plant, x0, &*input, times, longest / substeps as f64);
    let mut coarse = run(1);
    for substeps in (1..).map(|k| 1 << k).take_while(|&substeps| substeps <= substeps::MOST) {
        let fine = run(substeps);
        let settled =
            matches!((&coarse, &fine), (Ok(a), Ok(b)) if share_of_change(a, b) < STEPS_TELL);
        coarse = fine;
        if settled {
            break;
        }
    }
    Ok(coarse?)
}

/// Largest change of an entry of the state from one run to another, as a share of its largest value.
fn share_of_change(a: &Trajectory, b: &Trajectory) -> f64 {
    let entry = |i: usize| {
        let pairs = || a.states.iter().zip(&b.states).skip(i).step_by(a.width);
        let change = pairs().map(|(x, y)| (x - y).abs()).fold(0.0, f64::max);
        let largest = pairs().map(|(x, _)| x.abs()).fold(f64::MIN_POSITIVE, f64::max);
        change / largest
    };
    (0..a.width).map(entry).fold(0.0, f64::max)
}

/// States, row after row, of as many samples as a run reaches before it diverges, and their number.
fn until_diverged(
    times: &[f64],
    simulate: impl Fn(usize) -> Result<Trajectory, SimulationError>,
) -> (Vec<f64>, usize) {
    let reached = match simulate(times.len()) {
        Ok(trajectory) => return (trajectory.states, times.len()),
        Err(SimulationError::Diverged { time, .. }) => times.partition_point(|&t| t < time),
        Err(_) => return (vec![], 0),
    };
    match simulate(reached) {
        Ok(trajectory) => (trajectory.states, reached),
        Err(_) => (vec![], 0),
    }
}

impl Runner for Driving<'_> {
    fn observed(&self) -> &Observed {
        self.observed
    }

    fn weights(&self) -> &[f64] {
        &self.predictor.weights
    }

    fn guess(&self, at: usize) -> Vec<f64> {
        let width = self.predictor.plant.states();
        self.smoothed[at * width..(at + 1) * width].to_vec()
    }

    fn run(&self, range: Range<usize>, x0: &[f64]) -> Series {
        self.run_with(range, x0, self.predictor.substeps)
    }
}

/// An identified model as something that moves.
struct IdentifiedPlant<'a>(&'a IdentifiedModel);

impl<'a> IdentifiedPlant<'a> {
    fn new(model: &'a IdentifiedModel) -> Result<Self, DiagnoseError> {
        let (order, coordinates, arguments) = (model.order(), model.dimension(), model.arguments());
        let fits = arguments == coordinates || arguments == order * coordinates;
        if !(1..=2).contains(&order) || !fits {
            return Err(DiagnoseError::Form { order, coordinates, arguments });
        }
        Ok(Self(model))
    }
}

impl Plant for IdentifiedPlant<'_> {
    fn order(&self) -> usize {
        self.0.order()
    }

    fn dimension(&self) -> usize {
        self.0.dimension()
    }

    fn inputs(&self) -> usize {
        self.0.inputs()
    }

    fn derivative(&self, _t: f64, state: &[f64], u: &[f64], derivative: &mut [f64]) {
        let (n, m) = (self.dimension(), self.inputs());
        let (rates, highest) = derivative.split_at_mut(state.len() - n);
        rates.copy_from_slice(&state[n..]);
        let mut g = vec![0.0; n * m];
        if self.0.evaluate(&state[..self.0.arguments()], highest, &mut g).is_err() {
            // A state of another length than the model's has no derivative.
            highest.fill(f64::NAN);
        }
        for (i, slope) in highest.iter_mut().enumerate() {
            *slope += g[i * m..(i + 1) * m].iter().zip(u).map(|(g, u)| g * u).sum::<f64>();
        }
    }
}
