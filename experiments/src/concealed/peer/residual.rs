//! Residual forces of smoothed and differentiated recordings.

use lacuna_plants::Model;
use lacuna_recordings::{Prior, Recording, Smoothed, Smoother, Trajectory, estimate_noise_pooled};
use nalgebra::{DMatrix, DVector};

use super::PeerError;
use super::library::Sample;
use crate::concealed::ConcealedError;

/// Rows at both ends of a recording whose derivatives are not trusted.
const ENDS: usize = 15;
/// Share of a tolerance by which a parameter is moved to see what it does.
const NUDGE: f64 = 1e-3;
/// Steps of Euler's method between rows, for states that nothing measures.
const EULER: usize = 10;

/// Residual forces and what they may depend on, recording by recording.
pub struct Residuals {
    /// Rows of each recording.
    pub recordings: Vec<Vec<Row>>,
    measured: Vec<bool>,
}

/// One sample.
pub struct Row {
    /// State of the machine.
    pub state: Vec<f64>,
    /// By channel: what the model's force gains by each whole input.
    pub input_forces: Vec<Vec<f64>>,
    /// By channel: `M q'' - F`, or `x' - D`.
    pub residual: Vec<f64>,
    /// By channel: what a tolerance of each uncertain parameter changes of the residual.
    pub sensitivity: Vec<Vec<f64>>,
}

impl Row {
    /// The sample as a term of the library sees it.
    pub fn sample(&self, channel: usize) -> Sample<'_> {
        Sample { state: &self.state, input_forces: &self.input_forces[channel] }
    }
}

impl Residuals {
    /// Residuals of recordings under a model.
    ///
    /// # Errors
    /// [`PeerError`] where a channel cannot be smoothed.
    pub fn of(model: &Model, recordings: &[Recording]) -> Result<Self, PeerError> {
        let channels = 0..model.channels();
        let measured: Vec<bool> = channels
            .map(|c| has(&recordings[0], model.state_name(model.coordinate_index(c))))
            .collect();
        let noise: Vec<f64> = (0..model.machine_states())
            .map(|i| noise(recordings, model.state_name(i)))
            .collect::<Result<_, _>>()?;
        let rows = recordings.iter().map(|r| rows(model, r, &measured, &noise));
        Ok(Self { recordings: rows.collect::<Result<_, _>>()?, measured })
    }

    /// Whether a force channel's coordinate or state is measured.
    pub fn is_measured(&self, channel: usize) -> bool {
        self.measured[channel]
    }
}

fn has(recording: &Recording, name: &str) -> bool {
    recording.columns.iter().any(|c| c.name == name)
}

/// Noise of a channel over all recordings; 0 where it is not measured.
fn noise(recordings: &[Recording], name: &str) -> Result<f64, PeerError> {
    if !has(&recordings[0], name) {
        return Ok(0.0);
    }
    let pairs = recordings.iter().map(|r| Ok((r.time.as_slice(), r.column(name)?)));
    let pairs: Vec<_> = pairs.collect::<Result<_, _>>().map_err(ConcealedError::Recording)?;
    Ok(estimate_noise_pooled(&pairs)?.sd)
}

fn rows(
    model: &Model,
    recording: &Recording,
    measured: &[bool],
    noise: &[f64],
) -> Result<Vec<Row>, PeerError> {
    let (n, width) = (model.coordinates.len(), model.machine_states());
    let count = recording.len();
    let column = |name: &str| recording.column(name).map_err(ConcealedError::Recording);
    // Whole state, then the highest derivative of each channel.
    let mut states = vec![vec![0.0; width]; count];
    let mut highest = vec![vec![0.0; model.channels()]; count];
    for c in (0..model.channels()).filter(|c| measured[*c]) {
        let (q, v) = (model.coordinate_index(c), model.velocity_index(c));
        let path = smooth(model, recording, c, noise)?;
        for k in 0..count {
            states[k][q] = path.value[k];
            highest[k][c] = if c < n { path.second[k] } else { path.first[k] };
            if c < n {
                states[k][v] = path.first[k];
            }
        }
    }
    let inputs: Vec<&[f64]> =
        model.inputs.iter().map(|i| column(&i.name)).collect::<Result<_, _>>()?;
    let inputs: Vec<Vec<f64>> = (0..count).map(|k| inputs.iter().map(|u| u[k]).collect()).collect();
    let physics = Physics::of(model);
    for c in (n..model.channels()).filter(|c| !measured[*c]) {
        physics.integrate(c, &recording.time, &inputs, &mut states);
    }
    let middle = ENDS..count.saturating_sub(ENDS).max(ENDS);
    Ok(middle
        .map(|k| physics.row(recording.time[k], &states[k], &inputs[k], &highest[k]))
        .collect())
}

