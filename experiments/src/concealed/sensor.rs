//! What sensors and loggers make of the true motion.

use lacuna_excitation::add_gaussian_noise;
use rand::RngExt;
use rand_chacha::ChaCha8Rng;

use super::effects::{log_uniform, sign};
use super::truth::Motion;
use crate::StudyError;

/// A sensor that is wrong.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Sensor {
    /// The value times a scale.
    Scale(f64),
    /// The value and an offset.
    Bias(f64),
    /// The value of so many seconds ago.
    Delay(f64),
}

impl Sensor {
    /// The sensor of a class of the catalogue.
    pub fn of(class: &str, parameter: f64) -> Option<Self> {
        Some(match class {
            "sensor_scale" => Self::Scale(parameter),
            "sensor_bias" => Self::Bias(parameter),
            "sensor_delay" => Self::Delay(parameter),
            _ => return None,
        })
    }
}

/// What a sensor, right where there is none, shows of an entry of the machine's state at the
/// samples.
pub fn seen(motion: &Motion, entry: usize, sensor: Option<Sensor>) -> Vec<f64> {
    let truth = motion.series(entry);
    match sensor {
        None => truth,
        Some(Sensor::Scale(scale)) => truth.iter().map(|x| scale * x).collect(),
        Some(Sensor::Bias(bias)) => truth.iter().map(|x| x + bias).collect(),
        Some(Sensor::Delay(delay)) => {
            let step = (motion.times[1] - motion.times[0]) / motion.substeps as f64;
            let late = |k: usize| {
                let place = ((k * motion.substeps) as f64 - delay / step).max(0.0);
                let (below, share) = (place.floor() as usize, place.fract());
                let above = (below + 1).min(motion.fine.len() - 1);
                motion.fine[below][entry] * (1.0 - share) + motion.fine[above][entry] * share
            };
            (0..truth.len()).map(late).collect()
        }
    }
}

/// What hides the physics in the recordings.
#[derive(Clone, Copy, Debug, Default, PartialEq, serde::Deserialize, serde::Serialize)]
pub struct Concealment {
    /// Noise, as a share of the channel's standard deviation.
    pub noise_share: f64,
    /// Quantum of the encoders in noise standard deviations; 0: not quantised.
    pub quantum: f64,
    /// Share of the rows that are lost.
    pub dropped: f64,
    /// Whether velocities are recorded.
    pub velocities: bool,
    /// Whether inner states are recorded.
    pub inner_states: bool,
    /// Correlation of the noise from sample to sample; 0: white.
    pub colour: f64,
    /// Standard deviation of the time stamps, in sample steps.
    pub jitter: f64,
    /// Standard deviation of the noise on recorded inputs, as a share of each input's own; the
    /// machine gets them without.
    #[serde(default)]
    pub input_noise: f64,
    /// Share of the samples that are glitches.
    #[serde(default)]
    pub glitches: f64,
    /// One row in so many and one more is recorded.
    #[serde(default)]
    pub thinned: usize,
}

impl Concealment {
    /// Standard deviation of all that is added to a channel whose noise has deviation `sd`.
    pub fn total(&self, sd: f64) -> f64 {
        sd * (1.0 + self.quantum.powi(2) / 12.0).sqrt()
    }

    /// Noise, then quantisation.
    ///
    /// # Errors
    /// [`StudyError::Noise`] for a deviation that is none.
    pub fn measure(
        &self,
        mut values: Vec<f64>,
        sd: f64,
        rng: &mut ChaCha8Rng,
    ) -> Result<Vec<f64>, StudyError> {
        let mut noise = vec![0.0; values.len()];
        add_gaussian_noise(&mut noise, sd, rng)?;
        // Stationary from the first sample on, with deviation sd at any colour.
        let fresh = (1.0 - self.colour * self.colour).sqrt();
        for k in 1..noise.len() {
            noise[k] = self.colour * noise[k - 1] + fresh * noise[k];
        }
        values.iter_mut().zip(&noise).for_each(|(y, e)| *y += e);
        let quantum = self.quantum * sd;
        if quantum > 0.0 {
            values.iter_mut().for_each(|y| *y = (*y / quantum).round() * quantum);
        }
        Ok(values)
    }

