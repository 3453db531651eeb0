//! The smoothed trajectories that force laws are evaluated along.

use crate::DiagnoseError;
use crate::dataset::{Dataset, Observed};
use lacuna_effects::{ForceLaw, Local};
use lacuna_plants::Model;
use lacuna_recordings::{Prior, Smoother};

/// One recording's smoothed states.
#[derive(Clone, Debug)]
pub struct SmoothedRecording {
    /// Times (s).
    pub times: Vec<f64>,
    /// Commanded inputs, row-major.
    pub commands: Vec<f64>,
    /// Machine states, row-major `times.len() x machine_states`.
    pub states: Vec<f64>,
    /// Derivatives of the first-order states, row-major `times.len() x states`.
    pub rates: Vec<f64>,
    /// Second derivatives of the coordinates, row-major `times.len() x coordinates`.
    pub accelerations: Vec<f64>,
    coordinates: usize,
    width: usize,
}

/// Machine states that no output measures directly.
#[must_use]
pub fn unmeasured(model: &Model, dataset: &Dataset) -> Vec<usize> {
    (0..model.channels())
        .map(|c| model.coordinate_index(c))
        .filter(|&i| dataset.output_of_state(i).is_none())
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
            commands: observed.commands.clone(),
            states: vec![0.0; samples * width],
            accelerations: vec![0.0; samples * n],
            rates: vec![0.0; samples * (width - 2 * n)],
            coordinates: n,
            width,
        };
        for channel in 0..model.channels() {
            let state = model.coordinate_index(channel);
            let Some(output) = dataset.output_of_state(state) else { continue };
            let values = &observed.outputs[output];
            let mut smoother = Smoother::new(Prior::WhiteJerk);
            let rate = dataset.output_of_state(state + n).filter(|_| model.is_coordinate(channel));
            if let Some(rate) = rate {
                smoother =
                    smoother.with_derivative(&observed.outputs[rate], dataset.noise_sd(rate));
            }
            let smoothed = smoother
                .smooth(&observed.times, values, dataset.noise_sd(output))
                .map_err(|source| DiagnoseError::Signal {
                    recording: observed.name.clone(),
                    channel: dataset.outputs[output].name.clone(),
                    source,
                })?;
            let path = smoothed.at(&observed.times);
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

    /// The same recording on other states, row-major with rows of `stride` that begin with the
    /// machine's.
    #[must_use]
    pub fn along(&self, states: &[f64], stride: usize) -> Self {
        let rows = states.chunks_exact(stride);
        let states = rows.flat_map(|x| x[..self.width].iter().copied()).collect();
        Self { states, ..self.clone() }
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

    /// What a force effect on `channel` sees at sample `k`.
    #[must_use]
    pub fn local(&self, channel: usize, other: Option<usize>, k: usize) -> Local {
        let (n, x) = (self.coordinates, self.state(k));
        let q = |c: usize| if c < n { x[c] } else { x[c + n] };
        let (other_q, other_v) = other.map_or((0.0, 0.0), |o| (q(o), x[o + n]));
        Local { t: self.times[k], q: q(channel), v: x[channel + n], other_q, other_v }
    }

    /// The basis of a force law along the recording: one series an amplitude. Memory starts
    /// at rest and is integrated along the smoothed motion.
    #[must_use]
    pub fn basis(
        &self,
        law: &dyn ForceLaw,
        shape: &[f64],
        channel: usize,
        other: Option<usize>,
    ) -> Vec<Vec<f64>> {
        let mut series = vec![vec![0.0; self.len()]; law.amplitudes()];
        let mut basis = vec![0.0; law.amplitudes()];
        let mut memory = vec![0.0; law.memory()];
        let mut at = self.local(channel, other, 0);
        law.memory_at_rest(&at, &mut memory);
        for k in 0..self.len() {
            law.basis(shape, &at, &memory, &mut basis);
            for (series, value) in series.iter_mut().zip(&basis) {
                series[k] = *value;
            }
            if k + 1 < self.len() {
                let next = self.local(channel, other, k + 1);
                advance(law, shape, &at, &next, &mut memory);
                at = next;
            }
        }
        series
    }
}

/// Integrate a law's memory from one sample to the next by the midpoint rule, the motion
/// between them along a straight line.
fn advance(law: &dyn ForceLaw, shape: &[f64], from: &Local, to: &Local, memory: &mut [f64]) {
    const STEPS: usize = 4;
    if memory.is_empty() {
        return;
    }
    let between = |share: f64| Local {
        t: from.t + share * (to.t - from.t),
        q: from.q + share * (to.q - from.q),
        v: from.v + share * (to.v - from.v),
        other_q: from.other_q + share * (to.other_q - from.other_q),
        other_v: from.other_v + share * (to.other_v - from.other_v),
    };
    let h = (to.t - from.t) / STEPS as f64;
    let mut rate = vec![0.0; memory.len()];
    for k in 0..STEPS {
        let begin = k as f64 / STEPS as f64;
        law.memory_rate(shape, &between(begin), memory, &mut rate);
        let middle: Vec<f64> = memory.iter().zip(&rate).map(|(z, r)| z + 0.5 * h * r).collect();
        law.memory_rate(shape, &between(begin + 0.5 / STEPS as f64), &middle, &mut rate);
        for (z, r) in memory.iter_mut().zip(&rate) {
            *z += h * r;
        }
    }
}