fn smooth(
    model: &Model,
    recording: &Recording,
    channel: usize,
    noise: &[f64],
) -> Result<Trajectory, PeerError> {
    let (q, v) = (model.coordinate_index(channel), model.velocity_index(channel));
    let values = recording.column(model.state_name(q)).map_err(ConcealedError::Recording)?;
    let mut smoother = Smoother::new(Prior::WhiteJerk);
    if let (true, Ok(rates)) = (v != q, recording.column(model.state_name(v))) {
        smoother = smoother.with_derivative(rates, noise[v]);
    }
    let smoothed: Smoothed = smoother.smooth(&recording.time, values, noise[q])?;
    Ok(smoothed.at(&recording.time))
}

/// The model's equations with nominal and with moved parameters.
struct Physics {
    model: Model,
    nominal: Vec<f64>,
    moved: Vec<Vec<f64>>,
    coordinates: usize,
    channels: usize,
}

impl Physics {
    fn of(model: &Model) -> Self {
        let nominal = model.values();
        let uncertain = model.parameters.iter().enumerate().filter(|(_, p)| p.std() > 0.0);
        let moved = uncertain.map(|(k, p)| {
            let mut moved = nominal.clone();
            moved[k] += NUDGE * p.std();
            moved
        });
        Self {
            model: model.clone(),
            moved: moved.collect(),
            nominal,
            coordinates: model.coordinates.len(),
            channels: model.channels(),
        }
    }

    /// Mass matrix and forces.
    fn evaluate(&self, parameters: &[f64], t: f64, state: &[f64], u: &[f64]) -> Vec<f64> {
        let variables = [state, u, &[t]].concat();
        let dynamics = self.model.dynamics();
        let mut out = vec![0.0; dynamics.sizes().rates()];
        dynamics.bind(parameters).evaluate_once(&variables, &mut out);
        out
    }

    /// `M (q'' - M(p)^-1 F(p))` with the nominal `M`, and `x' - D(p)`. The measured acceleration
    /// stands alone: were its product with an uncertain mass a column of the regression, its noise
    /// would shrink the mass to nothing.
    fn residual(&self, parameters: &[f64], t: f64, x: &[f64], u: &[f64], top: &[f64]) -> Vec<f64> {
        let n = self.coordinates;
        let nominal = self.evaluate(&self.nominal, t, x, u);
        let moved = self.evaluate(parameters, t, x, u);
        let mass = |of: &[f64]| DMatrix::from_row_slice(n, n, &of[..n * n]);
        let forces = DVector::from_column_slice(&moved[n * n..n * n + n]);
        let believed = match n {
            0 => Some(forces),
            _ => mass(&moved).lu().solve(&forces),
        };
        let measured = DVector::from_column_slice(&top[..n]);
        let left = believed.map_or_else(|| measured.clone(), |b| &measured - b);
        let left = mass(&nominal) * left;
        let states = (n..self.channels).map(|c| top[c] - moved[n * n + c]);
        left.iter().copied().chain(states).collect()
    }

    fn row(&self, t: f64, state: &[f64], u: &[f64], top: &[f64]) -> Row {
        let residual = self.residual(&self.nominal, t, state, u, top);
        let moved: Vec<Vec<f64>> =
            self.moved.iter().map(|p| self.residual(p, t, state, u, top)).collect();
        let sensitivity =
            |c: usize| moved.iter().map(|r| (r[c] - residual[c]) / NUDGE).collect::<Vec<f64>>();
        let without: Vec<Vec<f64>> = (0..u.len())
            .map(|j| {
                let mut u = u.to_vec();
                u[j] = 0.0;
                self.residual(&self.nominal, t, state, &u, top)
            })
            .collect();
        // The residual is minus the force.
        let gains = |c: usize| without.iter().map(|r| r[c] - residual[c]).collect::<Vec<f64>>();
        Row {
            sensitivity: (0..self.channels).map(sensitivity).collect(),
            input_forces: (0..self.channels).map(gains).collect(),
            state: state.to_vec(),
            residual,
        }
    }

    /// Integrate a first-order state that nothing measures along the others, from zero.
    fn integrate(
        &self,
        channel: usize,
        times: &[f64],
        inputs: &[Vec<f64>],
        states: &mut [Vec<f64>],
    ) {
        let (n, place) = (self.coordinates, self.coordinates + channel);
        for k in 0..times.len() - 1 {
            let mut state = states[k].clone();
            let h = (times[k + 1] - times[k]) / EULER as f64;
            for _ in 0..EULER {
                let out = self.evaluate(&self.nominal, times[k], &state, &inputs[k]);
                state[place] += h * out[n * n + channel];
            }
            states[k + 1][place] = state[place];
        }
    }
}
