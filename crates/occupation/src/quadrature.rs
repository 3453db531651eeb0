//! Quadrature weights: sum_k w_k y(t_k) approximates int y dt over the samples.

use serde::{Deserialize, Serialize};

/// How integrals over samples are approximated.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Quadrature {
    /// Trapezoid sums, on any increasing times; exact for piecewise linear functions.
    Trapezoid,
    /// Composite Simpson sums on evenly spaced times; exact for cubics. With an even number of samples the
    /// last three intervals use Simpson's 3/8 rule.
    Simpson,
}

/// Steps may differ from their mean by this relative amount and still count as even.
const EVEN_TOLERANCE: f64 = 1e-6;

impl Quadrature {
    /// Weights w_k, in seconds, one per sample.
    ///
    /// # Errors
    /// Fewer than 2 samples (3 for Simpson), times that do not increase, or Simpson on uneven times.
    pub fn weights(self, times: &[f64]) -> Result<Vec<f64>, QuadratureError> {
        let expected = match self {
            Self::Trapezoid => 2,
            Self::Simpson => 3,
        };
        if times.len() < expected {
            return Err(QuadratureError::TooFewSamples { expected, found: times.len() });
        }
        check_increasing(times)?;
        match self {
            Self::Trapezoid => Ok(trapezoid(times)),
            Self::Simpson => Ok(simpson(times.len(), even_step(times)?)),
        }
    }
}

/// Refuses times that are not finite or do not increase.
pub(crate) fn check_increasing(times: &[f64]) -> Result<(), QuadratureError> {
    if let Some(sample) = times.iter().position(|time| !time.is_finite()) {
        return Err(QuadratureError::NotFinite { sample, found: times[sample] });
    }
    match times.windows(2).position(|pair| pair[1] <= pair[0]) {
        Some(k) => Err(QuadratureError::NotIncreasing {
            sample: k + 1,
            before: times[k],
            found: times[k + 1],
        }),
        None => Ok(()),
    }
}

fn trapezoid(times: &[f64]) -> Vec<f64> {
    let mut weights = vec![0.0; times.len()];
    for k in 1..times.len() {
        let half = 0.5 * (times[k] - times[k - 1]);
        weights[k - 1] += half;
        weights[k] += half;
    }
    weights
}

fn even_step(times: &[f64]) -> Result<f64, QuadratureError> {
    let mean = (times[times.len() - 1] - times[0]) / (times.len() - 1) as f64;
    let uneven = |pair: &[f64]| ((pair[1] - pair[0]) - mean).abs() > EVEN_TOLERANCE * mean;
    match times.windows(2).position(uneven) {
        Some(k) => Err(QuadratureError::Uneven {
            sample: k + 1,
            expected: mean,
            found: times[k + 1] - times[k],
        }),
        None => Ok(mean),
    }
}

fn simpson(samples: usize, step: f64) -> Vec<f64> {
    let mut weights = vec![0.0; samples];
    let even_number = samples.is_multiple_of(2);
    let parabolas_end = if even_number { samples - 4 } else { samples - 1 };
    for start in (0..parabolas_end).step_by(2) {
        for (offset, factor) in [1.0, 4.0, 1.0].into_iter().enumerate() {
            weights[start + offset] += factor * step / 3.0;
        }
    }
    if even_number {
        for (offset, factor) in [1.0, 3.0, 3.0, 1.0].into_iter().enumerate() {
            weights[parabolas_end + offset] += factor * 3.0 * step / 8.0;
        }
    }
    weights
}

/// Times over which an integral cannot be approximated as asked.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum QuadratureError {
    /// Not enough samples for the rule.
    #[error("the quadrature rule needs at least {expected} samples, found {found}")]
    TooFewSamples {
        /// Smallest number of samples for the rule.
        expected: usize,
        /// Number of samples given.
        found: usize,
    },
    /// A time that is no finite number.
    #[error("times must be finite: sample {sample} is at {found}")]
    NotFinite {
        /// Index of the sample at fault.
        sample: usize,
        /// Its time.
        found: f64,
    },
    /// Times that do not increase.
    #[error("times must increase: sample {sample} is at {found} s after {before} s")]
    NotIncreasing {
        /// Index of the sample at fault.
        sample: usize,
        /// Time of the sample before it.
        before: f64,
        /// Its time.
        found: f64,
    },
    /// Simpson's rule on uneven times.
    #[error(
        "Simpson's rule needs evenly spaced times: the step to sample {sample} is {found} s, the mean step {expected} s; \
         use trapezoid sums, or resample"
    )]
    Uneven {
        /// Index of the first sample at the end of a step of another length.
        sample: usize,
        /// Mean step, in seconds.
        expected: f64,
        /// Step found, in seconds.
        found: f64,
    },
}
