//! The smoothed trajectories that force laws are evaluated along.

use crate::DiagnoseError;
use crate::dataset::{Dataset, Observed, smoothed};
use lacuna_effects::{AnyForceLaw, At, Channel};
use lacuna_plants::{Model, Plant, System};
use rayon::prelude::*;

/// One recording's smoothed states.
#[derive(Clone, Debug)]
pub struct SmoothedRecording {
    /// Times (s).
    pub times: Vec<f64>,
    /// Inputs and imposed motion, row-major: as commanded, or along a fit as its actuators apply them.
    pub inputs: Vec<f64>,
    /// Machine states, row-major `times.len() x machine_states`.
    pub states: Vec<f64>,
    /// Derivatives of the first-order states, row-major `times.len() x states`.
    pub rates: Vec<f64>,
    /// Second derivatives of the coordinates, row-major `times.len() x coordinates`.
    pub accelerations: Vec<f64>,
    coordinates: usize,
    width: usize,
}

/// Machine states that no output measures directly and nothing imposes.
#[must_use]
pub fn unmeasured(model: &Model, dataset: &Dataset) -> Vec<usize> {
    (0..model.channels())
        .map(|c| model.coordinate_index(c))
        .filter(|&i| dataset.output_of_state(i).is_none() && !model.is_imposed_state(i))
        .collect()
}

impl SmoothedRecording {
    /// Smooth every measured coordinate and state of a recording.
    ///
    /// # Errors
    /// [`DiagnoseError::Signal`] for a channel that cannot be smoothed.
    pub fn new(
        model: &Model,
        dataset: &Dataset,
        observed: &Observed,
    ) -> Result<Self, DiagnoseError> {
        let (n, width, samples) = (model.coordinates.len(), model.machine_states(), observed.len());
        let mut this = Self {
            times: observed.times.clone(),
            inputs: observed.commands.clone(),
            states: vec![0.0; samples * width],
            accelerations: vec![0.0; samples * n],
            rates: vec![0.0; samples * (width - 2 * n)],
            coordinates: n,
            width,
        };
        let state = |channel: usize| model.coordinate_index(channel);
        let path = |channel: usize| {
            if model.motion_index(channel).is_some() {
                return Ok(None);
            }
            let rate = model.is_coordinate(channel).then_some(state(channel) + n);
            smoothed(dataset, observed, state(channel), rate)
        };
        let paths: Vec<_> = (0..model.channels()).into_par_iter().map(path).collect();
        for (channel, path) in paths.into_iter().enumerate() {
            if let Some(motion) = model.motion_index(channel) {
                this.follow(channel, motion);
            }
            let (state, Some(path)) = (state(channel), path?) else { continue };
            for k in 0..samples {
                this.states[k * width + state] = path.value[k];
                if model.is_coordinate(channel) {
                    this.states[k * width + state + n] = path.first[k];
                    this.accelerations[k * n + channel] = path.second[k];
                } else {
                    this.rates[k * (width - 2 * n) + state - 2 * n] = path.first[k];
                }
            }
        }
        Ok(this)
    }

    /// Take the motion of an imposed coordinate from the inputs, where it begins at `motion`.
    fn follow(&mut self, coordinate: usize, motion: usize) {
        let (n, m) = (self.coordinates, self.inputs.len() / self.len().max(1));
        for k in 0..self.len() {
            let row = &self.inputs[k * m + motion..];
            self.states[k * self.width + coordinate] = row[0];
            self.states[k * self.width + coordinate + n] = row[1];
            self.accelerations[k * n + coordinate] = row[2];
        }
    }

    /// Set an entry of the machine's state at sample `k`.
    pub fn set(&mut self, k: usize, state: usize, value: f64) {
        self.states[k * self.width + state] = value;
    }

    /// Time derivative of an entry of the machine's state at sample `k`.
    #[must_use]
    pub fn rate(&self, k: usize, state: usize) -> f64 {
        let n = self.coordinates;
        if state < n {
            self.state(k)[state + n]
        } else if state < 2 * n {
            self.accelerations[k * n + state - n]
        } else {
            self.rates[k * (self.width - 2 * n) + state - 2 * n]
        }
    }

