//! What drives a plant: sums of sinusoids, open loop or as the reference of a controller.
//!
//! The controllers know the nominal model, or no model, and the true sampled state, as a drive
//! with an encoder of its own does; their commands are held from sample to sample and are what the
//! recordings hold as inputs.

use lacuna_control::{ComputedTorque, Gains, PlantAccelerations, ReferenceFn};
use lacuna_excitation::{Sinusoid, SinusoidRanges, SumOfSinusoids};
use lacuna_plants::System;
use rand_chacha::ChaCha8Rng;

use crate::StudyError;

/// A signal to be drawn: a constant and a sum of sinusoids.
#[derive(Clone, Copy, Debug)]
pub struct Signal {
    /// Number of sinusoids.
    pub terms: usize,
    /// The constant.
    pub offset: f64,
    /// Range of the amplitudes.
    pub amplitude: [f64; 2],
    /// Range of the angular frequencies (rad/s).
    pub band: [f64; 2],
}

/// A proportional-derivative loop from a coordinate to an input.
#[derive(Clone, Copy, Debug)]
pub struct Loop {
    /// Index of the input.
    pub input: usize,
    /// Index of the coordinate.
    pub coordinate: usize,
    /// Input per unit of position error.
    pub stiffness: f64,
    /// Input per unit of velocity error.
    pub damping: f64,
    /// What the coordinate is to follow.
    pub reference: Signal,
}

/// How a plant is driven.
#[derive(Clone, Copy, Debug)]
pub enum Drive {
    /// One signal an input.
    Open(&'static [Signal]),
    /// Proportional-derivative loops; inputs without a loop are zero.
    Regulated(&'static [Loop]),
    /// Computed torque with the nominal model, one reference a coordinate.
    ComputedTorque {
        /// Position gain of the error dynamics (1/s^2).
        stiffness: f64,
        /// Velocity gain of the error dynamics (1/s).
        damping: f64,
        /// What the coordinates are to follow.
        references: &'static [Signal],
    },
}

impl Drive {
    /// The nature of the drive, in a word.
    pub fn word(&self) -> &'static str {
        match self {
            Self::Open(_) => "open loop",
            Self::Regulated(_) => "regulated",
            Self::ComputedTorque { .. } => "computed torque",
        }
    }

    /// Draw the signals of one recording.
    ///
    /// # Errors
    /// [`StudyError::Input`] for a range that is none.
    pub fn draw(&self, rng: &mut ChaCha8Rng) -> Result<Course, StudyError> {
        let signals: Vec<Signal> = match self {
            Self::Open(signals) => signals.to_vec(),
            Self::Regulated(loops) => loops.iter().map(|l| l.reference).collect(),
            Self::ComputedTorque { references, .. } => references.to_vec(),
        };
        let drawn = signals.iter().map(|s| sinusoids(s, rng)).collect::<Result<_, _>>()?;
        let offsets = signals.iter().map(|s| s.offset).collect();
        Ok(Course { drive: *self, offsets, signals: SumOfSinusoids { channels: drawn } })
    }
}

fn sinusoids(signal: &Signal, rng: &mut ChaCha8Rng) -> Result<Vec<Sinusoid>, StudyError> {
    let ranges = SinusoidRanges {
        amplitude: signal.amplitude[0]..=signal.amplitude[1],
        angular_frequency: signal.band[0]..=signal.band[1],
        phase: 0.0..=std::f64::consts::TAU,
    };
    Ok(SumOfSinusoids::random(rng, 1, signal.terms, &ranges)?.channels.remove(0))
}

/// A drive with the signals of one recording.
#[derive(Clone, Debug)]
pub struct Course {
    drive: Drive,
    offsets: Vec<f64>,
    signals: SumOfSinusoids,
}

impl Course {
    /// The same drive that commands, or refers to, nothing but the constants.
    #[must_use]
    pub fn quiet(mut self) -> Self {
        let all = self.signals.channels.iter_mut().flatten();
        all.for_each(|sinusoid| sinusoid.amplitude = 0.0);
        self
    }

    /// Signal `k` and its first two time derivatives at `t`.
    fn signal(&self, k: usize, t: f64) -> [f64; 3] {
        let mut out = [self.offsets[k], 0.0, 0.0];
        for s in &self.signals.channels[k] {
            let w = s.angular_frequency;
            let (sine, cosine) = (w * t + s.phase).sin_cos();
            out[0] += s.amplitude * sine;
            out[1] += s.amplitude * w * cosine;
            out[2] -= s.amplitude * w * w * sine;
        }
        out
    }

    /// The commanded inputs at `t` for the machine's `state`, into `u`; `nominal` is the model that
    /// a controller believes.
    ///
    /// # Errors
    /// [`StudyError::Control`] where computed torque cannot be computed.
    pub fn command(
        &self,
        nominal: &System,
        t: f64,
        state: &[f64],
        coordinates: usize,
        u: &mut [f64],
    ) -> Result<(), StudyError> {
        match self.drive {
            Drive::Open(_) => (0..u.len()).for_each(|j| u[j] = self.signal(j, t)[0]),
            Drive::Regulated(loops) => {
                u.fill(0.0);
                for (k, l) in loops.iter().enumerate() {
                    let [r, dr, _] = self.signal(k, t);
                    let (q, v) = (state[l.coordinate], state[coordinates + l.coordinate]);
                    u[l.input] += l.stiffness * (r - q) + l.damping * (dr - v);
                }
            }
            Drive::ComputedTorque { stiffness, damping, .. } => {
                let reference =
                    ReferenceFn(|t: f64, q: &mut [f64], v: &mut [f64], a: &mut [f64]| {
                        for k in 0..q.len() {
                            [q[k], v[k], a[k]] = self.signal(k, t);
                        }
                    });
                let model = PlantAccelerations::new(nominal)?;
                let gains = Gains::uniform(coordinates, stiffness, damping);
                ComputedTorque::new(&model, &reference, gains)?.input(t, state, u)?;
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use lacuna_excitation::rng;

    #[test]
    fn derivatives_of_a_signal_are_those_of_differences() {
        let drive = Drive::Open(&[Signal {
            terms: 3,
            offset: 2.0,
            amplitude: [0.5, 1.0],
            band: [1.0, 3.0],
        }]);
        let course = drive.draw(&mut rng(1, 0)).unwrap();
        let (t, h) = (0.7, 1e-4);
        let [before, here, after] = [t - h, t, t + h].map(|t| course.signal(0, t));
        assert!(((after[0] - before[0]) / (2.0 * h) - here[1]).abs() < 1e-6);
        assert!(((after[1] - before[1]) / (2.0 * h) - here[2]).abs() < 1e-5);
    }
}
