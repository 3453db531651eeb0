//! Sums of sinusoids, the excitation of the paper's studies.

use rand::{Rng, RngExt};
use std::ops::RangeInclusive;
use thiserror::Error;

/// One term `a sin(w t + phi)`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sinusoid {
    /// Amplitude `a`, in the unit of the input; may be negative.
    pub amplitude: f64,
    /// Angular frequency `w`, rad/s.
    pub angular_frequency: f64,
    /// Phase `phi`, rad.
    pub phase: f64,
}

impl Sinusoid {
    /// Value at time `t` in seconds.
    pub fn value(&self, t: f64) -> f64 {
        self.amplitude * (self.angular_frequency * t + self.phase).sin()
    }
}

/// From where the terms of a sum are drawn, each uniformly; a range of one point is a constant.
#[derive(Clone, Debug, PartialEq)]
pub struct SinusoidRanges {
    /// Amplitudes, in the unit of the input.
    pub amplitude: RangeInclusive<f64>,
    /// Angular frequencies, rad/s.
    pub angular_frequency: RangeInclusive<f64>,
    /// Phases, rad.
    pub phase: RangeInclusive<f64>,
}

/// Why no sum of sinusoids could be drawn.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum SinusoidError {
    /// A range is reversed or not finite.
    #[error("the range of {quantity} must be finite and increasing, found {from} to {to}")]
    BadRange {
        /// What the range is of.
        quantity: &'static str,
        /// Its lower end.
        from: f64,
        /// Its upper end.
        to: f64,
    },
}

/// An input `u(t) in R^m`: a sum of sinusoids in each channel.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SumOfSinusoids {
    /// The terms of each channel.
    pub channels: Vec<Vec<Sinusoid>>,
}

impl SumOfSinusoids {
    /// Draw `terms` sinusoids for each of `channels` channels.
    ///
    /// # Errors
    /// [`SinusoidError::BadRange`] when a range is reversed or not finite.
    pub fn random(
        rng: &mut impl Rng,
        channels: usize,
        terms: usize,
        ranges: &SinusoidRanges,
    ) -> Result<Self, SinusoidError> {
        check("amplitude", &ranges.amplitude)?;
        check("angular frequency", &ranges.angular_frequency)?;
        check("phase", &ranges.phase)?;
        let mut term = || Sinusoid {
            amplitude: rng.random_range(ranges.amplitude.clone()),
            angular_frequency: rng.random_range(ranges.angular_frequency.clone()),
            phase: rng.random_range(ranges.phase.clone()),
        };
        let channels = (0..channels).map(|_| (0..terms).map(|_| term()).collect()).collect();
        Ok(Self { channels })
    }

    /// Values of all channels at time `t` (seconds), into `u`.
    pub fn value(&self, t: f64, u: &mut [f64]) {
        for (u, terms) in u.iter_mut().zip(&self.channels) {
            *u = terms.iter().map(|s| s.value(t)).sum();
        }
    }

    /// Values at `times`, row-major `times.len() x m`.
    pub fn sample(&self, times: &[f64]) -> Vec<f64> {
        let m = self.channels.len();
        let mut values = vec![0.0; times.len() * m];
        for (&t, u) in times.iter().zip(values.chunks_exact_mut(m.max(1))) {
            self.value(t, u);
        }
        values
    }

    /// Values at the times 0, `step`, 2 `step`, ..., row-major `count x m`: what [`SumOfSinusoids::sample`] gives but for
    /// rounding, without a sine for each.
    pub fn sample_evenly(&self, step: f64, count: usize) -> Vec<f64> {
        let m = self.channels.len();
        let mut values = vec![0.0; count * m];
        for (channel, terms) in self.channels.iter().enumerate() {
            for term in terms {
                let (turn_sine, turn_cosine) = (term.angular_frequency * step).sin_cos();
                let (mut sine, mut cosine) = (0.0, 0.0);
                for (k, value) in values.iter_mut().skip(channel).step_by(m).enumerate() {
                    if k % ROTATIONS == 0 {
                        let angle = term.angular_frequency * (step * k as f64) + term.phase;
                        (sine, cosine) = angle.sin_cos();
                    }
                    *value += term.amplitude * sine;
                    (sine, cosine) = (
                        sine * turn_cosine + cosine * turn_sine,
                        cosine * turn_cosine - sine * turn_sine,
                    );
                }
            }
        }
        values
    }
}