    /// The same recording along a motion of a system, row-major with rows of its whole state.
    #[must_use]
    pub fn along(mut self, system: &System, path: &[f64]) -> Self {
        let (n, m, width) = (self.coordinates, system.inputs(), self.width);
        let mut derivative = vec![0.0; system.width()];
        for (k, x) in path.chunks_exact(system.width()).enumerate() {
            self.states[k * width..(k + 1) * width].copy_from_slice(&x[..width]);
            let u = &self.inputs[k * m..(k + 1) * m];
            system.derivative(self.times[k], x, u, &mut derivative);
            self.accelerations[k * n..(k + 1) * n].copy_from_slice(&derivative[n..2 * n]);
        }
        self
    }

    /// Rates of the machine's state that a system has along this motion, sample by sample, its memory at rest.
    #[must_use]
    pub fn rates_of(&self, system: &System) -> Vec<Vec<f64>> {
        let m = system.input_width();
        let mut derivative = vec![0.0; system.width()];
        let at = |k: usize| {
            let u = &self.inputs[k * m..(k + 1) * m];
            system.derivative(self.times[k], &system.at_rest(self.state(k)), u, &mut derivative);
            derivative[..system.machine_states()].to_vec()
        };
        (0..self.len()).map(at).collect()
    }

    /// The same motion with these effective inputs.
    #[must_use]
    pub fn driven_by(&self, inputs: Vec<f64>) -> Self {
        Self { inputs, ..self.clone() }
    }

    /// Number of coordinates.
    #[must_use]
    pub fn coordinates(&self) -> usize {
        self.coordinates
    }

    /// Number of samples.
    #[must_use]
    pub fn len(&self) -> usize {
        self.times.len()
    }

    /// Whether there is no sample.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.times.is_empty()
    }

    /// The machine's state at sample `k`.
    #[must_use]
    pub fn state(&self, k: usize) -> &[f64] {
        &self.states[k * self.width..(k + 1) * self.width]
    }

    /// What a force law sees at sample `k` of the channel that it acts on and those it names.
    #[must_use]
    pub fn at<'s>(&'s self, channels: &'s [Channel], k: usize) -> At<'s> {
        let (n, m) = (self.coordinates, self.inputs.len() / self.len());
        let own = channels[0].q;
        let acceleration = if own < n { self.accelerations[k * n + own] } else { 0.0 };
        let inputs = &self.inputs[k * m..(k + 1) * m];
        At { inputs, acceleration, ..At::new(self.times[k], self.state(k), channels) }
    }

    /// The basis of a force law along the recording: one series an amplitude. Memory starts
    /// at rest and is integrated along the smoothed motion.
    #[must_use]
    pub fn basis(
        &self,
        law: &dyn AnyForceLaw,
        shape: &[f64],
        channels: &[Channel],
    ) -> Vec<Vec<f64>> {
        let mut basis = vec![];
        self.bases(law, std::iter::once(shape), channels, |_, series| basis = series);
        basis
    }

    /// The basis of a force law along the recording for each of some shapes: see
    /// [`Self::basis`].
    pub fn bases<'s>(
        &self,
        law: &dyn AnyForceLaw,
        shapes: impl Iterator<Item = &'s [f64]>,
        channels: &[Channel],
        mut each: impl FnMut(&[f64], Vec<Vec<f64>>),
    ) {
        let mut memory = vec![0.0; law.memory()];
        law.memory_at_rest(&self.at(channels, 0), &mut memory);
        let seen = |k: usize| At { memory: &memory, ..self.at(channels, k) };
        let motion: Vec<At> = (0..self.len()).map(seen).collect();
        for shape in shapes {
            let mut series = vec![Vec::with_capacity(motion.len()); law.amplitudes()];
            law.plain().series(shape, &motion, &mut series);
            each(shape, series);
        }
    }
}
