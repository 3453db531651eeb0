//! The true machine: a model with effects of the catalogue and forces beyond it.

use lacuna_plants::dynamics::{Bound, Sizes};
use lacuna_plants::{Model, Plant, System, rk4};
use nalgebra::{DMatrix, DVector};

use super::actuator::{Actuator, Actuators};
use super::disturbance::Gusts;
use super::drive::Course;
use super::off_formula::{At, Law};
use super::sensor::Sensor;
use crate::StudyError;

/// What is true of a machine.
#[derive(Clone, Debug)]
pub struct Truth {
    /// The model with the true parameters and force effects of the catalogue.
    pub model: Model,
    /// Forces beyond the catalogue and the force channel of each.
    pub laws: Vec<(Law, usize)>,
    /// What the actuator of each input does.
    pub actuators: Vec<Option<Actuator>>,
    /// What the sensor of each entry of the machine's state does.
    pub sensors: Vec<Option<Sensor>>,
    /// A random force.
    pub gusts: Option<Gusts>,
}

impl Truth {
    /// The machine that a model believes, with nothing wrong.
    pub fn of(model: &Model) -> Self {
        Self {
            model: model.clone(),
            laws: Vec::new(),
            actuators: vec![None; model.inputs.len()],
            sensors: vec![None; model.machine_states()],
            gusts: None,
        }
    }
}

/// The true machine as a plant: the model's state, its effects' memory, then the laws' memory.
struct Machine {
    system: System,
    bound: Bound,
    sizes: Sizes,
    laws: Vec<(Law, usize)>,
    gusts: Option<Gusts>,
    coordinates: usize,
    memory: usize,
}

impl Machine {
    fn new(truth: &Truth) -> Self {
        let dynamics = truth.model.dynamics();
        Self {
            system: System::new(&truth.model),
            bound: dynamics.bind(&truth.model.values()),
            sizes: dynamics.sizes(),
            memory: truth.laws.iter().map(|(law, _)| law.memory()).sum(),
            laws: truth.laws.clone(),
            gusts: truth.gusts.clone(),
            coordinates: truth.model.coordinates.len(),
        }
    }

    fn at_rest(&self, state: &[f64]) -> Vec<f64> {
        let mut all = self.system.at_rest(state);
        all.resize(all.len() + self.memory, 0.0);
        all
    }

    /// Mass matrix (row-major) and generalised forces of the model's own physics.
    fn own_physics(&self, t: f64, state: &[f64], u: &[f64]) -> Vec<f64> {
        let mut variables = state[..self.system.machine_states()].to_vec();
        variables.extend_from_slice(u);
        variables.push(t);
        let mut out = vec![0.0; self.sizes.rates()];
        self.bound.evaluate_once(&variables, &mut out);
        out
    }

    /// Add the forces of laws and gusts to the accelerations and rates, and the memories' rates.
    fn add_laws(&self, t: f64, state: &[f64], u: &[f64], derivative: &mut [f64]) {
        let (n, known) = (self.coordinates, self.system.states());
        let own = self.own_physics(t, state, u);
        let mut force = vec![0.0; own.len() - n * n];
        let mut begin = known;
        for &(law, channel) in &self.laws {
            let q = if channel < n { state[channel] } else { state[channel + n] };
            let at = At { q, v: state[channel + n], load: own[n * n + channel] };
            let end = begin + law.memory();
            force[channel] += law.force(at, &state[begin..end], &mut derivative[begin..end]);
            begin = end;
        }
        if let Some(gusts) = &self.gusts {
            force[gusts.channel] += gusts.at(t);
        }
        if n > 0 {
            let mass = DMatrix::from_row_slice(n, n, &own[..n * n]);
            let a = mass.lu().solve(&DVector::from_column_slice(&force[..n]));
            // A mass matrix that turns singular ends the run as one that diverges.
            (0..n).for_each(|i| derivative[n + i] += a.as_ref().map_or(f64::NAN, |a| a[i]));
        }
        (n..force.len()).for_each(|i| derivative[n + i] += force[i]);
    }
}

impl Plant for Machine {
    fn order(&self) -> usize {
        1
    }

    fn dimension(&self) -> usize {
        self.system.states() + self.memory
    }

    fn inputs(&self) -> usize {
        self.system.inputs()
    }

    fn derivative(&self, t: f64, state: &[f64], u: &[f64], derivative: &mut [f64]) {
        let known = self.system.states();
        self.system.derivative(t, &state[..known], u, &mut derivative[..known]);
        if !self.laws.is_empty() || self.gusts.is_some() {
            self.add_laws(t, state, u, derivative);
        }
    }
}

/// A motion of the true machine.
#[derive(Clone, Debug)]
pub struct Motion {
    /// Sample times (s).
    pub times: Vec<f64>,
    /// Commanded inputs, row-major samples x inputs.
    pub commands: Vec<f64>,
    /// States of the machine on the fine grid, `substeps` steps a sample.
    pub fine: Vec<Vec<f64>>,
    /// Steps of the fine grid a sample.
    pub substeps: usize,
}

impl Motion {
    /// State of the machine at sample `k`.
    pub fn state(&self, k: usize) -> &[f64] {
        &self.fine[k * self.substeps]
    }

    /// One entry of the machine's state at all samples.
    pub fn series(&self, entry: usize) -> Vec<f64> {
        (0..self.times.len()).map(|k| self.state(k)[entry]).collect()
    }
}

/// Digits that commands are rounded to before they act, since the files hold as many.
const DIGITS: i32 = 7;

/// A number as the files hold it.
pub fn rounded(value: f64) -> f64 {
    if value == 0.0 || !value.is_finite() {
        return value;
    }
    let scale = 10f64.powi(DIGITS - 1 - value.abs().log10().floor() as i32);
    (value * scale).round() / scale
}

/// Run the machine from `start` along a course that `nominal` controls, with commands held for
/// `step` seconds and `substeps` Runge-Kutta steps of order 4 between samples.
///
/// # Errors
/// [`StudyError`] when the motion diverges or the controller fails.
pub fn run(
    truth: &Truth,
    nominal: &System,
    course: &Course,
    start: &[f64],
    (step, samples): (f64, usize),
    substeps: usize,
) -> Result<Motion, StudyError> {
    let machine = Machine::new(truth);
    let (n, m) = (machine.coordinates, machine.inputs());
    let width = machine.system.machine_states();
    let mut actuators = Actuators::new(truth.actuators.clone(), step);
    let mut x = machine.at_rest(start);
    let mut motion = Motion {
        times: (0..samples).map(|k| k as f64 * step).collect(),
        commands: Vec::with_capacity(samples * m),
        fine: vec![start.to_vec()],
        substeps,
    };
    let mut u = vec![0.0; m];
    for k in 0..samples {
        let t = motion.times[k];
        course.command(nominal, t, &x[..width], n, &mut u)?;
        u.iter_mut().for_each(|u| *u = rounded(*u));
        motion.commands.extend_from_slice(&u);
        if k + 1 == samples {
            break;
        }
        let grid: Vec<f64> =
            (0..=substeps).map(|s| t + step * s as f64 / substeps as f64).collect();
        let held = actuators.advance(&u);
        let path = rk4(&machine, &x, &held, &grid, step)?;
        motion.fine.extend((1..=substeps).map(|s| path.state(s)[..width].to_vec()));
        x.copy_from_slice(path.state(substeps));
    }
    Ok(motion)
}