    /// Glitches: lost counts and spikes, far beyond the noise and the motion between two samples.
    pub fn glitch(&self, values: &mut [f64], sd: f64, rng: &mut ChaCha8Rng) {
        if self.glitches == 0.0 {
            return;
        }
        for y in values {
            if rng.random_range(0.0..1.0) < self.glitches {
                *y += sign(rng) * log_uniform(rng, 15.0, 300.0) * sd;
            }
        }
    }

    /// Time stamps of samples taken at `times`; they stay in order.
    ///
    /// # Errors
    /// [`StudyError::Noise`] for a deviation that is none.
    pub fn stamps(&self, times: &[f64], rng: &mut ChaCha8Rng) -> Result<Vec<f64>, StudyError> {
        let mut stamps = times.to_vec();
        let Some(step) = times.get(1).map(|t| t - times[0]) else { return Ok(stamps) };
        let mut error = vec![0.0; times.len()];
        add_gaussian_noise(&mut error, self.jitter * step, rng)?;
        let limit = 0.45 * step;
        stamps.iter_mut().zip(&error).skip(1).for_each(|(t, e)| *t += e.clamp(-limit, limit));
        Ok(stamps)
    }

    /// Rows of the log: one in so many where it is slow.
    pub fn logged(&self, rows: usize) -> Vec<usize> {
        (0..rows).step_by(self.thinned + 1).collect()
    }

    /// Rows that survive: the first and the last, and the others but for losses of one to six
    /// rows in a row.
    pub fn kept(&self, rows: usize, rng: &mut ChaCha8Rng) -> Vec<usize> {
        let mut lost = vec![false; rows];
        let wanted = (self.dropped * rows as f64) as usize;
        let mut count = 0;
        while count < wanted {
            let begin = rng.random_range(1..rows - 1);
            let end = (begin + rng.random_range(1..7)).min(rows - 1);
            count += (begin..end).filter(|&k| !std::mem::replace(&mut lost[k], true)).count();
        }
        (0..rows).filter(|&k| !lost[k]).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use lacuna_excitation::rng;

    #[test]
    fn coloured_noise_has_its_deviation_and_correlation() {
        let how = Concealment { colour: 0.9, ..Concealment::default() };
        let n = 40_000;
        let y = how.measure(vec![0.0; n], 2.0, &mut rng(5, 0)).unwrap();
        let mean = |lag: usize| (lag..n).map(|k| y[k] * y[k - lag]).sum::<f64>() / (n - lag) as f64;
        // Effective samples: n (1 - c^2) / (1 + c^2) of about 4200; five standard errors.
        assert!((mean(0) / 4.0 - 1.0).abs() < 5.0 * (2.0f64 / 4200.0).sqrt(), "{}", mean(0));
        assert!((mean(1) / mean(0) - 0.9).abs() < 0.02);
    }

    #[test]
    fn stamps_stay_in_order_and_rows_are_lost_as_asked() {
        let how = Concealment { jitter: 0.3, dropped: 0.05, ..Concealment::default() };
        let times: Vec<f64> = (0..2000).map(|k| 0.01 * f64::from(k)).collect();
        let stamps = how.stamps(&times, &mut rng(1, 0)).unwrap();
        assert!(stamps.windows(2).all(|p| p[1] > p[0]) && stamps != times);
        let kept = how.kept(2000, &mut rng(1, 1));
        assert!((1894..=1900).contains(&kept.len()), "{}", kept.len());
        assert_eq!((kept[0], kept[kept.len() - 1]), (0, 1999));
    }
}