/// Rotations of a phase before it is worked out anew: each adds a rounding error.
const ROTATIONS: usize = 64;

fn check(quantity: &'static str, range: &RangeInclusive<f64>) -> Result<(), SinusoidError> {
    let (from, to) = (*range.start(), *range.end());
    // A width beyond the finite numbers cannot be drawn from either.
    match from <= to && (to - from).is_finite() {
        true => Ok(()),
        false => Err(SinusoidError::BadRange { quantity, from, to }),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rng;

    fn ranges() -> SinusoidRanges {
        SinusoidRanges { amplitude: -1.0..=1.0, angular_frequency: 1.0..=3.0, phase: 0.0..=0.0 }
    }

    #[test]
    fn a_known_sum_has_the_known_values() {
        let term =
            |amplitude, angular_frequency, phase| Sinusoid { amplitude, angular_frequency, phase };
        let sum = SumOfSinusoids {
            channels: vec![
                vec![term(2.0, 1.0, 0.0), term(1.0, 3.0, 0.0)],
                vec![term(1.5, 2.0, std::f64::consts::FRAC_PI_2)],
            ],
        };
        let values = sum.sample(&[0.0, std::f64::consts::FRAC_PI_2]);
        for (found, expected) in values.iter().zip([0.0, 1.5, 1.0, -1.5]) {
            assert!((found - expected).abs() < 1e-12, "{values:?}");
        }
    }

    #[test]
    fn even_samples_are_the_samples() {
        let phases = SinusoidRanges { phase: -3.0..=3.0, ..ranges() };
        let sum = SumOfSinusoids::random(&mut rng(1, 5), 2, 3, &phases).unwrap();
        let times: Vec<f64> = (0..500).map(|k| 0.01 * f64::from(k)).collect();
        for (a, b) in sum.sample_evenly(0.01, 500).iter().zip(sum.sample(&times)) {
            assert!((a - b).abs() < 1e-13, "{a} {b}");
        }
    }

    #[test]
    fn draws_stay_in_their_ranges_and_fill_them() {
        let sum = SumOfSinusoids::random(&mut rng(1, 0), 2, 2000, &ranges()).unwrap();
        let terms: Vec<_> = sum.channels.concat();
        assert_eq!(terms.len(), 4000);
        assert!(terms.iter().all(|s| s.amplitude.abs() <= 1.0 && s.phase == 0.0));
        assert!(terms.iter().all(|s| (1.0..=3.0).contains(&s.angular_frequency)));
        let mean = terms.iter().map(|s| s.angular_frequency).sum::<f64>() / 4000.0;
        // Standard error of the mean: 2 / sqrt(12 * 4000) = 0.009.
        assert!((mean - 2.0).abs() < 0.04, "{mean}");
    }

    #[test]
    fn the_seed_decides() {
        let draw = |seed| SumOfSinusoids::random(&mut rng(seed, 3), 1, 3, &ranges()).unwrap();
        assert_eq!(draw(5), draw(5));
        assert_ne!(draw(5), draw(6));
    }

    #[test]
    fn a_reversed_range_is_an_error() {
        let bad = SinusoidRanges {
            angular_frequency: std::ops::RangeInclusive::new(3.0, 1.0),
            ..ranges()
        };
        assert_eq!(
            SumOfSinusoids::random(&mut rng(1, 0), 1, 1, &bad),
            Err(SinusoidError::BadRange { quantity: "angular frequency", from: 3.0, to: 1.0 })
        );
        let nan = SinusoidRanges { amplitude: f64::NAN..=1.0, ..ranges() };
        assert!(SumOfSinusoids::random(&mut rng(1, 0), 1, 1, &nan).is_err());
    }
}
