//! A random force: a road, wind, a neighbour's vibrations.

use lacuna_excitation::add_gaussian_noise;
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use std::sync::Arc;

use super::effects::log_uniform;
use super::plants::PlantSpec;
use super::scales::Scales;
use crate::StudyError;

/// A random force on a channel, another course in each recording.
#[derive(Clone, Debug)]
pub struct Disturbance {
    channel: usize,
    step: f64,
    courses: Vec<Arc<[f64]>>,
}

/// Its course in one recording: straight lines between samples.
#[derive(Clone, Debug)]
pub struct Gusts {
    /// The force channel.
    pub channel: usize,
    step: f64,
    values: Arc<[f64]>,
}

impl Disturbance {
    /// Draw one of a standard deviation of `share` of what the channel feels anyway, correlated over
    /// 2 to 30 samples.
    ///
    /// # Errors
    /// [`StudyError::Noise`] for a deviation that is none.
    pub fn draw(
        spec: &PlantSpec,
        scales: &Scales,
        (share, recordings): ([f64; 2], usize),
        rng: &mut ChaCha8Rng,
    ) -> Result<Self, StudyError> {
        let channel = rng.random_range(0..scales.channels.len());
        let sd = log_uniform(rng, share[0], share[1]) * scales.channels[channel].force;
        let keeps = (-1.0 / log_uniform(rng, 2.0, 30.0)).exp();
        let mut courses = Vec::with_capacity(recordings);
        for _ in 0..recordings {
            let mut force = vec![0.0; spec.samples];
            add_gaussian_noise(&mut force, sd, rng)?;
            let fresh = (1.0 - keeps * keeps).sqrt();
            for k in 1..force.len() {
                force[k] = keeps * force[k - 1] + fresh * force[k];
            }
            courses.push(force.into());
        }
        Ok(Self { channel, step: spec.step, courses })
    }

    /// Its course in recording `k`.
    pub fn course(&self, k: usize) -> Gusts {
        Gusts { channel: self.channel, step: self.step, values: self.courses[k].clone() }
    }
}

impl Gusts {
    /// The force at a time.
    pub fn at(&self, t: f64) -> f64 {
        let place = (t / self.step).max(0.0);
        let last = self.values.len() - 1;
        let below = (place.floor() as usize).min(last);
        let (a, b) = (self.values[below], self.values[(below + 1).min(last)]);
        a + (b - a) * (place - below as f64).min(1.0)
    }
}

#[cfg(test)]
mod tests {
    use super::Gusts;

    #[test]
    fn gusts_run_on_straight_lines() {
        let gusts = Gusts { channel: 0, step: 0.5, values: [1.0, 3.0, -1.0].into() };
        let found = [0.0, 0.25, 0.5, 0.75, 1.0, 2.0].map(|t| gusts.at(t));
        assert_eq!(found, [1.0, 2.0, 3.0, 1.0, -1.0, -1.0]);
    }
}
