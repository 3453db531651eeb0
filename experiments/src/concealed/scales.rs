//! Magnitudes of a plant's motion, by which effects are made neither invisible nor absurd.

use lacuna_plants::Model;

use super::truth::Motion;

/// Magnitudes of a force channel (a coordinate or a first-order state).
#[derive(Clone, Copy, Debug)]
pub struct ChannelScale {
    /// Smallest and largest coordinate or state.
    pub range: [f64; 2],
    /// Standard deviation of the velocity; of a first-order state, that of the state itself, which
    /// is what the catalogue calls its velocity.
    pub velocity: f64,
    /// Standard deviation of the rate of change: of the velocity or of the state's derivative.
    pub rate: f64,
    /// Standard deviation of the model's generalised force, or of the state's derivative.
    pub force: f64,
    /// Mean of the mass matrix's diagonal entry; 1 for a first-order state.
    pub mass: f64,
}

impl ChannelScale {
    /// Half the range of the coordinate.
    pub fn half_range(&self) -> f64 {
        0.5 * (self.range[1] - self.range[0])
    }

    /// Middle of the range.
    pub fn centre(&self) -> f64 {
        0.5 * (self.range[1] + self.range[0])
    }
}

/// Magnitudes of a motion.
#[derive(Clone, Debug)]
pub struct Scales {
    /// Of the force channels.
    pub channels: Vec<ChannelScale>,
    /// Standard deviation and greatest absolute value of each input.
    pub inputs: Vec<[f64; 2]>,
    /// Sample step and length of a recording (s).
    pub time: [f64; 2],
}

impl Scales {
    /// Magnitudes of a motion of `model`.
    pub fn of(model: &Model, motion: &Motion) -> Self {
        let m = model.inputs.len();
        let n = model.coordinates.len();
        let own = own_physics(model, motion);
        let channel = |c: usize| {
            let q = motion.series(model.coordinate_index(c));
            let v = motion.series(model.velocity_index(c));
            let force = deviation(own.iter().map(|o| o[n * n + c]));
            let mass = match c < n {
                true => own.iter().map(|o| o[c * n + c]).sum::<f64>() / own.len() as f64,
                false => 1.0,
            };
            ChannelScale {
                range: range(&q),
                velocity: deviation(v.iter().copied()),
                rate: if c < n { deviation(v.iter().copied()) } else { force },
                force,
                mass,
            }
        };
        let input = |j: usize| {
            let u = motion.commands.iter().skip(j).step_by(m).copied();
            [deviation(u.clone()), u.fold(0.0, |a: f64, b| a.max(b.abs()))]
        };
        let times = &motion.times;
        Self {
            channels: (0..model.channels()).map(channel).collect(),
            inputs: (0..m).map(input).collect(),
            time: [times[1] - times[0], times[times.len() - 1]],
        }
    }
}

/// Mass matrices and generalised forces of the model along a motion.
fn own_physics(model: &Model, motion: &Motion) -> Vec<Vec<f64>> {
    let dynamics = model.dynamics();
    let bound = dynamics.bind(&model.values());
    let m = model.inputs.len();
    let at = |k: usize| {
        let mut variables = motion.state(k).to_vec();
        variables.extend_from_slice(&motion.commands[k * m..(k + 1) * m]);
        variables.push(motion.times[k]);
        let mut out = vec![0.0; dynamics.sizes().rates()];
        bound.evaluate_once(&variables, &mut out);
        out
    };
    (0..motion.times.len()).map(at).collect()
}

/// Smallest and largest value.
pub fn range(values: &[f64]) -> [f64; 2] {
    values.iter().fold([f64::INFINITY, f64::NEG_INFINITY], |[a, b], &v| [a.min(v), b.max(v)])
}

/// Standard deviation, divisor n.
pub fn deviation(values: impl Iterator<Item = f64> + Clone) -> f64 {
    let n = values.clone().count().max(1) as f64;
    let mean = values.clone().sum::<f64>() / n;
    (values.map(|v| (v - mean).powi(2)).sum::<f64>() / n).sqrt()
}
